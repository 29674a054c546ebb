"""Two buses as one: what all drives are to hear goes to both, back to back, and the rest to the bus of its node."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hognose.drive.bus import Bus, BusError, CanBus, ailment_of
from hognose.drive.frames import Frame
from hognose.drive.network import Network


class Buses:
    """See `hognose.drive.bus.Bus`. What nodes say on a bus that is not theirs is left out, and kept as a sentence.

    Attributes
    ----------
    misplaced
        Nodes that were heard on another bus than the network file has them on, in words.
    """

    def __init__(self, buses: Sequence[Bus], bus_of: Mapping[int, int], names: Sequence[str]) -> None:
        """Buses that are open.

        Parameters
        ----------
        buses
        bus_of
            The bus of every node of the network, from 0 on.
        names
            What people call the buses.
        """
        self._buses, self._bus_of, self._names = list(buses), dict(bus_of), list(names)
        self.misplaced: list[str] = []

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`: SYNC, heartbeats and what all drives listen to go to all buses, one right after the other.

        If one does not take frames any more, the others still get theirs: a stop is for all.
        """
        failed: BusError | None = None
        for k, bus in enumerate(self._buses):
            mine = [frame for frame in frames if self._bus_of.get(frame.cob & 0x7F, k) == k]
            try:
                if mine:
                    bus.send(mine)
            except BusError as error:
                failed = failed or error
        if failed is not None:
            raise failed

    def send_everywhere(self, frames: Sequence[Frame]) -> None:
        """Send frames to all buses, whosever they are."""
        for bus in self._buses:
            bus.send(frames)

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        found: list[Frame] = []
        for k, bus in enumerate(self._buses):
            for frame in bus.receive():
                node = frame.cob & 0x7F
                if self._bus_of.get(node, k) == k:
                    found.append(frame)
                else:
                    self._misplace(node, k)
        return found

    def _misplace(self, node: int, k: int) -> None:
        words = f"node {node} is on {self._names[k]}, but the file has it on {self._names[self._bus_of[node]]}"
        if words not in self.misplaced:
            self.misplaced.append(words)

    @property
    def ailment(self) -> str:
        """See `hognose.drive.bus.Ailing.ailment`."""
        ails = [(name, ailment_of(bus)) for name, bus in zip(self._names, self._buses, strict=True)]
        return "; ".join(f"{name}: {words}" for name, words in ails if words)

    def close(self) -> None:
        """See `Bus.close`."""
        for bus in self._buses:
            bus.close()


def opened(network: Network) -> Bus:
    """The bus of a network, or all of its buses as one.

    Raises
    ------
    InputError
        There is no such interface or channel.
    MissingExtraError
        python-can is not installed.
    """
    if len(network.spec.buses) == 1:
        return CanBus(network.spec.bus)
    buses: list[Bus] = []
    try:
        for spec in network.spec.buses:
            buses.append(CanBus(spec))
    except BaseException:
        for bus in buses:
            bus.close()
        raise
    return Buses(buses, network.bus_of, network.bus_names)
