"""The page: one workbench, one space, panels round it, and the thread that keeps them together."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise, product
from queue import SimpleQueue

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.path import Path
from hognose.planning import Plan, Task
from hognose.report.base_lines import base_points, standing_lines
from hognose.scene import Scene
from hognose.steering.steered_path import SteeredPath
from hognose.viewer.editing import Editing
from hognose.viewer.handles import Handles
from hognose.viewer.model import drafts
from hognose.viewer.model.arm_state import ArmState
from hognose.viewer.model.freshness import Standing
from hognose.viewer.model.workbench import Verdict, Workbench
from hognose.viewer.plots import Plots
from hognose.viewer.server.gate import open_server
from hognose.viewer.server.stick import Stick
from hognose.viewer.sharing import Sharing
from hognose.viewer.stage import Stage
from hognose.viewer.steering_panel import SteeringPanel
from hognose.viewer.timeline import Timeline
from hognose.viewer.tolerance_panel import TolerancePanel
from hognose.viewer.verdict_panel import VerdictPanel
from hognose.viewer.walls import OPACITY

Array = NDArray[np.float64]

#: How often a second the page is brought up to date: as fast as motion looks smooth, no faster.
HERTZ = 30.0
#: The first view shows a space wholly that is so many times as large as the motion at most.
MOST_SPACE = 1.75
#: Why cables are not shown.
NO_CABLES = "cables and disks are drawn for arms of links alone so far; this one has sections of other kinds"
#: A task that gives a target alone is searched for this long (s) when it is opened.
FIRST_SEARCH = 5.0


class Page:
    """A page on a workbench, or on a space alone.

    Everything that is drawn is drawn by one thread (`run`), 30 times a second at most; what people do in browsers
    only changes values, which that thread sees. So a slow machine makes fewer pictures and never a queue, and any
    number of browsers see and edit the same thing.

    Parameters
    ----------
    bench
        What is edited; None for a space alone.
    scene
        The space, where there is no bench.
    remark
        What is to be known of the space.
    host, port
        See `hognose.viewer.gate.open_server`.
    """

    def __init__(
        self,
        bench: Workbench | None,
        scene: Scene | None = None,
        remark: str = "",
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        self.bench = bench
        self.stick = Stick()
        self.server, self.address = open_server(host, port, "Hognose", self.stick.addition)
        self._plan: Plan | None = None
        self._drawn: tuple[Verdict, bool] | None = None  # whose path and findings are seen, and whether it is outdated
        self._row = -1  # of the plan, at which the arm is seen
        self._steered: float | None = None  # how deep the nose is that is seen steered
        self._later: SimpleQueue[Callable[[], None]] = SimpleQueue()
        gui = self.server.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        self.stage = Stage(self.server)
        if bench is None:
            assert scene is not None
            corners = scene.bounds.reshape(-1, 3)
            self._show_space(scene, corners.mean(axis=0)[None], corners)  # what is round its middle is seen through
            size = " × ".join(f"{1e3 * side:.0f}" for side in np.ptp(corners, axis=0))
            words = f"{len(scene.names)} bodies, {len(scene.triangles):,} triangles\n\n{size} mm{remark}"
            gui.add_markdown(words)
            return
        self.standing = Standing(bench)
        self._verdict_panel = VerdictPanel(gui, bench, lambda step: self.timeline.go(step))
        self._tolerance_panel = TolerancePanel(gui)
        self.timeline = Timeline(gui)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Edit"):
            self.editing = Editing(gui, bench, self.say)
        with tabs.add_tab("Look"):
            self._looks()
        with tabs.add_tab("Plots"):
            self.plots = Plots(gui)
        with tabs.add_tab("Steer"):
            self.steering = SteeringPanel(gui, bench, self.stick, self.say)
        with tabs.add_tab("Share"):
            self.sharing = Sharing(self.server, self.stage, gui, bench, self.say)
        self.handles = Handles(self.server, self.editing.moved, self.editing.choose)
        if bench.spec.path.target is not None:
            bench.search(FIRST_SEARCH)
        self.update(0.0)

    @property
    def plan(self) -> Plan | None:
        """The plan whose arm is shown; it is the task's unless `standing` says that it is outdated."""
        return self._plan

    def run(self, seconds: float = np.inf) -> None:
        """Keep the page up to date for some time, or until it is interrupted."""
        begin = last = time.perf_counter()
        while last - begin < seconds:
            now = time.perf_counter()
            self.update(now - last)
            last = now
            time.sleep(max(0.0, 1.0 / HERTZ - (time.perf_counter() - now)))

    def close(self) -> None:
        """Stop the server and the workbench."""
        self.server.stop()
        if self.bench is not None:
            self.bench.close()

    def left(self) -> str:
        """What a person should know when the page ends: that edits are kept."""
        if self.bench is None or not self.bench.dirty:
            return ""
        if drafts.folder() is None:
            return "unsaved edits are lost, because drafts are switched off (HOGNOSE_CACHE)"
        return "unsaved edits are kept, and restored when the file is opened again"

    def say(self, text: str) -> None:
        """Show a sentence to everybody who looks."""
        for client in self.server.get_clients().values():
            client.add_notification("Hognose", text, auto_close_seconds=8.0)

    def update(self, seconds: float) -> None:
        """Show what has changed, after some time."""
        if self.bench is None:
            return
        while not self._later.empty():
            self._later.get()()
        if self.standing.look(seconds):
            self._take_over(self.standing.verdict)
        self.stage.walls.see_through(1.0 - min(max(self._see_through.value, 0.0), 1.0))
        self.editing.show()
        self.handles.show(np.array(self.bench.spec.path.stops))
        steered = self.steering.update(seconds)
        if self.sharing.asked:
            self.sharing.record(self._draw_plan)
            self._forget_drawn()
        self._verdict_panel.show(self.standing, steered is not None, self._plan is not None)
        self._tolerance_panel.show(self.standing, steered is not None)
        if steered is not None:
            self._show_steered(steered)
            return
        if self._steered is not None:
            self.stage.hide_arm()
            self._forget_drawn()
        if self.standing.verdict is not None:
            self._show_motion(self.standing.verdict, seconds)

    def _take_over(self, verdict: Verdict | None) -> None:
        """Let the time line and the charts go over another plan."""
        self._refuse_cables()
        if verdict is not None and verdict.plan is not None:
            self._plan = verdict.plan
            self.timeline.show(verdict.plan)
            self.plots.show(verdict.plan)

    def _refuse_cables(self) -> None:
        """Untick the cables of an arm whose cables are not drawn yet, and say so."""
        assert self.bench is not None
        if self._cables.value and not self.bench.task.robot.straight_links:
            self._cables.value = False
            self.say(NO_CABLES)

    def _forget_drawn(self) -> None:
        """Something else was drawn: what is to be seen is drawn anew."""
        self._drawn, self._row, self._steered = None, -1, None

    def _draw_plan(self, plan: Plan) -> None:
        """What does not move of a plan."""
        self.stage.show_ahead(None)
        places = np.concatenate([plan.joints.reshape(-1, 3), plan.way_points, base_points(plan)])
        self._show_space(plan.task.placed_scene, _way(plan.path, plan.task), places)
        self.stage.show_plan(plan)

    def _show_steered(self, steered: SteeredPath) -> None:
        self.stage.show_ahead(self.steering.ahead(steered))
        if steered.depth != self._steered:
            if self._steered is None:
                self.stage.hide_findings()
            self._forget_drawn()
            self._steered = steered.depth
            self.stage.show_path(steered.path, steered.robot.length)
            self.stage.show(ArmState.of_steered(steered))

    def _show_motion(self, verdict: Verdict, seconds: float) -> None:
        """The newest verdict's motion at the row of the time line; what is not the task's as it is now, in grey."""
        outdated = self.standing.outdated
        if self._drawn != (verdict, outdated):
            if verdict.plan is not None and (self._drawn is None or self._drawn[0] is not verdict):
                self._draw_plan(verdict.plan)
            if outdated:
                self._outdate(verdict)
            self._drawn, self._row = (verdict, outdated), -1
        row = self.timeline.advance(seconds)
        if self._plan is None:
            return
        self.plots.follow(row)
        if row != self._row:
            self._row = row
            self.stage.walls.move(self._plan.task.moving, float(self._plan.clock[row]))
            self.stage.show(ArmState.of_plan(self._plan, row), outdated)

    def _outdate(self, verdict: Verdict) -> None:
        """The motion that is seen is not that of the task as it is now."""
        self.stage.outdate()
        self.timeline.show(None)
        self.plots.outdate()
        if verdict.plan is None:
            self._show_without_motion(verdict.task)

    def _show_without_motion(self, task: Task) -> None:
        """What there is to see of a task that has no motion: its space, and the path if there is one."""
        way = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(task.way_points)])
        with suppress(HognoseError):
            if task.spec.path.target is None:
                path = task.path_through(task.way_points)
                self.stage.show_path(path, task.base.run)
                way = _way(path, task)
            at_rest = np.concatenate([task.base.start[None], standing_lines(task).reshape(-1, 3)])
            self.stage.show_base(task)
            self._show_space(task.placed_scene, way, np.concatenate([task.way_points, at_rest]))
            self.stage.walls.move(task.moving, 0.0)

    def _show_space(self, scene: Scene, way: Array, places: Array) -> None:
        """A space that is not shown yet, seen into along a way (k, 3) m; the first one from where places are seen."""
        walls = self.stage.walls
        if walls.shown is None:
            self.stage.frame_camera(with_space(places, scene))
        if walls.shown is not scene:
            walls.show(scene, way)

    def _looks(self) -> None:
        gui = self.server.gui
        handles = gui.add_checkbox("way-point handles", True)
        self._cables = gui.add_checkbox("cables and disks", False)
        ghost = gui.add_checkbox("ghost of the swept body", False)
        self._see_through = gui.add_slider("transparency", min=0.0, max=1.0, step=0.05, initial_value=1 - OPACITY)
        hidden = gui.add_text("hide parts", "", hint="names of obstacles, or beginnings of names, separated by commas")

        def show_cables() -> None:
            self._refuse_cables()
            self.stage.show_cables(self._cables.value)
            self._row, self._steered = -1, None if self._steered is None else -1.0

        def show_ghost() -> None:
            self.stage.with_ghost = ghost.value
            self._drawn = None

        def hide() -> None:
            self.stage.walls.hide(tuple(word.strip() for word in hidden.value.split(",") if word.strip()))

        handles.on_update(lambda _: self._later.put(lambda: self.handles.show_at_all(handles.value)))
        self._cables.on_update(lambda _: self._later.put(show_cables))
        ghost.on_update(lambda _: self._later.put(show_ghost))
        hidden.on_update(lambda _: self._later.put(hide))


def with_space(places: Array, scene: Scene) -> Array:
    """Places (k, 3) m and, if the space is not much larger, its corners: then the first view cuts nothing off."""
    if not len(scene.triangles):
        return places
    low, high = scene.bounds.min(axis=(0, 1)), scene.bounds.max(axis=(0, 1))
    both = np.concatenate([places, list(product(*np.stack([low, high], axis=1)))])
    alone, together = (float(np.linalg.norm(np.ptp(each, axis=0))) for each in (places, both))
    return both if together <= MOST_SPACE * alone else places


def _way(path: Path, task: Task) -> Array:
    """Places (k, 3) m on a path from the entrance on."""
    return path.point(np.linspace(min(task.base.run, path.length), path.length, 100))
