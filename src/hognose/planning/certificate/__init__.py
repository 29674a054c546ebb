"""Proofs that the whole body stays clear between the set-points, too."""
