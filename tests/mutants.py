"""Make one mistake after another in a copy of the sources, and see that the tests notice: `make mutants`.

The mistakes and the tests that must notice them are in `mutants.toml`. Exit code 1 if one is not noticed, or if the
text that it changes is not in the sources any more.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

ROOT = Path(__file__).parents[1]
NEEDED = ("src", "tests", "examples", "docs", "pyproject.toml", "README.md")
#: Exit codes of pytest.
PASSED, FAILED = 0, 1
#: What runs this long (s) hangs, and is noticed.
HANGS = 1200.0


@dataclass(frozen=True)
class Mutant:
    """One mistake."""

    what: str
    file: str
    old: str
    new: str
    tests: list[str]

    def fault(self) -> str | None:
        """Why it is none, if so."""
        file = ROOT / self.file
        if not file.is_file():
            return f"there is no {self.file}"
        found = file.read_text(encoding="utf-8").count(self.old)
        missing = [test for test in self.tests if not (ROOT / test.partition("::")[0]).exists()]
        if missing:
            return f"there is no {missing[0]}"
        return None if found == 1 else f"{self.file} has its text {found} times, not once"


def pytest_in(tree: Path, tests: list[str]) -> tuple[int, str]:
    """The exit code of tests in a copy of the project, and what they said."""
    own = {"PYTHONPATH": str(tree / "src"), "HOGNOSE_CACHE": str(tree / "cache")}
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"} | own
    options = ["-x", "-q", "--no-header", "-p", "no:cacheprovider", "--hypothesis-profile=first"]
    command = [sys.executable, "-m", "pytest", *options, *tests]
    try:
        done = subprocess.run(
            command, cwd=tree, env=environment, capture_output=True, text=True, timeout=HANGS, check=False
        )
    except subprocess.TimeoutExpired:
        return FAILED, "hangs"
    return done.returncode, done.stdout + done.stderr


def verdict(mutant: Mutant, whole: Path) -> str:
    """What the tests make of a mutant, in a copy of the sources and of the kernels compiled from them."""
    with tempfile.TemporaryDirectory(dir=whole.parent) as folder:
        tree = Path(shutil.copytree(whole, Path(folder) / whole.name))
        file = tree / mutant.file
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        code, said = pytest_in(tree, mutant.tests)
    if code == FAILED:
        return "noticed"
    return "NOT NOTICED" if code == PASSED else f"NO VERDICT (pytest ended with {code})\n{said[-2000:]}"


def copied(to: Path) -> Path:
    """A copy of what the tests need."""
    for name in NEEDED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, to / name, ignore=shutil.ignore_patterns("__pycache__", "_build"))
        else:
            to.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, to)
    return to


def main() -> int:
    """Try all mutants, print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2, help="how many at a time")
    parser.add_argument("--only", default="", help="only those whose name this regular expression finds")
    chosen = parser.parse_args()
    listed = tomllib.loads((ROOT / "tests" / "mutants.toml").read_text(encoding="utf-8"))["mutant"]
    mutants = [mutant for mutant in (Mutant(**entry) for entry in listed) if re.search(chosen.only, mutant.what)]
    faults = {mutant.what: fault for mutant in mutants if (fault := mutant.fault())}
    for what, fault in faults.items():
        print(f"{what}: {fault}")
    if faults or not mutants:
        print("mend tests/mutants.toml" if faults else "no such mutant")
        return 1
    with tempfile.TemporaryDirectory(prefix="hognose-mutants-") as folder:
        print(f"the tests of {len(mutants)} mutants without any of them", end=" … ", flush=True)
        began = monotonic()
        every = sorted({test for mutant in mutants for test in mutant.tests})
        whole = copied(Path(folder) / "hognose")
        code, said = pytest_in(whole, every)
        print(f"{'passed' if code == PASSED else 'FAILED'}, {monotonic() - began:.0f} s")
        if code != PASSED:
            print(said)
            return 1

        def tried(mutant: Mutant) -> str:
            began = monotonic()
            found = verdict(mutant, whole)
            print(f"{monotonic() - began:6.1f} s  {mutant.what}: {found}", flush=True)
            return found

        with ThreadPoolExecutor(chosen.jobs) as pool:
            found = list(pool.map(tried, mutants))
    noticed = found.count("noticed")
    print(f"{noticed} of {len(mutants)} mutants noticed, {monotonic() - began:.0f} s")
    return 0 if noticed == len(mutants) else 1


if __name__ == "__main__":
    sys.exit(main())
