"""Opening the browser on a page whose address holds a secret.

Every user of a machine sees the arguments of a browser in the list of processes. So the browser is given a file that
only its owner can read, and that leads on to the page.
"""

from __future__ import annotations

import html
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath


def leading_to(address: str) -> str:
    """A page that leads on to an address at once, and leaves itself out of the way back."""
    there = html.escape(address)
    return (
        '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer"><title>Hognose</title>'
        '<link rel="icon" href="data:,">'  # else a browser asks for one, which is not there
        f'<meta http-equiv="refresh" content="0;url={there}"><a href="{there}">Hognose</a>\n'
    )


@contextmanager
def redirect_file(address: str) -> Iterator[FilePath]:
    """A file for the browser, in a folder of its own that is taken away at the end; nobody else can read either."""
    folder = FilePath(tempfile.mkdtemp(prefix="hognose-"))  # for its owner only
    try:
        file = folder / "open.html"
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as stream:
            stream.write(leading_to(address))
        yield file
    finally:
        shutil.rmtree(folder, ignore_errors=True)
