"""All emulated drives of an arm on one bus, with what their motors move, delays and faults."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.drive.emulator.board import EmulatedBoard
from hognose.drive.emulator.drive import BUS_OFF, FOLLOWING, OVERCURRENT, EmulatedDrive
from hognose.drive.emulator.encoder import Encoder
from hognose.drive.emulator.faults import Fault
from hognose.drive.emulator.plant import NoArm, Plant
from hognose.drive.frames import Frame
from hognose.drive.network import Network

Array = NDArray[np.float64]

#: Motors and arm move on in steps of at most so long (s).
STEP = 2e-3
#: A generic error (CiA 301); how late a drive that is late is (s), and how far an encoder jumps (counts).
_GENERIC, _LATE, _JUMP = 0x1000, 0.06, 1000.0
_DEAF = ("frozen", "bus_off")


@dataclass(frozen=True)
class Delays:
    """How long a drive takes to answer: at least, and at most so much longer (s), evenly distributed."""

    least: float = 0.0
    spread: float = 0.0


class Emulator:
    """Drives that take frames and give frames, as time goes on.

    Attributes
    ----------
    drives
        By node.
    board
        Of the slider, if that is on a serial line; otherwise None.
    """

    def __init__(
        self,
        network: Network,
        plant: Plant | None = None,
        start: Sequence[int] | None = None,
        delays: Delays | None = None,
        seed: int = 0,
        is_homed: bool = True,
    ) -> None:
        """The drives of a network, with power but not enabled.

        Parameters
        ----------
        network
        plant
            What cables' motors and the slider move; nothing unless given.
        start : (axes,) counts
            Where the motors stand; zero unless given.
        delays
        seed
            Of the delays.
        is_homed
            Whether drives know where they are; otherwise they say 0, as after their supply came on.
        """
        self.network, cables = network, len(network.spec.drives.nodes)
        self._plant: Plant = NoArm(cables) if plant is None else plant
        begin = [0] * len(network.nodes) if start is None else list(start)
        encoders = [Encoder(is_absolute=each) for each in network.is_absolute]
        parts = zip(network.nodes, network.kinds, begin, network.counts_per_turn, encoders, strict=True)
        on_bus = [each for each in parts if each[0] != network.board_node]
        self.drives = {node: EmulatedDrive(node, kind, at, turn, encoder) for node, kind, at, turn, encoder in on_bus}
        self._board_node = network.board_node
        self.board = None if self._board_node is None else EmulatedBoard(begin[cables], seed)
        if not is_homed:
            for drive in self.drives.values():
                drive.lose_power()
        self._cables = network.spec.drives.nodes
        self._slider = network.nodes[cables] if len(self.drives) > cables else None
        self._delays, self._rng = delays or Delays(), np.random.default_rng(seed)
        self._bus_of = network.bus_of
        self._due: list[list[tuple[float, int, Frame]]] = [[] for _ in network.spec.buses]
        self._count, self._now = 0, 0.0
        self._faults: dict[int, set[str]] = {}
        self._later: list[Fault] = []

    def inject(self, fault: Fault) -> None:
        """Let something go wrong, now or at the fault's time.

        Raises
        ------
        InputError
            There is no such node, or that kind is none of its faults.
        """
        nodes = {*self.drives} if self._board_node is None else {*self.drives, self._board_node}
        fault.refuse(nodes, self._board_node)
        if fault.time > self._now:
            self._later.append(fault)
            return
        if self.board is not None and fault.node == self._board_node:
            self.board.inject(fault)
            return
        drive = self.drives[fault.node]
        self._faults.setdefault(fault.node, set()).add(fault.kind)
        at_once: dict[str, Callable[[], None]] = {
            "following_error": lambda: drive.fault(FOLLOWING),
            "overcurrent": lambda: drive.fault(OVERCURRENT),
            "emergency": lambda: drive.fault(_GENERIC),
            "bus_off": lambda: drive.fault(BUS_OFF),
            "power_lost": drive.lose_power,
            "underflow": drive.axis.records.clear,
        }
        if fault.kind in at_once:
            at_once[fault.kind]()
        elif fault.kind == "stuck":
            drive.axis.is_stuck = True
        elif fault.kind == "encoder_jump":
            drive.axis.actual += _JUMP
        self._collect(drive)

    def sight(self) -> object:
        """What is to be told to who watches the arm from outside; see `Plant.sight`."""
        return self._plant.sight()

    def repair(self, node: int) -> None:
        """End all faults of a node; errors stay until they are reset."""
        if self.board is not None and node == self._board_node:
            self.board.repair()
            return
        self._faults.pop(node, None)
        self.drives[node].axis.is_stuck = False

    def receive(self, frames: Sequence[Frame], now: float, bus: int = 0) -> None:
        """Take frames from a bus, as all drives on it hear them."""
        self.advance(now)
        for frame in frames:
            for drive in self._meant(frame.cob):
                if self._bus_of[drive.node] == bus and not self._is_deaf(drive.node):
                    drive.receive(frame, now)
                    self._collect(drive)

    def _meant(self, cob: int) -> Sequence[EmulatedDrive]:
        """The drives that may have to do with a frame: a request for one, or a PDO with its node, is for no other."""
        for base in (0x600, 0x200, 0x300, 0x500):
            if cob - base in self.drives:
                return (self.drives[cob - base],)
        return tuple(self.drives.values())

    def advance(self, now: float) -> None:
        """Let time pass, up to now (s)."""
        while now - self._now > 1e-9:
            dt = min(STEP, now - self._now)
            self._now += dt
            if self._later:
                due = [fault for fault in self._later if fault.time <= self._now]
                self._later = [fault for fault in self._later if fault.time > self._now]
                for fault in due:
                    self.inject(fault)
            for drive in self.drives.values():
                drive.advance(dt, self._now)
            if self.board is not None:
                self.board.advance(dt, self._now)
            self._move(dt)
            for drive in self.drives.values():
                if drive.out:
                    self._collect(drive)

    def send(self, now: float, bus: int = 0) -> list[Frame]:
        """The frames that go onto a bus by now (s)."""
        found: list[Frame] = []
        due = self._due[bus]
        while due and due[0][0] <= now + 1e-12:
            found.append(heapq.heappop(due)[2])
        return found

    def _move(self, dt: float) -> None:
        counts = np.array([self.drives[node].axis.actual for node in self._cables])
        slider = 0.0 if self._slider is None else self.drives[self._slider].axis.actual
        if self.board is not None:
            slider = self.board.place
        self._plant.move(counts, slider, dt)
        said = self._plant.tensions / self.network.spec.drives.newton_per_unit
        loads = np.clip(np.rint(said), -32768, 32767)  # 16 bits
        for node, load in zip(self._cables, loads.astype(np.int64).tolist(), strict=True):
            self.drives[node].load = load

    def _is_deaf(self, node: int) -> bool:
        return any(kind in self._faults.get(node, ()) for kind in _DEAF)

    def _collect(self, drive: EmulatedDrive) -> None:
        """Put what a drive wants to say onto the bus, later if it takes its time."""
        frames, drive.out = drive.out, []
        faults = self._faults.get(drive.node, set())
        for frame in frames:
            if faults and not self._is_said(frame, drive.node, faults):
                continue
            late = _LATE if "late" in faults else 0.0
            when = self._now + late + self._delays.least + self._delays.spread * float(self._rng.random())
            self._count += 1
            heapq.heappush(self._due[self._bus_of[drive.node]], (when, self._count, frame))
        if frames and "bus_off" in faults:
            faults.add("said")

    def _is_said(self, frame: Frame, node: int, faults: set[str]) -> bool:
        """Whether a frame of a drive with faults gets onto the bus; that it is bus off is said once."""
        if self._is_deaf(node):
            return frame.cob == 0x80 + node and "bus_off" in faults and "said" not in faults
        return not ("heartbeat_lost" in faults and frame.cob == 0x700 + node)
