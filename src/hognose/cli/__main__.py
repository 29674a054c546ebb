"""`python -m hognose.cli`."""

from hognose.cli import entry_point

entry_point()
