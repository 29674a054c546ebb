"""An extension of Hognose; `pyproject.toml` lists its entry points."""
