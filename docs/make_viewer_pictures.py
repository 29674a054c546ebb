"""Take the pictures of the viewer for the documentation: `python docs/make_viewer_pictures.py`, or only those named.

The pages are opened in Chromium without a window, each with its plan at 80 % of the motion.
"""

from __future__ import annotations

import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser
from playwright.sync_api import Page as Tab

sys.path.insert(0, str(Path(__file__).parents[1]))  # so that `benchmarks` is found, whatever the current folder

import hognose
from benchmarks.chromium import browser
from hognose.report.base_lines import mount_at
from hognose.viewer.model.edits import move_way_point
from hognose.viewer.opening import opened
from hognose.viewer.page import Page, with_space

FOLDER = Path(__file__).parent / "pictures"
#: Size of the window in pixels, and the longest wait (s): without a graphics card a page takes its time.
SIZE, PATIENCE = (1280, 800), 180.0
#: The part of the motion at which the arm is shown.
PART = 0.8
#: Frames that the browser draws before a picture is taken.
FRAMES = 20


def main(names: list[str]) -> None:
    """Take the pictures of these names, or all."""
    hognose.plan(hognose.load_task("pipe-tank"))  # loads the kernels, so that pages show how long planning alone takes
    with browser() as chromium:
        for name in names or PICTURES:
            task, act = PICTURES[name]
            # Its own cache, so that no unsaved edits are restored.
            with tempfile.TemporaryDirectory() as cache, shown(chromium, task, cache) as (page, tab):
                act(page, tab)
                tab.screenshot(path=FOLDER / f"{name}.png")


@contextmanager
def shown(chromium: Browser, task: str, cache: str) -> Iterator[tuple[Page, Tab]]:
    """A page on a bundled task that has a good plan, kept up to date by a thread, and a tab on it."""
    os.environ["HOGNOSE_CACHE"] = cache
    ended = threading.Event()
    with opened(task, port=0) as page:
        thread = threading.Thread(target=lambda: _keep_up(page, ended), daemon=True)
        thread.start()
        tab = chromium.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        try:
            tab.set_default_timeout(1e3 * PATIENCE)
            tab.goto(page.address.url)
            tab.get_by_role("heading", name="GOOD:").wait_for()
            tab.get_by_role("alert").get_by_role("button").click()  # that there is no graphics card
            yield page, tab
        finally:
            tab.close()
            ended.set()
            thread.join(PATIENCE)


def _keep_up(page: Page, ended: threading.Event) -> None:
    while not ended.is_set():
        page.run(0.1)


def under_way(page: Page, tab: Tab) -> None:
    """The arm under way."""
    if page.bench is not None and page.bench.searching:
        tab.get_by_role("button", name="Find a route").wait_for()
    rows = page.timeline.clock.rows
    _go(page, tab, round(PART * (rows - 1)))


def not_good(page: Page, tab: Tab) -> None:
    """The second way-point in a pipe, and the step that fails by most."""
    assert page.bench is not None
    page.bench.edit(move_way_point(1, (0.03, 0.025, 0.43)))
    tab.get_by_role("heading", name="NOT GOOD").wait_for()
    tab.get_by_role("button", name="Show where").click()
    assert page.bench.verdict is not None
    assert page.bench.verdict.step is not None
    _go(page, tab, page.bench.verdict.step)


def steering(page: Page, tab: Tab) -> None:
    """The nose steered to the upper right until the arm stops before a pipe, the stick and the lever held."""
    tab.get_by_role("tab", name="Steer").click()
    tab.get_by_text("steer the nose by hand").click()
    stick = tab.locator("#hognose-stick .well").first
    stick.wait_for()
    tab.keyboard.down("r")
    _until(lambda: _depth(page) > 0.2)
    box = stick.bounding_box()
    assert box is not None
    tab.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.25 * box["height"])
    _until(lambda: page.stick.warning.startswith("Stopped"))
    _settle(tab)


def budget(page: Page, tab: Tab) -> None:
    """The arm where tolerances leave least, and what they take of each link."""
    tab.get_by_text("tolerances", exact=True).click()
    tab.locator(".hognose-links").wait_for()
    assert page.plan is not None
    step = page.plan.check("clearance_at_steps").step
    assert step is not None
    _go(page, tab, step)


def _go(page: Page, tab: Tab, row: int) -> None:
    """Show a step, from nearer than the first view, which holds the arm as it was before it went in."""
    page.timeline.go(row)
    plan = page.plan
    assert plan is not None
    seen = np.concatenate([plan.body[row], plan.way_points, mount_at(plan, row).reshape(-1, 3)])
    page.stage.frame_camera(with_space(seen, plan.task.placed_scene))
    _settle(tab)


def _depth(page: Page) -> float:
    return page.steering.steered.depth if page.steering.steered is not None else 0.0


def _until(holds: Callable[[], bool]) -> None:
    begin = time.monotonic()
    while not holds():
        assert time.monotonic() - begin < PATIENCE, "the arm did not come so far"
        time.sleep(0.05)


def _settle(tab: Tab) -> None:
    """Let the browser receive all and draw it: what is received takes several frames to be shown."""
    tab.wait_for_timeout(4000)
    tab.evaluate(f"""() => new Promise((done) => {{
        let left = {FRAMES};
        const next = () => (left-- > 0 ? requestAnimationFrame(next) : done());
        next();
    }})""")


#: Each picture: a bundled task, and what is done before the picture is taken.
PICTURES: dict[str, tuple[str, Callable[[Page, Tab], None]]] = {
    "viewer": ("pipe-tank", under_way),
    "viewer-not-good": ("pipe-tank", not_good),
    "viewer-steering": ("pipe-tank", steering),
    "viewer-tolerances": ("tolerances", budget),
    "viewer-obstacle-array": ("obstacle-array", under_way),
    "viewer-detour": ("detour", under_way),
    "viewer-step-tank": ("step-tank", under_way),
    "viewer-find-a-way": ("find-a-way", under_way),
}

if __name__ == "__main__":
    main(sys.argv[1:])
