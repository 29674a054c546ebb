"""The stick: what a browser may say, and that a hand which says nothing has let go."""

from __future__ import annotations

import http.client
import json
import math

import pytest
import websockets.exceptions
from websockets.sync.client import ClientConnection, connect
from workbench_makers import eventually

from hognose.errors import HognoseError
from hognose.viewer import addition
from hognose.viewer.addition import SCRIPT, SOCKET, TAG
from hognose.viewer.gate import Address, open_server
from hognose.viewer.stick import Deflection, Stick, understood


@pytest.fixture(scope="module")
def served():
    stick = Stick()
    server, address = open_server(port=0, addition=stick.addition)
    yield stick, address
    server.stop()


def took_hold(address: Address, origin: str = "ours", cookie: str | None = "ours") -> ClientConnection:
    """A browser's websocket to the stick."""
    held = f"hognose_{address.port}={address.token if cookie == 'ours' else cookie}"
    return connect(
        f"ws://127.0.0.1:{address.port}{SOCKET}",
        origin=f"http://127.0.0.1:{address.port}" if origin == "ours" else origin,  # pyright: ignore[reportArgumentType]
        additional_headers={} if cookie is None else {"Cookie": held},
        proxy=None,
    )


def asked(address: Address, path: str, cookie: bool = True) -> tuple[int, str, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", address.port, timeout=5)
    headers = {"Cookie": f"hognose_{address.port}={address.token}"} if cookie else {}
    connection.request("GET", path, headers={"Accept-Encoding": "gzip", **headers})
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, response.headers.get("Content-Type", ""), body


@pytest.mark.parametrize(
    "message",
    [
        "",
        "{}",
        "1",
        "[1, 2]",
        "[1, 2, 3, 4]",
        "[NaN, 0, 0]",
        "[0, Infinity, 0]",
        '["a", 0, 0]',
        "[null, 0, 0]",
        "[[0], 0, 0]",
        "[" * 100_000,
        "[0, 0, " + "0" * 200 + "]",
        b"\xff\xfe[0]",
    ],
)
def test_what_is_no_deflection_is_not_understood(message):
    assert understood(message) is None


def test_a_deflection_is_understood_within_its_bounds():
    assert understood("[0.5, -0.25, 1]") == Deflection(0.5, -0.25, 1.0)
    assert understood(b"[7, -7, 1e300]") == Deflection(1.0, -1.0, 1.0)


def test_a_push_arrives_and_the_answer_says_what_to_show(served):
    stick, address = served
    stick.steering, stick.words, stick.warning = True, "nose 3 mm in", "Held: wall"
    with took_hold(address) as hand:
        hand.send("[0.3, -0.4, 1]")
        assert json.loads(hand.recv(5)) == {"steering": True, "words": "nose 3 mm in", "warning": "Held: wall"}
        assert stick.deflection == Deflection(0.3, -0.4, 1.0)


def test_a_hand_that_says_nothing_has_let_go(served):
    stick, address = served
    with took_hold(address) as hand:
        hand.send("[0, 0, 1]")
        hand.recv(5)
        assert stick.deflection.on == 1
        eventually(lambda: stick.deflection == Deflection())
        assert stick._hands


def test_a_connection_that_is_gone_has_let_go_at_once(served):
    stick, address = served
    with took_hold(address) as hand:
        hand.send("[0, 0, 1]")
        hand.recv(5)
    eventually(lambda: not stick._hands)
    assert stick.deflection == Deflection()


def test_two_hands_add_up_within_a_circle(served):
    stick, address = served
    with took_hold(address) as one, took_hold(address) as other:
        one.send("[1, 0, 1]")
        one.recv(5)
        other.send("[0, 1, -1]")
        other.recv(5)
        pushed = stick.deflection
    assert (pushed.right, pushed.up, pushed.on) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.0))


def test_who_talks_nonsense_is_sent_away(served):
    stick, address = served
    with took_hold(address) as hand:
        hand.send("advance!")
        with pytest.raises(websockets.exceptions.ConnectionClosed) as closed:
            hand.recv(5)
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1008
    assert stick.deflection == Deflection()


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
