"""A page under test: served from a thread, looked at in Chromium."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import numpy as np
from playwright.sync_api import Browser, ConsoleMessage
from playwright.sync_api import Page as Tab
from workbench_makers import LONG, eventually

from hognose.planning import Task
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.opening import opened
from hognose.viewer.page import Page

#: Sizes of a window: pictures of a small one are drawn sooner where there is no GPU. The stick needs some width.
SMALL, WIDE, LARGE = (640, 360), (960, 360), (960, 620)
#: Without a GPU a page that draws as often as it can leaves no processor to what is tested: 5 pictures a second do.
FEW_PICTURES = """
  window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 200);
  window.cancelAnimationFrame = (number) => clearTimeout(number);
"""


@contextmanager
def running(source: str | Task, lit: bool = False) -> Iterator[Page]:
    """A page that is kept up to date by a thread of its own.

    Unless it is lit as usual, its space has only lamps: without a GPU it takes seconds to make light of a picture of
    surroundings, each time that a browser comes.
    """
    with closing(Page(Workbench(source), port=0)) if isinstance(source, Task) else opened(source, port=0) as page:
        if not lit:
            page.server.scene.configure_environment_map(None)
        with kept_up(page):
            yield page


@contextmanager
def kept_up(page: Page) -> Iterator[None]:
    """A thread keeps a page up to date, until the end."""
    stop = threading.Event()

    def run() -> None:
        while not stop.is_set():
            page.run(0.1)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(LONG)


@contextmanager
def looked_at(chromium: Browser, page: Page, size: tuple[int, int] = SMALL) -> Iterator[Tab]:
    """A tab on the page; at the end there must have been no error in it, and nothing asked of another host."""
    tab = chromium.new_page(viewport={"width": size[0], "height": size[1]})
    try:
        tab.set_default_timeout(1e3 * LONG)
        tab.add_init_script(FEW_PICTURES)
        errors: list[str] = []
        tab.on("console", lambda message: errors.extend(_errors(message)))
        tab.on("pageerror", lambda error: errors.append(str(error)))
        own = (f"http://127.0.0.1:{page.address.port}/", "data:", "blob:")
        tab.on("request", lambda request: None if request.url.startswith(own) else errors.append(request.url))
        before = len(page.server.get_clients())
        tab.goto(page.address.url)
        wait(lambda: len(page.server.get_clients()) > before, "the browser did not come in")
        yield tab
        assert errors == [], errors
    finally:
        tab.close()


def _errors(message: ConsoleMessage) -> list[str]:
    return [message.text] if message.type == "error" else []


def wait(holds: Callable[[], object], what: str = "it did not come to hold") -> None:
    """Until something holds, or the test fails."""
    eventually(lambda: bool(holds()), what)


def on_screen(page: Page, tab: Tab, place: np.ndarray) -> tuple[float, float]:
    """Where in a tab, in pixels, a place (3,) m of the space is seen."""
    camera = next(iter(page.server.get_clients().values())).camera
    canvas = tab.locator("canvas").first.bounding_box()
    assert canvas is not None
    ahead = camera.look_at - camera.position
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up_direction)
    right = right / np.linalg.norm(right)
    up = np.cross(right, ahead)
    off = place - camera.position
    scale = 0.5 * canvas["height"] / np.tan(camera.fov / 2) / (off @ ahead)
    return (
        canvas["x"] + 0.5 * canvas["width"] + scale * (off @ right),
        canvas["y"] + 0.5 * canvas["height"] - scale * (off @ up),
    )
