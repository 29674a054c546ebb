"""The stick: what a browser may say, and that a hand which says nothing has let go."""

from __future__ import annotations

import http.client
import json
import math

import pytest
import websockets.exceptions
from hypothesis import given, settings
from hypothesis import strategies as st
from websockets.sync.client import ClientConnection, connect
from websockets.sync.connection import Connection
from workbench_makers import LONG, eventually

from hognose.errors import HognoseError
from hognose.viewer.server import injected_script as addition
from hognose.viewer.server.gate import Address, open_server
from hognose.viewer.server.injected_script import SCRIPT, SOCKET, TAG
from hognose.viewer.server.stick import DEAD_MAN, Deflection, Pushed, Stick, understood


class Clock:
    """A clock that the test winds."""

    def __init__(self):
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture(scope="module")
def door():
    stick = Stick(Clock())
    server, address = open_server(port=0, addition=stick.addition)
    yield stick, address
    server.stop()


@pytest.fixture
def served(door):
    """The stick and where it is, with no hand on it."""
    stick, address = door
    eventually(lambda: not stick._hands)
    stick.steering, stick.words, stick.warning = False, "", ""
    stick._clock.now += 10.0
    return stick, address


def says(hand=(0, 0, 0), **pads) -> str:
    """What the script says."""
    return json.dumps({"hand": hand, "gamepads": pads})


def push(hand: Connection, *pushed: float, **pads: tuple[float, float, float]) -> None:
    """Say something, and wait until it was heard."""
    hand.send(says(pushed or (0, 0, 0), **pads))
    hand.recv(LONG)


def took_hold(address: Address, origin: str = "ours", cookie: str | None = "ours") -> ClientConnection:
    """A browser's websocket to the stick."""
    held = f"hognose_{address.port}={address.token if cookie == 'ours' else cookie}"
    return connect(
        f"ws://127.0.0.1:{address.port}{SOCKET}",
        origin=f"http://127.0.0.1:{address.port}" if origin == "ours" else origin,  # pyright: ignore[reportArgumentType]
        additional_headers={} if cookie is None else {"Cookie": held},
        proxy=None,
        open_timeout=LONG,
    )


def asked(address: Address, path: str, cookie: bool = True) -> tuple[int, str, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", address.port, timeout=LONG)
    headers = {"Cookie": f"hognose_{address.port}={address.token}"} if cookie else {}
    connection.request("GET", path, headers={"Accept-Encoding": "gzip", **headers})
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, response.headers.get("Content-Type", ""), body


NO_PUSH = ["{}", "1", "[1, 2]", "[1, 2, 3, 4]", "[NaN, 0, 0]", "[0, Infinity, 0]", "[0, -Infinity, 0]", '["a", 0, 0]',
           '["1", 0, 0]', "[true, 0, 0]", "[null, 0, 0]", "[[0], 0, 0]", "null", '"abc"', "[0, 0, 1e999]"]  # fmt: skip


@pytest.mark.parametrize(
    "message",
    [
        "",
        "{}",
        "1",
        "null",
        "[0, 0, 0]",
        '{"hand": [0, 0, 0]}',
        '{"gamepads": {}}',
        '{"hand": [0, 0, 0], "gamepads": {}, "more": 1}',
        '{"hand": [0, 0, 0], "gamepads": []}',
        '{"hand": [0, 0, 0], "gamepads": {}',
        "[" * 1_900,
        "[" * 100_000,
        says((0, 0, 0), **{f"pad {k}": (0, 0, 0) for k in range(5)}),
        says((0, 0, 0), **{"x" * 2000: (0, 0, 0)}),
        b"\xff\xfe[0]",
        b"\0",
        *(f'{{"hand": {no}, "gamepads": {{}}}}' for no in NO_PUSH),
        *(f'{{"hand": [0, 0, 0], "gamepads": {{"pad": {no}}}}}' for no in NO_PUSH),
    ],
)
def test_what_is_no_push_is_not_understood(message):
    assert understood(message) is None


@given(st.binary(max_size=60) | st.text(max_size=60) | st.recursive(st.none() | st.floats() | st.text(), st.lists))
@settings(deadline=None)
def test_whatever_is_said_is_a_push_or_not_understood(said):
    message = said if isinstance(said, str | bytes) else json.dumps({"hand": said, "gamepads": {}})
    pushed = understood(message)
    assert pushed is None or all(-1 <= x <= 1 for x in (pushed.hand.right, pushed.hand.up, pushed.hand.on))


def test_a_push_is_understood_within_its_bounds():
    assert understood(says((0.5, -0.25, 1))) == Pushed(Deflection(0.5, -0.25, 1.0))
    assert understood(says((7, -7, 1e300)).encode()) == Pushed(Deflection(1.0, -1.0, 1.0))
    assert understood(says((10**400, -(10**400), 0))) == Pushed(Deflection(1.0, -1.0, 0.0))
    assert understood(says((0, 0, 0), pad=(0, 1, 2))) == Pushed(Deflection(), {"pad": Deflection(0.0, 1.0, 1.0)})


def test_a_push_arrives_and_the_answer_says_what_to_show(served):
    stick, address = served
    stick.steering, stick.words, stick.warning = True, "nose 3 mm in", "Held: wall"
    with took_hold(address) as hand:
        hand.send(says((0.3, -0.4, 1)))
        assert json.loads(hand.recv(LONG)) == {"steering": True, "words": "nose 3 mm in", "warning": "Held: wall"}
        assert stick.deflection == Deflection(0.3, -0.4, 1.0)


def test_a_hand_that_says_nothing_has_let_go(served):
    stick, address = served
    with took_hold(address) as hand:
        push(hand, 0, 0, 1, pad=(1, 0, 0))
        stick._clock.now += 0.99 * DEAD_MAN
        assert stick.deflection == Deflection(1, 0, 1)
        stick._clock.now += 0.02 * DEAD_MAN
        assert stick.deflection == Deflection()
        assert stick._hands
        push(hand, 0, 0, -1)
        assert stick.deflection == Deflection(0, 0, -1)


def test_a_connection_that_is_gone_has_let_go_at_once(served):
    stick, address = served
    with took_hold(address) as hand:
        push(hand, 0, 0, 1)
    eventually(lambda: not stick._hands)
    assert stick.deflection == Deflection()


def test_two_hands_add_up_within_a_circle(served):
    stick, address = served
    with took_hold(address) as one, took_hold(address) as other:
        push(one, 1, 0, 1)
        push(other, 0, 1, -1)
        pushed = stick.deflection
    assert (pushed.right, pushed.up, pushed.on) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.0))


