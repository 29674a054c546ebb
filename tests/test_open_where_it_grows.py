"""Who reads only CONTRIBUTING adds a check, a column and an export, in one place each; they are wherever ours are.

The recipes are those of the page. They are added to a copy of the files, and all else is done by commands. The tests of
checks, columns and exports pass with them.
"""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from tests.recipes import ROOT, recipe

pytestmark = pytest.mark.slow

#: What a recipe may cost.
MOST_LINES = 20
#: By heading of the page: the module that the recipe adds to, and the list in it.
PLACES = {
    "A check": ("hognose.planning.checks.motion", "CRITERIA"),
    "A column of the plan file": ("hognose.planning.columns", "QUANTITIES"),
}
#: The package with the table of exports, and the module beside it that the recipe writes.
EXPORTS, TEXT = "hognose.files.exports", "text"
#: Tests of what the recipes add to.
TESTS = (
    *(f"tests/planning/test_{name}.py" for name in ("checks", "columns", "criteria")),
    "tests/files/test_export.py",
)
#: A command writes this page anew, which is that of the repository here.
PAGE = "tests/planning/test_columns.py::test_the_table_of_the_documentation_is_made_from_the_declarations"
#: How each of our checks can fail is not what the recipes add to; what all of them say together is.
SELECTED = "not test_checks or verdict or every_check or again"
#: Lets a process import the files beside it instead of ours. (Kernels of a copy of all sources would compile anew.)
GROWN = """
import sys
from importlib.machinery import PathFinder
from importlib.util import spec_from_file_location
from pathlib import Path

class Grown:
    @staticmethod
    def find_spec(name, path=None, target=None):
        file = Path(__file__).with_name(f"{name}.py")
        if not file.is_file():
            return None
        ours = PathFinder.find_spec(name, path)
        within = None if ours is None else ours.submodule_search_locations
        return spec_from_file_location(name, file, submodule_search_locations=within)

sys.meta_path.insert(0, Grown)
"""
#: What commands make, one after another in one process; and what is not asked for by a command: the page's verdict, and
#: the tables of the documentation.
ASKED = """
import grown
import contextlib
import io
import json
import sys
import hognose
from checks_table import checks_table
from hognose.cli import main
from hognose.viewer.model.replanner import Question, judged
from plan_columns import table

said = {}
for tokens in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.suppress(SystemExit):
        main([*tokens, "--json"])
    said[tokens[0]] = json.loads(out.getvalue())
verdict = judged(Question(1, hognose.load_task("pipe-tank")))
checks = {check.key: check.sentence for check in verdict.checks}
made = {"said": said, "good": verdict.good, "checks": checks, "documented": [checks_table(), table()]}
print(json.dumps(made))
"""
COMMANDS = [
    ["plan", "pipe-tank"],
    ["report", "pipe-tank.parquet", "--no-animation"],
    ["export", "pipe-tank.parquet", "-o", "plan.csv"],
    ["export", "pipe-tank.parquet", "-o", "plan.txt"],
    ["check", "pipe-tank.parquet"],
]


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """A folder whose processes have all three recipes."""
    folder = tmp_path_factory.mktemp("grown")
    (folder / "grown.py").write_text(GROWN, encoding="utf-8")
    for heading, (module, listed) in PLACES.items():
        code = recipe(heading)
        assert code.count("\n    ...,\n") == 1  # stands for what is there already
        added = code.replace("\n    ...,\n", f"\n    *{listed},\n")
        grow(folder, module, f"{module.replace('.', '/')}.py", added)
    (folder / f"{EXPORTS}.{TEXT}.py").write_text(recipe("An export format"), encoding="utf-8")
    listing = f"from {EXPORTS} import {TEXT}\n_BUNDLED[{TEXT!r}] = {TEXT}.EXPORT\n"
    grow(folder, EXPORTS, f"{EXPORTS.replace('.', '/')}/__init__.py", listing)
    return folder


