"""`python -m benchmarks.drives`: what emulated drives get, how long a cycle takes, faults, and the twin behind them."""

from __future__ import annotations

import argparse
import statistics
import time
from dataclasses import replace
from functools import cache

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
from hognose.drive.neighbours import LISTENS
from hognose.drive.network import emulated_network
from hognose.drive.settings import Settings
from hognose.drive.stream import Cycle
from hognose.errors import HognoseError
from hognose.planning import Plan, Task
from hognose.studies.rehearsal import TwinPlant

#: Drives that answer within 2 to 5 ms.
SLOW = Delays(2e-3, 3e-3)
FAULTS: tuple[FaultKind, ...] = (
    "following_error", "overcurrent", "emergency", "heartbeat_lost", "frozen", "bus_off", "stuck", "power_lost",
    "underflow", "encoder_jump",
)  # fmt: skip


def main() -> None:
    """Print all of it, or the parts that are asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.drives", description=__doc__)
    parser.add_argument("--seeds", type=int, default=3, help="of jitter and delay; 20 is what it is to reach")
    parser.add_argument("--faults", type=int, default=5, help="of each of ten kinds; 50")
    parser.add_argument("--kills", type=int, default=5, help="at random moments; 100")
    parser.add_argument("--cycles", type=int, default=1000, help="of 20 ms in real time; 10000")
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), default=tuple(PARTS), help="these parts")
    given = parser.parse_args()
    for name in given.only:
        PARTS[name](given)


def exactness(given: argparse.Namespace) -> None:
    """Every drive gets the plan's counts."""
    heading(f"what the drives get: 312 steps, 36 axes and the slider, {given.seeds} seeds of jitter and delay")
    wrong = [wrong_counts(boards(), seed) for seed in range(given.seeds)]
    row("counts that are not the plan's, in order, lost or twice", float(sum(wrong)), 0.0, "")


def times(given: argparse.Namespace) -> None:
    """Bring-up, cycles and lateness; on a machine that does nothing else."""
    heading("finding and configuring 37 drives that answer within 2 to 5 ms")
    took, network = bringing_up(boards())
    row("all of them, behind 0.3 s of listening to who else is there", took - LISTENS, 1.0, "s")
    aside("load of the bus, computed", 100.0 * network, "%")
    heading("drives in another process, over TCP")
    cycle = times_of_cycles(boards(), 500)
    row("a cycle of 37 axes, median", 1e3 * statistics.median(cycle), 1.5, "ms")
    aside("a cycle of 37 axes, 99.9 %", 1e3 * float(np.quantile(cycle, 0.999)), "ms")
    heading(f"{given.cycles} cycles of 20 ms in real time, drives in another process")
    late, troubles = in_real_time(given.cycles)
    row("buffers that ran empty, and other troubles", float(len(troubles)), 0.0, "")
    for words in troubles:
        print(f"  {words}")
    aside("cycles that began more than 20 ms late", float((late > 0.02).sum()), "")
    aside("lateness, median", 1e3 * float(np.median(late)), "ms")
    aside("lateness, 99.9 %", 1e3 * float(np.quantile(late, 0.999)), "ms")


def faults(given: argparse.Namespace) -> None:
    """Drives that fail."""
    heading(f"{given.faults} faults of each of {len(FAULTS)} kinds, at random steps")
    stopped = [stopping(boards(), kind, seed) for kind in FAULTS for seed in range(given.faults)]
    row("all other axes at rest, after it was noticed", 1e3 * max(each[0] for each in stopped), 50.0, "ms")
    lost = sum(not each[1] for each in stopped)
    row("runs that did not come back to the plan and to its start", float(lost), 0.0, "")


def tensions(given: argparse.Namespace) -> None:
    """What cables pull when all axes stop at once."""
    heading(f"{given.faults} stops at once on the twin")
    errors = [tension_error(boards(), seed) for seed in range(given.faults)]
    row("a tension off its plan while it stops and 0.5 s after it", max(errors), 20.0, "N")
    aside("the median of them", statistics.median(errors), "N")


def kills(given: argparse.Namespace) -> None:
    """The program that dies."""
    heading(f"the program dies at {given.kills} random moments")
    row("all axes hold by themselves", 1e3 * max(dying(boards(), seed) for seed in range(given.kills)), 150.0, "ms")


