"""The checks that a plan must pass."""

from hognose.planning.checks.run import run_checks

__all__ = ["run_checks"]
