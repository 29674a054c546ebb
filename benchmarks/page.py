"""The page itself: what it costs to keep an arm moving in it, and how soon a case is seen in Chromium."""

from __future__ import annotations

import re
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.sharedctypes import Synchronized

import viser
from playwright.sync_api import Browser, expect
from websockets import Origin, Subprotocol
from websockets.sync.client import connect

import hognose
from benchmarks.chromium import browser
from benchmarks.clearance import empty_cache
from benchmarks.rows import aside, heading, row
from hognose.planning import Task
from hognose.robot import Robot
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.page import HERTZ, Page
from hognose.viewer.server.gate import Address

BODIES = 24
#: How long the arm is watched, s.
WATCHED = 10.0


def main() -> None:
    heading(f"the page: an arm of {BODIES} links moving in it, and how soon it is seen")
    moving()
    with empty_cache(), browser() as chromium:
        for case in ("obstacle-array", "pipe-tank"):
            seconds = statistics.median(first_view(chromium, case) for _ in range(5))
            row(f"{case}: from the command to arm and verdict in Chromium", seconds, 3.0, "s")


def moving() -> None:
    """Print what a core has to do while an arm plays so fast that every picture is another."""
    page = Page(Workbench(finely_jointed(hognose.load_task("pipe-tank"))), port=0)
    assert page.bench is not None
    page.bench.settle(60.0)
    with watched(page.address) as pictures:
        page.run(2.0)  # whoever watches gets the space first
        page.timeline.clock = replace(page.timeline.clock.to(0), playing=True, speed=5.0)
        before, spent, begin = pictures.value, time.process_time(), time.perf_counter()
        page.run(WATCHED)
        seconds = time.perf_counter() - begin
        share = (time.process_time() - spent) / seconds
        assert page.timeline.clock.row > 0
    page.close()
    row(f"{BODIES} links and their joints at {HERTZ:g} Hz, one browser: of one core", 100 * share, 30.0, "%")
    aside("messages with pictures that arrived", (pictures.value - before) / seconds, "1/s")


def finely_jointed(task: Task) -> Task:
    """The task with an arm of twice as many sections of half the length."""
    spec = task.robot.spec
    halved = [
        section.model_copy(
            update={
                "count": 2 * section.count,
                "pitch": section.pitch / 2,
                "half_lengths": section.half_lengths and tuple(half / 2 for half in section.half_lengths),
            }
        )
        for section in spec.section
    ]
    return Task(task.spec, Robot.from_spec(spec.model_copy(update={"section": tuple(halved)})))


@contextmanager
def watched(address: Address) -> Iterator[Synchronized[int]]:
    """Somebody in another process who gets everything the page sends, and draws nothing; how many messages came."""
    came = get_context("spawn").Value("q", 0)
    watcher = get_context("spawn").Process(target=watch, args=(address.port, address.token, came), daemon=True)
    watcher.start()
    while came.value == 0:
        time.sleep(0.05)
    yield came
    watcher.terminate()
    watcher.join()


def watch(port: int, token: str, came: Synchronized[int]) -> None:
    """Receive as a browser does, without end."""
    with connect(
        f"ws://127.0.0.1:{port}",
        origin=Origin(f"http://127.0.0.1:{port}"),
        additional_headers={"Cookie": f"hognose_{port}={token}"},
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        max_size=None,
        proxy=None,
    ) as connection:
        for _ in connection:
            came.value += 1


def first_view(chromium: Browser, case: str) -> float:
    """Seconds from the command to a page that shows the space, the arm and its verdict."""
    tab = chromium.new_page(viewport={"width": 960, "height": 620})
    begin = time.perf_counter()
    command = [sys.executable, "-m", "hognose.cli", "view", case, "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            found = re.search(r"http\S+", process.stdout.readline())
            assert found
            tab.goto(found[0])
            expect(tab.get_by_role("heading", name="mm certified")).to_be_visible(timeout=60_000)
            tab.locator("canvas").first.wait_for()
            seconds = time.perf_counter() - begin
        finally:
            process.terminate()
    tab.close()
    return seconds


if __name__ == "__main__":
    main()
