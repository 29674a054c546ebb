"""A network that fits an arm: which node drives which cable, and how the steps of a plan become cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hognose.drive.bus_load import bus_load, refuse_slow_line
from hognose.drive.network_spec import EMULATED, BusSpec, DrivesSpec, Kind, NetworkSpec, SliderSpec, WatchSpec
from hognose.errors import InputError
from hognose.files import load_robot
from hognose.files.toml_source import read_model
from hognose.planning import Plan
from hognose.robot import Robot

#: In how many cycles a drive says its following error and what is left in its buffer.
FEEDBACK_EVERY = 5
#: A record of the interpolated position mode lasts whole milliseconds, up to these.
LONGEST_RECORD = 0.255
#: Counts that a 32-bit position holds.
MOST_COUNTS = 2**31 - 1


@dataclass(frozen=True, eq=False)
class Network:
    """The drives of an arm.

    Attributes
    ----------
    spec
    robot
    source
        The file, or what else it is from.
    """

    spec: NetworkSpec
    robot: Robot
    source: str

    def __post_init__(self) -> None:
        nodes, cables = len(self.spec.drives.nodes), self.robot.cables
        if nodes != cables:
            raise InputError(
                f"{self.source}: drives.nodes: {nodes} nodes, but {self.robot.name} has {cables} cables; give the node "
                "of the drive of every cable, in the order of the robot file"
            )
        refuse_slow_line(self.spec, self.source)
        load, most = self.load, self.spec.bus.most_load
        if load > most:
            raise InputError(
                f"{self.source}: the bus would be taken for {100 * load:.0f} % of the time, more than most_load of "
                f"{100 * most:.0f} %: lengthen cycle_s ({1e3 * self.spec.cycle_s:g} ms), raise bus.bitrate "
                f"({self.spec.bus.bitrate:,} bit/s), or use two buses"
            )

    @property
    def nodes(self) -> tuple[int, ...]:
        """Of all axes: the cables in their order, and then the slider."""
        slider = self.spec.slider
        return (*self.spec.drives.nodes, *(() if slider is None else (slider.at_node,)))

    @property
    def board_node(self) -> int | None:
        """The node that a slider on a serial board goes by; None if there is none."""
        slider = self.spec.slider
        return slider.at_node if slider is not None and slider.kind == "serial" else None

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Of the drive of every axis; a board on a serial port takes cyclic positions as well."""
        slider, kind = self.spec.slider, self.spec.drives.kind
        cables: tuple[Kind, ...] = (kind,) * len(self.spec.drives.nodes)
        if slider is None:
            return cables
        return (*cables, "cia402" if slider.kind == "serial" else slider.kind)

    @property
    def counts_per_turn(self) -> tuple[int, ...]:
        """Of the encoder of every axis."""
        groups = [group for group in self.robot.spec.section for _ in range(group.count)]
        cables = tuple(groups[section].transmission.counts_per_turn for section in self.robot.cable_sections)
        slider = self.spec.slider
        return cables if slider is None else (*cables, slider.counts_per_turn)

    def axis_name(self, axis: int) -> str:
        """What people call an axis (0-based), with its node."""
        slider, is_cable = self.spec.slider, axis < len(self.spec.drives.nodes)
        if slider is not None and slider.kind == "serial" and not is_cable:
            return f"the slider (board at {slider.port})"
        return f"{f'cable {axis + 1}' if is_cable else 'the slider'} (node {self.nodes[axis]})"

    @property
    def travel_per_count(self) -> NDArray[np.float64]:
        """How far (A,) m each axis goes for a count; above zero a cable is paid out."""
        cables, slider = self.robot.travel_per_count, self.spec.slider
        return cables if slider is None else np.append(cables, 1.0 / slider.counts_per_metre)

    @property
    def load(self) -> float:
        """The share of time that the bus is taken at most."""
        return bus_load(self.spec, FEEDBACK_EVERY)

    def cycles_of(self, plan: Plan) -> int:
        """How many cycles a step of a plan takes: its period divided into whole milliseconds, none longer than a cycle.

        Raises
        ------
        InputError
            There is no such division.
        """
        period = float(plan.task.spec.motion.period_s)
        milliseconds = round(1e3 * period)
        if abs(1e3 * period - milliseconds) > 1e-6:
            raise InputError(
                f"{plan.task.name}: a period of {1e3 * period:g} ms is no whole number of milliseconds, which records "
                "of drives are; plan again with another motion.period_s"
            )
        least = max(1, math.ceil(period / min(self.spec.cycle_s, LONGEST_RECORD) - 1e-9))
        for cycles in range(least, 2 * least + 1):
            if milliseconds % cycles == 0:
                return cycles
        raise InputError(
            f"{plan.task.name}: a period of {milliseconds} ms cannot be divided into whole milliseconds near "
            f"cycle_s of {1e3 * self.spec.cycle_s:g} ms; plan with another motion.period_s"
        )

    def refuse(self, plan: Plan) -> None:
        """Raise an InputError that says why these drives cannot move through a plan, if they cannot."""
        if plan.robot.fingerprint != self.robot.fingerprint:
            raise InputError(
                f"{plan.task.name}: was planned for another arm than {self.robot.name} of {self.source}; plan it again "
                "with that robot file, or name the other one in the network file"
            )
        drives, counts = self.spec.drives, plan.motor_counts
        low, high = max(drives.lowest_counts, -MOST_COUNTS), min(drives.highest_counts, MOST_COUNTS)
        for step, cable in zip(*((counts < low) | (counts > high)).nonzero(), strict=True):
            raise InputError(
                f"{plan.task.name}: {self.axis_name(int(cable))} would go to {counts[step, cable]:,} counts at step "
                f"{step}, but its axis ends at {low:,} and {high:,} (drives.lowest_counts, drives.highest_counts)"
            )
        if plan.task.base.follows:
            raise InputError(
                f"{plan.task.name}: the arm is carried by another robot, which has a controller of its own; drives of "
                "this network move cables and a slider. Plan with a slider, a cart or a drum"
            )
        slider = self.spec.slider
        if slider is None and plan.task.base.straight:
            raise InputError(f"{self.source}: `slider` is missing, which {plan.task.name} needs to feed the arm")
        if slider is not None and abs(float(plan.feed.max()) * slider.counts_per_metre) > MOST_COUNTS:
            raise InputError(
                f"{self.source}: slider: the feed is more counts than a drive holds; is counts_per_metre right?"
            )
        if slider is not None:
            self._refuse_way_of_slider(plan, slider)
        if plan.task.moving:
            raise InputError(
                f"{plan.task.name}: {plan.task.moving[0].name} moves. Its times hold only for a motion that never "
                "pauses, and drives may have to stop: plan among obstacles that stand still"
            )

    def _refuse_way_of_slider(self, plan: Plan, slider: SliderSpec) -> None:
        """Raise an InputError if a plan feeds the arm beyond where the slider's axis ends."""
        counts = np.rint(plan.feed * slider.counts_per_metre)
        for step in ((counts < slider.lowest_counts) | (counts > slider.highest_counts)).nonzero()[0]:
            raise InputError(
                f"{plan.task.name}: {self.axis_name(len(self.nodes) - 1)} would go to {counts[step]:,.0f} counts at "
                f"step {step}, but its axis ends at {slider.lowest_counts:,} and {slider.highest_counts:,} "
                "(slider.lowest_counts, slider.highest_counts)"
            )


