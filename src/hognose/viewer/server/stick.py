"""The stick that drives the nose: on the screen, held keys or a gamepad, as `stick.js` reads them in the browser."""

from __future__ import annotations

import itertools
import json
import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from hognose.viewer.server.injected_script import Addition

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

#: A hand that has said nothing for so long (s) has let go: its browser is gone, busy or out of sight.
DEAD_MAN = 0.4
#: No message of the script is longer (characters), and none tells of more gamepads.
_LONGEST, _MOST_PADS = 2000, 4
#: A websocket that speaks another language is closed with this code, "policy violation".
_NOT_UNDERSTOOD = 1008
_EXPECTED = 'expected {"hand": [right, up, on], "gamepads": {name: [right, up, on]}}, numbers from -1 to 1'


@dataclass(frozen=True)
class Deflection:
    """How far the stick is pushed, each from -1 to 1: to the right and up, looking out of the nose, and onwards."""

    right: float = 0.0
    up: float = 0.0
    on: float = 0.0


@dataclass(frozen=True)
class Pushed:
    """What one browser says: what its hand and keys push, and each gamepad that it sees, by name."""

    hand: Deflection = Deflection()
    gamepads: Mapping[str, Deflection] = field(default_factory=dict)


@dataclass(frozen=True)
class _Said:
    """What a browser said last, from which machine, and when (s)."""

    pushed: Pushed
    machine: str
    at: float


class Stick:
    """All hands on the stick. What they push adds up; one that says nothing any more has let go.

    A gamepad is seen by every page on its machine: it counts once, as the page says that was heard last.

    Parameters
    ----------
    clock
        The time, s.

    Attributes
    ----------
    steering
        Whether somebody steers; the stick is shown only then.
    words, warning
        What is shown beside it: how the arm stands, and what holds it.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.steering, self.words, self.warning = False, "", ""
        self._clock = clock
        self._hands: dict[int, _Said] = {}
        self._numbers = itertools.count()

    @property
    def addition(self) -> Addition:
        """The script that reads it in a browser, and who answers that."""
        script = resources.files("hognose.viewer.server").joinpath("stick.js").read_text(encoding="utf-8")
        return Addition(script, self.talk)

    @property
    def deflection(self) -> Deflection:
        """How far it is pushed now."""
        oldest = self._clock() - DEAD_MAN
        heard = sorted((said for said in list(self._hands.values()) if said.at >= oldest), key=lambda said: said.at)
        pads = {(said.machine, name): push for said in heard for name, push in said.pushed.gamepads.items()}
        pushes = [(push.right, push.up, push.on) for push in (*(said.pushed.hand for said in heard), *pads.values())]
        right, up, on = np.clip(np.sum([(0.0, 0.0, 0.0), *pushes], axis=0), -1.0, 1.0)
        reach = max(1.0, float(np.hypot(right, up)))  # a stick moves within a circle
        return Deflection(float(right) / reach, float(up) / reach, float(on))

    async def talk(self, connection: ServerConnection) -> None:
        """Listen to a browser, and answer each message with what it is to show."""
        from websockets.exceptions import ConnectionClosed

        number, machine = next(self._numbers), str((connection.remote_address or ("",))[0])
        try:
            with suppress(ConnectionClosed):
                async for message in connection:
                    pushed = understood(message)
                    if pushed is None:
                        await connection.close(_NOT_UNDERSTOOD, _EXPECTED)
                        return
                    self._hands[number] = _Said(pushed, machine, self._clock())
                    shown = {"steering": self.steering, "words": self.words, "warning": self.warning}
                    await connection.send(json.dumps(shown))
        finally:
            self._hands.pop(number, None)


def understood(message: str | bytes) -> Pushed | None:
    """What a message of the script says; None if it says nothing of the kind."""
    if len(message) > _LONGEST:
        return None
    try:
        said = json.loads(message)
    except (ValueError, RecursionError):
        return None
    if not isinstance(said, dict) or set(said) != {"hand", "gamepads"} or not isinstance(said["gamepads"], dict):
        return None
    hand, pads = _deflection(said["hand"]), {name: _deflection(push) for name, push in said["gamepads"].items()}
    if hand is None or len(pads) > _MOST_PADS or None in pads.values():
        return None
    return Pushed(hand, {name: push for name, push in pads.items() if push is not None})


def _deflection(said: Any) -> Deflection | None:
    """Three numbers, within their bounds; None if it is anything else."""
    if not isinstance(said, list) or len(said) != 3:
        return None
    if any(isinstance(value, bool) or not isinstance(value, int | float) for value in said):
        return None
    if any(value != value or abs(value) == math.inf for value in said):  # `isfinite` fails at whole numbers over 1e308
        return None
    right, up, on = (float(min(max(value, -1), 1)) for value in said)
    return Deflection(right, up, on)
