"""Knocking at the viewer's door, over HTTP and as a websocket."""

from __future__ import annotations

import http.client
from typing import Any

import msgspec
import viser
import websockets.exceptions
from websockets.sync.client import connect
from workbench_makers import LONG

from hognose.viewer.server.gate import Address

encode = msgspec.msgpack.encode
#: What a browser says first: from where it looks.
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0.0, 0.0, -1.0],
    "fov": 1.3,
    "near": 0.01,
    "far": 1000,
    "image_height": 620,
    "image_width": 960,
    "look_at": [0, 0, 0],
    "up_direction": [0, 1, 0],
}


def ask(address: Address, path: str = "/", **headers: str) -> tuple[http.client.HTTPResponse, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", address.port, timeout=LONG)
    try:
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        return response, response.read()
    finally:
        connection.close()


def status(address: Address, path: str = "/", **headers: str) -> int:
    return ask(address, path, **headers)[0].status


def cookie(address: Address, token: str | None = None) -> str:
    return f"hognose_{address.port}={token or address.token}"


def dial(address: Address, origin: str | None = "ours", cookie: str | None = None, **more: Any) -> Any:
    """Open a websocket as a browser would."""
    return connect(
        f"ws://127.0.0.1:{address.port}/{more.pop('query', '')}",
        origin=f"http://127.0.0.1:{address.port}" if origin == "ours" else origin,  # pyright: ignore[reportArgumentType]
        additional_headers={"Cookie": cookie} if cookie else {},
        subprotocols=[f"viser-v{viser.__version__}"],  # pyright: ignore[reportArgumentType]
        open_timeout=LONG,
        close_timeout=1,
        proxy=None,
        max_size=None,
        **more,
    )


def farewell(socket: Any) -> tuple[int, str]:
    """Code and reason with which a server closes a websocket, whatever it says before."""
    try:
        while True:
            socket.recv(timeout=LONG)
    except websockets.exceptions.ConnectionClosed as closed:
        rcvd = closed.rcvd
    return (0, "") if rcvd is None else (rcvd.code, rcvd.reason)
