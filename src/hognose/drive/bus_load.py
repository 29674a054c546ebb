"""How much of the time a CAN bus is taken by what is sent in every cycle, with as many stuffed bits as there can be."""

from __future__ import annotations

from hognose.drive.network_spec import EMULATED, BusSpec, NetworkSpec
from hognose.errors import InputError

#: Bits of a frame with an identifier of 11 bits besides its data, and those of them that are stuffed (CAN 2.0, A.1).
_BESIDE, _STUFFED = 47, 34
#: A drive answers to a SYNC within this (s), if the bus is free.
_ANSWERS = 5e-3
#: Bits of a byte on a serial line, with a start bit and a stop bit. Bytes to a slider's board in a cycle (TARGET and
#: LATCH) and with a heartbeat (ASK), and those of its answer. So much of the time they may take.
_BITS_OF_A_BYTE, _TOLD, _ASKED, _ANSWER, _MOST_OF_LINE = 10, 29, 6, 23, 0.5


def frame_bits(size: int) -> int:
    """Bits of a frame with so many bytes of data at most, with the space behind it."""
    return _BESIDE + 8 * size + (_STUFFED + 8 * size - 1) // 4


def bus_load(spec: NetworkSpec, feedback_every: int) -> float:
    """The share of time that the bus, or the fuller one of two, is taken at most; see `bus_loads`."""
    return max(bus_loads(spec, feedback_every))


def bus_loads(spec: NetworkSpec, feedback_every: int) -> tuple[float, ...]:
    """The share of time that each bus is taken at most, by all that is sent again and again.

    Parameters
    ----------
    spec
    feedback_every
        In how many cycles a drive says its following error and what is left in its buffer.
    """
    if spec.bus2 is None:
        return (_load(spec, spec.bus, len(spec.drives.nodes), True, feedback_every),)
    second = [node for node in spec.drives.nodes if node in spec.bus2.nodes]
    has_slider = spec.slider is not None and spec.slider.node in spec.bus2.nodes
    return (
        _load(spec, spec.bus, len(spec.drives.nodes) - len(second), not has_slider, feedback_every),
        _load(spec, spec.bus2, len(second), has_slider, feedback_every),
    )


def heard_within(spec: NetworkSpec) -> float:
    """How long (s) it takes at most until all drives have said on the buses how they are, after a SYNC."""
    drives = [len(spec.drives.nodes)]
    if spec.bus2 is not None:
        second = sum(node in spec.bus2.nodes for node in spec.drives.nodes)
        drives = [drives[0] - second, second]
    an_axis = frame_bits(8) + frame_bits(5)
    if spec.bus.interface == EMULATED:  # frames take no time
        return _ANSWERS
    busy = [(count + 1) * an_axis / bus.bitrate for count, bus in zip(drives, spec.buses, strict=True)]
    return _ANSWERS + max(busy)


def _load(spec: NetworkSpec, bus: BusSpec, axes: int, has_slider: bool, feedback_every: int) -> float:
    """The share of time that a bus is taken at most, with the drives of so many cables, and perhaps the slider's."""
    of_a_drive = 8 if spec.drives.kind == "epos2" else 4
    cycle = axes * (frame_bits(of_a_drive) + frame_bits(4) + frame_bits(8) + frame_bits(5) / feedback_every)
    nodes = axes + 1
    if has_slider and spec.slider is not None and spec.slider.kind != "serial":
        cycle += frame_bits(8 if spec.slider.kind == "epos2" else 4) + 2 * frame_bits(8)
        nodes += 1
    per_second = (cycle + frame_bits(0)) / spec.cycle_s + nodes * frame_bits(1) / spec.watch.heartbeat_s
    return per_second / bus.bitrate


def line_load(spec: NetworkSpec) -> float:
    """The share of time that the line of a slider's board is taken, in the busier direction; 0 without a board."""
    slider = spec.slider
    if slider is None or slider.kind != "serial":
        return 0.0
    beats = 2.0 / spec.watch.heartbeat_s
    there, back = _TOLD / spec.cycle_s + _ASKED * beats, _ANSWER / spec.cycle_s + _ANSWER * beats
    return _BITS_OF_A_BYTE * max(there, back) / slider.baud


def refuse_slow_line(spec: NetworkSpec, source: str) -> None:
    """Raise an InputError if a slider's board cannot be told and asked in time."""
    load = line_load(spec)
    if load > _MOST_OF_LINE:
        assert spec.slider is not None, "there is a line"
        raise InputError(
            f"{source}: slider: its serial line would be taken for {100 * load:.0f} % of the time at "
            f"{spec.slider.baud:,} baud, more than {100 * _MOST_OF_LINE:.0f} %: raise slider.baud, or lengthen cycle_s "
            f"({1e3 * spec.cycle_s:g} ms)"
        )
