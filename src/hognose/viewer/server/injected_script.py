"""What Hognose adds to viser's page: a script of its own, and the websocket through which that talks."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

Talk = Callable[["ServerConnection"], Awaitable[None]]

#: Where the script and its websocket are found.
SCRIPT, SOCKET = "/hognose.js", "/hognose"
#: What is put into the page, before its end.
TAG = f'<script src="{SCRIPT}" defer></script>'.encode()
_END = b"</body>"


@dataclass(frozen=True)
class Addition:
    """A script and who answers it.

    Attributes
    ----------
    script
        The text of the script.
    talk
        Called with each websocket that the script opens; the socket closes when it returns.
    """

    script: str
    talk: Talk

    def routed(self, others: Talk) -> Talk:
        """A handler of websockets: ours for ours, that of `others` for the rest."""

        async def handle(connection: ServerConnection) -> None:
            ours = connection.request is not None and _path(connection.request) == SOCKET
            await (self.talk if ours else others)(connection)

        return handle

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The script if that is asked for; what viser is asked for is asked for in a form that `put_into` reads."""
        if _path(request) == SCRIPT and "Upgrade" not in request.headers:
            return answered(connection, self.script, "text/javascript")
        if "Accept-Encoding" in request.headers:
            del request.headers["Accept-Encoding"]
        return None

    def put_into(self, response: Response | None) -> Response | None:
        """Viser's answer, with the script in it if it is the page."""
        if response is not None and response.headers.get("Content-Type", "").startswith("text/html"):
            response.body = response.body.replace(_END, TAG + _END)
            del response.headers["Content-Length"]
            response.headers["Content-Length"] = str(len(response.body))
        return response


def answered(connection: ServerConnection, text: str, kind: str) -> Response:
    """A text of a kind, such as text/html, as the answer to a request."""
    response = connection.respond(HTTPStatus.OK, text)
    del response.headers["Content-Type"]  # setting it adds a second one
    response.headers["Content-Type"] = f"{kind}; charset=utf-8"
    return response


def _path(request: Request) -> str:
    return request.path.partition("?")[0]
