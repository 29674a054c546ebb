"""What the tests in a browser share: one browser a file, one page on the pipe tank and one tab on it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browsing import SMALL, looked_at, put_back, running
from playwright.sync_api import Browser, expect
from playwright.sync_api import Page as Tab
from workbench_makers import LONG

import hognose
from benchmarks.chromium import browser
from hognose.planning import Task
from hognose.viewer.page import Page

expect.set_options(timeout=1e3 * LONG)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture(scope="session")
def pipe_tank() -> Task:
    """The task, whose space is built once."""
    task = hognose.load_task("pipe-tank")
    assert task.scene.names
    return task


@pytest.fixture(scope="module")
def shared_tank(pipe_tank: Task) -> Iterator[Page]:
    """A page on the pipe tank, with its verdict."""
    with running(pipe_tank) as page:
        assert page.bench is not None
        page.bench.settle(LONG)
        yield page


@pytest.fixture
def tank(shared_tank: Page) -> Iterator[Page]:
    """The page on the pipe tank, as it was opened."""
    yield shared_tank
    put_back(shared_tank)


@pytest.fixture(scope="module")
def shared_tab(chromium: Browser, shared_tank: Page) -> Iterator[Tab]:
    """A small window on the tank: to load the page takes longer than most tests."""
    with looked_at(chromium, shared_tank) as found:
        yield found


@pytest.fixture
def tab(tank: Page, shared_tab: Tab) -> Iterator[Tab]:
    """The small window on the tank, at what is opened first."""
    del tank  # is put back after the window
    yield shared_tab
    shared_tab.set_viewport_size({"width": SMALL[0], "height": SMALL[1]})
    shared_tab.get_by_role("tab", name="Edit").click()
