"""Finding the board of a slider, and telling it what it needs to know; what is wrong with it in a sentence."""

from __future__ import annotations

import struct
from collections.abc import Callable

from hognose.drive.bus import Bus
from hognose.drive.clock import Clock
from hognose.drive.frames import Frame
from hognose.drive.network import Network
from hognose.drive.serial_slider.adapter import SliderBus
from hognose.drive.serial_slider.line import LineError
from hognose.drive.serial_slider.link import Link
from hognose.drive.serial_slider.messages import (
    VERSION,
    BoardState,
    Configure,
    Flags,
    Kind,
    Result,
    Status,
    Welcome,
)
from hognose.errors import InputError

#: A board answers within this (s), or is asked again, so often.
PATIENCE, TRIES = 0.25, 3
#: How long (s) the line is not looked at while the board is waited for.
_PAUSE = 1e-3


def greet(
    bus: Bus, clock: Clock, network: Network, cycle: float, others: Callable[[Frame], None] = lambda frame: None
) -> tuple[Welcome, bool]:
    """Open the line, and find and configure the board; what it says, and whether it had to be configured anew.

    A board that holds its position goes on holding it. From then on it is a node of the bus.

    Parameters
    ----------
    bus
        Of `with_slider`.
    clock
    network
    cycle : s
    others
        Called with frames of the bus that come meanwhile.

    Raises
    ------
    LineError
        No such port, a port that is busy, no answer, only garbage, another protocol, a board that does not know where
        it is, or refuses what it is told.
    InputError
        The bus has no slider.
    """
    slider = network.spec.slider
    if not isinstance(bus, SliderBus) or slider is None:
        raise InputError(f"{network.source}: slider: the bus was opened without its board; open it by `with_slider`")
    bus.open()
    talk = _Talk(bus, clock, others)
    if not talk.ask(Kind.HELLO, bytes([VERSION]), lambda: bus.link.welcome is not None):
        raise LineError(_silence(bus.link, slider.port, slider.baud))
    welcome = bus.link.welcome
    assert welcome is not None, "it has answered"
    if welcome.version != VERSION:
        raise LineError(
            f"speaks version {welcome.version} of the protocol, expected {VERSION}: change its program, or use another "
            "version of Hognose"
        )
    if not welcome.flags & Flags.REFERENCED:
        raise LineError(
            f"{welcome.name!r} does not know where it is ({welcome.position} counts are from nowhere): bring it to its "
            "reference first, with the board's own means or with REFERENCE"
        )
    watch = network.spec.watch
    configure = Configure(
        round(1e3 * watch.lost_after_s), slider.following_window, slider.lowest_counts, slider.highest_counts
    )
    answer = talk.command(Kind.CONFIGURE, configure.payload())
    if answer.result is not Result.DONE:
        raise LineError(f"refuses its configuration: {answer.result.words}")
    bus.connect(cycle)
    return welcome, welcome.state is BoardState.UNCONFIGURED


def set_reference(bus: SliderBus, clock: Clock, counts: int) -> Status:
    """Tell a board that its motor, at rest and without power, is at a position (counts), before it is greeted.

    Raises
    ------
    LineError
        It does not answer, or not in its present state.
    """
    bus.open()
    answer = _Talk(bus, clock, lambda frame: None).command(Kind.REFERENCE, struct.pack("<i", counts))
    if answer.result is not Result.DONE:
        raise LineError(f"does not take {counts} counts for its position: {answer.result.words}")
    return answer


class _Talk:
    """Asks a board, again if it does not answer, while frames of the bus are passed on."""

    def __init__(self, bus: SliderBus, clock: Clock, others: Callable[[Frame], None]) -> None:
        self._bus, self._clock, self._others = bus, clock, others
        self._answers: list[tuple[Kind, Status]] = []

    def command(self, kind: Kind, payload: bytes) -> Status:
        """The answer to a command; a `LineError` if none comes."""
        self._answers.clear()
        if not self.ask(kind, payload, lambda: any(of is kind for of, _ in self._answers)):
            raise LineError(f"no answer to {kind.name} in {1e3 * PATIENCE * TRIES:.0f} ms")
        return next(status for of, status in self._answers if of is kind)

    def ask(self, kind: Kind, payload: bytes, answered: Callable[[], bool]) -> bool:
        """Send a message up to some times; whether it was answered."""
        for _ in range(TRIES):
            self._bus.link.send(kind, payload)
            end = self._clock.now() + PATIENCE
            while self._clock.now() < end:
                self._answers += self._bus.link.receive()
                for frame in self._bus.receive():
                    self._others(frame)
                if answered():
                    return True
                self._clock.wait(self._clock.now() + _PAUSE)
        return False


def _silence(link: Link, port: str, baud: int) -> str:
    """Why there is no answer to HELLO, by what came instead."""
    if link.echoed:
        return f"what is sent to {port!r} comes back, and no answer: are its lines looped, or bridged?"
    if link.valid:
        return "a board answers, but not to HELLO as version 1 of the protocol has it: is its program another's?"
    if link.garbage:
        return (
            f"{link.garbage} bytes came at {baud:,} baud, and no message in them: is `slider.baud` the board's, and is "
            f"it the board that is at {port!r}?"
        )
    return (
        f"no answer in {1e3 * PATIENCE * TRIES:.0f} ms at {port!r}, {baud:,} baud. Is the board on, are its lines not "
        "crossed, and is it the board that is there?"
    )
