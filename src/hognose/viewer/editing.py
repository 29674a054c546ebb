"""The panel that edits a task: way-points, how they are joined, how the motion is made, and a search for a route."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.files import bundled_robots, bundled_tasks
from hognose.following import METHODS, OF_SECTIONS
from hognose.planning import Task
from hognose.viewer.model import edits
from hognose.viewer.model.saving import file_stem
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.verdict_panel import plain

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]
Say = Callable[[str], None]

SEARCH_SECONDS = 10.0
#: Feed steps and margins that make sense, mm.
STEPS, MARGINS = (0.1, 50.0), (0.0, 100.0)


class Editing:
    """Fields and buttons on a workbench; each one is an edit.

    Parameters
    ----------
    gui, bench
    say
        Shows a sentence to whoever looks at the page: what went wrong, what was written.
    """

    def __init__(self, gui: viser.GuiApi, bench: Workbench, say: Say) -> None:
        self._gui, self._bench, self._say = gui, bench, say
        self.chosen = 0
        self._taken = 0
        self._shown_number = -1
        with gui.add_folder("way-points"):
            self._which = gui.add_dropdown("way-point", _names(2), hint="or click its handle")
            self._place = gui.add_vector3("x, y, z in mm", (0.0, 0.0, 0.0), step=1.0)
            self._count = gui.add_button_group("change", ("add after", "remove"))
        with gui.add_folder("path and motion"):
            self._order = gui.add_dropdown("order k", tuple(map(str, range(1, 10))), initial_value="3")
            self._step = gui.add_number("feed step, mm", 3.5, min=STEPS[0], max=STEPS[1], step=0.5)
            self._margin = gui.add_number("margin, mm", 5.0, min=MARGINS[0], max=MARGINS[1], step=0.5)
            self._method = gui.add_dropdown("method", tuple(METHODS), initial_value="exact")
            robots = tuple(dict.fromkeys((bench.spec.robot, *bundled_robots())))
            self._robot = gui.add_dropdown("robot", robots, initial_value=bench.spec.robot)
        self._undo = gui.add_button_group("undo", ("undo", "redo"), hint="Ctrl+Z, Ctrl+Shift+Z")
        with gui.add_folder("find a route"):
            self._seconds = gui.add_number("seconds", SEARCH_SECONDS, min=1.0, max=600.0, step=1.0)
            self._search = gui.add_button("Find a route", hint="from the entrance to the target, without way-points")
            self._searched = gui.add_markdown("")
        with gui.add_folder("save"):
            hint = f"within {bench.folder.resolve()}; a plan gets the same name with .parquet"
            self._file = gui.add_text("task file", _suggested(bench), hint=hint)
            self._over = gui.add_checkbox("overwrite", False, hint="also a file that somebody else wrote or changed")
            self._save = gui.add_button_group("write", ("task", "plan"))
        self._connect_fields()
        self._connect_buttons()

    def _edit(self, change: edits.Change, merge: str = "") -> None:
        """Make an edit; what is wrong with it is said, and the fields show again what counts."""
        try:
            self._bench.edit(change, merge)
        except HognoseError as error:
            self._say(str(error))
            self._shown_number = -1

    def moved(self, stop: int, place: Array) -> None:
        """A handle was dragged: to place (3,) m."""
        self._edit(edits.move_way_point(stop, tuple(place.tolist())), merge=f"drag {self._taken}")

    def choose(self, stop: int) -> None:
        """A handle was taken hold of, or another stop is to be edited: what comes is another step to undo."""
        self.chosen = stop
        self._taken += 1
        self._shown_number = -1

    def _connect_fields(self) -> None:
        @self._which.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self.choose(int(self._which.value.split()[0]) - 1)

        @self._place.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                place = np.array(self._place.value) / 1e3
                self._edit(edits.move_way_point(self.chosen, tuple(place.tolist())), merge=f"place {self._taken}")

        def connect(field: viser.GuiInputHandle, change: Callable[[], edits.Change]) -> None:
            @field.on_update
            async def _(event: viser.GuiEvent) -> None:
                if event.client is not None:
                    self._edit(change(), merge="")

        connect(self._order, lambda: edits.set_order(int(self._order.value)))
        self._connect_mm(self._step, STEPS, edits.set_step)
        self._connect_mm(self._margin, MARGINS, edits.set_margin)
        connect(self._method, lambda: edits.set_method(self._method.value))
        connect(self._robot, lambda: edits.set_robot(self._robot.value))

    def _connect_mm(
        self, field: viser.GuiInputHandle, bounds: tuple[float, float], change: Callable[[float], edits.Change]
    ) -> None:
        """A field in mm; what is typed, not stepped, may be out of bounds."""

        @field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client is None:
                return
            if bounds[0] <= field.value <= bounds[1]:
                self._edit(change(field.value / 1e3))
            else:
                self._say(f"{field.label}: expected {bounds[0]:g} to {bounds[1]:g}, got {field.value:g}")
                self._shown_number = -1

    def _connect_buttons(self) -> None:
        gui = self._gui

        @self._count.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event
            if self._count.value == "remove":
                self._edit(edits.remove_way_point(self.chosen))
                self.choose(max(self.chosen - 1, 0))
            else:
                self._edit(edits.add_way_point(self.chosen))
                self.choose(self.chosen + 1)

        @self._undo.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event
            self._back(self._undo.value == "undo")

        undo = gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl")
        redo = gui.add_command("Redo", hotkey="Z", modifier="cmd/ctrl+shift")
        undo.on_trigger(lambda _: self._back(True))
        redo.on_trigger(lambda _: self._back(False))

        @self._search.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            if self._bench.searching:
                self._bench.stop_search()
                return
            try:
                self._bench.search(float(self._seconds.value))
            except HognoseError as error:
                self._say(str(error))

        @self._save.on_click
        async def _(event: viser.GuiEvent) -> None:
            del event  # what is asked is read at once, and written while others go on
            await asyncio.to_thread(self._write, self._save.value, self._file.value, self._over.value)

    def _back(self, undo: bool) -> None:
        if undo:
            self._bench.undo()
        else:
            self._bench.redo()

    def _write(self, what: str, name: str, over: bool) -> None:
        write = self._bench.save if what == "task" else self._bench.save_plan
        try:
            file = write(name, over)
        except HognoseError as error:
            self._say(str(error))
            return
        self._over.value = False
        self._say(f"written to {file}")

    def show(self) -> None:
        """Let the fields show what counts now. Only the page's thread may call this."""
        bench = self._bench
        self._search.label = "Stop the search" if bench.searching else "Find a route"
        self._searched.content = plain(bench.search_said)
        if bench.number == self._shown_number:
            return
        self._shown_number = bench.number
        spec = bench.spec
        stops = spec.path.stops
        self.chosen = min(self.chosen, len(stops) - 1)
        names = _names(len(stops))
        if names != tuple(self._which.options):
            self._which.options = names
        self._which.value = names[self.chosen]
        x, y, z = stops[self.chosen]
        self._place.value = (round(1e3 * x, 3), round(1e3 * y, 3), round(1e3 * z, 3))
        self._order.value = str(spec.path.order)
        self._step.value = round(1e3 * spec.motion.step, 6)
        self._margin.value = round(1e3 * spec.margin, 6)
        methods = _methods(bench.task)
        if methods != tuple(self._method.options):
            self._method.options = methods
        self._method.value = spec.motion.method
        if spec.robot in self._robot.options:
            self._robot.value = spec.robot


def _names(stops: int) -> tuple[str, ...]:
    """What the stops of a way are called, entrance first and target last."""
    return ("1 entrance", *(str(k) for k in range(2, stops)), f"{stops} target")


def _methods(task: Task) -> tuple[str, ...]:
    """The methods for the kind of the task's arm, and the one that it has."""
    able = METHODS if task.robot.straight_links else OF_SECTIONS
    return tuple(dict.fromkeys((*able, task.spec.motion.method)))


def _suggested(bench: Workbench) -> str:
    """Where to save, below the bench's folder: the file it came from; a new one for what is bundled or has no file."""
    if bench.source is not None and bench.source not in bundled_tasks().values():
        return bench.source.name
    return f"{file_stem(bench.spec.name)}.toml"
