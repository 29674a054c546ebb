"""`python -m hognose.cli`."""

from hognose.cli import main

main()
