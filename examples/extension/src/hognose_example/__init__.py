"""What a package of its own adds to Hognose; `pyproject.toml` says what is what."""