def test_a_gamepad_that_several_pages_see_counts_once_as_the_last_one_says(served):
    stick, address = served
    with took_hold(address) as one, took_hold(address) as other:
        push(one, 0.1, 0, 0, pad=(0.4, 0, 0.25))
        push(other, 0, 0, 0, pad=(0.4, 0, 0.25))
        assert stick.deflection == Deflection(0.5, 0.0, 0.25)  # with the one hand, which adds up
        stick._clock.now += 0.01
        push(one, 0, 0, 0, pad=(-0.2, 0, 0))
        assert stick.deflection == Deflection(-0.2, 0.0, 0.0)
        push(one, 0, 0, 0)
        assert stick.deflection == Deflection(0.4, 0.0, 0.25)
        push(one, 0, 0, 0, another=(0.3, 0, -0.25))
        pushed = stick.deflection
    assert (pushed.right, pushed.up, pushed.on) == pytest.approx((0.7, 0.0, 0.0))


@pytest.mark.parametrize("nonsense", ["advance!", b"\0\xff", "[" * 1_900, "x" * 300_000])
def test_who_talks_nonsense_is_told_what_is_expected_and_the_others_are_still_heard(served, nonsense, caplog):
    stick, address = served
    with took_hold(address) as other, took_hold(address) as hand:
        push(other, 0, 0, 0.5)
        hand.send(nonsense)
        with pytest.raises(websockets.exceptions.ConnectionClosed) as closed:
            hand.recv(LONG)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008
        assert closed.value.rcvd.reason.startswith('expected {"hand"')
        push(other, 0, 0, 0.25)
        assert stick.deflection == Deflection(0, 0, 0.25)
    assert caplog.records == []


@pytest.mark.parametrize("how", [{"origin": "http://evil.example"}, {"cookie": None}, {"cookie": "wrong"}])
def test_only_our_page_may_take_hold(served, how):
    with pytest.raises(websockets.exceptions.InvalidStatus) as refused:
        took_hold(served[1], **how)
    assert refused.value.response.status_code == 403


def test_the_page_brings_the_script_and_only_to_guests(served):
    _, address = served
    status, kind, page = asked(address, "/")
    assert (status, page.count(TAG)) == (200, 1)
    assert kind.startswith("text/html")
    status, kind, script = asked(address, SCRIPT)
    assert (status, kind) == (200, "text/javascript; charset=utf-8")
    assert b"getGamepads" in script
    assert asked(address, SCRIPT, cookie=False)[0] == 403


def test_a_page_without_a_place_for_the_script_is_not_served(monkeypatch):
    monkeypatch.setattr(addition, "_END", b"</nothing>")
    with pytest.raises(HognoseError, match="no place for Hognose's script"):
        open_server(port=0, addition=Stick().addition)
