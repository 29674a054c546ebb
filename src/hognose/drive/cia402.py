"""The state machine of a drive as CiA 402 defines it (IEC 61800-7-201): statuswords, controlwords, modes."""

from __future__ import annotations

from enum import Enum
from functools import cache


class State(Enum):
    """Of a drive, with the bits of the statusword that say it, and those that count."""

    NOT_READY = (0x00, 0x4F)
    SWITCH_ON_DISABLED = (0x40, 0x4F)
    READY_TO_SWITCH_ON = (0x21, 0x6F)
    SWITCHED_ON = (0x23, 0x6F)
    OPERATION_ENABLED = (0x27, 0x6F)
    QUICK_STOP_ACTIVE = (0x07, 0x6F)
    FAULT_REACTION = (0x0F, 0x4F)
    FAULT = (0x08, 0x4F)

    @property
    def has_power(self) -> bool:
        """Whether the motor holds its position."""
        return self in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)

    @property
    def words(self) -> str:
        """As people read it."""
        return self.name.lower().replace("_", " ")


@cache
def state_of(statusword: int) -> State:
    """The state that a statusword says; not ready where it says none."""
    for state in State:
        bits, mask = state.value
        if statusword & mask == bits:
            return state
    return State.NOT_READY


#: Controlwords (CiA 402): commands of the state machine.
SHUTDOWN, SWITCH_ON, ENABLE, DISABLE_VOLTAGE, QUICK_STOP, FAULT_RESET = 0x06, 0x07, 0x0F, 0x00, 0x02, 0x80
#: Enabled, with the bit that starts the interpolated position mode.
INTERPOLATE = 0x1F
#: Of the statusword in that mode: the drive goes through its records.
INTERPOLATING = 0x1000
#: Modes of operation: homing, interpolated position, cyclic synchronous position.
HOMING, INTERPOLATED_POSITION, CYCLIC_POSITION = 6, 7, 8
#: Bits of the statusword of maxon's drives: homing attained, homing error (both in homing mode), and the position is
#: referenced to the home position (in all modes).
HOMING_ATTAINED, HOMING_ERROR, REFERENCED = 0x1000, 0x2000, 0x8000


def towards_enabled(state: State) -> int | None:
    """The controlword of the next step towards `OPERATION_ENABLED`; None if there is none, or if it is enabled."""
    return {
        State.SWITCH_ON_DISABLED: SHUTDOWN,
        State.READY_TO_SWITCH_ON: SWITCH_ON,
        State.SWITCHED_ON: ENABLE,
    }.get(state)
