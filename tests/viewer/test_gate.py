"""The viewer's door: real servers, knocked at over HTTP and as a websocket."""

import html
import logging
import re
import socket
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
import viser
import websockets.asyncio.server
import websockets.datastructures
import websockets.exceptions
from knocking import ask, cookie, dial, farewell, status
from viser import _messages
from viser import _viser as viser_module
from viser.infra import _infra
from workbench_makers import LONG

from hognose.errors import HognoseError, InputError, MissingExtraError
from hognose.viewer.server import free_port as listening
from hognose.viewer.server import gate
from hognose.viewer.server.gate import Address, open_server

Served = tuple[viser.ViserServer, Address]


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    server, address = open_server(port=0)
    yield server, address
    server.stop()


@pytest.fixture(scope="module")
def other() -> Iterator[Served]:
    """A second viewer at the same time."""
    server, address = open_server(port=0)
    yield server, address
    server.stop()


@pytest.fixture(scope="module")
def everywhere() -> Iterator[Served]:
    server, address = open_server("0.0.0.0", port=0)
    yield server, address
    server.stop()


def refused(address: Address, **how: Any) -> bool:
    try:
        dial(address, **how).close()
    except websockets.exceptions.InvalidStatus as error:
        return error.response.status_code == 403
    return False


# --- token and cookie


def test_without_a_token_nobody_comes_in(served: Served) -> None:
    response, body = ask(served[1])
    assert response.status == 403
    assert b"address that the command printed" in body
    assert response.headers["Cache-Control"] == "no-store"
    assert "html" not in response.headers["Content-Type"]


@pytest.mark.parametrize("token", ["", "wrong", "%ff%00", "%C3%A9", "%ED%B3%BF"])
def test_a_wrong_token_does_not_open(served: Served, token: str) -> None:
    assert status(served[1], f"/?token={token}") == 403
    assert status(served[1], Cookie=f"hognose_{served[1].port}={token}") == 403


def test_bytes_that_are_no_text_do_not_open(served: Served) -> None:
    _, address = served
    for line, more in (
        (b"/?token=\xff%ff", b""),
        (b"/\xff", b""),
        (b"/", f"Cookie: {cookie(address, 'ä')}\r\n".encode()),
    ):
        with socket.create_connection(("127.0.0.1", address.port), LONG) as visitor:
            host = f"Host: 127.0.0.1:{address.port}\r\n".encode()
            visitor.sendall(b"GET " + line + b" HTTP/1.1\r\n" + host + more + b"\r\n")
            assert visitor.recv(100).startswith(b"HTTP/1.1 403")


def test_two_tokens_do_not_open(served: Served) -> None:
    assert status(served[1], f"/?token=wrong&token={served[1].token}") == 403
    assert status(served[1], f"/?token={served[1].token}&token=wrong") == 403


def test_the_token_becomes_a_cookie(served: Served) -> None:
    _, address = served
    assert address.url == f"http://127.0.0.1:{address.port}/?token={address.token}"
    response, body = ask(address, f"/?token={address.token}")
    assert (response.status, leads_to(body)) == (200, "/")
    assert address.token.encode() not in body
    value, *attributes = response.headers["Set-Cookie"].split("; ")
    assert value == cookie(address)
    assert set(attributes) == {"HttpOnly", "SameSite=Strict", "Path=/"}
    assert response.headers["Cache-Control"] == "no-store"
    assert response.headers["Referrer-Policy"] == "no-referrer"


@pytest.mark.parametrize(
    ("path", "location"),
    [
        ("/a/b.html", "/a/b.html"),
        ("//evil.example/", "/evil.example/"),
        ("/\\evil.example", "/"),
        ("//[", "/%5B"),
        ("/;url=//evil.example", "/%3Burl%3D//evil.example"),
        ("/'\"><script>", "/%27%22%3E%3Cscript%3E"),
        ("/a%20b", "/a%20b"),
    ],
)
def test_the_way_on_stays_here(served: Served, path: str, location: str) -> None:
    response, body = ask(served[1], f"{path}?token={served[1].token}&more=1")
    assert (response.status, leads_to(body)) == (200, location)


def leads_to(page: bytes) -> str:
    """Where a page leads on to."""
    found = re.search(rb'<meta http-equiv="refresh" content="0;url=([^"]*)">', page)
    assert found
    return html.unescape(found[1].decode())


