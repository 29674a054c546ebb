"""A bus within the program: an executor and emulated drives that share a simulated clock."""

from __future__ import annotations

from collections.abc import Sequence

from hognose.drive.bus import ailment_words
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.frames import Frame


class LocalBus:
    """Carries frames between the program and emulated drives at once; what drives say late comes late."""

    def __init__(self, emulator: Emulator, clock: SimulatedClock, bitrate: int | None = None) -> None:
        """A bus; where its bitrate (bit/s) is given and another than the drives', there are only errors."""
        self._emulator, self._clock, self._errors = emulator, clock, 0
        self._bitrate = bitrate or emulator.network.spec.bus.bitrate
        clock.attach(emulator.advance)

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`."""
        if self._bitrate != self._emulator.network.spec.bus.bitrate:
            self._errors += len(frames)
            return
        self._emulator.receive(frames, self._clock.now())

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        found = self._emulator.send(self._clock.now())
        return found if self._bitrate == self._emulator.network.spec.bus.bitrate else []

    @property
    def ailment(self) -> str:
        """See `Ailing.ailment`."""
        return ailment_words(self._errors, 0, self._bitrate)

    def close(self) -> None:
        """See `Bus.close`."""
