"""Takes a run to its end, and does on the way what people want: pause, go on, one step, back, stop, end."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Protocol

from hognose.drive.executor import Executor
from hognose.drive.settings import Phase
from hognose.drive.stream import Outcome
from hognose.drive.watch import Trouble
from hognose.drive.wishes import Want, Wish, Wishes
from hognose.errors import InfeasibleError

#: Who says what is typed where the program runs.
TERMINAL = "terminal"
#: What may be typed where it holds; anything else is asked for again.
_CHOICES = {
    **dict.fromkeys(("g", "go", "go on"), Want.GO_ON), **dict.fromkeys(("s", "step", "one step"), Want.STEP),
    **dict.fromkeys(("r", "retract"), Want.RETRACT), **dict.fromkeys(("e", "end", "stop", "quit", ""), Want.END),
}  # fmt: skip
#: So many wishes are looked at in a cycle.
_AT_ONCE = 64
#: What a person types for the arm to move, and how that is asked for.
YES = "yes"
HOW = f"Type {YES} to go: "
#: Parts of a step that rounding leaves.
_ROUNDING = 1e-9
#: What brings the arm to rest along its path.
_RESTING = (Want.PAUSE, Want.END, Want.RETRACT)
_QUESTION = "g: go on, s: one step, r: retract, e: end here? "


class Terminal(Protocol):
    """Where the program runs, and somebody who is there."""

    def ask(self, question: str) -> None:
        """Ask; does not wait."""
        ...

    def answer(self) -> str | None:
        """What was typed to what was asked, in lower case; None as long as nothing was. Empty if nothing will be."""
        ...


class Conductor:
    """A run with the people beside it.

    Parameters
    ----------
    executor
        It is ready, or stands along its plan.
    wishes
        Of people elsewhere; what makes the arm move is done only once somebody at the terminal confirms it.
    terminal
        None where nobody is asked: whatever brings the arm to rest is the end then.
    """

    def __init__(self, executor: Executor, wishes: Wishes, terminal: Terminal | None = None) -> None:
        self._executor, self._wishes, self._terminal = executor, wishes, terminal
        self._pending: deque[Wish] = deque()
        self._runs, self._asks = False, False
        self._trouble: Trouble | None = None
        self._declined: set[str] = set()
        #: Where it turned round or ended, in words, if it was told to; empty otherwise.
        self.turned = ""

    def notice(self) -> None:
        """Look for what is wanted; to be called with every cycle while it runs."""
        tensions = self._executor.phase is Phase.TENSION
        for _ in range(_AT_ONCE):
            if not (self._runs or tensions) or (wish := self._wishes.take()) is None:
                return
            if tensions and not self._runs and wish.want in _RESTING:
                self._executor.refuse_to_go_on(f"{wish.who} wants it to {wish.want.value}")
            else:
                self._take(wish)

    def interrupt(self, at_once: bool = False) -> bool:
        """Ctrl-C: come to rest along the path; once more, or `at_once`, stop at once; whether it concerned a motion.

        Where the arm holds and somebody is asked what then, it ends the run.
        """
        if self._runs:
            self._take(Wish(Want.STOP if at_once or self._pending else Want.PAUSE, TERMINAL))
        elif self._asks:
            self._wishes.put(Want.END, TERMINAL)
        return self._runs or self._asks

    def go(self, goal: float, one_step: bool = False) -> Outcome:
        """Go to a place (steps), or where people want to go instead.

        Parameters
        ----------
        goal
        one_step
            Pause at every step, and ask.
        """
        executor, self.turned = self._executor, ""
        while True:
            outcome = self._leg(self._next_step(goal) if one_step else goal)
            self._note_late()
            there = outcome.trouble is None and executor.place == goal and not self._pending
            if there or executor.phase is Phase.STOPPED:
                return outcome
            want = self._decided()
            if self._trouble is not None:
                return Outcome(executor.place, self._trouble)
            if want is Want.END:
                self.turned = self.turned or f"ended at step {executor.place:.2f}, as it was asked to"
                return outcome
            one_step = want is Want.STEP
            if want is Want.RETRACT:
                goal, self.turned = 0.0, f"retracted from step {executor.place:.2f}, as it was asked to"

    def confirmed(self, question: str) -> bool:
        """Ask whether to do something; yes where nobody is asked any more. Drives are heard meanwhile.

        Raises
        ------
        InfeasibleError
            Something went wrong with the drives meanwhile.
        """
        if self._terminal is None:
            return True
        self._pending.clear()
        said = self._answer(question, self._ended)
        if self._trouble is not None:
            raise InfeasibleError(self._trouble.words)
        return said == YES and not self._pending

    def _take(self, wish: Wish) -> None:
        """Do what is wanted while it runs, or keep it until it holds."""
        if wish.want is Want.STOP:
            self._executor.stop_at_once()
        elif self._pending or wish.want in _RESTING:
            self._executor.stop()
            self._pending.append(wish)

    def _leg(self, end: float) -> Outcome:
        self._pending.clear()
        self._declined.clear()
        self._runs = True
        try:
            return self._executor.run(end)
        finally:
            self._runs = False

    def _note_late(self) -> None:
        """Keep what came after the last cycle and brings the arm to rest: it is not to go on, nor back."""
        others: list[Wish] = []
        while (wish := self._wishes.take()) is not None:
            (self._pending if wish.want is Want.STOP or wish.want in _RESTING else others).append(wish)
        for wish in others:
            self._wishes.put(*wish)

    def _next_step(self, goal: float) -> float:
        place = self._executor.place
        if goal > place:
            return min(math.floor(place + _ROUNDING) + 1.0, goal)
        return max(math.ceil(place - _ROUNDING) - 1.0, goal)

    def _decided(self) -> Want:
        """What is to be done where the arm holds; the end if something goes wrong while that is waited for."""
        while self._terminal is not None and self._trouble is None:
            wish = self._pending.popleft() if self._pending else self._next_wish()
            if wish.want in (Want.END, Want.STOP):
                break
            if wish.want.starts_motion and (wish.who == TERMINAL or self._agreed(wish)):
                return wish.want
        return Want.END

    def _agreed(self, wish: Wish) -> bool:
        what = f"{wish.who} wants it to {wish.want.value} from step {self._executor.place:.2f}"
        said = self._answer(f"{what}. {HOW}", self._ended)
        if said != YES:
            self._declined.add(wish.who)
        return said == YES

    def _ended(self) -> bool:
        """Whether somebody wants it to end or to stop, which is kept; for other wishes there is a time later."""
        wish = self._wishes.take()
        if wish is not None and wish.want in (Want.END, Want.STOP):
            self._pending.append(wish)
        return bool(self._pending)

    def _next_wish(self) -> Wish:
        """What somebody wants next; the end if something goes wrong while that is waited for."""
        found: list[Wish] = []

        def noticed() -> bool:
            wish = self._wishes.take()
            if wish is not None and not (wish.want.starts_motion and wish.who in self._declined):
                found.append(wish)
            return bool(found)

        said = self._answer(f"step {self._executor.place:.2f}. {_QUESTION}", noticed)
        if found:
            return found[0]
        return Wish(Want.END if said is None else _CHOICES.get(said, Want.PAUSE), TERMINAL)

    def _answer(self, question: str, otherwise: Callable[[], bool]) -> str | None:
        """What is typed to a question; None if something else ended the wait."""
        terminal, said = self._terminal, None
        assert terminal is not None, "somebody is there"
        terminal.ask(question)

        def answered() -> bool:
            nonlocal said
            said = terminal.answer()
            return said is not None or otherwise()

        self._asks = self._executor.phase is not Phase.ARMED
        try:
            self._trouble = self._executor.wait(answered)
        finally:
            self._asks = False
        return said
