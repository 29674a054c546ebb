"""What a browser says: nothing that it may say ends the page, leaves a traceback, or goes without an answer."""

from __future__ import annotations

import asyncio
import gc
import math
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from knocking import CAMERA, cookie, dial, encode, farewell, status
from workbench_makers import LONG, eventually, small

from hognose.viewer.model.freshness import CALM
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.page import Page
from hognose.viewer.server.incoming import LONGEST, Misunderstood, Sieved, is_heeded
from hognose.viewer.server.injected_script import SOCKET

DRAG = {"type": "TransformControlsUpdateMessage", "name": "/stops/1", "wxyz": [1, 0, 0, 0], "owner": ""}
DRAG = {**DRAG, "position": [0.02, 0.01, 0.2]}
SET = {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}}
PRESS = {"type": "CommandTriggerMessage", "uuid": "x"}


def field(value: Any, **more: Any) -> Any:
    """Fields of which one, x, has a value."""
    return SimpleNamespace(_gui_input_handle_from_uuid={"x": SimpleNamespace(value=value, **more)})


@pytest.mark.parametrize("said", [CAMERA, DRAG, SET, PRESS])
def test_what_the_page_says_is_heeded(said):
    assert is_heeded(encode(said), None)


def wrong() -> Iterator[tuple[str, Any]]:
    """Messages that the page never sends."""
    yield from {"text": "{}", "empty": b"", "cut": encode(CAMERA)[:-3], "more": encode(CAMERA) + b"x"}.items()
    yield "deep", b"\x91" * 90_000 + b"\xc0"
    for name, said in (("null", None), ("list", [CAMERA]), ("no type", {"uuid": "x"}), ("a type", {"type": 1})):
        yield name, encode(said)
    for kind in ("ShareUrlRequest", "FileTransferStartUpload", "GuiFormSubmitMessage", "Message", "__class__", "\0"):
        yield kind, encode({**PRESS, "type": kind})
    for said in (CAMERA, DRAG, SET, PRESS):
        yield f"more of {said['type']}", encode({**said, "owner_": "x"})
        for key in sorted(said.keys() - {"type"}):
            yield f"no {key} in {said['type']}", encode({k: v for k, v in said.items() if k != key})
            for odd in (
                None,
                {},
                [],
                [1, 2],
                [math.nan] * 3,
                [math.nan] * 4,
                ["a"] * 3,
                [[0]] * 3,
                math.inf,
                True,
                b"x",
            ):
                yield f"{odd!r} for {key} in {said['type']}", encode({**said, key: odd})
    yield "another property", encode({**SET, "updates": {"update_cb": []}})
    yield "two properties", encode({**SET, "updates": {"value": 1, "options": []}})
    yield "huge", encode({**PRESS, "uuid": "x" * LONGEST})


WRONG = dict(wrong())


@pytest.mark.parametrize("message", WRONG.values(), ids=WRONG.keys())
def test_what_it_does_not_say_is_not_understood(message):
    with pytest.raises(Misunderstood):
        is_heeded(message, None)


@pytest.mark.parametrize(
    ("now", "values"),
    [
        (True, [1, 0.0, "true", None]),
        ("a", [1, None, b"a", ["a"]]),
        (1.0, ["1", None, True, math.nan, math.inf, [1.0]]),
        (1, ["1", math.nan, -math.inf]),
        ((0.0, 0.0, 0.0), [1.0, [1.0, 2.0], [1.0, 2.0, math.nan], "abc", [1, 2, 3, 4]]),
    ],
)
def test_a_value_of_another_type_than_the_field_is_not_understood(now, values):
    assert is_heeded(encode({**SET, "updates": {"value": now}}), field(now))
    for value in values:
        with pytest.raises(Misunderstood):
            is_heeded(encode({**SET, "updates": {"value": value}}), field(now))


def test_a_choice_that_is_not_offered_any_more_and_a_camera_that_looks_at_nothing_are_passed_over():
    chosen = {**SET, "updates": {"value": "c"}}
    assert is_heeded(encode(chosen), field("a", options=("a", "c")))
    assert not is_heeded(encode(chosen), field("a", options=("a", "b")))
    assert is_heeded(encode(chosen), SimpleNamespace(_gui_input_handle_from_uuid={}))  # pyright: ignore[reportArgumentType]
    assert not is_heeded(encode({**CAMERA, "look_at": CAMERA["position"]}), None)


