"""Emulated drives that move the twin of an arm: a run as it will be, with everything but the hardware."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.bus import Bus
from hognose.drive.buses import opened
from hognose.drive.clock import Clock, RealClock, SimulatedClock
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.faults import Fault
from hognose.drive.emulator.plant import NoArm
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.local_bus import local_bus
from hognose.drive.motions import counts_of
from hognose.drive.network import Network, emulated_network, load_network
from hognose.drive.network_spec import EMULATED
from hognose.drive.senses import Senses
from hognose.drive.serial_slider.adapter import with_slider
from hognose.planning import Plan
from hognose.sim import Twin
from hognose.studies.senses import DistantSenses, Sight, TipCamera, TwinSenses, sight_of

Array = NDArray[np.float64]

#: A time (s) that is nothing but rounding: a step of the twin is not put off for it.
_NO_TIME = 1e-9


class TwinPlant:
    """The twin of an arm behind emulated motors; see `hognose.drive.emulator.plant.Plant`.

    Attributes
    ----------
    twin
    """

    def __init__(self, plan: Plan, network: Network, twin: Twin | None = None) -> None:
        """At rest where a plan begins: the arm that was planned for, or a twin of another truth."""
        self._plan, self._robot, self._base = plan, plan.robot, plan.task.base
        slider, cables = network.spec.slider, plan.robot.cables
        self._zeros = network.zeros.astype(np.float64)
        if twin is not None and network.calibrated:  # what was calibrated is not of motors, but of its cables
            self._zeros[:cables] -= network.calibrated
        self._per_count = 1.0 if slider is None else 1.0 / slider.counts_per_metre
        self._counts: Array = (counts_of(plan, network)[0] - self._zeros)[:cables]
        self.twin = Twin(plan.task) if twin is None else twin
        commanded = None if twin is None else self._robot.lengths_of_counts(self._counts)
        self.twin.put(plan.at[0], plan.angles[0], commanded)
        self.twin.shorten_step()
        self._feed = float(plan.feed[0])
        self._time, self._left = float(plan.clock[0]), 0.0
        self.tensions: Array = self.twin.tensions

    def move(self, counts: Array, slider: float, dt: float) -> None:
        """See `Plant.move`: in steps of the twin's integration, motors and slider going steadily."""
        cables = len(counts)
        counts, slider = counts - self._zeros[:cables], slider - float(self._zeros[cables:].sum())
        feed, step = slider * self._per_count, self.twin.time_step
        before, ahead = self._robot.lengths_of_counts(self._counts), self._robot.lengths_of_counts(counts)
        speeds, rate = (ahead - before) / dt, (feed - self._feed) / dt
        at, then = (self._base.coordinates(np.array([x]), self._plan.joints[:1])[0] for x in (self._feed, feed))
        self._left += dt
        done = 0.0
        while self._left >= step - _NO_TIME:
            share = min(done / dt, 1.0)
            now = at + share * (then - at)
            self.twin.step(before + share * (ahead - before), speeds, now, np.full_like(now, rate), self._time)
            self._left, done, self._time = self._left - step, done + step, self._time + step
        self._counts, self._feed = counts.copy(), feed
        self.tensions = self.twin.tensions

    def sight(self) -> Sight:
        """See `Plant.sight`."""
        return sight_of(self.twin)


@dataclass(frozen=True)
class Rehearsal:
    """Makes the emulated drives of a plan, in whatever process that is to be.

    Attributes
    ----------
    file
        The plan file.
    twin
        Whether the motors move the twin, not nothing.
    network
        The network file whose drives they are; nodes from 1 on unless given.
    is_homed
        Whether drives know where they are, as if their supply had not been cut since they were homed.
    """

    file: Path
    twin: bool = True
    network: Path | None = None
    is_homed: bool = True

    def __call__(self) -> Emulator:
        """The drives, standing where the plan begins.

        Raises
        ------
        InputError
            The network file's drives are another arm's.
        """
        plan = Plan.load(self.file)
        network = _network_of(plan, self.network)
        network.refuse(plan)
        plant = TwinPlant(plan, network) if self.twin else NoArm(plan.robot.cables)
        return Emulator(network, plant, counts_of(plan, network)[0].tolist(), is_homed=self.is_homed)


class Emulated(NamedTuple):
    """Emulated drives: network, bus, the time they go by, what is seen of the twin, and how to make them fail."""

    network: Network
    bus: Bus
    clock: Clock
    senses: Senses | None
    inject: Callable[[Fault], None]


def emulated(stack: ExitStack, plan: Plan, twin: bool, fast: bool, file: Path | None = None) -> Emulated:
    """Emulated drives of a plan, which end with the stack.

    Parameters
    ----------
    stack
    plan
    twin
        Whether the motors move the twin of the arm.
    fast
        In this program and in simulated time; otherwise a process of its own, in real time.
    file
        The network file whose drives, and slider's board, are emulated; nodes from 1 on unless given.

    Raises
    ------
    InputError
        The network file has faults, or its drives are another arm's.
    """
    network = _network_of(plan, file)
    network.refuse(plan)
    if fast:
        clock, plant = SimulatedClock(), TwinPlant(plan, network) if twin else NoArm(plan.robot.cables)
        emulator = Emulator(network, plant, counts_of(plan, network)[0].tolist())
        senses = TwinSenses(plant.twin, TipCamera(plan)) if isinstance(plant, TwinPlant) else None
        return Emulated(network, local_bus(emulator, clock), clock, senses, emulator.inject)
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hognose-run-")))
    plan.save(folder / "plan.parquet")
    process = EmulatorProcess(Rehearsal(folder / "plan.parquet", twin, file))
    stack.callback(process.close)
    network = _on_emulated_bus(network, process.channels, process.slider_port)
    clock = RealClock()
    bus = with_slider(opened(network), clock, network)
    stack.callback(bus.close)
    if not twin:
        return Emulated(network, bus, clock, None, process.inject)
    senses = DistantSenses(process, folder / "plan.parquet")
    stack.callback(senses.close)
    return Emulated(network, bus, clock, senses, process.inject)


def _network_of(plan: Plan, file: Path | None) -> Network:
    """The network of emulated drives: a file's, or one for the plan's arm."""
    return emulated_network(plan.robot) if file is None else _on_emulated_bus(load_network(file))


def _on_emulated_bus(network: Network, channels: Sequence[str] = ("", ""), slider_port: str = "") -> Network:
    """The same network, with buses that are emulated, and the line to the slider's board if it has one."""
    spec = network.spec
    buses = {
        name: bus.model_copy(update={"interface": EMULATED, "channel": channel, "options": {}})
        for name, bus, channel in zip(("bus", "bus2"), spec.buses, channels, strict=False)
    }
    slider = spec.slider
    if slider is not None and slider_port:
        slider = slider.model_copy(update={"port": slider_port})
    return replace(network, spec=spec.model_copy(update={**buses, "slider": slider}))
