"""What the arm is: sections, kinematics, cables, and the bundled robots."""

from hognose.robot.robot import Robot
from hognose.robot.spec import RobotSpec

__all__ = ["Robot", "RobotSpec"]
