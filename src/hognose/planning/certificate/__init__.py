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
from hognose.planning.certificate.own_body import OwnClearance, certify_own_body
from hognose.planning.certificate.passing import Passing, certify_mount_passing, certify_passing

__all__ = [
    "Certificate",
    "OwnClearance",
    "Passing",
    "UndeterminedError",
    "cables_motion",
    "certify",
    "certify_cables",
    "certify_mount_passing",
    "certify_own_body",
    "certify_passing",
    "gliding_motion",
    "interpolated_motion",
    "judges_cables",
]