def test_with_the_cookie_the_page_comes(served: Served) -> None:
    response, body = ask(served[1], Cookie=f"theme=dark; hognose_{served[1].port}=planted; {cookie(served[1])}")
    assert response.status == 200
    assert b"<html" in body
    assert response.headers.get_all("X-Frame-Options") == ["DENY"]
    assert response.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert response.headers["Referrer-Policy"] == "no-referrer"
    assert response.headers["X-Content-Type-Options"] == "nosniff"


def test_a_file_that_is_not_there_is_told_only_to_a_guest(served: Served) -> None:
    assert status(served[1], "/nothing") == 403
    assert status(served[1], "/nothing", Cookie=cookie(served[1])) == 404


def test_two_viewers_do_not_share_a_token(served: Served, other: Served) -> None:
    (_, one), (_, two) = served, other
    assert one.port != two.port
    assert one.token != two.token
    assert status(two, f"/?token={one.token}") == 403
    assert status(two, Cookie=cookie(two, one.token)) == 403
    assert status(two, Cookie=cookie(one)) == 403
    assert status(two, Cookie=f"{cookie(one)}; {cookie(two)}") == 200


def test_the_token_is_not_shown_by_accident(served: Served) -> None:
    assert served[1].token not in repr(served[1])


# --- host and origin


@pytest.mark.parametrize("name", ["127.0.0.1:{}", "localhost:{}", "LOCALHOST:{}", "[::1]:{}"])
def test_our_names_are_known(served: Served, name: str) -> None:
    host = name.format(served[1].port)
    assert status(served[1], Host=host, Cookie=cookie(served[1])) == 200
    assert status(served[1], Host=host, Origin=f"http://{host}", Cookie=cookie(served[1])) == 200


@pytest.mark.parametrize("name", ["evil.example:{}", "127.0.0.1", "127.0.0.1:1", "127.0.0.1.evil.example:{}", "", "@"])
def test_other_names_are_refused(served: Served, name: str) -> None:
    _, address = served
    host = name.format(address.port)
    assert status(address, Host=host, Cookie=cookie(address)) == 403
    assert status(address, f"/?token={address.token}", Host=host) == 403
    assert status(address, Host=host, Origin=f"http://{host}", Cookie=cookie(address)) == 403


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "https://127.0.0.1:{}",
        "http://127.0.0.1:1",
        "http://127.0.0.1",
        "http://localhost:{}",
    ],
)
def test_pages_of_others_are_refused(served: Served, origin: str) -> None:
    _, address = served
    origin = origin.format(address.port)
    assert status(address, Origin=origin, Cookie=cookie(address)) == 403
    assert status(address, f"/?token={address.token}", Origin=origin) == 403
    assert refused(address, origin=origin, cookie=cookie(address))


# --- websocket


def test_a_websocket_of_our_page_is_accepted(served: Served) -> None:
    with dial(served[1], cookie=cookie(served[1])) as socket_:
        assert socket_.subprotocol == f"viser-v{viser.__version__}"
        assert len(socket_.recv(timeout=LONG)) > 16


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"cookie": "hognose=1"},
        {"query": "?token={token}"},
        {"origin": None, "cookie": "hognose_{port}={token}"},
        {"cookie": "hognose_{port}=wrong"},
    ],
    ids=["no cookie", "another cookie", "token in the URL", "no origin", "wrong cookie"],
)
def test_other_websockets_are_refused(served: Served, how: dict[str, str | None]) -> None:
    _, address = served
    filled = {k: v and v.format(port=address.port, token=address.token) for k, v in how.items()}
    assert refused(address, **filled)


def test_an_upgrade_by_another_spelling_is_no_way_round(served: Served) -> None:
    for value in ("WebSocket", "websocket, h2c", "h2c"):
        assert status(served[1], Upgrade=value, Connection="Upgrade") == 403
        assert status(served[1], Upgrade=value, Connection="Upgrade", Cookie=cookie(served[1])) == 403


# --- the tunnel


