"""Proofs that the whole body stays clear between the set-points, too."""

from hognose.planning.certificate.bound import Certificate, certify
from hognose.planning.certificate.cables import (
    UndeterminedError,
    cables_motion,
    certify_cables,
    judges_cables,
)
from hognose.planning.certificate.gliding import gliding_motion
from hognose.planning.certificate.interpolated import interpolated_motion
from hognose.planning.certificate.moving import OneChord, first_joint_motion, mount_motion, standing
from hognose.planning.certificate.outlined import outlined
from hognose.planning.certificate.own_body import OwnClearance, certify_own_body
from hognose.planning.certificate.passing import Passing, certify_passing

__all__ = [
    "Certificate",
    "OneChord",
    "OwnClearance",
    "Passing",
    "UndeterminedError",
    "cables_motion",
    "certify",
    "certify_cables",
    "certify_own_body",
    "certify_passing",
    "first_joint_motion",
    "gliding_motion",
    "interpolated_motion",
    "judges_cables",
    "mount_motion",
    "outlined",
    "standing",
]
