"""The recipes of CONTRIBUTING, to be run."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]


def recipe(heading: str) -> str:
    """The code of one recipe."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    found = re.search(rf"^### {heading}\n.*?^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]
