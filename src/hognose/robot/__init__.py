"""What the arm is: sections, kinematics, cables, and the bundled robots; and what it stands on."""

from hognose.robot.base import Base, Slider
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum
from hognose.robot.outline import Outline
from hognose.robot.robot import Robot
from hognose.robot.spec import RobotSpec

__all__ = ["Base", "Carrier", "Drum", "Outline", "Robot", "RobotSpec", "Slider"]
