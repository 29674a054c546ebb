"""How much of the time a CAN bus is taken by what is sent in every cycle, with as many stuffed bits as there can be."""

from __future__ import annotations

from hognose.drive.network_spec import NetworkSpec

#: Bits of a frame with an identifier of 11 bits besides its data, and those of them that are stuffed (CAN 2.0, A.1).
_BESIDE, _STUFFED = 47, 34


def frame_bits(size: int) -> int:
    """Bits of a frame with so many bytes of data at most, with the space behind it."""
    return _BESIDE + 8 * size + (_STUFFED + 8 * size - 1) // 4


def bus_load(spec: NetworkSpec, feedback_every: int) -> float:
    """The share of time that the bus is taken at most, by all that is sent again and again.

    Parameters
    ----------
    spec
    feedback_every
        In how many cycles a drive says its following error and what is left in its buffer.
    """
    axes = len(spec.drives.nodes)
    of_a_drive = 8 if spec.drives.kind == "epos2" else 4
    cycle = axes * (frame_bits(of_a_drive) + frame_bits(4) + frame_bits(8) + frame_bits(5) / feedback_every)
    nodes = axes + 1
    if spec.slider is not None and spec.slider.kind != "serial":
        cycle += frame_bits(8 if spec.slider.kind == "epos2" else 4) + 2 * frame_bits(8)
        nodes += 1
    per_second = (cycle + frame_bits(0)) / spec.cycle_s + nodes * frame_bits(1) / spec.watch.heartbeat_s
    return per_second / spec.bus.bitrate
