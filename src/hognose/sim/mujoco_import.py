"""MuJoCo, imported whether or not there is OpenGL: the twin draws nothing."""

from __future__ import annotations

import importlib
import os
from typing import Any

from hognose.errors import MissingExtraError

#: Says by what MuJoCo draws; a value that does not fit the machine makes its import fail.
_DRAWS_BY = "MUJOCO_GL"


def mujoco() -> Any:
    """The package; without its OpenGL if that cannot be loaded.

    Raises
    ------
    MissingExtraError
        It is not installed, or cannot be imported.
    """
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise _missing(error) from None
    except Exception:
        return _without_opengl()


def _without_opengl() -> Any:
    """As `mujoco`, with an environment that asks for no drawing; afterwards it is as before."""
    before = os.environ.get(_DRAWS_BY)
    os.environ[_DRAWS_BY] = "disable"
    try:
        return importlib.import_module("mujoco")
    except Exception as error:
        raise _missing(error) from None
    finally:
        os.environ.pop(_DRAWS_BY)
        if before is not None:
            os.environ[_DRAWS_BY] = before


def _missing(error: Exception) -> MissingExtraError:
    install = "install it with: pip install 'hognose[sim]'"
    if isinstance(error, ImportError) and error.name == "mujoco":
        return MissingExtraError(f"the twin needs the package mujoco; {install}")
    said = " ".join(str(error).split()) or type(error).__name__
    return MissingExtraError(f"the twin needs the package mujoco, which cannot be imported: {said}; {install}")
