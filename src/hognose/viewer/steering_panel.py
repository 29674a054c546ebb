"""Driving the nose with the stick, on a `SteeredPath`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.planning import Task
from hognose.steering.limits import Held
from hognose.steering.stand import nearest_method
from hognose.steering.steered_path import SteeredPath
from hognose.viewer import shapes
from hognose.viewer.model.edits import take_steered
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.server.stick import Deflection, Stick
from hognose.viewer.verdict_panel import plain
from hognose.wording import at_least_mm

if TYPE_CHECKING:
    from collections.abc import Callable

    import viser

Array = NDArray[np.float64]

HOW = (
    "Pull the stick and the lever at the bottom left, use a gamepad, or hold keys: **I K J L** turn the nose, **R** "
    "drives it forward, **F** back. Right and up are as seen when looking out of the nose."
)
#: One press of "forward" or "back" moves the nose so many feed steps.
PRESS = 3
#: Speeds of the slider that the stick may ask for, in feed steps a control period of the task.
FASTEST = 2.0


class SteeringPanel:
    """Buttons, the stick, and what holds the arm back.

    Callbacks only say what is wanted; the arm is driven by the page's thread in `update`.
    """

    def __init__(self, gui: viser.GuiApi, bench: Workbench, stick: Stick, say: Callable[[str], None]) -> None:
        self._bench, self._stick, self._say = bench, stick, say
        self.steered: SteeredPath | None = None
        self._number = -1  # of the version of the task that is steered in
        self._owed = 0.0
        self._restart = False
        self._keep_asked = False
        self.active = gui.add_checkbox("steer the nose by hand", False)
        gui.add_markdown(HOW)
        self._moves = gui.add_button_group("nose", ("back", "stop", "forward"))
        self._status = gui.add_markdown("")
        self._again = gui.add_button("Restart at the entrance")
        self._keep = gui.add_button("Make it the task", hint="way-points on the steered path; undo reverts this")
        self._connect(gui)

    def _connect(self, gui: viser.GuiApi) -> None:
        @self._moves.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event
            self._press({"back": -1, "stop": 0, "forward": 1}[self._moves.value])

        @self._again.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            self._restart = True

        @self._keep.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            self._keep_asked = True

    def _press(self, direction: int) -> None:
        """Some feed steps on or back, or stop."""
        self._owed = self._owed + direction * PRESS * self._bench.spec.motion.step if direction else 0.0

    def update(self, seconds: float) -> SteeredPath | None:
        """Drive on; the steered arm, or None while nobody steers. Only the page's thread may call this."""
        if not self.active.value:
            self._leave()
            if self._keep_asked:
                self._keep_asked = False
                self._say("steer first; then the steered path can be made the task")
            return None
        if self.steered is not None and not self._bench.is_current(self._number):
            self._leave()
            self._say("the task was edited, which ended the steering; steer again from the entrance")
            return None
        if (self.steered is None or self._restart) and not self._begin():
            return None
        assert self.steered is not None
        if self._keep_asked:
            self._keep_asked = False
            if self._make_task(self.steered):
                return None
        pushed = self._stick.deflection
        motion = self._bench.spec.motion
        most = FASTEST * motion.step / motion.period_s * min(seconds, 0.2)
        owed = float(np.clip(self._owed, -2 * most, 2 * most))
        self._owed -= owed
        self._drive_nose(self.steered, owed + pushed.on * most, pushed)
        return self.steered

    def _begin(self) -> bool:
        """Start at the entrance; whether that was possible. A search would change the task under the hand: it ends."""
        self._restart, self._owed = False, 0.0
        self._bench.stop_search()
        self._number = self._bench.number  # before the task: an edit in between ends the steering
        try:
            self.steered = self._at_entrance(self._bench.task)
        except HognoseError as error:
            self._leave()
            self._say(str(error))
            return False
        self._stick.steering = True
        self._tell(None)
        return True

    def _at_entrance(self, task: Task) -> SteeredPath:
        """A steered arm with the task's method, or with another one where that is none to steer with, which is said."""
        method, asked = nearest_method(task.robot, task.spec.motion.method), task.spec.motion.method
        steered = SteeredPath.of(task, method=method)
        if method != asked and not task.robot.straight_links:
            self._say(f"no arm is steered by {asked}, which needs a path that is known to its end: steered by {method}")
        return steered

    def _leave(self) -> None:
        """Nobody steers any more."""
        self._stick.steering, self._stick.words, self._stick.warning = False, "", ""
        if self.steered is not None or self.active.value:
            self.steered, self.active.value, self._status.content = None, False, ""
        self._restart = False

    def ahead(self, steered: SteeredPath) -> Array:
        """Where (k, 3) m the nose would go on for a link's length, the stick held as it is."""
        turn = self._turn(steered, self._stick.deflection)
        return shapes.arc(steered.tip, steered.frame, turn, float(steered.robot.link_lengths[-1]))

    def _drive_nose(self, steered: SteeredPath, distance: float, pushed: Deflection) -> None:
        if distance < 0:
            self._tell(steered.retreat(-distance).held_by)
        elif distance > 0:
            turn = self._turn(steered, pushed)
            move = steered.advance(distance, turn=turn if turn.any() else None)
            if move.held_by is not None:
                self._owed = 0.0
            self._tell(move.held_by, move.limited_by)

    def _turn(self, steered: SteeredPath, pushed: Deflection) -> Array:
        """The turn (2,) rad/m that the stick asks for; looking ahead with y up, x is to the left."""
        return steered.sharpest * np.array([-pushed.right, pushed.up])

    def _tell(self, held: Held | None, limited: Held | None = None) -> None:
        steered = self.steered
        if steered is None:
            return
        smallest = float(steered.clearance.min())
        bound = "≥ " if smallest >= steered.horizon else ""
        words = f"nose {1e3 * steered.depth:.1f} mm in · clearance {bound}{at_least_mm(smallest, 1)} mm"
        warning = f"Stopped: {held.sentence}" if held else f"Turn limited: {limited.sentence}" if limited else ""
        self._stick.words, self._stick.warning = words, warning
        self._status.content = f"{words}\n\n**{plain(warning)}**" if warning else words

    def _make_task(self, steered: SteeredPath) -> bool:
        """Make way-points of what was steered; whether that was possible."""
        try:
            made = steered.task(self._bench.spec.name)
            self._bench.edit(take_steered(made.spec), made_of=self._number)
        except HognoseError as error:
            self._say(str(error))
            return False
        self._leave()
        count, off = len(made.spec.path.way_points), 1e3 * made.deviation
        self._say(f"{count} way-points, at most {off:.2f} mm off the steered path")
        return True