def test_a_client_cannot_open_a_tunnel(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    server, address = served
    opened: list[str] = []

    def tunnel(*_: Any) -> None:
        opened.append("tunnel")
        raise RuntimeError("a tunnel was asked for")

    monkeypatch.setattr(viser_module, "ViserTunnel", tunnel)
    heard: list[object] = []

    def hear(_client: object, message: object) -> None:
        heard.append(message)

    messages = (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect)
    handlers = server._websock_server
    assert not any(handlers._incoming_handlers.get(message) for message in messages)
    handlers.register_handler(_messages.ShareUrlRequest, hear)
    for kind in ("ShareUrlRequest", "ShareUrlDisconnect"):
        with dial(address, cookie=cookie(address)) as socket_:
            socket_.send(msgspec.msgpack.encode({"type": kind}))
            assert farewell(socket_) == (1008, "expected a message of a type that this page sends")
    handlers.unregister_handler(_messages.ShareUrlRequest)
    # What viser would have left to its threads is done when as many errands as it has threads are done.
    barrier = threading.Barrier(server._thread_executor._max_workers)
    for errand in [server._thread_executor.submit(barrier.wait, LONG) for _ in range(barrier.parties)]:
        errand.result(timeout=LONG)
    assert (heard, opened) == ([], [])

    with pytest.raises(HognoseError, match="not shared"):
        server.request_share_url()
    assert opened == []
    with pytest.raises(RuntimeError, match="asked for"):  # the spy stands where viser would go
        viser.ViserServer.request_share_url(server)
    assert opened == ["tunnel"]


# --- where it listens


def test_it_listens_on_this_machine_only(monkeypatch: pytest.MonkeyPatch) -> None:
    bound: list[socket.socket] = []
    listen = socket.create_server
    monkeypatch.setattr(socket, "create_server", lambda *a, **k: bound.append(listen(*a, **k)) or bound[-1])
    begun: list[Any] = []
    start = websockets.asyncio.server.Server.wrap
    monkeypatch.setattr(
        websockets.asyncio.server.Server, "wrap", lambda self, server: (begun.append(server), start(self, server))[1]
    )
    server, address = open_server(port=0)
    try:
        assert [s.getsockname() for s in bound] == [("127.0.0.1", address.port)]
        assert [s.getsockname() for one in begun for s in one.sockets] == [("127.0.0.1", address.port)]
        assert server.get_port() == address.port != 0
    finally:
        server.stop()


def test_a_port_that_is_taken_is_passed_over() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        asked = taken.getsockname()[1]
        server, address = open_server(port=asked)
        try:
            assert asked < address.port < asked + 50
            assert status(address, Cookie=cookie(address)) == 200
        finally:
            server.stop()


@pytest.mark.parametrize(
    ("host", "port", "said"),
    [("192.0.2.1", 0, "192.0.2.1"), ("", 0, "''"), ("127.0.0.1", 70000, "70000"), ("no such host", 0, "no such host")],
)
def test_what_cannot_be_listened_on_is_said(host: str, port: int, said: str) -> None:
    with pytest.raises(InputError, match=said):
        open_server(host, port)


def test_all_ports_taken_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listening, "TRIES", 1)
    with (
        socket.create_server(("127.0.0.1", 0)) as taken,
        pytest.raises(InputError, match="are all taken"),
    ):
        open_server(port=taken.getsockname()[1])


def test_on_all_networks_only_this_machine_is_meant(everywhere: Served) -> None:
    _, address = everywhere
    assert address.url == f"http://127.0.0.1:{address.port}/?token={address.token}"
    for name in ("127.0.0.1", "localhost", socket.gethostname()):
        assert status(address, Host=f"{name}:{address.port}", Cookie=cookie(address)) == 200
    for name in ("evil.example", "192.0.2.1", "0.0.0.0"):
        assert status(address, Host=f"{name}:{address.port}", Cookie=cookie(address)) == 403
    assert status(address) == 403


def test_an_address_of_this_machine_is_one_that_was_reached() -> None:
    wide, narrow = gate._Gate("0.0.0.0", "0.0.0.0", 8080), gate._Gate("lab.example", "192.0.2.7", 80)
    assert wide.knows("192.0.2.9:8080", "192.0.2.9")
    assert not wide.knows("192.0.2.9:8080", "192.0.2.8")
    assert not wide.knows("192.0.2.9:8081", "192.0.2.9")
    assert gate._Gate("::", "::", 8080).knows("[2001:db8::1]:8080", "2001:db8::1")
    for name in ("lab.example", "LAB.example:80", "192.0.2.7", "localhost"):  # of port 80, browsers say nothing
        assert narrow.knows(name, "192.0.2.7")
    assert not narrow.knows("192.0.2.9", "192.0.2.9")
    assert not narrow.knows("192.0.2.9:80", "192.0.2.9")
    assert narrow.name == "lab.example:80"


