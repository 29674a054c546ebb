"""`python -m benchmarks.drives`: what emulated drives get, how long a cycle takes, faults, and the twin behind them."""

from __future__ import annotations

import statistics
import time

import numpy as np

import hognose
from benchmarks.mechanics import CASES
from benchmarks.rows import aside, heading, row
from hognose.drive.bring_up import bring_up
from hognose.drive.bus import CanBus
from hognose.drive.cia402 import State
from hognose.drive.clock import RealClock, SimulatedClock
from hognose.drive.emulator.drive import EmulatedDrive
from hognose.drive.emulator.emulator import Delays, Emulator
from hognose.drive.emulator.faults import Fault, FaultKind
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.executor import Executor
from hognose.drive.local_bus import LocalBus
from hognose.drive.motions import counts_of
from hognose.drive.network import emulated_network
from hognose.drive.settings import Settings
from hognose.drive.stream import Cycle
from hognose.planning import Plan
from hognose.studies.rehearsal import TwinPlant

#: Drives that answer within 2 to 5 ms.
SLOW = Delays(2e-3, 3e-3)
FAULTS: tuple[FaultKind, ...] = (
    "following_error", "overcurrent", "emergency", "heartbeat_lost", "frozen", "bus_off", "stuck", "power_lost",
    "underflow", "encoder_jump",
)  # fmt: skip


def main(seeds: int = 3, faults: int = 5, cycles: int = 500) -> None:
    """Print all of it."""
    plans = {name: hognose.plan(hognose.load_task(name)) for name in CASES}
    boards = plans["obstacle-array"]
    heading("what the drives get: 312 steps, 36 axes and the slider")
    for seed in range(seeds):
        row(f"counts that are not the plan's, in order, seed {seed}", float(wrong_counts(boards, seed)), 0.0, "")
    heading("finding and configuring 37 drives that answer within 2 to 5 ms")
    took, network = bringing_up(boards)
    row("all of them", took, 1.0, "s")
    aside("load of the bus, computed", 100.0 * network, "%")
    heading("drives in another process, over TCP")
    cycle = times_of_cycles(boards, cycles)
    row("a cycle of 37 axes, median", 1e3 * statistics.median(cycle), 1.5, "ms")
    aside("a cycle of 37 axes, 99.9 %", 1e3 * float(np.quantile(cycle, 0.999)), "ms")
    heading(f"{faults} faults of each of {len(FAULTS)} kinds, at random steps")
    stopped = [stopping(boards, kind, seed) for kind in FAULTS for seed in range(faults)]
    row("all other axes at rest, after it was noticed", 1e3 * max(stopped), 50.0, "ms")
    heading("the program dies")
    row("all axes hold by themselves", 1e3 * max(dying(boards, seed) for seed in range(faults)), 150.0, "ms")
    heading("the twin behind the drives, there and back")
    for name, plan in plans.items():
        there, back = tips(plan)
        row(f"{name}: tip off the plan in root mean square, there", there, 0.1, "mm")
        row(f"{name}: tip off the plan in root mean square, back", back, 0.1, "mm")


class Rig:
    """An executor on emulated drives in simulated time, where its plan begins."""

    def __init__(self, plan: Plan, delays: Delays | None = None, seed: int = 0, twin: bool = False) -> None:
        self.network = emulated_network(plan.robot)
        self.counts, self.clock = counts_of(plan, self.network), SimulatedClock()
        self.plant = TwinPlant(plan, self.network) if twin else None
        self.emulator = Emulator(self.network, self.plant, self.counts[0].tolist(), delays, seed)
        self.cycles: list[Cycle] = []
        bus = LocalBus(self.emulator, self.clock)
        settings = Settings(watches_tension=twin)
        self.executor = Executor(plan, self.network, bus, self.clock, settings, self.seen)
        self.executor.arm()
        self.executor.hold()
        self.executor.tension()

    def seen(self, cycle: Cycle) -> None:
        """Note a cycle."""
        self.cycles.append(cycle)


def wrong_counts(plan: Plan, seed: int) -> int:
    """How many counts at steps of the plan differ from those that drives got, there."""
    got: dict[int, list[int]] = {}
    whole = EmulatedDrive._record

    def record(self: EmulatedDrive, number: int) -> int:
        data = (number % (1 << 64)).to_bytes(8, "little")
        got.setdefault(self.node, []).append(int.from_bytes(data[:4], "little", signed=True))
        return whole(self, number)

    rig = Rig(plan, Delays(2e-4, 3e-3), seed)
    EmulatedDrive._record = record
    try:
        rig.cycles.clear()
        rig.executor.run()
    finally:
        EmulatedDrive._record = whole
    places = np.array([cycle.set_point.place for cycle in rig.cycles])
    sent = np.array([got[node] for node in rig.network.nodes]).T
    at = [int(np.flatnonzero(places == step)[0]) for step in range(len(rig.counts))]
    return int(np.count_nonzero(sent[at] != rig.counts))


