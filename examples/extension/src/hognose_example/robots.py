"""Robots: each is the path of its file."""

from __future__ import annotations

from pathlib import Path

SLIM_8 = Path(__file__).parent / "slim-8.toml"
