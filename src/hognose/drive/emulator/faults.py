"""What can be made to go wrong with emulated drives."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal, cast, get_args

from hognose.errors import InputError

FaultKind = Literal[
    "following_error", "overcurrent", "emergency", "heartbeat_lost", "frozen", "bus_off", "stuck", "power_lost",
    "underflow", "encoder_jump", "late", "garbage", "bad_checksums",
]  # fmt: skip
KINDS: tuple[str, ...] = get_args(FaultKind)
_KINDS = ", ".join(KINDS)
#: Those that only a slider's board has, and those that it has not.
OF_BOARDS, OF_DRIVES = ("garbage", "bad_checksums"), ("bus_off", "underflow")


@dataclass(frozen=True)
class Fault:
    """A fault of a node at a time.

    Attributes
    ----------
    node
    kind
        `following_error`, `overcurrent` and `emergency` report an error and cut the power; `heartbeat_lost` sends no
        heartbeats; `frozen` sends nothing and hears nothing, while the motor goes on; `bus_off` as well, and says so;
        `stuck` blocks the motor; `power_lost` starts the drive anew; `underflow` empties its buffer; `encoder_jump`
        shifts its position by 1000 counts; `late` sends everything 60 ms later. A slider's board has no buffer and no
        bus; its encoder jumps by 10000 counts, it is late by 100 ms, its answers are nothing but `garbage`, or some
        have `bad_checksums`, and after `power_lost` it does not know where it is.
    time : s
        Of the emulator; at once unless given.
    """

    node: int
    kind: FaultKind
    time: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"fault: kind: expected one of {_KINDS}, got {self.kind!r}")

    @classmethod
    def parsed(cls, text: str, nodes: Collection[int], board: int | None) -> Fault:
        """A fault as people type it, `NODE:KIND:WHEN` or `NODE:KIND`; see `refuse`.

        Raises
        ------
        InputError
            It is no such fault.
        """
        node, _, rest = text.partition(":")
        kind, _, when = rest.partition(":")
        try:
            number, time = int(node), float(when or 0.0)
        except ValueError:
            number, time = 0, -1.0
        if not (math.isfinite(time) and time >= 0.0):
            raise InputError(f"fault: expected NODE:KIND:WHEN, such as 9:overcurrent:20, got {text!r}; kinds: {_KINDS}")
        fault = cls(number, cast("FaultKind", kind), time)
        fault.refuse(nodes, board)
        return fault

    def refuse(self, nodes: Collection[int], board: int | None) -> None:
        """Raise an InputError if none of these nodes, of which one may be a slider's board, can have it."""
        if self.node not in nodes:
            raise InputError(f"fault: there is no node {self.node}; nodes are {sorted(nodes)}")
        if self.kind in OF_BOARDS and self.node != board:
            raise InputError(f"fault: kind: {self.kind!r} is one of a slider's board, and node {self.node} is none")
        if self.kind in OF_DRIVES and self.node == board:
            known = ", ".join(kind for kind in KINDS if kind not in OF_DRIVES)
            raise InputError(f"fault: kind: {self.kind!r} is none of a slider's board; those are {known}")