# --- the rest of viser


def test_other_servers_are_left_alone() -> None:
    before = websockets.asyncio.server.serve
    with socket.create_server(("127.0.0.1", 0)) as listener:
        own = gate._Gate("127.0.0.1", *listener.getsockname())
        with gate._guarded(gate._Marked("127.0.0.1"), own, listener):
            assert websockets.asyncio.server.serve is not before
            plain = viser.ViserServer("127.0.0.1", 0, verbose=False)
    assert websockets.asyncio.server.serve is before
    try:
        assert not own.guards
        assert status(Address("127.0.0.1", plain.get_port(), "", "")) == 200
    finally:
        plain.stop()


def test_viewers_opened_at_once_have_gates_of_their_own() -> None:
    with ThreadPoolExecutor(4) as pool:
        opened = list(pool.map(lambda _: open_server(port=0), range(4)))
    try:
        for _, one in opened:
            assert status(one) == 403
            assert [status(one, Cookie=cookie(one, two.token)) for _, two in opened].count(200) == 1
    finally:
        for server, _ in opened:
            server.stop()
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"


def test_viser_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    server, address = open_server(port=0)
    with dial(address, cookie=cookie(address)) as socket_:
        socket_.recv(timeout=LONG)
    server.stop()
    print("still heard")
    assert capfd.readouterr() == ("still heard\n", "")


def test_who_talks_no_http_fills_no_log(
    served: Served, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    logger = logging.getLogger("hognose.viewer.websockets")
    monkeypatch.setattr(logger, "filters", [])  # viser added one of its own at its first guest
    assert gate._logger() is logger
    with caplog.at_level(logging.ERROR), socket.create_connection(("127.0.0.1", served[1].port), LONG) as visitor:
        visitor.sendall(b"POST / HTTP/1.1\r\n\r\n")
        assert b" 200 " not in visitor.recv(100)
    assert status(served[1]) == 403
    assert caplog.records == []


def test_without_viser_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingExtraError, match=r'pip install "hognose\[view\]"'):
        open_server(port=0)


# --- a viser that is made otherwise


def test_a_viser_that_goes_round_the_gate_is_not_served(monkeypatch: pytest.MonkeyPatch) -> None:
    own = SimpleNamespace(serve=websockets.asyncio.server.serve, ServerConnection=None)
    elsewhere = SimpleNamespace(
        asyncio=SimpleNamespace(server=own),
        datastructures=websockets.datastructures,
        exceptions=websockets.exceptions,
    )
    monkeypatch.setattr(_infra, "websockets", elsewhere)
    before = threading.active_count()
    with pytest.raises(HognoseError, match=r"could not be made safe.*not started as expected.*pip install viser"):
        open_server(port=0)
    assert threading.active_count() <= before


def test_a_gate_that_stands_open_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gate._Gate, "_answer", lambda *_: None)
    with pytest.raises(HognoseError, match=r"a visitor without a token \(status 200\)"):
        open_server(port=0)


def test_a_gate_that_lets_websockets_through_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    real = gate._Gate._answer
    monkeypatch.setattr(gate._Gate, "_answer", lambda *a: None if "Upgrade" in a[2].headers else real(*a))
    with pytest.raises(HognoseError, match=r"a visitor without a token \(status 101\)"):
        open_server(port=0)


def test_a_viser_without_the_message_is_not_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(_messages, "ShareUrlDisconnect")
    with pytest.raises(HognoseError, match="could not be made safe"):
        open_server(port=0)


def test_a_viser_that_never_comes_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    real = websockets.asyncio.server.serve
    monkeypatch.setattr(websockets.asyncio.server, "serve", real)  # so that it is put back
    monkeypatch.setattr(gate, "_PATIENCE", 0.2)
    go = threading.Event()
    late: list[object] = []

    def slow(host: str, port: int, **_: Any) -> None:
        go.wait(LONG)
        late.append(websockets.asyncio.server.serve)

    monkeypatch.setattr(viser, "ViserServer", slow)
    with pytest.raises(HognoseError, match=r"not ready after 0\.2 s"):
        open_server(port=0)
    go.set()
    for thread in threading.enumerate():
        if thread.name == "hognose-viewer-start":
            thread.join(LONG)
    assert len(late) == 1
    assert late[0] is not real  # if it does come, the gate is there
