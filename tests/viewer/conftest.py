"""What the tests in a browser share: one browser a file, and a page of its own for each test."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from browsing import looked_at, running
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


@contextmanager
def settled(task: Task) -> Iterator[Page]:
    """A page on a task, once that is planned."""
    with running(task) as page:
        assert page.bench is not None
        page.bench.settle(LONG)
        yield page


@pytest.fixture(scope="session")
def pipe_tank() -> Task:
    """The task, whose space is built once."""
    task = hognose.load_task("pipe-tank")
    assert task.scene.names
    return task


@pytest.fixture(scope="module")
def still(pipe_tank: Task) -> Iterator[Page]:
    """A page on the pipe tank, with its verdict, for tests that edit nothing."""
    with settled(pipe_tank) as page:
        yield page


@pytest.fixture
def tank(pipe_tank: Task) -> Iterator[Page]:
    """A page on the pipe tank, with its verdict."""
    with settled(pipe_tank) as page:
        yield page


@pytest.fixture
def tab(chromium: Browser, tank: Page) -> Iterator[Tab]:
    """A small window on the tank."""
    with looked_at(chromium, tank) as found:
        yield found


@pytest.fixture
def watched(chromium: Browser, still: Page) -> Iterator[Tab]:
    """A small window on the page that nobody edits."""
    with looked_at(chromium, still) as found:
        yield found
