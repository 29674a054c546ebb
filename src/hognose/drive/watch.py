"""What goes wrong while an arm moves, by axis, and how all axes have to stop for it: looked for in every cycle."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from hognose.drive.axes import Axes
from hognose.drive.cia402 import CYCLIC_POSITION, INTERPOLATED_POSITION, State

Array = NDArray[np.float64]

#: A cable that is so many times farther off than it may be stops all at once, not along the path.
_WORSE = 3.0
#: What error codes of drives mean (maxon, CiA 301 and CiA 402).
CODES = {
    0x1000: "generic error",
    0x2310: "over-current",
    0x3210: "over-voltage",
    0x3220: "under-voltage",
    0x4210: "over-temperature",
    0x7320: "position sensor",
    0x8110: "CAN overrun",
    0x8130: "the master's heartbeat was lost",
    0x8210: "a PDO was too short",
    0x8181: "messages on its serial line are damaged or lost",
    0x8182: "its serial line is gone: is it unplugged?",
    0x8183: "it refused what it was told",
    0x81FD: "bus off",
    0x8611: "following error",
    0xFF0C: "interpolated position mode: its buffer ran empty or full",
}


class Stop(Enum):
    """How all axes stop: along the path, or at once."""

    ALONG_PATH = "along the path"
    AT_ONCE = "at once"


@dataclass(frozen=True)
class Trouble:
    """What went wrong.

    Attributes
    ----------
    stop
    axis
        0-based; None where it is no axis'.
    words
        With the name of the axis.
    """

    stop: Stop
    axis: int | None
    words: str


class Watch:
    """Looks at all axes once a cycle.

    Parameters
    ----------
    axes
    cycle : s
    only_above
        Whether cables may pull less than they are to, as long as slack is taken up.
    """

    def __init__(self, axes: Axes, cycle: float, only_above: bool = False) -> None:
        self._axes, self._cycle, self._seen = axes, cycle, len(axes.emergencies)
        self._only_above, self._commanded = only_above, axes.foreign_commands
        self._allowed: Array = np.full(len(axes.tensions), axes.network.spec.watch.tension_band_N)

    def look(self, now: float, tensions: Array | None, powered: int | None = None) -> Trouble | None:
        """The worst that is wrong now (s); None if all is well.

        Parameters
        ----------
        now : s
        tensions : (c,) N
            What is planned; None where it may be anything.
        powered
            So many axes have to hold their positions, from the first one on; all unless given.
        """
        wrong = self._errors() or self.other_master() or self._restarts() or self._silence(now)
        return wrong or self._power(powered) or self.band(tensions)

    def is_out(self, tensions: Array) -> bool:
        """Whether a cable is out of its band around what is planned (c,) N."""
        band = self._axes.network.spec.watch.tension_band_N
        return bool((np.abs(self._axes.tensions - tensions) > band).any())

    def forgive(self, tensions: Array) -> None:
        """Let cables that are out of their band around (c,) N come back into it: they may not get further out by more.

        After a stop for a tension, the way back must be open.
        """
        off, band = np.abs(self._off(tensions)), self._axes.network.spec.watch.tension_band_N
        self._allowed = np.where(off > band, off + band, band)

    def _named(self, axis: int, words: str, stop: Stop = Stop.AT_ONCE) -> Trouble:
        return Trouble(stop, axis, f"{self._axes.network.axis_name(axis)}: {words}")

    def _errors(self) -> Trouble | None:
        fresh = self._axes.emergencies[self._seen :]
        self._seen = len(self._axes.emergencies)
        for _, axis, code in fresh:
            return self._named(axis, f"reports an error, {CODES.get(code, 'of its maker')} (0x{code:04X})")
        return None

    def other_master(self) -> Trouble | None:
        """What is wrong if somebody else has commanded drives since this was made."""
        if self._axes.foreign_commands == self._commanded:
            return None
        words = f"there is another master on the bus: somebody {self._axes.other_master}. End that program"
        return Trouble(Stop.AT_ONCE, None, words)

    def _restarts(self) -> Trouble | None:
        axes = self._axes
        for axis in np.flatnonzero(axes.restarted):
            return self._named(int(axis), "has started anew: was its supply cut?")
        for axis in np.flatnonzero(axes.dropped):
            return self._named(int(axis), "is not operational any more, and hears no set-points: who told it so?")
        wanted = np.where(axes.by_records, INTERPOLATED_POSITION, CYCLIC_POSITION)
        for axis in np.flatnonzero((axes.mode != 0) & (axes.mode != wanted)):
            return self._named(int(axis), f"is in mode {axes.mode[axis]} of operation, expected {wanted[axis]}")
        return None

    def _silence(self, now: float) -> Trouble | None:
        watch = self._axes.network.spec.watch
        silent = now - self._axes.beaten
        axis = int(np.argmax(silent))
        if silent[axis] > watch.lost_after_s:
            return self._named(axis, f"no heartbeat for {1e3 * silent[axis]:.0f} ms")
        late = now - self._axes.heard
        axis = int(np.argmax(late))
        if late[axis] > (watch.late_cycles + 0.5) * self._cycle:
            return self._named(axis, f"its status is {1e3 * late[axis]:.0f} ms late", Stop.ALONG_PATH)
        return None

    def _power(self, count: int | None) -> Trouble | None:
        for axis, state in enumerate(self._axes.states()[:count]):
            if state is not State.OPERATION_ENABLED:
                return self._named(axis, f"does not hold its position any more: {state.words}")
        return None

    def band(self, tensions: Array | None) -> Trouble | None:
        """What is wrong if a cable is out of its band around what is planned (c,) N; nothing if that is None."""
        if tensions is None:
            return None
        off, band = np.abs(self._off(tensions)), self._axes.network.spec.watch.tension_band_N
        axis = int(np.argmin(self._axes.tensions))
        if self._axes.tensions[axis] < -band:
            pushes = f"says that it pushes with {-self._axes.tensions[axis]:.0f} N"
            return self._named(axis, f"{pushes}, which no cable can: has drives.newton_per_unit the right sign?")
        axis = int(np.argmax(off - self._allowed))
        if off[axis] > self._allowed[axis]:
            pulls = f"pulls {self._axes.tensions[axis]:.0f} N, planned are {tensions[axis]:.0f} N"
            stop = Stop.AT_ONCE if off[axis] > _WORSE * self._allowed[axis] else Stop.ALONG_PATH
            return self._named(axis, f"{pulls}, more than {self._allowed[axis]:.0f} N apart", stop)
        self._allowed = np.maximum(band, np.minimum(self._allowed, off + band))
        return None

    def _off(self, tensions: Array) -> Array:
        off = self._axes.tensions - tensions
        return np.maximum(off, 0.0) if self._only_above else off
