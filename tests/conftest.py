"""What all tests share: a cache folder of their own."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hognose.cache_folder import cache_folder

if "NUMBA_CACHE_DIR" not in os.environ:
    # Compiled kernels are shared with the user and with the processes that the tests start, wherever their caches are.
    os.environ["NUMBA_CACHE_DIR"] = str(cache_folder() or Path(tempfile.gettempdir()) / "hognose")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The tests' cache; the user's is left alone."""
    folder, before = tmp_path_factory.mktemp("cache"), os.environ.get("HOGNOSE_CACHE")
    os.environ["HOGNOSE_CACHE"] = str(folder)
    yield folder
    if before is None:
        del os.environ["HOGNOSE_CACHE"]
    else:
        os.environ["HOGNOSE_CACHE"] = before
