"""A bus within the program: an executor and emulated drives that share a simulated clock."""

from __future__ import annotations

from collections.abc import Sequence

from hognose.drive.bus import Bus
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.board_line import LocalLine
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.frames import Frame
from hognose.drive.serial_slider.adapter import with_slider


def local_bus(emulator: Emulator, clock: SimulatedClock) -> Bus:
    """The bus of emulated drives in this program, with the slider's board if there is one."""
    bus, slider = LocalBus(emulator, clock), emulator.network.spec.slider
    if emulator.board is None or slider is None:
        return bus
    return with_slider(bus, clock, emulator.network, LocalLine(emulator.board, clock, slider.baud))


class LocalBus:
    """Carries frames between the program and emulated drives at once; what drives say late comes late."""

    def __init__(self, emulator: Emulator, clock: SimulatedClock) -> None:
        self._emulator, self._clock = emulator, clock
        clock.attach(emulator.advance)

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`."""
        self._emulator.receive(frames, self._clock.now())

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        return self._emulator.send(self._clock.now())

    def close(self) -> None:
        """See `Bus.close`."""