def there_and_back(given: argparse.Namespace) -> None:
    """Both cases through drives and twin."""
    del given
    heading("the twin behind the drives, there and back")
    for name in CASES:
        there, back = tips(hognose.plan(hognose.load_task(name)))
        row(f"{name}: tip off the plan in root mean square, there", there, 0.1, "mm")
        row(f"{name}: tip off the plan in root mean square, back", back, 0.1, "mm")


PARTS = {
    "counts": exactness, "times": times, "faults": faults, "tensions": tensions, "kills": kills, "tips": there_and_back,
}  # fmt: skip


@cache
def boards() -> Plan:
    """The plan of the obstacle array."""
    return hognose.plan(hognose.load_task("obstacle-array"))


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


def in_real_time(count: int) -> tuple[np.ndarray, list[str]]:
    """How late (s) cycles of 20 ms begin, there and back until there were so many, and what went wrong."""
    task = hognose.load_task("obstacle-array")
    motion = task.spec.motion.model_copy(update={"period_s": 0.16})
    plan = hognose.plan(Task(task.spec.model_copy(update={"motion": motion}), task.robot))
    process, late = EmulatorProcess(boards_emulated), []
    network = emulated_network(plan.robot, channel=process.channel)
    drives = network.spec.drives.model_copy(update={"least_records": 7, "most_records": 11})  # they outlast the master
    network = replace(network, spec=network.spec.model_copy(update={"cycle_s": 0.02, "drives": drives}))
    bus = CanBus(network.spec.bus)
    try:
        settings = Settings(watches_tension=False)
        executor = Executor(plan, network, bus, RealClock(), settings, lambda cycle: late.append(cycle.lateness))
        executor.arm()
        executor.hold()
        executor.tension()
        late.clear()
        while len(late) < count:
            outcome = executor.run(0.0 if executor.place else None)
            if outcome.trouble is not None:
                return np.array(late), [outcome.trouble.words]
    finally:
        bus.close()
        process.close()
    return np.array(late), []


def tension_error(plan: Plan, seed: int) -> float:
    """The largest error (N) of a tension while all axes stop at once, and 0.5 s after that, on the twin."""
    rng, rig = np.random.default_rng(seed), Rig(plan, Delays(2e-4, 5e-4), seed, twin=True)
    assert rig.plant is not None, "with the twin"
    assert plan.held is not None, "mechanics are known"
    at, kind = float(rng.uniform(1.0, 40.0)), FAULTS[seed % len(FAULTS)]
    node, broken, worst = int(rng.choice(rig.network.nodes[:36])), False, 0.0

    def seen(cycle: Cycle) -> None:
        nonlocal broken
        if cycle.set_point.place >= at and not broken:
            broken = True
            rig.emulator.inject(Fault(node, kind))

    rig.executor._stream._seen = seen
    place = rig.executor.run(300.0).place
    planned = plan.held.tensions[round(place)]
    end = rig.clock.now() + 0.54
    while rig.clock.now() < end:
        rig.clock.wait(rig.clock.now() + 1e-3)
        worst = max(worst, float(np.abs(rig.plant.tensions - planned).max()))
    return worst


def stopping(plan: Plan, kind: FaultKind, seed: int) -> tuple[float, bool]:
    """How long (s) all axes but the one that fails take to come to rest, from when the executor knows of it.

    And whether the arm, repaired, comes back to its plan and to its start; drives that lost where they are do not.
    """
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
    return rig.clock.now() - began, _comes_back(rig, kind, node)


def _comes_back(rig: Rig, kind: FaultKind, node: int) -> bool:
    """Whether it returns to its plan and to its start; a drive whose power was lost, or whose encoder jumped, must not.

    An encoder that jumped is as far from the plan as it says, which is within what is taken up: it comes back.
    """
    rig.clock.wait(rig.clock.now() + 0.2)
    rig.emulator.repair(node)
    try:
        if kind == "power_lost":
            rig.executor.arm()
        rig.executor.recover()
    except HognoseError as error:
        return kind == "power_lost" and "not referenced" in str(error)
    outcome = rig.executor.run(0.0)
    return outcome.trouble is None and bool((rig.executor.axes.position == rig.counts[0]).all())


class _DeadError(Exception):
    """The program ends here."""


def dying(plan: Plan, seed: int) -> float:
    """How long (s) after the last frame of the program all drives are at rest and hold."""
    rng, rig = np.random.default_rng(seed), Rig(plan)
    at = float(rng.uniform(1.0, 20.0))

    def seen(cycle: Cycle) -> None:
        if cycle.set_point.place >= at:
            rig.executor._stream.stop_at_once = lambda: None  # nothing is sent any more
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
