"""What all tests share: a cache folder of their own."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest


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
