"""Chromium without a window, for what is measured and tested in a real browser."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
#: It may run as root in a container, and draws with the processor where there is no graphics card.
FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-dev-shm-usage",
]


@contextmanager
def browser() -> Iterator[Browser]:
    """A browser, closed at the end."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    assert found, f"one of {', '.join(NAMES)} is needed; on Debian: apt-get install chromium"
    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=found, args=FLAGS)
        yield chromium
        chromium.close()
