"""A bus within the program: an executor and emulated drives that share a simulated clock."""

from __future__ import annotations

from collections.abc import Sequence

from hognose.drive.bus import Bus, ailment_words
from hognose.drive.buses import Buses
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.board_line import LocalLine
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.frames import Frame
from hognose.drive.serial_slider.adapter import with_slider


def local_bus(emulator: Emulator, clock: SimulatedClock) -> Bus:
    """The bus of emulated drives in this program, with the slider's board if there is one."""
    network = emulator.network
    buses = [LocalBus(emulator, clock, number=k) for k in range(len(network.spec.buses))]
    bus = buses[0] if len(buses) == 1 else Buses(buses, network.bus_of, network.bus_names)
    slider = network.spec.slider
    if emulator.board is None or slider is None:
        return bus
    return with_slider(bus, clock, network, LocalLine(emulator.board, clock, slider.baud))


class LocalBus:
    """Carries frames between the program and emulated drives at once; what drives say late comes late."""

    def __init__(self, emulator: Emulator, clock: SimulatedClock, bitrate: int | None = None, number: int = 0) -> None:
        """A bus of the drives, the first one or the second (`number` 0 or 1).

        Where its bitrate (bit/s) is given and another than the drives', there are only errors.
        """
        self._emulator, self._clock, self._errors, self._number = emulator, clock, 0, number
        self._bitrate = bitrate or emulator.network.spec.buses[number].bitrate
        self._is_strange = self._bitrate != emulator.network.spec.buses[number].bitrate
        clock.attach(emulator.advance)

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`."""
        if self._is_strange:
            self._errors += len(frames)
            return
        self._emulator.receive(frames, self._clock.now(), self._number)

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        found = self._emulator.send(self._clock.now(), self._number)
        return [] if self._is_strange else found

    @property
    def ailment(self) -> str:
        """See `Ailing.ailment`."""
        return ailment_words(self._errors, 0, self._bitrate)

    def close(self) -> None:
        """See `Bus.close`."""
