"""The link with the token: not in the list of processes, and in no file that others can read."""

from __future__ import annotations

import html
import os
import re
import stat
import threading
import webbrowser
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest
from knocking import CAMERA, cookie, dial, encode, status
from workbench_makers import LONG, eventually

from hognose.cli.view import view
from hognose.viewer.page import Page
from hognose.viewer.server.gate import Address
from hognose.viewer.server.redirect import redirect_file


def mode(file: Path) -> int:
    return stat.S_IMODE(file.stat().st_mode)


def test_the_file_is_its_owners_and_gone_afterwards():
    mask = os.umask(0)
    try:
        with redirect_file("http://127.0.0.1:1/?token=abc&x='\"<>") as file:
            assert (mode(file), mode(file.parent)) == (0o600, 0o700)
            found = re.search(r'content="0;url=([^"]*)"', file.read_text())
            assert found
            assert html.unescape(found[1]) == "http://127.0.0.1:1/?token=abc&x='\"<>"
        assert not file.parent.exists()
        with pytest.raises(KeyboardInterrupt), redirect_file("http://x/") as file:
            raise KeyboardInterrupt
        assert not file.parent.exists()
    finally:
        os.umask(mask)


def test_the_command_tells_the_browser_nothing_secret_and_takes_the_file_away_when_it_is_in(monkeypatch, capsys):
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    over = threading.Event()

    def run(page: Page) -> None:
        """A browser comes by the file; then the command is interrupted."""
        (address,) = opened
        assert page.address.token not in address
        file = Path(unquote(urlparse(address).path))
        assert page.address.token in file.read_text()
        assert (mode(file), mode(file.parent)) == (0o600, 0o700)
        assert status(page.address, f"/?token={page.address.token}") == 200
        with dial(page.address, cookie=cookie(page.address)) as visitor:
            visitor.send(encode(CAMERA))
            eventually(lambda: not file.exists())
        over.set()
        raise KeyboardInterrupt

    monkeypatch.setattr(Page, "run", run)
    assert view("sjtu-25dof", port=0) == 0
    assert over.wait(LONG)
    assert "?token=" in capsys.readouterr().out  # whoever has no browser here copies it
    assert not Path(unquote(urlparse(opened[0]).path)).parent.exists()


def test_without_a_browser_no_file_is_written(monkeypatch, capsys):
    monkeypatch.setattr(webbrowser, "open", lambda _: pytest.fail("a browser was opened"))

    def run(page: Page) -> None:
        assert isinstance(page.address, Address)
        raise KeyboardInterrupt

    monkeypatch.setattr(Page, "run", run)
    assert view("sjtu-25dof", port=0, browser=False, json=True) == 0
    assert "token" in capsys.readouterr().out
