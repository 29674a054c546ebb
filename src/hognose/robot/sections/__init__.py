"""Section models: how one kind of section bends, and what its body is. One file a model."""

from hognose.robot.sections.link import RIGID_LINK
from hognose.robot.sections.model import SectionModel

__all__ = ["RIGID_LINK", "SectionModel"]
