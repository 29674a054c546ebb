"""The pages of the documentation, and the code in them."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page, language):
    """The code blocks of one language on a page."""
    return [text for named, text in _BLOCK.findall(page.read_text(encoding="utf-8")) if named == language]


def pages_with(language):
    """Pages that have such code, the README among them."""
    return [page for page in [*PAGES, ROOT / "README.md"] if blocks(page, language)]


def write_files_of(page, folder):
    """Write the TOML files that a page tells its reader to write: those that begin with their name."""
    for text in blocks(page, "toml"):
        if named := re.match(r"# (\S+\.toml)\n", text):
            (folder / named[1]).write_text(text, encoding="utf-8")


def build(docs, out):
    """Build the site as `make docs` does; what came of it."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", docs, out]
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