def load_network(file: str | Path) -> Network:
    """A network from its file (TOML), with the robot that it names.

    Raises
    ------
    InputError
        A file with faults: says file, line, key and what was expected; a robot with another number of cables; too much
        for the bus.
    """
    path = Path(file)
    spec = read_model(path, NetworkSpec)
    try:
        robot = load_robot(spec.robot, path.parent)
    except InputError as error:
        raise InputError(f"{path}: robot: {error}") from None
    return Network(spec, robot, str(path))


def emulated_network(robot: Robot, channel: str = "") -> Network:
    """The network of emulated drives for an arm: one EPOS2 for each cable, from node 1 on, and one for the slider.

    Raises
    ------
    InputError
        More cables than there are nodes.
    """
    if robot.cables + 1 > 126:
        raise InputError(f"{robot.name}: {robot.cables} cables and a slider are more than the 126 nodes of a bus")
    spec = NetworkSpec(
        schema=1,
        name="emulated",
        robot=robot.name,
        bus=BusSpec(interface=EMULATED, channel=channel, most_load=1.0),
        drives=DrivesSpec(nodes=tuple(range(1, robot.cables + 1)), newton_per_unit=0.1),
        slider=SliderSpec(kind="epos2", node=robot.cables + 1, counts_per_metre=1e6),
        watch=WatchSpec(),
        assumed=("drives.newton_per_unit", "slider.counts_per_metre"),
    )
    return Network(spec, robot, "the emulated network")
