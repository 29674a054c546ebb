"""Driving the nose: a stick on the screen and keys, on a `SteeredPath`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from hognose.errors import HognoseError
from hognose.planning.steering import Held, SteeredPath
from hognose.viewer.workbench import Workbench

if TYPE_CHECKING:
    from collections.abc import Callable

    import viser

#: One press of a key moves the stick by this much, of 1.
NUDGE = 0.2
#: One press of "on" or "back" moves the nose so many feed steps.
PRESS = 3
#: Speeds of the slider that the stick may ask for, in feed steps a control period of the task.
FASTEST = 2.0

Key = Literal["I", "J", "K", "L", "M", "U", "O"]


class SteeringPanel:
    """Stick, keys and what holds the arm back.

    Callbacks only say what is wanted; the arm is driven by the page's thread in `update`.
    """

    def __init__(self, gui: viser.GuiApi, bench: Workbench, say: Callable[[str], None]) -> None:
        self._bench, self._say = bench, say
        self.steered: SteeredPath | None = None
        self._owed = 0.0
        self._restart = False
        self._keep_asked = False
        self.active = gui.add_checkbox("steer the nose by hand", False, hint="the plan waits meanwhile")
        gui.add_markdown("Keys: **U** on, **O** back, **I K** up and down, **J L** to the sides, **M** straight")
        self._drive = gui.add_slider("drive", min=-1.0, max=1.0, step=0.05, initial_value=0.0, hint="back … on")
        self._x = gui.add_slider("stick x", min=-1.0, max=1.0, step=0.05, initial_value=0.0)
        self._y = gui.add_slider("stick y", min=-1.0, max=1.0, step=0.05, initial_value=0.0)
        self._moves = gui.add_button_group("nose", ("back", "stop", "on"))
        self._status = gui.add_markdown("")
        self._again = gui.add_button("From the entrance anew")
        self._keep = gui.add_button("Make it the task", hint="way-points on the steered path, one step to undo")
        self._connect(gui)

    def _connect(self, gui: viser.GuiApi) -> None:
        @self._moves.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            self._press({"back": -1, "stop": 0, "on": 1}[self._moves.value])

        @self._again.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            self._restart = True

        @self._keep.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            self._keep_asked = True

        keys: tuple[tuple[Key, str, Callable[[], None]], ...] = (
            ("U", "Nose on", lambda: self._press(1)),
            ("O", "Nose back", lambda: self._press(-1)),
            ("I", "Steer up", lambda: self._nudge(0, 1)),
            ("K", "Steer down", lambda: self._nudge(0, -1)),
            ("J", "Steer to -x", lambda: self._nudge(-1, 0)),
            ("L", "Steer to +x", lambda: self._nudge(1, 0)),
            ("M", "Steer straight", lambda: self._nudge(0, 0)),
        )
        for key, label, do in keys:
            self._hotkey(gui, key, label, do)

    def _hotkey(self, gui: viser.GuiApi, key: Key, label: str, do: Callable[[], None]) -> None:
        command = gui.add_command(label, hotkey=key)

        @command.on_trigger
        def _(event: object) -> None:
            del event
            if self.active.value:
                do()

    def _press(self, direction: int) -> None:
        """Some feed steps on or back, or stop."""
        if direction == 0:
            self._owed, self._drive.value = 0.0, 0.0
        else:
            self._owed += direction * PRESS * self._bench.spec.motion.step

    def _nudge(self, x: int, y: int) -> None:
        """Move the stick; to the middle with 0, 0."""
        if x == y == 0:
            self._x.value = self._y.value = 0.0
        self._x.value = float(np.clip(self._x.value + x * NUDGE, -1, 1))
        self._y.value = float(np.clip(self._y.value + y * NUDGE, -1, 1))

    def update(self, seconds: float) -> SteeredPath | None:
        """Drive on; the steered arm, or None while nobody steers. Only the page's thread may call this."""
        if not self.active.value:
            self.steered = None
            if self._keep_asked:
                self._keep_asked = False
                self._say("steer first; then what was steered can be made the task")
            return None
        if self.steered is None or self._restart:
            self._restart, self._owed = False, 0.0
            try:
                self.steered = SteeredPath.of(self._bench.task)
            except HognoseError as error:
                self._say(str(error))
                self.active.value = False
                return None
            self._tell(None)
        if self._keep_asked:
            self._keep_asked = False
            self._make_task(self.steered)
        motion = self._bench.spec.motion
        speed = FASTEST * motion.step / motion.period_s
        most = speed * min(seconds, 0.2)
        wanted = self._drive.value * most + self._owed
        part = float(np.clip(wanted, -2 * most, 2 * most)) if self._owed else wanted
        self._owed = wanted - part if self._owed else 0.0
        if part:
            self._drive_nose(self.steered, part)
        return self.steered

    def _drive_nose(self, steered: SteeredPath, distance: float) -> None:
        if distance < 0:
            self._tell(steered.retreat(-distance).held_by)
            return
        stick = np.array([self._x.value, self._y.value])
        move = steered.advance(distance, turn=steered.sharpest * stick if stick.any() else None)
        if move.held_by is not None:
            self._owed = 0.0
        self._tell(move.held_by, move.limited_by)

    def _tell(self, held: Held | None, limited: Held | None = None) -> None:
        steered = self.steered
        if steered is None:
            return
        smallest = float(steered.clearance.min())
        bound = "≥ " if smallest >= steered.horizon else ""
        words = f"nose {1e3 * steered.depth:.1f} mm in · clearance {bound}{1e3 * smallest:.1f} mm"
        if held:
            words += f"\n\n**Held:** {held.sentence}"
        elif limited:
            words += f"\n\n**Turn limited:** {limited.sentence}"
        self._status.content = words

    def _make_task(self, steered: SteeredPath) -> None:
        try:
            made = steered.task(self._bench.spec.name)
            path, motion = made.spec.path, made.spec.motion
            self._bench.edit(lambda spec: spec.model_copy(update={"path": path, "motion": motion}))
        except HognoseError as error:
            self._say(str(error))
            return
        self.active.value = False
        self._say(f"{len(path.way_points)} way-points, at most {1e3 * made.deviation:.2f} mm off what was steered")
