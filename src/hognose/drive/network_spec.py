"""What a network file says: the bus, the drive of every cable, the slider, and when to stop."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from hognose.units import FileModel

#: Node ids that drives may have. 127 is the master's own: its heartbeats have the id that belongs to it.
MASTER, HIGHEST_NODE = 127, 126
#: The interface of emulated drives.
EMULATED = "hognose"
#: What 0x60C2:1 of an EPOS4 may be at most (s).
_LONGEST_PERIOD = 0.1
#: A slider may be so far (m) from where it is told to be, unless the file says how far.
_FOLLOWING = 0.2e-3
Node = Annotated[int, Field(ge=1, le=HIGHEST_NODE)]
Seconds = Annotated[float, Field(gt=0, le=10, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Kind = Literal["epos2", "cia402"]
Counts = Annotated[int, Field(ge=-(2**31), lt=2**31)]
#: What a drive knows of where it is when its supply comes on: nothing until it is homed, or all of it.
Position = Literal["homed", "absolute"]


class BusSpec(FileModel):
    """The CAN bus, as python-can is to open it; `options` are passed on to its interface.

    `others` are nodes that are on the bus beside the drives, such as a force sensor.
    """

    interface: Annotated[str, Field(min_length=1, max_length=100)]
    channel: Annotated[str, Field(max_length=500)] = ""
    bitrate: Annotated[int, Field(ge=10_000, le=1_000_000)] = 1_000_000
    options: dict[str, str | int | float | bool] = Field(default_factory=dict)
    most_load: Share = 0.8
    others: tuple[Node, ...] = ()


class SecondBusSpec(BusSpec):
    """Another bus: with full feedback, one is too slow for cycles of 10 ms. `nodes` of the drives are on it."""

    nodes: tuple[Node, ...]


class DrivesSpec(FileModel):
    """The drives of the cables, in the order of the robot's cables.

    An `epos2` is moved by records of position, velocity and time in its buffer (interpolated position mode), others by
    a position every cycle that takes effect at SYNC (cyclic synchronous position mode). `newton_per_unit` is what a
    cable pulls for a unit of what its drive says: mA of an `epos2`, a thousandth of the rated torque of others; below
    zero where what it says is the less the more the cable pulls.
    `lowest_counts` and `highest_counts` are where its axis ends. Encoders that are `absolute` know where they are after
    the supply was cut; others must be `homed`. `zeros` are what drives say where the plan says 0, one for each cable.
    `calibration` is a file of `hognose calibrate`, whose zeros count as well. `eds` is the file that describes the
    drives' objects.
    """

    kind: Kind = "epos2"
    nodes: tuple[Node, ...]
    newton_per_unit: Annotated[float, Field(allow_inf_nan=False)]
    following_error_counts: Annotated[int, Field(ge=1, le=1_000_000)] = 200
    lowest_counts: Counts = -(2**31)
    highest_counts: Counts = 2**31 - 1
    position: Position = "homed"
    zeros: tuple[Counts, ...] = ()
    calibration: str = ""
    least_records: Annotated[int, Field(ge=2, le=60)] = 5
    most_records: Annotated[int, Field(ge=3, le=63)] = 9
    eds: str = ""

    @model_validator(mode="after")
    def _makes_sense(self) -> DrivesSpec:
        if not self.nodes:
            raise ValueError("`nodes` is empty; give the node id of the drive of every cable, in order")
        if not self.newton_per_unit:
            raise ValueError("`newton_per_unit` is 0: no tension would be seen; give what a cable pulls for a unit")
        seen: dict[int, int] = {}
        for cable, node in enumerate(self.nodes, 1):
            if node in seen:
                raise ValueError(f"node {node} is there twice, for cables {seen[node]} and {cable}; it is one drive")
            seen[node] = cable
        if self.zeros and len(self.zeros) != len(self.nodes):
            raise ValueError(
                f"`zeros` are {len(self.zeros)}, but `nodes` are {len(self.nodes)}; give what the drive of every cable "
                "says where the plan says 0, in the same order"
            )
        if self.most_records < self.least_records + 2:
            raise ValueError("`most_records` must be above `least_records` by two at least")
        if not self.lowest_counts < self.highest_counts:
            raise ValueError("`lowest_counts` must be below `highest_counts`")
        return self


class SliderSpec(FileModel):
    """The drive that feeds the arm: one more node on the bus, or a board on a serial port (docs/slider-board.md).

    A board is a node as well for the rest of the program: `node`, or 126. `following_error_counts` are those of 0.2 mm
    unless given. `lowest_counts` and `highest_counts` are where its axis ends; `position`, `zero` and `eds` as those of
    the drives.
    """

    kind: Literal["epos2", "cia402", "serial"] = "cia402"
    node: Node | None = None
    port: str = ""
    baud: Annotated[int, Field(ge=1200, le=4_000_000)] = 115_200
    counts_per_metre: Annotated[float, Field(ge=1e3, le=1e11, allow_inf_nan=False)]
    counts_per_turn: Annotated[int, Field(ge=64, le=10_000_000)] = 2000
    following_error_counts: Annotated[int, Field(ge=1, le=10_000_000)] | None = None
    lowest_counts: Counts = -(2**31)
    highest_counts: Counts = 2**31 - 1
    position: Position = "homed"
    zero: Counts = 0
    eds: str = ""

    @property
    def following_window(self) -> int:
        """How many counts it may be from where it is told to be."""
        default = max(round(_FOLLOWING * self.counts_per_metre), 1)
        return default if self.following_error_counts is None else self.following_error_counts

    @property
    def at_node(self) -> int:
        """Its node on the bus, or the one that a board on a serial port goes by."""
        return HIGHEST_NODE if self.node is None else self.node

    @model_validator(mode="after")
    def _is_reachable(self) -> SliderSpec:
        if self.kind == "serial" and not self.port:
            raise ValueError("a slider on a serial board needs its `port`, such as /dev/ttyUSB0")
        if self.kind != "serial" and self.node is None:
            raise ValueError('a slider on the bus needs its `node`; or give kind = "serial" and a `port`')
        if not self.lowest_counts < self.highest_counts:
            raise ValueError("`lowest_counts` must be below `highest_counts`")
        return self


class WatchSpec(FileModel):
    """When something is wrong, and how fast all axes stop then.

    Heartbeats are sent every `heartbeat_s`, and missed after `lost_after_s`. `stop_s` is how long all axes take to stop
    together. A cable may differ from what it is planned to pull by `tension_band_N`. Feedback may be late by so many
    cycles.
    """

    heartbeat_s: Seconds = 0.05
    lost_after_s: Seconds = 0.1
    stop_s: Annotated[float, Field(ge=0.005, le=0.5, allow_inf_nan=False)] = 0.04
    tension_band_N: Annotated[float, Field(gt=0, le=500, allow_inf_nan=False)] = 20.0
    late_cycles: Annotated[int, Field(ge=1, le=100)] = 2

    @model_validator(mode="after")
    def _is_consistent(self) -> WatchSpec:
        if not self.heartbeat_s < self.lost_after_s:
            raise ValueError(
                f"lost_after_s {self.lost_after_s:g} must be above heartbeat_s {self.heartbeat_s:g}, or each is missed"
            )
        return self


class NetworkSpec(FileModel):
    """A network file. `cycle_s` is how often set-points are sent; steps of a plan are divided into whole cycles."""

    schema_version: Literal[1] = Field(1, alias="schema")
    name: Annotated[str, Field(min_length=1, max_length=200)]
    robot: Annotated[str, Field(min_length=1, max_length=1000)]
    cycle_s: Seconds = 0.03
    bus: BusSpec
    bus2: SecondBusSpec | None = None
    drives: DrivesSpec
    slider: SliderSpec | None = None
    watch: WatchSpec = WatchSpec()
    assumed: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _outlast_the_master(self) -> NetworkSpec:
        """A buffer that runs empty is a fault, which cuts the power; a drive that lost its master stops and holds."""
        lasts, lost = (self.drives.least_records - 1) * self.cycle_s, self.watch.lost_after_s
        kinds = (self.drives.kind, self.slider.kind if self.slider is not None else "")
        if "epos2" in kinds and lasts < lost:
            raise ValueError(
                f"drives: `least_records` of {self.drives.least_records} last {1e3 * lasts:g} ms at cycle_s "
                f"{self.cycle_s:g}, but drives notice after lost_after_s, {1e3 * lost:g} ms, that the master is gone. "
                "Their buffers would run empty before that, and the power would be cut: give more records"
            )
        return self

    @model_validator(mode="after")
    def _can_be_interpolated(self) -> NetworkSpec:
        kinds = (self.drives.kind, self.slider.kind if self.slider is not None else "")
        if ("cia402" in kinds or "serial" in kinds) and self.cycle_s > _LONGEST_PERIOD:
            raise ValueError(
                f"cycle_s {self.cycle_s:g}: drives with cyclic positions interpolate over {_LONGEST_PERIOD:g} s at most"
            )
        return self

    @model_validator(mode="after")
    def _nodes_are_different(self) -> NetworkSpec:
        slider = self.slider
        if slider is not None and slider.at_node in self.drives.nodes:
            cable, node = self.drives.nodes.index(slider.at_node) + 1, slider.at_node
            hint = " Give a board on a serial port a free `node`." if slider.node is None else ""
            raise ValueError(f"slider: node {node} is the drive of cable {cable} already; a node is one drive.{hint}")
        return self

    @property
    def buses(self) -> tuple[BusSpec, ...]:
        """The bus, and the second one if there is one."""
        return (self.bus,) if self.bus2 is None else (self.bus, self.bus2)

    @model_validator(mode="after")
    def _others_are_others(self) -> NetworkSpec:
        for bus in self.buses:
            for node in bus.others:
                if node in self._nodes():
                    raise ValueError(f"bus.others: node {node} is a drive of this file; `others` are nodes beside them")
        return self

    @model_validator(mode="after")
    def _buses_are_different(self) -> NetworkSpec:
        second, nodes = self.bus2, self._nodes()
        if second is None:
            return self
        for k, node in enumerate(second.nodes):
            if node not in nodes:
                raise ValueError(f"bus2.nodes: node {node} is no drive of this file; name nodes that are")
            if node in second.nodes[:k]:
                raise ValueError(f"bus2.nodes: node {node} is there twice")
        if not 0 < len(second.nodes) < len(nodes):
            raise ValueError("bus2.nodes: give some drives, not all: the others are on `bus`")
        if (second.interface, second.channel) == (self.bus.interface, self.bus.channel):
            raise ValueError(f"bus2.channel: {second.channel!r} is the channel of `bus` already")
        return self

    def _nodes(self) -> tuple[int, ...]:
        slider = self.slider
        return (*self.drives.nodes, *(() if slider is None or slider.node is None else (slider.node,)))
