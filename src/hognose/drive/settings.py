"""How far a run is, and how a plan is run."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from hognose.errors import InputError


class Phase(Enum):
    """How far a run is."""

    OFF = "off"
    ARMED = "armed"
    HOLD = "hold"
    TENSION = "tension"
    READY = "ready"
    PREFILL = "prefill"
    RUN = "run"
    HELD = "held"
    STOPPED = "stopped"


@dataclass(frozen=True)
class Settings:
    """How a plan is run.

    Attributes
    ----------
    rate
        As a share of the plan's own speed, above 0 and up to 1.
    ramp : s
        How long it takes to come to the plan's own speed, or to rest.
    watches_tension
        Whether tensions must stay in their band; not where nothing hangs on the motors.
    """

    rate: float = 1.0
    ramp: float = 0.3
    watches_tension: bool = True

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1.0:
            raise InputError(f"rate: expected a share of the plan's speed, above 0 and up to 1, got {self.rate:g}")
        if not 0.0 <= self.ramp <= 10.0:
            raise InputError(f"ramp: expected seconds from 0 to 10, got {self.ramp:g}")