def bringing_up(plan: Plan) -> tuple[float, float]:
    """How long (s) it takes until all drives are found and configured, and the load of their bus."""
    network, clock = emulated_network(plan.robot), SimulatedClock()
    bring_up(LocalBus(Emulator(network, delays=SLOW), clock), clock, network, network.spec.cycle_s)
    return clock.now(), network.load


def boards_emulated() -> Emulator:
    """In the process of the drives."""
    return Emulator(emulated_network(hognose.load_robot("sjtu-25dof")))


def times_of_cycles(plan: Plan, count: int) -> list[float]:
    """How long (s) cycles take: set-points of all axes and SYNC, until the status of all has come."""
    process = EmulatorProcess(boards_emulated)
    network = emulated_network(plan.robot, channel=process.channel)
    bus, found = CanBus(network.spec.bus), []
    try:
        executor = Executor(plan, network, bus, RealClock(), Settings(watches_tension=False))
        executor.arm()
        axes = executor.axes
        # As many frames as set-points, of what may be written again and again while nothing moves.
        frames = axes.decelerations(np.zeros(len(axes)), 0.04)
        for _ in range(count):
            began = time.perf_counter()
            axes.heard[:] = -np.inf
            axes.send(frames)
            axes.sync()
            while not np.isfinite(axes.heard).all():
                axes.listen()
            found.append(time.perf_counter() - began)
            time.sleep(0.005)
    finally:
        bus.close()
        process.close()
    return found


def stopping(plan: Plan, kind: FaultKind, seed: int) -> float:
    """How long (s) all axes but the one that fails take to come to rest, from when the executor knows of it."""
    rng, rig = np.random.default_rng(seed), Rig(plan, Delays(2e-4, 5e-4), seed)
    at, node = float(rng.uniform(1.0, 20.0)), int(rng.choice(rig.network.nodes[:36]))
    broken: list[float] = []

    def seen(cycle: Cycle) -> None:
        if cycle.set_point.place >= at and not broken:
            broken.append(rig.clock.now())
            rig.emulator.inject(Fault(node, kind))

    rig.executor._stream._seen = seen
    outcome = rig.executor.run(300.0)
    if outcome.trouble is None or outcome.trouble.axis != rig.network.nodes.index(node):
        raise AssertionError(f"{kind} of node {node}: {outcome}")
    began = rig.clock.now()
    others = [drive for each, drive in rig.emulator.drives.items() if each != node]
    while any(drive.axis.velocity for drive in others):
        rig.clock.wait(rig.clock.now() + 1e-3)
        if rig.clock.now() - began > 1.0:
            raise AssertionError(f"{kind} of node {node}: some axes never come to rest")
    return rig.clock.now() - began


class _DeadError(Exception):
    """The program ends here."""


def dying(plan: Plan, seed: int) -> float:
    """How long (s) after the last frame of the program all drives are at rest and hold."""
    rng, rig = np.random.default_rng(seed), Rig(plan)
    at = float(rng.uniform(1.0, 20.0))

    def seen(cycle: Cycle) -> None:
        if cycle.set_point.place >= at:
            rig.executor.axes.control_all = lambda word: None  # nothing is sent any more
            raise _DeadError

    rig.executor._stream._seen = seen
    try:
        rig.executor.run()
    except _DeadError:
        began = rig.clock.now()
    else:
        raise AssertionError("it did not end")
    drives = rig.emulator.drives.values()
    while not all(drive.state is State.QUICK_STOP_ACTIVE and not drive.axis.velocity for drive in drives):
        rig.clock.wait(rig.clock.now() + 1e-3)
        if rig.clock.now() - began > 1.0:
            raise AssertionError("some drives do not hold")
    return rig.clock.now() - began


def tips(plan: Plan) -> tuple[float, float]:
    """How far (mm) the twin's tip is off its plan in root mean square, there and back."""
    rig, found = Rig(plan, Delays(2e-4, 5e-4), twin=True), []
    assert rig.plant is not None, "with the twin"
    twin, body = rig.plant.twin, plan.body[:, -1]
    for until in (None, 0.0):
        places: list[float] = []
        reached: list[np.ndarray] = []

        def seen(cycle: Cycle, places: list[float] = places, reached: list[np.ndarray] = reached) -> None:
            places.append(cycle.set_point.place)
            reached.append(twin.joints[-1])

        rig.executor._stream._seen = seen
        outcome = rig.executor.run(until)
        if outcome.trouble is not None:
            raise AssertionError(outcome.trouble.words)
        # A cycle is over when the next one's set-point takes effect.
        at = np.array(places[1:])
        low = np.minimum(at.astype(int), len(body) - 2)
        planned = body[low] + (at - low)[:, None] * (body[low + 1] - body[low])
        off = np.linalg.norm(np.array(reached[:-1]) - planned, axis=1)
        found.append(1e3 * float(np.sqrt((off**2).mean())))
    return found[0], found[1]


if __name__ == "__main__":
    main()
