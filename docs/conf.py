"""How the documentation site is built: `make docs`."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

from sphinx.application import Sphinx

import hognose
from hognose.planning import TaskSpec
from hognose.robot import RobotSpec

sys.path.insert(0, str(Path(__file__).parent))

from checks_table import checks_table
from file_reference import reference

project = "Hognose"
author = "The Hognose developers"
project_copyright = author
version = release = hognose.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
exclude_patterns = ["_build"]
default_role = "py:obj"
highlight_language = "none"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "none"  # docstrings say shapes and units, which the types of arrays do not
napoleon_google_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"Hognose {release}"

#: Pages whose tables are made from the models that read the files, and those models.
FILES = {"reference/robot-file": RobotSpec, "reference/task-file": TaskSpec}


def setup(app: Sphinx) -> None:
    """Connect what is made while the site is built."""
    app.connect("source-read", _add_tables)
    app.connect("env-get-outdated", lambda *_: [*FILES, "checks"])  # what they are made from may have changed
    app.connect("autodoc-process-docstring", _name_each_attribute, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", _leave_prose_alone, priority=600)  # after it


def _add_tables(app: Sphinx, page: str, source: list[str]) -> None:
    if page in FILES:
        source[0] += "\n" + reference(FILES[page])
    if page == "checks":
        source[0] += "\n" + checks_table()


def _name_each_attribute(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Repeat an entry of two attributes, `a, b : (n,)`, for each of them: napoleon does so for parameters only."""
    if "Attributes" in lines:
        start = lines.index("Attributes") + 2
        entries = re.findall(r"^\S.*\n?(?:^(?: .*)?\n?)*", "\n".join(lines[start:]), re.MULTILINE)
        lines[start:] = [line for entry in entries for line in _repeated(entry.rstrip("\n"))]


def _repeated(entry: str) -> list[str]:
    head, *words = entry.split("\n")
    names, colon, kind = head.partition(" : ")
    return [line for name in names.split(", ") for line in [f"{name}{colon}{kind}", *words]]


def _leave_prose_alone(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Keep prose from being read as markup.

    The words before a colon in a property's docstring are no type, |α| is no substitution, and the dot of `.toml` does
    not stand for a module.
    """
    said = inspect.getdoc(of) or ""
    if what == "property" and "---" not in said:
        lines[:] = [*said.split("\n"), ""]
    lines[:] = [re.sub(r"(?<!`)`(\.[^`]+)`(?!`)", r"``\1``", line).replace("|", "\\|") for line in lines]
