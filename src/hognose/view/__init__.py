"""The name of `hognose.report` in version 0.1: its modules can be imported from here for one version more.

`hognose.view.camera` is `hognose.report.camera`, not a second copy of it.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

_HERE, _THERE = "hognose.view.", "hognose.report."


class _FormerName(MetaPathFinder, Loader):
    """Finds a module of this name in `hognose.report`."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The module of that name, if it is one of this package."""
        if not fullname.startswith(_HERE):
            return None
        there = importlib.util.find_spec(_THERE + fullname.removeprefix(_HERE))
        return None if there is None else ModuleSpec(fullname, self, loader_state=there)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The one that is there already, or is loaded now."""
        return importlib.import_module(spec.loader_state.name)

    def exec_module(self, module: ModuleType) -> None:
        """Nothing is run again; the module is still the one of its own name."""
        assert module.__spec__ is not None, "importlib has just set it"
        module.__spec__ = module.__spec__.loader_state


warnings.warn("hognose.view is called hognose.report now", DeprecationWarning, stacklevel=2)
__path__ = []
sys.meta_path.append(_FormerName())
