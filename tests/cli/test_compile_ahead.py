"""The second process of a first plan: it fills the folder that the first one reads, and runs nothing of the user's."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import hognose
from hognose.kernels import sources_digest


def kernels_but_those_of(missing: str, folder: Path) -> None:
    """Copy what is compiled already, which takes a minute to compile anew, without the kernels of some source files."""
    hognose.plan(hognose.load_task("pipe-tank"))
    given = Path(os.environ["NUMBA_CACHE_DIR"]) / "kernels" / folder.name
    # Others may compile meanwhile: what they are just writing is not copied.
    shutil.copytree(given, folder, ignore=shutil.ignore_patterns("*.tmp.*", f"{missing}.*"))


def test_a_first_plan_says_that_it_compiles_and_runs_no_file_of_the_current_folder(tmp_path: Path):
    for name in ("numpy.py", "hognose.py", "types.py"):
        (tmp_path / name).write_text(f"open({str(tmp_path / 'was run')!r}, 'w').close()")
    cold = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    cold["HOGNOSE_CACHE"] = str(tmp_path / "cache")
    kept = tmp_path / "cache" / "kernels" / str(sources_digest())[:16]
    kernels_but_those_of("nearest", kept)
    assert not list(kept.rglob("nearest.*"))
    # As the installed program does, which does not look for modules in the current folder.
    code = "import sys; sys.argv[1:] = ['plan', 'pipe-tank']; from hognose.cli import entry_point; entry_point()"
    done = [
        subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, env=cold, capture_output=True, text=True)
        for _ in range(2)
    ]
    assert [each.returncode for each in done] == [0, 0], done[0].stderr
    assert ["compiling for this processor" in each.stderr for each in done] == [True, False]
    assert not (tmp_path / "was run").exists()
    assert list(kept.parent.iterdir()) == [kept]
    assert list(kept.rglob("nearest._distances-*.nbc"))