def grow(folder: Path, module: str, file: str, added: str) -> None:
    """Put a copy of a source into the folder, with more at its end."""
    source = (ROOT / "src" / file).read_text(encoding="utf-8")
    (folder / f"{module}.py").write_text(f"{source}\n\n{added}", encoding="utf-8")


def python(folder: Path, *arguments: str, within: Path | None = None) -> str:
    """What Python prints, run in the folder or another one."""
    places = os.pathsep.join(map(str, (folder, ROOT / "src", ROOT / "docs")))
    environment = {**os.environ, "PYTHONPATH": places, "COLUMNS": "200"}
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=within or folder, env=environment, capture_output=True, text=True, encoding="utf-8", check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def asked(grown):
    """What the commands say and write into the folder, and what the page and the documentation make of it."""
    return json.loads(python(grown, "-c", ASKED, json.dumps(COMMANDS)))


@pytest.fixture(scope="module")
def rows(grown, asked):
    """The cells of the CSV, by column."""
    assert asked["said"]["plan"]["good"] is True
    with (grown / "plan.csv").open(newline="", encoding="utf-8") as file:
        head, *lines = csv.reader(file)
    return dict(zip(head, np.array(lines, dtype=np.float64).T, strict=True))


@pytest.mark.parametrize("heading", [*PLACES, "An export format"])
def test_a_recipe_takes_few_lines(heading):
    assert recipe(heading).count("\n") <= MOST_LINES


def test_the_check_judges_plans_that_are_read(asked, rows):
    said = asked["said"]["check"]
    (check,) = (check for check in said["checks"] if check["key"] == "tip_speed")
    tip = np.stack([rows[f"joint_12_{axis}_m"] for axis in "xyz"], axis=1)
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.diff(rows["time_s"])
    assert (said["good"], check["ok"], check["limit"], check["unit"]) == (True, True, 0.1, "m/s")
    assert check["value"] == pytest.approx(speed.max())
    assert speed[check["step"]] == pytest.approx(speed.max())


def test_the_check_is_on_the_page_and_in_the_report(grown, asked):
    assert asked["good"] is True
    assert re.match(r"tip speed: [\d.]+ mm/s is within 100(\.0+)? mm/s at step \d+$", asked["checks"]["tip_speed"])
    report = unescape((grown / "pipe-tank.html").read_text(encoding="utf-8"))
    (row,) = (row for row in re.findall(r"<tr>(.*?)</tr>", report, re.DOTALL) if "tip speed" in row)
    assert re.search(r"≤ 100(\.0+)? mm/s", row)
    assert "passed" in row


def test_the_column_is_in_the_files_and_what_it_says_is_true(grown, rows):
    named = [f"bend_{section:02d}_rad" for section in range(1, 13)]
    assert list(rows)[-12:] == named  # behind ours
    for section, name in enumerate(named, 1):
        bend = np.arccos(np.cos(rows[f"alpha_{section:02d}_rad"]) * np.cos(rows[f"beta_{section:02d}_rad"]))
        np.testing.assert_allclose(rows[name], bend, rtol=0, atol=1e-12)


def test_the_export_is_made(grown, rows):
    columns = (rows[name].tolist() for name in ("time_s", "feed_m"))
    lines = (grown / "plan.txt").read_text().splitlines()
    assert lines == [f"{time!r} {feed!r}" for time, feed in zip(*columns, strict=True)]


def test_our_tests_pass_with_them(grown):
    code = "import grown, pytest, sys; sys.exit(pytest.main(sys.argv[1:]))"
    python(grown, "-c", code, "-p", "no:cacheprovider", *TESTS, "--deselect", PAGE, "-k", SELECTED, within=ROOT)


def test_both_are_documented(asked):
    checks, columns = asked["documented"]
    assert "| `tip_speed` | tip speed | m/s | The tip moves no faster than 0.1 m/s. |" in checks.splitlines()
    (row,) = (line for line in columns.splitlines() if "`bend_01_rad` … `bend_12_rad`" in line)
    assert "| rad | step × section | double | angle between each link and the previous one" in row
