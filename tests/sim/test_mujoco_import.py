"""MuJoCo is imported whatever it is told to draw by, and what cannot be imported is told in a sentence."""

import os
import subprocess
import sys

import pytest

from hognose.errors import MissingExtraError
from hognose.sim import mujoco_import

_IMPORTS = "import os; from hognose.sim.mujoco_import import mujoco as f; print(f().MjModel, os.environ['MUJOCO_GL'])"


@pytest.mark.parametrize("draws_by", ["osmesa", "nothing"])
def test_it_needs_no_opengl(draws_by):
    done = subprocess.run(
        [sys.executable, "-c", _IMPORTS], env={**os.environ, "MUJOCO_GL": draws_by}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-1] == draws_by


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ModuleNotFoundError("No module named 'mujoco'", name="mujoco"), "the package mujoco; install it with: pip"),
        (OSError("libmujoco.so:\n no such file"), r"cannot be imported: libmujoco.so: no such file; install it"),
    ],
)
def test_what_cannot_be_imported_is_told(error, words, monkeypatch):
    def fail(name):
        raise error

    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(mujoco_import.importlib, "import_module", fail)
    with pytest.raises(MissingExtraError, match=words):
        mujoco_import.mujoco()
    assert "MUJOCO_GL" not in os.environ
