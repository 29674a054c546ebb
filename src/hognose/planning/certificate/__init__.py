"""Proofs that the whole body stays clear between the set-points, too."""

from hognose.planning.certificate.bound import Certificate
from hognose.planning.certificate.cables import certify_cables, judges_cables
from hognose.planning.certificate.gliding import certify_gliding
from hognose.planning.certificate.interpolated import certify_interpolated

__all__ = ["Certificate", "certify_cables", "certify_gliding", "certify_interpolated", "judges_cables"]
