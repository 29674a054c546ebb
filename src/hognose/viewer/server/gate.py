"""The door of the viewer: a viser server that answers only to whom the command gave its address.

viser on its own listens on all networks, asks nobody who they are, takes the word of any web page that the
browser happens to show, and opens a public tunnel when a client asks for one. Here it listens on this machine
only, wants a token, checks `Host` and `Origin`, and has no tunnel.
"""

from __future__ import annotations

import hmac
import inspect
import ipaddress
import logging
import queue
import secrets
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, quote

import rich

from hognose.errors import HognoseError, MissingExtraError
from hognose.viewer.server.free_port import listen
from hognose.viewer.server.injected_script import TAG, Addition, answered
from hognose.viewer.server.redirect import leading_to

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

_LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
_REFUSAL = "Not open. Copy the whole address that the command printed into the browser's address bar.\n"
#: How long viser may take to start, s; and to answer a request, s.
_PATIENCE, _ANSWER = 60.0, 60.0
_HEADERS = {
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
#: Held while websockets' `serve` is replaced.
_replacing = threading.Lock()


@dataclass(frozen=True)
class Address:
    """Where a viewer is found.

    Attributes
    ----------
    host
        The name or the IP address it listens on.
    port
        The port it got, which may be another than was asked for.
    token
        The secret that opens it; neither it nor the URL is shown by `repr`.
    url
        What to open in a browser. If it listens on all networks, this is the URL on its own machine; from
        another, put the machine's name or IP address in its place.
    """

    host: str
    port: int
    token: str = field(repr=False)
    url: str = field(repr=False)


def open_server(
    host: str = "127.0.0.1", port: int = 8080, title: str = "Hognose", addition: Addition | None = None
) -> tuple[viser.ViserServer, Address]:
    """Start a viser server behind a token; stop it with its `stop`.

    Parameters
    ----------
    host
        What to listen on. Anything but this machine's loopback shows the plan to whoever gets hold of the URL on
        the way, which is not encrypted.
    port
        The port, or the next that is free; 0 for any.
    title
        Stands above the panel.
    addition
        What the page is given besides viser's.

    Raises
    ------
    MissingExtraError
        Without the extra `view`.
    InputError
        If the host or the port cannot be listened on.
    HognoseError
        If the server does not keep out a visitor without a token, as it may be with another version of viser.
    """
    try:
        import viser
    except ImportError:
        raise MissingExtraError(
            'the viewer needs the package viser; install it with: pip install "hognose[view]"'
        ) from None
    listener = listen(host, port)
    gate = _Gate(host, *listener.getsockname()[:2], addition=addition)
    server = None
    try:
        server = _start(gate, listener, title)
        gate.fields = server.gui
        _close_tunnel(server)
        _prove(server, gate)
    except BaseException as error:
        with suppress(Exception):
            if server is not None:
                server.stop()
        listener.close()
        if not isinstance(error, Exception):
            raise
        # Whatever went wrong, it was in viser: nothing of it is served that was not seen to be closed.
        raise HognoseError(
            f"the viewer was not opened, as viser {viser.__version__} could not be made safe: "
            f"{error or type(error).__name__}; try version 1.1.1, which Hognose was tested with: "
            "pip install viser==1.1.1"
        ) from error
    return server, Address(host, gate.port, gate.token, f"http://{gate.name}/?token={gate.token}")


class _Gate:
    """Who may come in."""

    def __init__(self, host: str, bound: str, port: int, addition: Addition | None = None) -> None:
        self.port = port
        self.addition = addition
        self.token = secrets.token_urlsafe(32)
        # Cookies are shared by all ports of a host: with one name, two viewers would lock each other out.
        self.cookie = f"hognose_{port}"
        self.guards = False
        self.fields: viser.GuiApi | None = None
        self.everywhere = ipaddress.ip_address(bound.partition("%")[0]).is_unspecified
        v6 = ":" in bound
        if self.everywhere:
            self.reach = "::1" if v6 else "127.0.0.1"
            self.name = f"{_literal(self.reach)}:{port}"
            more = (socket.gethostname(),)
        else:
            self.reach = bound
            self.name = f"{_literal(host)}:{port}"
            more = (_literal(host), _literal(bound))
        self.names = {f"{name.lower()}:{port}" for name in (*_LOOPBACK, *more)}
        if port == 80:  # which browsers leave away
            self.names |= {name.removesuffix(":80") for name in self.names}

    async def answer(self, connection: ServerConnection, request: Request, inner: Callable[..., Any] | None) -> Any:
        """Answer a request, with `inner` if it may come in; None lets a websocket open."""
        response = self._answer(connection, request)
        if response is None and self.addition is not None:
            response = self.addition.answer(connection, request)
        if response is None and inner is not None:
            try:
                response = inner(connection, request)
                if inspect.isawaitable(response):
                    response = await response
            except (OSError, ValueError):  # a name that no file can have
                response = connection.respond(HTTPStatus.NOT_FOUND, "There is no such file.\n")
            if self.addition is not None:
                response = self.addition.put_into(response)
        if response is not None:
            for name, value in _HEADERS.items():
                response.headers[name] = value
        return response

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Refuse or redirect a request, or let it pass."""
        path, _, query = request.path.partition("?")
        upgrade = "Upgrade" in request.headers
        tokens = parse_qs(query, keep_blank_values=True).get("token", [])
        if not self._is_for_us(connection, request, upgrade):
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSAL)
        if tokens and not upgrade:
            if len(tokens) > 1 or not self._is_token(tokens[0]):
                return connection.respond(HTTPStatus.FORBIDDEN, _REFUSAL)
            return self._welcome(connection, path)
        if not any(self._is_token(value) for value in _cookies(request, self.cookie)):
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSAL)
        return None

    def _is_for_us(self, connection: ServerConnection, request: Request, upgrade: bool) -> bool:
        """Whether a request calls us by a name of ours and comes from no page but ours."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or not self.knows(hosts[0], connection.local_address[0]):
            return False  # another name that leads here: DNS rebinding
        # The same port too: a page of another port counts as the same site, and so the cookie comes with it.
        return origins == [f"http://{hosts[0]}"] or (not origins and not upgrade)

    def knows(self, host: str, local: str) -> bool:
        """Return whether a `Host` is ours, in a request that came to the IP address `local`."""
        if host.lower() in self.names:
            return True
        # Listening on all addresses: the one that was reached is one of this machine.
        return self.everywhere and host.lower() == f"{_literal(local)}:{self.port}"

    def _is_token(self, said: str) -> bool:
        return hmac.compare_digest(said.encode("utf-8", "replace"), self.token.encode())

    def _welcome(self, connection: ServerConnection, path: str) -> Response:
        """Take the token out of the address bar and into a cookie, which is sent where a page of ours leads on to."""
        # Two slashes in front would lead to another host.
        plain = path.isascii() and path.isprintable() and "\\" not in path
        there = quote("/" + path.lstrip("/"), safe="/%") if plain else "/"
        response = answered(connection, leading_to(there), "text/html")
        response.headers["Set-Cookie"] = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
        return response


def _literal(host: str) -> str:
    """A host as it stands in a URL."""
    return f"[{host}]" if ":" in host else host


def _cookies(request: Request, name: str) -> list[str]:
    """All cookies of that name: a page of another port may have set one more."""
    pairs = [part.strip().partition("=") for part in ";".join(request.headers.get_all("Cookie")).split(";")]
    return [value for key, _, value in pairs if key == name]


def _start(gate: _Gate, listener: socket.socket, title: str) -> viser.ViserServer:
    """Start viser behind the gate, within bounds: it waits without end for a server thread that has died."""
    import viser

    host = _Marked("127.0.0.1")
    made: queue.SimpleQueue[viser.ViserServer | Exception] = queue.SimpleQueue()

    def work() -> None:
        _hush()
        try:
            made.put(viser.ViserServer(host=host, port=gate.port, label=title, verbose=False))
        except Exception as error:
            made.put(error)

    with _guarded(host, gate, listener):
        threading.Thread(target=work, name="hognose-viewer-start", daemon=True).start()
        try:
            server = made.get(timeout=_PATIENCE)
        except queue.Empty:
            raise TimeoutError(f"it was not ready after {_PATIENCE:g} s") from None
    if isinstance(server, Exception):
        raise server
    return server


class _Marked(str):
    """A string that is told from its equals: viser hands it on as it is, to `serve`."""

    __slots__ = ()


@contextmanager
def _guarded(host: str, gate: _Gate, listener: socket.socket) -> Iterator[None]:
    """Have websockets put the gate before the server that is started for `host`, which is told by identity."""
    from websockets.asyncio import server as module

    from hognose.viewer.server.incoming import sieved

    def serve(handler: Any, its_host: Any = None, its_port: Any = None, **options: Any) -> Any:
        if its_host is not host:
            return real(handler, its_host, its_port, **options)
        _hush()  # in viser's server thread
        inner = options.get("process_request")
        options["process_request"] = lambda connection, request: gate.answer(connection, request, inner)
        gate.guards = True
        handler = sieved(handler, lambda: gate.fields)
        if gate.addition is not None:
            handler = gate.addition.routed(handler)
        return real(handler, sock=listener, logger=_logger(), server_header=None, **options)

    with _replacing:
        real = module.serve
        module.serve = serve
        yield  # left by an error, that is before viser was ready, the gate stays: viser may come late
        module.serve = real


def _logger() -> logging.Logger:
    """A logger that does not show a traceback for each visitor who talks no HTTP."""
    logger = logging.getLogger("hognose.viewer.websockets")
    logger.addFilter(_is_worth_saying)
    return logger


def _is_worth_saying(record: logging.LogRecord) -> bool:
    return record.getMessage() != "opening handshake failed"


def _hush() -> None:
    """Keep what this thread prints with rich off the standard output, which is the command's; viser prints a lot."""
    rich.get_console().begin_capture()  # a capture is of one thread, and this one never ends


def _close_tunnel(server: viser.ViserServer) -> None:
    """Take away what would show the server to the world: any client may ask for it."""
    from viser import _messages

    server._websock_server.unregister_handler(_messages.ShareUrlRequest)
    server._websock_server.unregister_handler(_messages.ShareUrlDisconnect)

    def refuse(verbose: bool = True) -> str | None:
        raise HognoseError("the viewer is not shared through viser's public tunnel; use an SSH tunnel to its port")

    server.request_share_url = refuse


def _prove(server: viser.ViserServer, gate: _Gate) -> None:
    """Knock without a token, as a page and as a websocket, and with one; an error if it is not as it should be."""
    if not gate.guards or server.get_port() != gate.port:
        raise HognoseError("its server was not started as expected")
    upgrade = {
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "MDEyMzQ1Njc4OWFiY2RlZg==",
        "Origin": f"http://{gate.name}",
    }
    for headers in ({}, upgrade):
        status = _knock(gate, headers)[0]
        if status != HTTPStatus.FORBIDDEN:
            raise HognoseError(f"its server answered a visitor without a token (status {status})")
    if gate.addition is not None:
        status, page = _knock(gate, {"Cookie": f"{gate.cookie}={gate.token}"})
        if status != HTTPStatus.OK or TAG not in page:
            raise HognoseError(f"its page has no place for Hognose's script (status {status})")


def _knock(gate: _Gate, headers: dict[str, str]) -> tuple[int, bytes]:
    """What the server answers."""
    connection = HTTPConnection(gate.reach, gate.port, timeout=_ANSWER)
    try:
        connection.request("GET", "/", headers={"Host": gate.name, **headers})
        response = connection.getresponse()
        return response.status, response.read()
    except (OSError, HTTPException) as error:
        raise HognoseError(f"its server gave no answer ({error or type(error).__name__})") from error
    finally:
        connection.close()
