"""One motion of all axes: set-points go out ahead of time, take effect together, and end together or in a stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.axes import Axes
from hognose.drive.bus import BusError
from hognose.drive.cia402 import ENABLE, INTERPOLATE, INTERPOLATING, QUICK_STOP, State
from hognose.drive.frames import Frame
from hognose.drive.motions import Counts, Motion, SetPoint
from hognose.drive.network import FEEDBACK_EVERY
from hognose.drive.watch import Stop, Trouble, Watch

Array = NDArray[np.float64]
#: Tensions (c,) N that are planned at a place (steps), or None where they may be anything.
Planned = Callable[[float], Array | None]

#: Bits of the status of a buffer: it holds few records, or many.
_FEW, _MANY = 0x01, 0x02
#: So many cycles are waited for until all axes are where the motion ends, before that is an error.
_PATIENCE = 40
#: So long (s) a drive may take to do what a controlword says.
_REACTION = 2e-3
#: Axes are where they were told to be within so many counts, or what they may be off by, if that is less.
_ARRIVED = 20


class Cycle(NamedTuple):
    """A cycle that is over.

    Attributes
    ----------
    time : s
        When it began.
    set_point
        What took effect at its beginning.
    lateness : s
        How much later than it should its set-points went out.
    """

    time: float
    set_point: SetPoint
    lateness: float


@dataclass
class Outcome:
    """How a motion ended.

    Attributes
    ----------
    place
        Along the plan (steps), of the last set-point that took effect.
    trouble
        What ended it; None if it came to its end, or was told to stop.
    """

    place: float
    trouble: Trouble | None = None


def _anything(place: float) -> None:
    """Nothing is planned of tensions."""
    del place


class Stream:
    """Sends the set-points of a motion, cycle after cycle.

    Parameters
    ----------
    axes
    clock
    cycle : s
        Whole milliseconds.
    seen : function
        Called with every cycle.

    Attributes
    ----------
    halted
        Set it, and all axes stop at once.
    """

    def __init__(
        self,
        axes: Axes,
        cycle: float,
        seen: Callable[[Cycle], None],
    ) -> None:
        self._axes, self._clock, self._cycle = axes, axes.clock, cycle
        self._milliseconds = round(1e3 * cycle)
        self._seen, self._planned = seen, _anything
        self._unbegun, self._asked = axes.by_records.copy(), False
        self.halted = False
        self._arrived = np.minimum(_ARRIVED, axes.network.following_windows)
        drives = axes.network.spec.drives
        self._depth, self._most_extra = drives.least_records + 1, drives.most_records - drives.least_records - 1

    def go(
        self,
        motion: Motion,
        start: SetPoint,
        watch: Watch,
        planned: Planned = _anything,
        begun: Callable[[], None] = lambda: None,
    ) -> Outcome:
        """Go through a motion that begins where all axes are, to its end or to what stops it.

        What cables pull on the way is compared with what is planned. Where anything fails in the program itself, all
        axes stop at once. `begun` is called when the first set-points are with the drives.
        """
        self._planned = planned
        self._axes.ask()
        wrong = self._told() or watch.look(self._clock.now(), None) or self._elsewhere(start)
        if wrong is None:
            self._axes.control_all(ENABLE)  # records are not to begin while buffers are filled
            wrong = self._empty()
        if wrong is not None:
            return Outcome(start.place, wrong)
        try:
            return self._go(motion, start, watch, begun)
        except BaseException:
            self.stop_at_once()
            raise

    def _go(self, motion: Motion, start: SetPoint, watch: Watch, begun: Callable[[], None]) -> Outcome:
        queue = _Ahead(motion, start, self._cycle)
        for depth in range(1, self._depth + 1):  # a record of all at a time: all at once are more than sockets queue
            filled = self._clock.now()
            self._axes.send(self._frames(queue, depth, start.counts))
            self._axes.sync()
            self._axes.wait(filled + self._cycle)
        if queue.ended and len(queue.points) == 1:  # it was stopped before it began, and a single record is a fault
            return Outcome(start.place)
        begun()
        if (wrong := self._told() or watch.look(self._clock.now(), None)) is not None:  # all that follows enables
            self.stop_at_once()
            return Outcome(start.place, wrong)
        self._axes.control_all(ENABLE)  # so that the bit that starts the records rises with the next
        self._axes.control_all(INTERPOLATE)
        began, k, extra, trouble = self._clock.now(), 0, 0, None
        self._unbegun, self._asked = self._axes.by_records.copy(), False
        while k <= queue.last():
            at = queue.points[k]
            extra = min(max(extra + self._more(k), 0), self._most_extra)
            frames = self._frames(queue, k + 1 + self._depth + extra, queue.now(k + 1).counts)
            fastest = np.max([np.abs(queue.velocity(k + ahead)) for ahead in range(self._depth)], axis=0)
            frames += self._axes.decelerations(fastest, self._axes.network.spec.watch.stop_s)
            now = self._clock.now()
            late = max(0.0, now - began - k * self._cycle)
            if not self._axes.by_records.any():  # what takes effect at SYNC is late with it, and must not catch up
                began += late
            self._axes.send(frames)
            self._axes.sync()
            self._axes.wait(began + (k + 1) * self._cycle)
            self._seen(Cycle(now, at, late))
            found = self._too_late(late) or self._wrong(watch, now, at, fastest * (1.5 + late / self._cycle))
            if found is not None and found.stop is Stop.AT_ONCE:
                self.stop_at_once()
                return Outcome(at.place, found)
            if found is not None and trouble is None:
                trouble = found
                motion.stop()
            k += 1
        return self._settled(queue, trouble, watch)

    def _too_late(self, late: float) -> Trouble | None:
        """What is wrong if the program is late: records go on in time, and cyclic positions would have to catch up."""
        records = self._axes.by_records
        if records.all() or not records.any() or late <= 0.5 * self._cycle:
            return None
        words = f"the program was {1e3 * late:.0f} ms late with set-points for drives of both kinds"
        return Trouble(Stop.AT_ONCE, None, words)

    def _wrong(self, watch: Watch, began: float, at: SetPoint, ahead: Array) -> Trouble | None:
        """What is wrong after a cycle that began at a time (s), when a set-point took effect.

        Axes may be so far (A,) counts/s, a cycle long, from it by now.
        """
        wrong = self._told() or watch.look(self._clock.now(), self._planned(at.place))
        return wrong or self._left_behind(began) or self._behind(at, ahead)

    def _told(self) -> Trouble | None:
        return Trouble(Stop.AT_ONCE, None, "it was told to stop at once") if self.halted else None

    def _left_behind(self, began: float) -> Trouble | None:
        """What is wrong if a drive does not begin to go through its records: all others would go on without it.

        Each is judged by the first status that it gives after its second SYNC.
        """
        if not self._unbegun.any():
            return None
        begun = (self._axes.status & INTERPOLATING) != 0
        late = self._unbegun & ~begun & (self._axes.heard >= began) & self._asked
        self._unbegun &= ~begun
        self._asked = True
        for axis in np.flatnonzero(late):
            words = f"{self._axes.network.axis_name(int(axis))}: did not begin to move with the others"
            return Trouble(Stop.AT_ONCE, int(axis), words)
        return None

    def _empty(self) -> Trouble | None:
        """Empty the buffers of what a motion before, or another program, left there; what is wrong if that fails."""
        words = self._axes.empty_buffers()
        return Trouble(Stop.AT_ONCE, None, f"{words}; nothing was moved") if words else None

    def _behind(self, at: SetPoint, ahead: Array) -> Trouble | None:
        """What is wrong if an axis does not go where it is told to: it may be far from that without noticing itself."""
        windows = self._axes.network.following_windows + self._arrived
        beyond = np.abs(self._axes.position - at.counts) - (windows + self._cycle * ahead)
        axis = int(np.argmax(beyond))
        if beyond[axis] <= 0.0:
            return None
        off = abs(int(self._axes.position[axis] - at.counts[axis]))
        return Trouble(
            Stop.AT_ONCE, axis, f"{self._axes.network.axis_name(axis)}: is {off} counts from where it is to be"
        )

    def _elsewhere(self, start: SetPoint) -> Trouble | None:
        """What is wrong if an axis is not where a motion begins: it would jump there."""
        off = np.abs(self._axes.position - start.counts)
        axis = int(np.argmax(off - self._arrived))
        if off[axis] <= self._arrived[axis]:
            return None
        words = f"is {int(off[axis])} counts from where the motion begins; nothing was moved"
        return Trouble(Stop.AT_ONCE, axis, f"{self._axes.network.axis_name(axis)}: {words}")

    def stop_at_once(self) -> None:
        """Stop all axes by one frame; they take the same time, and hold their positions then.

        Drives that say afterwards that they go on are told again, by themselves. If one still does, or the bus takes
        nothing any more, the master falls silent: all stop by themselves then.
        """
        axes, first = self._axes, self._clock.now()
        a_round, insists = _REACTION + axes.network.answer_s, axes.network.insists_s(self._cycle)
        going: list[int] = []
        while True:
            began = self._clock.now()
            is_last, failed = began + 2.0 * a_round > first + insists, None
            try:
                axes.control_all(QUICK_STOP)
                for axis in going:
                    axes.stop_one(axis)
                axes.wait(began + _REACTION)
                axes.ask()
            except BusError as error:
                failed = error
                self._clock.wait(began + a_round)
            going = self._going(began)
            if failed is None and not going:
                return
            if is_last:
                break
        names = ", ".join(axes.network.axis_name(axis) for axis in going[:3])
        axes.mute_for = f"{names or 'some drives'} went on"
        if failed is not None:
            axes.mute_for = "the bus took no frames"
            raise failed

    def _going(self, since: float) -> list[int]:
        """The axes that say since a time (s) that they go on, or could not hear that they are to stop."""
        axes = self._axes
        enabled, fresh = [state is State.OPERATION_ENABLED for state in axes.states()], axes.heard > since
        return np.flatnonzero(np.where(fresh, enabled, axes.dropped & ~axes.restarted)).tolist()

    def _more(self, k: int) -> int:
        """One record more where a buffer holds few, one less where one holds many, as often as drives say it."""
        records = self._axes.buffer[self._axes.by_records]
        if not records.size or k % FEEDBACK_EVERY:
            return 0
        return 1 if (records & _FEW).any() else -1 if (records & _MANY).any() else 0

    def _frames(self, queue: _Ahead, upto: int, current: Counts) -> list[Frame]:
        """Set-points that are due: records ahead of time, up to a number; cyclic positions for the next cycle."""
        found: list[Frame] = []
        for point, velocity, is_last in queue.take(upto):
            milliseconds = 0 if is_last else self._milliseconds
            found += self._axes.set_points(point.counts, velocity, milliseconds, records=True)
        return found + self._axes.set_points(current, np.zeros(len(current)), self._milliseconds, records=False)

    def _settled(self, queue: _Ahead, trouble: Trouble | None, watch: Watch) -> Outcome:
        """Wait until all axes are where the motion ends."""
        end = queue.points[-1]
        for _ in range(_PATIENCE):
            off = np.abs(self._axes.position - end.counts)
            if (off <= self._arrived).all():
                return Outcome(end.place, trouble)
            now = self._clock.now()
            self._axes.sync()
            self._axes.wait(now + self._cycle)
            self._seen(Cycle(now, end, 0.0))
            found = self._told() or watch.look(self._clock.now(), None)
            if found is not None and found.stop is Stop.AT_ONCE:
                self.stop_at_once()
                return Outcome(end.place, found)
        axis = int(np.argmax(np.abs(self._axes.position - end.counts) - self._arrived))
        self.stop_at_once()
        words = f"is {abs(int(self._axes.position[axis] - end.counts[axis]))} counts from where the motion ends"
        return Outcome(end.place, Trouble(Stop.AT_ONCE, axis, f"{self._axes.network.axis_name(axis)}: {words}"))


class _Ahead:
    """The set-points of a motion, with the velocities there, as far ahead as they were asked for."""

    def __init__(self, motion: Motion, start: SetPoint, cycle: float) -> None:
        self.points, self.ended, self._motion, self._cycle = [start], False, motion, cycle
        self._sent = 0

    def take(self, upto: int) -> list[tuple[SetPoint, Array, bool]]:
        """Those that were not taken yet, up to a number; the last of all has no velocity."""
        self._reach(upto + 1)
        found = []
        while self._sent < min(upto, len(self.points)):
            k = self._sent
            is_last = self.ended and k == len(self.points) - 1
            found.append((self.points[k], self.velocity(k), is_last))
            self._sent += 1
        return found

    def velocity(self, k: int) -> Array:
        """Counts/s (A,) at the k-th: the mean of both sides, at both ends of the motion none."""
        last = len(self.points) - 1
        if k <= 0 or k >= last:
            return np.zeros(len(self.points[0].counts))
        return (self.points[k + 1].counts - self.points[k - 1].counts) / (2.0 * self._cycle)

    def now(self, k: int) -> SetPoint:
        """The k-th, or the last."""
        self._reach(k)
        return self.points[min(k, len(self.points) - 1)]

    def last(self) -> int:
        """The number of the last one, or of one that is still to come."""
        return len(self.points) - 1

    def _reach(self, k: int) -> None:
        while not self.ended and len(self.points) <= k:
            point = self._motion.next()
            if point is None:
                self.ended = True
            else:
                self.points.append(point)
