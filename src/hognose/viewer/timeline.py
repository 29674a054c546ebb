"""The time line of a page: scrub, play, step, in and out again."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from hognose.planning import Plan
from hognose.viewer.model.clock import Clock
from hognose.wording import at_least_mm

if TYPE_CHECKING:
    import viser

Key = Literal["space", "N", "B"]
SPEEDS = ("0.25", "0.5", "1", "2", "5", "10")
#: While it plays, the slider follows this often a second: a browser has better things to do than to move sliders.
SLIDER_HERTZ = 8.0


class Timeline:
    """Slider and buttons, and the clock they move.

    Attributes
    ----------
    clock
        Where it is; replaced as a whole, so that any thread may read it.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self.clock = Clock(1)
        self._since_shown = 0.0
        self._plan: Plan | None = None
        self._slider = gui.add_slider("step", min=0, max=1, step=1, initial_value=0)
        self._said = gui.add_markdown("")
        self._buttons = gui.add_button_group(
            "move",
            ("|<", "<", "play / stop", ">", ">|"),
            hint="first, back (B), play or stop (space), forward (N), last",
        )
        self._direction = gui.add_button_group("direction", ("in", "out again"), hint="insertion, or retraction")
        self._speed = gui.add_dropdown("speed ×", SPEEDS, initial_value="1")
        self._connect(gui)

    def _connect(self, gui: viser.GuiApi) -> None:
        @self._slider.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client is not None:  # a person moved it, not the program
                self.go(self._slider.value)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event
            self.press(self._buttons.value)

        @self._direction.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event
            self.clock = replace(self.clock, outwards=self._direction.value != "in")

        @self._speed.on_update
        async def _(event: viser.GuiEvent) -> None:
            del event
            self.clock = replace(self.clock, speed=float(self._speed.value))

        keys: tuple[tuple[str, Key, str], ...] = (
            ("Play or stop", "space", "play / stop"),
            ("Step forward", "N", ">"),
            ("Step back", "B", "<"),
        )
        for label, key, button in keys:
            self._hotkey(gui, label, key, button)

    def _hotkey(self, gui: viser.GuiApi, label: str, key: Key, button: str) -> None:
        command = gui.add_command(label, hotkey=key)

        @command.on_trigger
        def _(event: object) -> None:
            del event
            self.press(button)

    def press(self, button: str) -> None:
        """What a button does; without a motion nothing."""
        clock = self.clock
        if self._plan is None:
            return
        if button == "play / stop":
            self.clock = clock.toggled()
        elif button in ("<", ">"):
            self.clock = clock.stepped(-1 if button == "<" else 1)
        else:
            self.go(0 if button == "|<" else clock.rows - 1)

    def go(self, row: int) -> None:
        """Stop at a row."""
        self.clock = replace(self.clock.to(row), playing=False)

    def show(self, plan: Plan | None) -> None:
        """Run over another plan, at the same part of the whole; None if there is none of the task as it is now."""
        self._plan = plan
        self._slider.disabled = plan is None
        if plan is None:
            self.clock = replace(self.clock, playing=False)
            self._said.content = "*no motion of the current task*"
            return
        self.clock = self.clock.over(len(plan.feed))
        self._slider.max = max(len(plan.feed) - 1, 1)
        self._tell()

    def advance(self, seconds: float) -> int:
        """Let time pass; the row to show."""
        plan, before = self._plan, self.clock
        if plan is None:
            return before.shown
        # A person may have moved it while a plan of another length was shown.
        clock = before.over(len(plan.feed)).after(seconds, plan.task.spec.motion.period_s)
        self._since_shown += seconds
        if self.clock is not before:  # moved just now: that counts, the next time
            return clock.shown
        self.clock = clock
        if self._slider.value != clock.shown and (not clock.playing or self._since_shown > 1.0 / SLIDER_HERTZ):
            self._since_shown = 0.0
            self._slider.value = clock.shown
            self._tell()
        return clock.shown

    def _tell(self) -> None:
        plan, row = self._plan, min(self.clock.shown, self.clock.rows - 1)
        if plan is not None:
            self._said.content = (
                f"{plan.time[row]:.1f} of {plan.time[-1]:.1f} s · feed {1e3 * plan.feed[row]:.1f} mm · "
                f"clearance {_clearance(plan, row)}"
            )
            if plan.task.moving and self.clock.outwards:
                self._said.content += " · *obstacles go backwards, too; a retraction meets them where they are then*"


def _clearance(plan: Plan, row: int) -> str:
    smallest = float(plan.clearance[row].min())
    planned = "" if plan.task.budget is None else " as planned"  # tolerances leave less
    return f"{'≥ ' if smallest >= plan.horizon else ''}{at_least_mm(smallest, 1)} mm{planned}"
