"""A page under test: served from a thread, looked at in Chromium."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from playwright.sync_api import Browser, ConsoleMessage
from playwright.sync_api import Page as Tab

from hognose.viewer.opening import opened
from hognose.viewer.page import Page

#: Without a GPU a browser makes few frames a second: states are waited for this long (s).
PATIENCE = 60.0


@contextmanager
def running(source: str) -> Iterator[Page]:
    """A page that is kept up to date by a thread of its own."""
    with opened(source, port=0) as page:
        stop = threading.Event()

        def run() -> None:
            while not stop.is_set():
                page.run(0.1)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        try:
            yield page
        finally:
            stop.set()
            thread.join(10)


@contextmanager
def looked_at(chromium: Browser, page: Page) -> Iterator[Tab]:
    """A tab on the page; at the end there must have been no error in it, and nothing asked of another host."""
    tab = chromium.new_page(viewport={"width": 960, "height": 620})
    errors: list[str] = []
    tab.on("console", lambda message: errors.extend(_errors(message)))
    tab.on("pageerror", lambda error: errors.append(str(error)))
    own = (f"http://127.0.0.1:{page.address.port}/", "data:", "blob:")
    tab.on("request", lambda request: None if request.url.startswith(own) else errors.append(request.url))
    tab.goto(page.address.url)
    wait(lambda: len(page.server.get_clients()) > 0)
    yield tab
    tab.close()
    assert errors == []


def _errors(message: ConsoleMessage) -> list[str]:
    return [message.text] if message.type == "error" else []


def wait(holds: Callable[[], object], what: str = "") -> None:
    """Until something holds, or the test fails."""
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, what or "it did not come to hold"
        time.sleep(0.05)


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
