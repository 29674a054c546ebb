"""Section models: how one kind of section bends, and what its body is. One file a kind, one row in the table."""

from hognose.robot.sections.arc import ARC
from hognose.robot.sections.hinges import HINGES
from hognose.robot.sections.joints import JOINTS
from hognose.robot.sections.kind import Geometry, Piece, SectionKind
from hognose.robot.sections.link import LINK, RIGID_LINK, RigidLink
from hognose.robot.sections.mixed import MixedSections, model_of
from hognose.robot.sections.model import SectionModel

#: Every kind of section by what `kind` says in a robot file.
KINDS: dict[str, SectionKind] = {kind.name: kind for kind in (LINK, HINGES, JOINTS, ARC)}

__all__ = [
    "KINDS",
    "LINK",
    "RIGID_LINK",
    "Geometry",
    "MixedSections",
    "Piece",
    "RigidLink",
    "SectionKind",
    "SectionModel",
    "model_of",
]
