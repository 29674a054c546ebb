"""A network that fits an arm: which node drives which cable, and how the steps of a plan become cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hognose.drive.bus_load import bus_loads, heard_within, refuse_slow_line
from hognose.drive.calibrated import calibrated_by
from hognose.drive.eds import Eds, load_eds
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
#: Lengths of sections that are worked out of joints are the same within this (m).
_SAME_LENGTH = 1e-6


@dataclass(frozen=True, eq=False)
class Network:
    """The drives of an arm.

    Attributes
    ----------
    spec
    robot
    source
        The file, or what else it is from.
    sheets
        The data sheets of the drives of the cables, and of the slider's, where there are any.
    calibrated
        What is added to the counts of every cable for its calibration; nothing if empty.
    """

    spec: NetworkSpec
    robot: Robot
    source: str
    sheets: tuple[Eds | None, Eds | None] = (None, None)
    calibrated: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        nodes, cables = len(self.spec.drives.nodes), self.robot.cables
        if nodes != cables:
            raise InputError(
                f"{self.source}: drives.nodes: {nodes} nodes, but {self.robot.name} has {cables} cables; give the node "
                "of the drive of every cable, in the order of the robot file"
            )
        refuse_slow_line(self.spec, self.source)
        for name, bus, load in zip(self.bus_names, self.spec.buses, bus_loads(self.spec, FEEDBACK_EVERY), strict=True):
            if load > bus.most_load:
                rest = "use two buses (`bus2`)" if self.spec.bus2 is None else "move nodes to the other bus"
                raise InputError(
                    f"{self.source}: {name} would be taken for {100 * load:.0f} % of the time, more than most_load of "
                    f"{100 * bus.most_load:.0f} %: lengthen cycle_s ({1e3 * self.spec.cycle_s:g} ms), raise "
                    f"bus.bitrate ({bus.bitrate:,} bit/s), or {rest}"
                )
        if self.insists_s(self.spec.cycle_s) < 2.0 * self.answer_s:
            raise InputError(
                f"{self.source}: drives answer within {1e3 * self.answer_s:.0f} ms on this bus, and a stop that one of "
                "them misses could not be said again before its buffer runs empty: raise drives.least_records "
                f"({self.spec.drives.least_records}), lower watch.lost_after_s, or use two buses (`bus2`)"
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

    @property
    def following_windows(self) -> NDArray[np.int64]:
        """How far (A,) counts each axis may be from where it is told to be."""
        drives, slider = self.spec.drives, self.spec.slider
        found = [drives.following_error_counts] * len(drives.nodes)
        return np.array([*found, *([] if slider is None else [slider.following_window])][: len(self.nodes)])

    @property
    def answer_s(self) -> float:
        """Within how long (s) all drives have said their status after a SYNC."""
        return heard_within(self.spec)

    def insists_s(self, cycle: float) -> float:
        """For how long (s) drives that do not stop can be told again, before a silent master would be too late.

        Buffers of records, a cycle (s) each, must not run empty before drives miss the master.
        """
        drives, wanted = self.spec.drives, max(0.03, 3.0 * self.answer_s)
        if "epos2" not in self.kinds:
            return wanted
        return min(wanted, drives.least_records * cycle - self.spec.watch.lost_after_s)

    @property
    def zeros(self) -> NDArray[np.int64]:
        """What every drive (A,) says where the plan says 0, counts: those of a drive are the plan's and its zero."""
        drives, slider = self.spec.drives, self.spec.slider
        nothing = (0,) * len(drives.nodes)
        cables = np.array(drives.zeros or nothing, np.int64) + np.array(self.calibrated or nothing, np.int64)
        rest = () if slider is None else (slider.zero,)
        return np.array((*cables, *rest)[: len(self.nodes)], np.int64)

    @property
    def is_absolute(self) -> tuple[bool, ...]:
        """Whether an axis knows where it is after its supply was cut."""
        drives, slider = self.spec.drives, self.spec.slider
        cables = (drives.position == "absolute",) * len(drives.nodes)
        rest = () if slider is None else (slider.position == "absolute",)
        return (*cables, *rest)[: len(self.nodes)]

    @property
    def ends(self) -> NDArray[np.int64]:
        """Where every axis ends (A, 2) by what its drive says, counts: the lowest and the highest."""
        drives, slider = self.spec.drives, self.spec.slider
        found = [(drives.lowest_counts, drives.highest_counts)] * len(drives.nodes)
        if slider is not None:
            found.append((slider.lowest_counts, slider.highest_counts))
        return np.clip(np.array(found[: len(self.nodes)], np.int64), -MOST_COUNTS, MOST_COUNTS)

    def counts_of(self, plan: Plan) -> NDArray[np.int64]:
        """What the drives of all axes are to say at the steps of a plan: counts (T, A), with their zeros."""
        counts, slider = plan.motor_counts, self.spec.slider
        if slider is not None and len(self.nodes) > counts.shape[1]:
            counts = np.column_stack([counts, np.rint(plan.feed * slider.counts_per_metre).astype(np.int64)])
        return counts + self.zeros

    def sheet(self, axis: int) -> Eds | None:
        """The data sheet of the drive of an axis (0-based), if there is one."""
        return self.sheets[0 if axis < len(self.spec.drives.nodes) else 1]

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
        """The share of time that the bus, or the fuller one of two, is taken at most."""
        return max(bus_loads(self.spec, FEEDBACK_EVERY))

    @property
    def bus_of(self) -> dict[int, int]:
        """The bus of every node: 0, or 1 for the second."""
        second = self.spec.bus2
        return {node: int(second is not None and node in second.nodes) for node in self.nodes}

    @property
    def bus_names(self) -> tuple[str, ...]:
        """What people call the buses."""
        if self.spec.bus2 is None:
            return ("the bus",)
        return tuple(f"the bus {each.channel!r}" for each in self.spec.buses)

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

    def declared_counts(self, plan: Plan) -> NDArray[np.int64]:
        """What drives are told that they are at (T, A) where the arm stands at steps of a plan, when they are homed.

        Without what was calibrated: that is how far the cables are off then, and is added when they move.
        """
        counts = self.counts_of(plan)
        counts[:, : len(self.calibrated)] -= np.array(self.calibrated, np.int64)
        return counts

    def refuse(self, plan: Plan) -> None:
        """Raise an InputError that says why these drives cannot move through a plan, if they cannot."""
        if plan.robot.fingerprint != self.robot.fingerprint:
            raise InputError(
                f"{plan.task.name}: was planned for another arm than {self.robot.name} of {self.source}; plan it again "
                "with that robot file, or name the other one in the network file"
            )
        if plan.task.base.follows:
            raise InputError(
                f"{plan.task.name}: the arm is carried by another robot, which has a controller of its own; drives of "
                "this network move cables and a slider. Plan with another kind of base"
            )
        if float(np.ptp(plan.section_lengths, axis=0).max()) > _SAME_LENGTH:
            raise InputError(
                f"{plan.task.name}: sections of {self.robot.name} change their length on the way, which their "
                'backbones\' drives do, and this network moves cables and a slider only. Plan with `method = "exact"` '
                'or `"aim"`, which keep all lengths, and hold the backbones at rest'
            )
        slider = self.spec.slider
        if slider is None and plan.task.base.straight:
            raise InputError(f"{self.source}: `slider` is missing, which {plan.task.name} needs to feed the arm")
        if slider is not None and abs(float(plan.feed.max()) * slider.counts_per_metre) > MOST_COUNTS:
            raise InputError(
                f"{self.source}: slider: the feed is more counts than a drive holds; is counts_per_metre right?"
            )
        self._refuse_beyond_ends(plan)
        self._refuse_cycle(plan)
        if plan.task.moving:
            raise InputError(
                f"{plan.task.name}: {plan.task.moving[0].name} moves. Its times hold only for a motion that never "
                "pauses, and drives may have to stop: plan among obstacles that stand still"
            )

    def _refuse_cycle(self, plan: Plan) -> None:
        """Raise an InputError if the cycles that a plan's steps are divided into are too short for bus and buffers."""
        cycle = float(plan.task.spec.motion.period_s) / self.cycles_of(plan)
        if cycle > self.spec.cycle_s - 1e-9:
            return
        content = self.spec.model_dump(by_alias=True) | {"cycle_s": cycle}
        try:
            replace(self, spec=NetworkSpec.model_validate(content))
        except (InputError, ValidationError) as error:
            words = str(error) if isinstance(error, InputError) else error.errors()[0]["msg"]
            raise InputError(
                f"{plan.task.name}: its steps are divided into cycles of {1e3 * cycle:g} ms, shorter than cycle_s of "
                f"{1e3 * self.spec.cycle_s:g} ms, as they must be whole milliseconds. With these: {words}"
            ) from None

    def _refuse_beyond_ends(self, plan: Plan) -> None:
        """Raise an InputError that names the axis that a plan leads farthest beyond its end, if there is one."""
        counts, ends = self.counts_of(plan), self.ends
        beyond = np.maximum(ends[:, 0] - counts, counts - ends[:, 1])
        step, axis = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
        if beyond[step, axis] <= 0:
            return
        table = "drives" if axis < len(self.spec.drives.nodes) else "slider"
        zero = f", its zero of {self.zeros[axis]:,} included" if self.zeros[axis] else ""
        raise InputError(
            f"{plan.task.name}: {self.axis_name(int(axis))} would go to {counts[step, axis]:,} counts at step {step}"
            f"{zero}, but its axis ends at {ends[axis, 0]:,} and {ends[axis, 1]:,} ({table}.lowest_counts, "
            f"{table}.highest_counts): {beyond[step, axis]:,} counts too far"
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
    sheets = (_sheet(path, "drives", spec.drives), _sheet(path, "slider", spec.slider))
    return Network(spec, robot, str(path), sheets, calibrated_by(path, spec.drives.calibration, robot))


def _sheet(path: Path, table: str, spec: DrivesSpec | SliderSpec | None) -> Eds | None:
    """The data sheet that a table of a network file names."""
    if spec is None or not spec.eds or (isinstance(spec, SliderSpec) and spec.kind == "serial"):
        return None
    try:
        return load_eds(path.parent / spec.eds)
    except InputError as error:
        raise InputError(f"{path}: {table}.eds: {error}") from None


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
