"""The stick that drives the nose: on the screen, held keys or a gamepad, as `stick.js` reads them in the browser."""

from __future__ import annotations

import itertools
import json
import time
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from hognose.viewer.addition import Addition

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

#: A hand that has said nothing for so long (s) has let go: its browser is gone, busy or out of sight.
DEAD_MAN = 0.4
#: No message of the script is longer (characters).
_LONGEST = 200
#: A websocket that speaks another language is closed with this code, "policy violation".
_NOT_UNDERSTOOD = 1008


@dataclass(frozen=True)
class Deflection:
    """How far the stick is pushed, each from -1 to 1: to the right and up, looking out of the nose, and onwards."""

    right: float = 0.0
    up: float = 0.0
    on: float = 0.0


class Stick:
    """All hands on the stick. What they push adds up; one that says nothing any more has let go.

    Attributes
    ----------
    steering
        Whether somebody steers; the stick is shown only then.
    words, warning
        What is shown beside it: how the arm stands, and what holds it.
    """

    def __init__(self) -> None:
        self.steering, self.words, self.warning = False, "", ""
        self._hands: dict[int, tuple[Deflection, float]] = {}
        self._numbers = itertools.count()

    @property
    def addition(self) -> Addition:
        """The script that reads it in a browser, and who answers that."""
        script = resources.files("hognose.viewer").joinpath("stick.js").read_text(encoding="utf-8")
        return Addition(script, self.talk)

    @property
    def deflection(self) -> Deflection:
        """How far it is pushed now."""
        oldest = time.monotonic() - DEAD_MAN
        hands = [(hand.right, hand.up, hand.on) for hand, said in list(self._hands.values()) if said >= oldest]
        right, up, on = np.clip(np.sum([(0.0, 0.0, 0.0), *hands], axis=0), -1.0, 1.0)
        reach = max(1.0, float(np.hypot(right, up)))  # a stick moves within a circle
        return Deflection(float(right) / reach, float(up) / reach, float(on))

    async def talk(self, connection: ServerConnection) -> None:
        """Listen to a browser, and answer each message with what it is to show."""
        from websockets.exceptions import ConnectionClosed

        number = next(self._numbers)
        try:
            with suppress(ConnectionClosed):
                async for message in connection:
                    pushed = understood(message)
                    if pushed is None:
                        await connection.close(_NOT_UNDERSTOOD)
                        return
                    self._hands[number] = pushed, time.monotonic()
                    shown = {"steering": self.steering, "words": self.words, "warning": self.warning}
                    await connection.send(json.dumps(shown))
        finally:
            self._hands.pop(number, None)


def understood(message: str | bytes) -> Deflection | None:
    """What a message of the script says, three numbers; None if it says nothing of the kind."""
    if len(message) > _LONGEST:
        return None
    try:
        said = json.loads(message)
        right, up, on = np.asarray(said, dtype=np.float64)
    except (ValueError, TypeError):
        return None
    if not np.isfinite([right, up, on]).all():
        return None
    right, up, on = np.clip([right, up, on], -1.0, 1.0)
    return Deflection(float(right), float(up), float(on))