keys = st.sampled_from([*CAMERA, *DRAG, *SET, "owner"])
values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers(-(2**63), 2**63) | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from([CAMERA, DRAG, SET, PRESS]), st.dictionaries(keys, values, max_size=3) | st.binary(max_size=50))
@settings(max_examples=300, deadline=None)
def test_whatever_is_said_is_understood_or_not_and_nothing_else(said, odd):
    message = odd if isinstance(odd, bytes) else encode({**said, **odd})
    try:
        heeded = is_heeded(message, field("a"))
    except Misunderstood:
        return
    assert heeded in (True, False)


def test_what_is_passed_over_is_not_heard_and_what_is_not_understood_closes():
    messages = [encode({**CAMERA, "look_at": CAMERA["position"]}), encode(PRESS), b"\xc1"]
    closed: list[tuple[int, str]] = []

    class Browser:
        async def recv(self) -> bytes:
            if closed:
                raise ConnectionError
            return messages.pop(0)

        async def close(self, code: int, reason: str) -> None:
            closed.append((code, reason))

    async def listen() -> list[Any]:
        heard, sieved = [], Sieved(Browser(), lambda: None)  # pyright: ignore[reportArgumentType]
        while True:
            try:
                heard.append(await sieved.recv())
            except ConnectionError:
                return heard

    assert asyncio.run(listen()) == [encode(PRESS)]
    assert closed == [(1008, "expected a message in msgpack")]


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page at work."""
    folder = tmp_path_factory.mktemp("fuzz")
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("HOGNOSE_CACHE", str(folder / "cache"))
        page = Page(Workbench(small(), folder=folder), port=0)
        over = threading.Event()

        def run() -> None:
            while not over.is_set():
                page.run(0.05)

        thread = threading.Thread(target=run)
        thread.start()
        yield page
        over.set()
        thread.join()
        page.close()


@pytest.fixture
def page(running, capfd, caplog) -> Iterator[Page]:
    """A page that goes on, with nothing in its logs and on its standard error but what the test leaves there."""
    yield running
    assert running.bench.settle(LONG) is not None
    eventually(lambda: not running._later.qsize())
    assert status(running.address, Cookie=cookie(running.address)) == 200
    with guest(running) as visitor:
        visitor.send(encode(CAMERA))
        eventually(lambda: len(running.server.get_clients()) == 1)
    eventually(lambda: not running.server.get_clients())
    gc.collect()  # tasks whose exception nobody took say so when they are gone
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")


def guest(page: Page) -> Any:
    return dial(page.address, cookie=cookie(page.address))


def test_who_talks_nonsense_is_told_so_and_the_page_goes_on(page):
    for name in ("text", "empty", "cut", "deep", "__class__", "another property", "huge"):
        with guest(page) as visitor:
            visitor.send(encode(CAMERA))
            visitor.send(WRONG[name])
            code, reason = farewell(visitor)
        assert code == 1008, name
        assert "expected" in reason, name


def test_a_message_that_is_too_large_to_be_taken_in_closes(page):
    with guest(page) as visitor:
        visitor.send(b"\0" * (51 * 2**20))
        assert farewell(visitor)[0] == 1009


ODD_TEXTS = ["", "\0", "a\0.toml", "../../etc/x.toml", "/x.toml", "x" * 90_000, "\u202e\ud7ff", "C:\\x", "%s{}<b>[]()"]
ODD_NUMBERS = [0, -1, 1, 1e308, -1e308, 1e-320, 2**63, 0.5, -0.0]


def odd_values(handle: Any) -> list[Any]:
    """What a browser may say for a field, however unlikely."""
    if options := getattr(handle, "options", None):
        return [*options, *ODD_TEXTS]
    if isinstance(handle.value, bool):
        return [True, False]
    if isinstance(handle.value, str):
        return ODD_TEXTS
    if isinstance(handle.value, tuple):
        return [[x] * len(handle.value) for x in ODD_NUMBERS]
    return ODD_NUMBERS


def test_whatever_is_typed_is_answered_and_the_page_goes_on(page, monkeypatch):
    told: list[str] = []
    for part in (page.editing, page.steering, page.sharing):
        monkeypatch.setattr(part, "_say", told.append)
    monkeypatch.setattr(page.bench, "search", lambda seconds: told.append(f"search {seconds}"))
    slow = ("Picture", "Video", "Report", "Recording", "Restart at the entrance", "Make it the task")
    handles = dict(page.server.gui._gui_input_handle_from_uuid)
    with guest(page) as visitor:
        visitor.send(encode(CAMERA))
        eventually(lambda: page.server.get_clients())
        for uuid, handle in handles.items():
            if handle.label.startswith(slow):
                continue
            for value in odd_values(handle):
                visitor.send(encode({**SET, "uuid": uuid, "updates": {"value": value}}))
        for place in ([1e308] * 3, [1e-320] * 3, [2**63] * 3, [0, 0, 0], [0.02, 0.01, 0.2]):
            visitor.send(encode({**DRAG, "position": place}))
        for button in ("task", "plan"):
            for name in ODD_TEXTS:
                visitor.send(encode({**SET, "uuid": page.editing._file._impl.uuid, "updates": {"value": name}}))
                visitor.send(encode({**SET, "uuid": page.editing._save._impl.uuid, "updates": {"value": button}}))
        eventually(lambda: "\n".join(told).count("too long") >= 2)
        margin = page.editing._margin
        visitor.send(encode({**SET, "uuid": margin._impl.uuid, "updates": {"value": 2.5}}))
        eventually(lambda: page.bench.spec.margin == 0.0025)
        page.server._thread_executor.submit(lambda: None).result(LONG)
    page.bench.settle(LONG)
    said = "\n".join(told)
    for words in (
        "does not name a file",
        "control characters",
        "files are written within",
        "too long",
        "expected 0 to 100",
    ):
        assert words in said, words
    assert not [file for file in Path(page.bench.folder).rglob("*.toml") if file.stem in ("x", "a")]


def test_a_message_for_the_stick_that_is_none_closes_and_the_page_goes_on(page):
    for nonsense in ("{", b"\xff", "[NaN]", "x" * 2**20):
        with dial(page.address, cookie=cookie(page.address), query=SOCKET[1:]) as visitor:
            visitor.send(nonsense)
            code, reason = farewell(visitor)
            assert (code, reason[:16]) == (1008, 'expected {"hand"')


#: Requests that get no page.
REFUSED = [
    b"GET /%00 HTTP/1.1",
    b"GET /" + b"x" * 300 + b" HTTP/1.1",
    b"GET /" + b"x" * 5000 + b" HTTP/1.1",
    b"GET /" + b"x" * 100_000 + b" HTTP/1.1",
    b"GET /%ff%fe HTTP/1.1",
    b"GET /../../../etc/passwd HTTP/1.1",
    b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1",
    b"GET //etc/passwd HTTP/1.1",
    b"GET /?token=%00 HTTP/1.1",
    b"GET /hognose?%00=%00 HTTP/1.1",
    b"POST / HTTP/1.1",
    b"GET / HTTP/9.9",
    b"\0\xff\xfe",
    b"",
]


def test_a_request_for_what_cannot_be_gets_no_page(page):
    host = f"Host: 127.0.0.1:{page.address.port}\r\nCookie: {cookie(page.address)}\r\n".encode()
    for line in REFUSED:
        with socket.create_connection(("127.0.0.1", page.address.port), LONG) as visitor:
            visitor.sendall(line + b"\r\n" + host + b"\r\n")
            visitor.shutdown(socket.SHUT_WR)
            answer = visitor.recv(1000)
        assert b" 200 " not in answer, line
        assert b" 500 " not in answer, line
        assert b"root:" not in answer, line


def test_edits_of_the_fields_are_shown_after_all_that(page):
    page.bench.edit(lambda spec: spec.model_copy(update={"margin": 0.005}))
    eventually(lambda: page.editing._margin.value == 5.0)
    eventually(lambda: page._verdict_panel._words.content.startswith(("### GOOD", "### NO")))
    assert CALM < 1
