"""What a browser may send to viser: messages that its page makes, in the shapes in which it makes them.

viser takes any of its messages from anybody and believes what is in them; what does not fit ends its handlers with a
traceback, or breaks what is shown to everybody. So nothing comes through that the page would not have sent.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

import msgspec

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection

Handler = Callable[[Any], Awaitable[None]]

#: No message but a picture is longer (bytes).
LONGEST = 100_000
#: A websocket that speaks another language is closed with this code, "policy violation", and a reason of this length.
_NOT_UNDERSTOOD, _LONGEST_REASON = 1008, 120


class Misunderstood(Exception):  # noqa: N818 -- it is no error of ours, and never leaves this room
    """A message that the page does not send; says what was expected."""


class Sieved:
    """A browser's websocket of which only messages are heard that are understood; at any other it is closed.

    Parameters
    ----------
    connection
    fields
        Gives viser's fields, when they are there.
    """

    def __init__(self, connection: ServerConnection, fields: Callable[[], viser.GuiApi | None]) -> None:
        self._connection, self._fields = connection, fields

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    async def recv(self) -> str | bytes:
        """The next message that is to be heeded."""
        while True:
            message = await self._connection.recv()
            try:
                if is_heeded(message, self._fields()):
                    return message
            except Misunderstood as error:
                await self._connection.close(_NOT_UNDERSTOOD, str(error)[:_LONGEST_REASON])


def sieved(handler: Handler, fields: Callable[[], viser.GuiApi | None]) -> Handler:
    """A handler of websockets that hears only what viser's page says."""

    async def handle(connection: Any) -> None:
        await handler(Sieved(connection, fields))

    return handle


def is_heeded(message: str | bytes, gui: viser.GuiApi | None) -> bool:
    """Whether a message means something; a choice that is not offered, or not any more, means nothing.

    Parameters
    ----------
    message
    gui
        Has the fields that people may set; None for none.

    Raises
    ------
    Misunderstood
        The page sends no such message.
    """
    if isinstance(message, str):
        raise Misunderstood("expected a binary message")
    try:
        said = msgspec.msgpack.decode(message)
    except (msgspec.DecodeError, ValueError, RecursionError):
        raise Misunderstood("expected a message in msgpack") from None
    kind = said.pop("type", None) if isinstance(said, dict) else None
    if not isinstance(kind, str) or kind not in _FIELDS:
        raise Misunderstood("expected a message of a type that this page sends")
    if len(message) > LONGEST and kind != "GetRenderResponseMessage":
        raise Misunderstood(f"{kind}: expected at most {LONGEST:,} bytes")
    fields = _FIELDS[kind]
    if said.keys() != fields.keys():
        raise Misunderstood(f"{kind}: expected the fields {', '.join(fields)}")
    for name, fits in fields.items():
        if not fits(said[name]):
            raise Misunderstood(f"{kind}: {name} is not what was expected")
    if kind == "ViewerCameraMessage":
        return said["position"] != said["look_at"]
    if kind == "GuiUpdateMessage" and gui is not None:
        return _is_offered(said["updates"]["value"], gui._gui_input_handle_from_uuid.get(said["uuid"]))
    return True


def _is_offered(value: Any, field: Any) -> bool:
    """Whether a field may be given a value; one that is not there any more may be given any, nobody heeds it.

    Raises
    ------
    Misunderstood
        The value is of another type than the field.
    """
    if field is None:
        return True
    now = field.value
    if isinstance(now, bool | str):
        fits = isinstance(value, type(now))
    elif isinstance(now, tuple):
        fits = _are_numbers(len(now))(value)
    else:
        fits = _is_number(value)
    if not fits:
        raise Misunderstood(f"GuiUpdateMessage: expected a {type(now).__name__} for this field")
    options = getattr(field, "options", None)
    return options is None or value in options


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= LONGEST


def _are_numbers(count: int) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and len(value) == count and all(map(_is_number, value))


#: The messages that the page sends, with what their fields must be.
_FIELDS: dict[str, dict[str, Callable[[Any], bool]]] = {
    "GuiUpdateMessage": {"uuid": _is_text, "updates": lambda said: isinstance(said, dict) and said.keys() == {"value"}},
    "CommandTriggerMessage": {"uuid": _is_text},
    "TransformControlsDragStartMessage": {"name": _is_text, "owner": _is_text},
    "TransformControlsUpdateMessage": {
        "name": _is_text,
        "wxyz": _are_numbers(4),
        "position": _are_numbers(3),
        "owner": _is_text,
    },
    "TransformControlsDragEndMessage": {"name": _is_text, "owner": _is_text},
    "GetRenderResponseMessage": {"payload": lambda said: isinstance(said, bytes), "render_uuid": _is_text},
    "ViewerCameraMessage": {
        "wxyz": _are_numbers(4),
        "position": _are_numbers(3),
        "fov": lambda said: _is_number(said) and 0 < said < math.pi,
        "near": _is_number,
        "far": _is_number,
        "image_height": _is_size,
        "image_width": _is_size,
        "look_at": _are_numbers(3),
        "up_direction": _are_numbers(3),
    },
}
