"""What all tests share: how examples are drawn, which tests are slow, and a cache folder of their own."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hognose.cache_folder import cache_folder

if "NUMBA_CACHE_DIR" not in os.environ:
    # Compiled kernels are shared with the user and with the processes that the tests start, wherever their caches are.
    os.environ["NUMBA_CACHE_DIR"] = str(cache_folder() or Path(tempfile.gettempdir()) / "hognose")
from hypothesis import HealthCheck, Phase, settings

# The same examples in every run, however slow the machine; `pytest --hypothesis-profile=search` draws new ones.
settings.register_profile(
    "fixed", deadline=None, database=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("search", settings.get_profile("fixed"), derandomize=False)
# Any failure will do: none is made smaller (tests/mutants.py).
settings.register_profile("first", settings.get_profile("fixed"), phases=(Phase.explicit, Phase.generate))
settings.load_profile("fixed")

pytest_plugins = ["bundled_plans"]

#: Folders of tests that draw, run commands, browse or build the documentation.
SLOW = {"cli", "docs", "report", "viewer"}


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark what `make quick` leaves out; single files elsewhere mark themselves."""
    if item.path.parent.name in SLOW:
        item.add_marker(pytest.mark.slow)


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
