"""Runs a plan on drives: from finding them to holding at the end, and back on the same way at any moment."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hognose.drive import cia402
from hognose.drive.approach import Approach
from hognose.drive.axes import Axes
from hognose.drive.bring_up import Found, bring_up
from hognose.drive.bus import Bus, BusError
from hognose.drive.cia402 import State
from hognose.drive.clock import Clock
from hognose.drive.expected import Expected
from hognose.drive.holding import Holding
from hognose.drive.homing import refuse_not_homed
from hognose.drive.motions import AlongPlan, SetPoint, counts_of, nearest_place
from hognose.drive.network import Network
from hognose.drive.progress import Progress, interpolated
from hognose.drive.settings import Phase, Settings
from hognose.drive.stream import Cycle, Outcome, Stream
from hognose.drive.switching import Switching
from hognose.drive.watch import Stop, Trouble, Watch
from hognose.errors import InfeasibleError, InputError
from hognose.planning import Plan

Array = NDArray[np.float64]

#: Cables that pull less (N) are slack.
_NO_TENSION = 5.0
#: By how much (m) cables may be off where a plan begins; they are brought there, slowly.
MOST_SLACK = 5e-3


class Executor:
    """A run of a plan.

    Attributes
    ----------
    plan, network
    axes
        What the drives say.
    phase
    place
        Along the plan (steps), of the last set-point that took effect.
    obstructed
        Why it must not go further in, in words; empty if it may. The way back is open.
    """

    def __init__(
        self,
        plan: Plan,
        network: Network,
        bus: Bus,
        clock: Clock,
        settings: Settings | None = None,
        seen: Callable[[Cycle], None] = lambda cycle: None,
        said: Callable[[str, str, int | None], None] = lambda kind, words, axis: None,
    ) -> None:
        """Nothing is sent yet.

        Parameters
        ----------
        plan, network
        bus, clock
        settings
        seen
            Called with every cycle that is over.
        said
            Called with the kind of an event, what happened in words, and the axis (0-based) that it is about, or None.

        Raises
        ------
        InputError
            The plan is not good, is another robot's, or beyond what the axes reach.
        """
        failed = [check.sentence for check in plan.checks if check.failed]
        if failed:
            raise InputError(f"{plan.task.name}: the plan is not good, and is not run: {failed[0]}")
        network.refuse(plan)
        self.plan, self.network, self.axes = plan, network, Axes(bus, clock, network)
        self.phase, self.place = Phase.OFF, 0.0
        self._bus, self._clock, self._said = bus, clock, said
        self._settings = settings or Settings()
        self._counts, self._cycles = counts_of(plan, network), network.cycles_of(plan)
        self.cycle = float(plan.task.spec.motion.period_s) / self._cycles
        self._expected = Expected(plan, self.axes, self.cycle, self._settings.watches_tension)
        self._stream = Stream(self.axes, self.cycle, seen)
        self._approach = Approach(self.axes, self._stream, self.cycle, self._counts, self._cycles)
        self._switching, self._holding = Switching(self.axes), Holding(self.axes, self.cycle, seen, said)
        self._motion: AlongPlan | None = None
        self._refused = self.obstructed = ""

    def arm(self, progress: Callable[[int, int], None] = lambda done, total: None) -> list[Found]:
        """Find all drives, write what they need, and begin to exchange heartbeats; still without power.

        Raises
        ------
        InputError
            What is wrong with which drives.
        """
        watch = Watch(self.axes, self.cycle)
        found = bring_up(self._bus, self._clock, self.network, self.cycle, self.axes.take, progress)
        self.axes.start()
        self._switching.until(self._switching.all_heard, "says its status and sends heartbeats")
        if other := watch.other_master():
            raise InputError(f"{self.network.source}: {other.words}")
        self._enter(Phase.ARMED, f"{len(found)} drives, {sum(each.written > 0 for each in found)} configured anew")
        return found

    def hold(self) -> None:
        """Enable all drives where they stand, from the base to the tip; none moves.

        Raises
        ------
        InfeasibleError
            A drive does not know where it is, or does not come to hold its position.
        """
        if self.phase is not Phase.ARMED:
            raise InputError(f"hold: it is {self.phase.value}; arm it first, or `recover` after a stop")
        refuse_not_homed(self.axes)
        self._stream.halted = False
        watch, targets = Watch(self.axes, self.cycle), self.axes.position.copy()
        with self._stopping_all("while drives were enabled"):
            for axis in range(len(self.axes)):
                targets[axis] = self.axes.position[axis]  # those that hold already keep theirs, or they might creep
                self.axes.send(self.axes.set_points(targets, np.zeros(len(self.axes)), 0, records=False))
                self._switching.enable(axis, lambda axis=axis: watch.look(self._clock.now(), None, powered=axis))
            if (trouble := watch.look(self._clock.now(), None)) is not None:
                raise InfeasibleError(trouble.words)
        self._enter(Phase.HOLD, "all axes hold their positions")

    def tension(self, place: float = 0.0, may_be_out: bool = False) -> None:
        """Bring all axes to where the plan is at a place (steps), slowly, and see that cables pull what they are to.

        Cables may be out of their band where that is asked for: then the way back is open, and no other.

        Raises
        ------
        InfeasibleError
            The arm stands elsewhere, or something goes wrong on the way.
        """
        if self.phase is not Phase.HOLD:
            raise InputError(f"tension: it is {self.phase.value}; hold it first, or `recover` after a stop")
        end, self._refused = interpolated(self._counts, place), ""
        off = self._approach.off(end)
        axis = int(np.argmax(np.abs(off)))
        if abs(off[axis]) > MOST_SLACK:
            raise InfeasibleError(
                f"the arm stands elsewhere than the plan at step {place:g}: {self.network.axis_name(axis)} is off by "
                f"{1e3 * off[axis]:.2f} mm, at most {1e3 * MOST_SLACK:g} mm are taken up. Bring it to where the plan "
                "begins, or continue with --resume from where it stands"
            )
        self._enter(Phase.TENSION, f"the largest way is {1e3 * abs(off[axis]):.2f} mm")
        trouble = self._approach.go(end, place, self._expected.tensions(place))
        if trouble is not None:
            self._enter(Phase.STOPPED, trouble.words)
            raise InfeasibleError(f"on the way to where the plan is: {trouble.words}")
        self._enter(Phase.READY, "the arm is where the plan is" + self._expected.in_words(place, may_be_out))
        self.place = place

    def run(self, until: float | None = None, rate: float | None = None) -> Outcome:
        """Go along the plan to a place (steps), forwards or back; to its end unless given.

        Raises
        ------
        InputError
            It is not ready.
        """
        if self.phase is Phase.STOPPED:
            raise InputError("run: all axes were stopped at once, off their plan; `recover` brings them back first")
        if self.phase not in (Phase.READY, Phase.HELD):
            raise InputError(f"run: it is {self.phase.value}; bring it to ready first")
        end, share = self.end(until), self._settings.rate if rate is None else Settings(rate).rate
        if end == self.place:
            return Outcome(self.place)
        ramp = max(1, round(self._settings.ramp / self.cycle))
        progress = Progress(len(self._counts) - 1, self._cycles, ramp, self.place)
        self._motion = AlongPlan(self._counts, progress, math.copysign(share, end - self.place), end)
        watch = Watch(self.axes, self.cycle)
        if end > self.place:  # before drives get records, which cannot be taken back
            self.axes.ask()
            closed = Trouble(Stop.ALONG_PATH, None, self.obstructed) if self.obstructed else None
            if (closed := closed or self._expected.closes(self.place)) is not None:
                self._motion = None
                self._said("trouble", closed.words, closed.axis)
                return Outcome(self.place, closed)
        self._refused = ""
        self._enter(Phase.PREFILL, "the drives get their first set-points")
        start, planned = SetPoint(self.commanded, self.place), self._expected.tensions(self.place)
        words = f"from step {self.place:.1f} to {end:g} at {100 * share:g} % of the plan's speed"
        if planned is not None and end < self.place:  # the way back is open, the way into it is not
            watch.forgive(planned)
        with self._stopping_all("on the way"):
            begun = partial(self._enter, Phase.RUN, words)
            outcome = self._stream.go(self._motion, start, watch, self._expected.tensions, begun)
        self.place, self._motion = outcome.place, None
        if outcome.trouble is not None:
            self._said("trouble", outcome.trouble.words, outcome.trouble.axis)
        if self._refused:  # a contact, say; what else went wrong may follow from it
            other = outcome.trouble or Trouble(Stop.ALONG_PATH, None, "")
            words = "; ".join(filter(None, (self._refused, other.words)))
            outcome = Outcome(outcome.place, Trouble(other.stop, other.axis, words))
        at_once = outcome.trouble is not None and outcome.trouble.stop is Stop.AT_ONCE
        self._enter(Phase.STOPPED if at_once else Phase.HELD, f"at step {self.place:.1f}")
        return outcome

    @contextmanager
    def _stopping_all(self, when: str) -> Iterator[None]:
        """Whatever fails within stops all axes; `when` is said of what is no error of the program's."""
        try:
            yield
        except BaseException as error:
            with suppress(BusError):  # they stop by themselves then
                self._stream.stop_at_once()
            self._enter(Phase.STOPPED, str(error) or type(error).__name__)
            if isinstance(error, InfeasibleError):
                raise InfeasibleError(f"{when}: {error}") from None
            raise

    def end(self, until: float | None = None) -> float:
        """The step at which a run ends: the last one unless given; an InputError if there is no such step."""
        last = float(len(self._counts) - 1)
        if until is not None and not 0.0 <= until <= last:
            raise InputError(f"until: expected a step from 0 to {last:g}, got {until:g}")
        return last if until is None else float(until)

    def wait(self, done: Callable[[], bool]) -> Trouble | None:
        """Let all drives hold, or be without power, until something is done; what went wrong meanwhile, or None.

        Heartbeats and statuses are exchanged in cycles. If an axis that is to hold does not, all stop at once.
        """
        powered = self.phase not in (Phase.OFF, Phase.ARMED, Phase.STOPPED)
        planned = self._expected.tensions(self.place) if self.phase in (Phase.READY, Phase.HELD) else None
        at = SetPoint(self.commanded, self.place)
        trouble = self._holding.until(done, at, len(self.axes) if powered else 0, planned)
        if trouble is not None and powered:
            self._stream.stop_at_once()
            self._enter(Phase.STOPPED, f"at step {self.place:.1f}")
        return trouble

    def stop(self) -> None:
        """Come to rest along the path; to be called from `seen` or `said` while it runs."""
        if self._motion is not None:
            self._motion.stop()

    def refuse_to_go_on(self, why: str) -> None:
        """Come to rest along the path, and say why."""
        if not self._refused:
            self._refused = why
            self._said("trouble", why, None)
        self.stop()
        self._approach.refuse_to_go_on(why)

    @property
    def refuses(self) -> bool:
        """Whether it comes to rest, or did, because it was told to refuse to go on."""
        return bool(self._refused)

    def stop_at_once(self) -> None:
        """Stop all axes together, as soon as the cycle is over; to be called as `stop`."""
        self._stream.halted = True

    def change_rate(self, rate: float) -> None:
        """Go on at another share of the plan's speed, above 0 and up to 1."""
        if self._motion is not None:
            self._motion.rate = math.copysign(Settings(rate).rate, self._motion.rate)

    @property
    def rate(self) -> float:
        """The share of the plan's speed that it goes at unless told otherwise."""
        return self._settings.rate

    @property
    def commanded(self) -> NDArray[np.int64]:
        """The counts (A,) of the last set-point that took effect."""
        return interpolated(self._counts, self.place)

    def recover(self) -> float:
        """Reset errors, enable all axes again where they stand, and return to the plan where it is closest: that place.

        Raises
        ------
        InfeasibleError
            A drive does not hold its position again, or the arm is too far from its plan.
        """
        self.axes.forget()
        self.axes.mute_for, watch = "", Watch(self.axes, self.cycle)
        self._switching.until(self._switching.all_heard, "says its status and sends heartbeats")
        for axis, state in enumerate(self.axes.states()):
            if state in (State.FAULT, State.FAULT_REACTION):
                self.axes.control(axis, 0)
                self.axes.control(axis, cia402.FAULT_RESET)
        self._switching.rest()
        if other := watch.other_master():
            raise InfeasibleError(other.words)
        self.phase = Phase.ARMED
        self.hold()
        place, off = nearest_place(self._counts, self.axes.position)
        self._said("recovered", f"closest to step {place:.2f}, {int(np.abs(off).max())} counts off at most", None)
        self.tension(place, may_be_out=True)
        return place

    def release(self) -> None:
        """Pay out all cables until none pulls, and take the power of all drives, from the tip to the base.

        Nothing holds the arm then: it must lie, or be in its jig.

        Raises
        ------
        InfeasibleError
            A cable still pulls, or something goes wrong on the way; then all axes hold.
        """
        if self.phase not in (Phase.READY, Phase.HELD):
            raise InputError(
                f"release: it is {self.phase.value}; only an arm that holds along its plan can be released"
            )
        if self.place != 0.0:
            raise InputError(f"release: the arm is at step {self.place:g}; it is released at step 0, outside")
        slack = np.zeros(len(self.axes), np.int64)
        slack[: self.plan.robot.cables] = np.rint(MOST_SLACK / self.plan.robot.travel_per_count)
        end = self.axes.position + slack
        words = f"cables are paid out by {1e3 * MOST_SLACK:g} mm, in {self._approach.duration(end):.0f} s"
        self._enter(Phase.TENSION, words)
        trouble = self._approach.go(end, self.place, None)
        if trouble is not None:
            self._enter(Phase.STOPPED, trouble.words)
            raise InfeasibleError(f"while cables were paid out: {trouble.words}")
        cable = int(np.argmax(pulls := np.abs(self.axes.tensions)))
        if pulls[cable] > _NO_TENSION:
            self._enter(Phase.HOLD, "all axes hold, with slack")
            raise InfeasibleError(
                f"{self.network.axis_name(cable)} still pulls {pulls[cable]:.0f} N with "
                f"{1e3 * MOST_SLACK:g} mm of slack: the drives keep their power. Is the arm in its jig, or does it lie?"
            )
        for axis in reversed(range(len(self.axes))):
            self._switching.take_power(axis)
        self._enter(Phase.ARMED, "all drives are without power")

    def _enter(self, phase: Phase, words: str) -> None:
        self.phase = phase
        if phase is Phase.STOPPED and self.axes.mute_for:
            words += f"; {self.axes.mute_for}, so the master fell silent: drives stop by themselves"
        self._said(phase.value, words, None)
