"""What stands in the page's space: obstacles, path, arm, and what is pointed out on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hognose.path import Path
from hognose.planning import Plan, Task
from hognose.report.base_lines import mount_lines, standing_lines, workspace_lines
from hognose.report.camera import fitted
from hognose.report.style import FAINT, JOINT, PATH, TIP
from hognose.robot import Robot
from hognose.robot.base import Mount
from hognose.robot.bends import on_side, used
from hognose.ties import first_largest, first_smallest
from hognose.viewer import shapes
from hognose.viewer.model.arm_state import ArmState, too_close
from hognose.viewer.shapes import rgb
from hognose.viewer.walls import Walls
from hognose.wording import at_least_mm

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

#: Radius of the links while cables are shown round them, in parts of their own.
SPINE = 0.2
#: Colours of the arm before its clearance is known and of its ghost, of disks, and of four sections' cables in turn.
ARM, DISKS = (232, 163, 61), (95, 107, 120)
CABLES = np.array([(31, 111, 139), (179, 32, 42), (90, 125, 44), (122, 79, 163)], np.uint8)
#: Colour of what belongs to a version of the task before.
OUTDATED = "#a4a9ae"
#: From where a page looks at first: from the side, a little from above, +y up as in the reports.
VIEW = np.array([-1.05, 0.45, -0.55])
#: Width and height of the picture that must hold everything at first, and the share of it that is left free each side:
#: a window beside the panel is wider, and names stand beside their places.
FRAME, BORDER = (110, 100), 0.1
#: The vertical angle of view (rad): wider ones distort.
FIELD = np.radians(50.0)
#: Size (m) of the dots where the body is too close.
DOT = 0.006
#: The ghost is made of the body at so many rows.
GHOSTS = 30
#: What arms and their joints are drawn of.
CYLINDER, BOX, BALL = shapes.unit_cylinder(), shapes.unit_box(), shapes.unit_ball()


class Stage:
    """The space of a page. Only one thread may change it.

    Nothing of it but the walls is transparent: within walls that are seen through it would vanish.

    Attributes
    ----------
    walls
        The obstacles.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._server = server
        self.walls = Walls(server.scene)
        self._robot: Robot | None = None
        self._links: Any = None
        self._necks: Any = None
        self._skin: Any = None
        self._smooth = np.empty(0, np.bool_)
        self._disks: Any = None
        self._cables: Any = None
        self._path: Any = None
        self._standing: Any = None
        self._mount_lines: Any = None
        self._mount: Mount | None = None
        self._ahead: Any = None
        self._contacts: Any = None
        self._ghost: Any = None
        self._closest: Any = None
        self._said: Any = None
        self._bend: Any = None
        self.with_cables = self.with_ghost = False
        self._arm_visible = True
        server.scene.set_up_direction("+y")
        server.scene.configure_default_lights(True, False)

    def frame_camera(self, places: Array) -> None:
        """Point all cameras at places (k, 3) m, seen from the side, so that all of them are in the picture."""
        camera = self._server.initial_camera
        seen = fitted(places, FRAME, towards_eye=VIEW, half_angle=0.5 * FIELD, border=BORDER)
        _, depth = seen.project(places, FRAME)
        target = seen.eye + 0.5 * float(depth.min() + depth.max()) * seen.axes[2]
        camera.position, camera.look_at, camera.up = tuple(seen.eye), tuple(target), (0.0, 1.0, 0.0)
        camera.fov = FIELD
        for client in self._server.get_clients().values():
            client.camera.fov, client.camera.position, client.camera.look_at = FIELD, seen.eye, target

    def show_plan(self, plan: Plan) -> None:
        """Draw what does not move of a plan: its path, where it is too close, the ghost of the body if it is wanted."""
        self.show_path(plan.path, plan.task.base.run)
        self.show_base(plan.task)
        self._show_contacts(too_close(plan))
        self.draw_ghost(plan)

    def hide_findings(self) -> None:
        """Take away what was found out about a plan: where it is too close, and the ghost."""
        for handle in (self._contacts, self._ghost):
            if handle is not None:
                handle.visible = False

    def outdate(self) -> None:
        """Let it be seen that the path is not the task's as it is now, and nothing that was found out about it."""
        self.hide_findings()
        if self._path is not None:
            self._path.colors = np.array(rgb(OUTDATED), np.uint8)

    def hide_arm(self) -> None:
        """Take away the arm with its path, until they are shown again."""
        self._arm_visible = False
        self._point_at_nothing()
        arm = (self._links, self._necks, self._skin, self._disks, self._cables, self._mount_lines)
        for handle in (*arm, self._path, self._ahead):
            if handle is not None:
                handle.visible = False

    def _show_contacts(self, places: Array) -> None:
        """Dots where the body comes too close (k, 3) m."""
        if self._contacts is None:
            self._contacts = self._scene.add_point_cloud(
                "/contacts",
                places.astype(np.float32),
                rgb(TIP),
                point_size=DOT,
                point_shape="circle",
                precision="float32",
            )
        self._contacts.points = places.astype(np.float32)
        self._contacts.visible = len(places) > 0

    def show_path(self, path: Path, run: float) -> None:
        """Draw a path behind the slider's run (m)."""
        line = path.point(np.linspace(min(run, path.length), path.length, 240))
        self._path = self._line("/path", self._path, line, PATH)
        self._path.colors, self._path.visible = np.array(rgb(PATH), np.uint8), True

    def show_base(self, task: Task) -> None:
        """Draw what an arm stands on: a drum and its nozzle, a carrier's workspace; the mount comes with the arm."""
        self._mount = task.base.mount
        pieces = np.concatenate([standing_lines(task), workspace_lines(task)])
        self._standing = self._thin("/base", self._standing, pieces)

    def _thin(self, name: str, drawn: Any, pieces: Array) -> Any:
        """Thin lines (k, 2, 3) m that were not drawn yet, or were drawn somewhere else; none may be left."""
        single = pieces.astype(np.float32)
        if drawn is None:
            if not len(pieces):
                return None
            return self._scene.add_line_segments(name, single, rgb(FAINT), thickness=1.0, thickness_units="screen")
        if len(pieces):
            drawn.points = single
        drawn.visible = len(pieces) > 0
        return drawn

    def show_ahead(self, line: Array | None) -> None:
        """Draw where (k, 3) m a nose that is steered would go; None takes it away."""
        if line is not None:
            self._ahead = self._line("/ahead", self._ahead, line, TIP)
        if self._ahead is not None:
            self._ahead.visible = line is not None

    def _line(self, name: str, drawn: Any, line: Array, colour: str) -> Any:
        """A line that was not drawn yet, or was drawn somewhere else."""
        pieces = np.stack([line[:-1], line[1:]], axis=1).astype(np.float32)
        if drawn is None:
            return self._scene.add_line_segments(name, pieces, rgb(colour), thickness=3.0, thickness_units="screen")
        drawn.points = pieces
        return drawn

    def draw_ghost(self, plan: Plan) -> None:
        """Draw or take away the ghost of the body that sweeps along: rings round links at many rows."""
        if self.with_ghost:
            rows = np.unique(np.linspace(0, len(plan.feed) - 1, GHOSTS).astype(int))
            pieces = shapes.rings(plan.centre_line[rows], plan.robot.chord_radii).astype(np.float32)
            if self._ghost is None:
                self._ghost = self._scene.add_line_segments(
                    "/ghost", pieces, ARM, thickness=1.0, thickness_units="screen"
                )
            self._ghost.points = pieces
        if self._ghost is not None:
            self._ghost.visible = self.with_ghost

    def show(self, state: ArmState, outdated: bool = False) -> None:
        """Move the arm, coloured by clearance, with what is closest pointed out; without all that if it is outdated."""
        if self._robot is not state.robot:
            self._make_arm(state.robot)
        if not self._arm_visible:
            self._arm_visible = self._links.visible = True
            if self._skin is not None:
                self._skin.visible = True
            self.show_cables(self.with_cables)
        sections = state.robot.chord_sections
        radii = state.robot.chord_radii * (SPINE if self._shows_cables else 1.0)
        places, turns, scales = shapes.bodies(state.robot, state.vertices, state.outline, radii)
        with self._server.atomic():
            self._links.batched_positions = places.astype(np.float32)
            self._links.batched_wxyzs = turns.astype(np.float32)
            self._links.batched_scales = scales.astype(np.float32)
            colours = shapes.clearance_colours(state.clearance, state.margin, state.horizon)[sections]
            self._links.batched_colors = np.full_like(colours, rgb(OUTDATED)) if outdated else colours
            around = mount_lines(self._mount, state.joints[0], state.frames[0])
            self._mount_lines = self._thin("/mount", self._mount_lines, around)
            inner = state.vertices[1:-1].astype(np.float32)
            if self._necks is not None:
                self._necks.batched_positions = inner[~self._smooth]
            if self._skin is not None:
                self._skin.batched_positions = inner[self._smooth]
                self._skin.batched_colors = self._links.batched_colors[:-1][self._smooth]
            if outdated:
                self._point_at_nothing()
            else:
                self._point_out(state)
            if self._shows_cables:
                self._move_cables(state)

    @property
    def _shows_cables(self) -> bool:
        """Whether cables are wanted, of an arm of links: where they run along other sections is not drawn yet."""
        return self.with_cables and self._robot is not None and self._robot.straight_links

    def show_cables(self, wanted: bool) -> None:
        """Show cables and disks round a thin spine, from the next state on; or the links as thick as they are."""
        self.with_cables = wanted
        for handle in (self._disks, self._cables):
            if handle is not None:
                handle.visible = self._shows_cables
        if self._necks is not None:
            self._necks.visible = not self._shows_cables

    def _make_arm(self, robot: Robot) -> None:
        for handle in (self._links, self._necks, self._skin, self._disks, self._cables):
            if handle is not None:
                handle.remove()
        self._disks = self._cables = None
        straight = robot.joint_positions(np.zeros((robot.sections, 2)))
        vertices, radii = robot.model.vertices(straight), robot.chord_radii
        places, turns, scales = shapes.links(vertices, radii)
        self._links = self._solids("/arm/links", places, turns, scales, ARM, BOX if robot.outline.flat else CYLINDER)
        self._robot, self._smooth = robot, robot.model.smooth(robot.link_lengths)
        thin = robot.outline.inner_radii[robot.chord_sections] if robot.outline.flat else radii
        between = np.minimum(thin[:-1], thin[1:])
        self._necks, self._skin = (
            self._balls(name, vertices[1:-1][chosen], scale * between[chosen], tone) if chosen.any() else None
            for name, chosen, scale, tone in (
                ("/arm/joints", ~self._smooth, shapes.NECK, rgb(JOINT)),
                (
                    "/arm/skin",
                    self._smooth,
                    shapes.SKIN,
                    ARM,
                ),  # closes the gaps between chords
            )
        )
        if self._necks is not None:
            self._necks.visible = not self._shows_cables

    def _balls(self, name: str, places: Array, radii: Array, colour: tuple[int, int, int]) -> Any:
        return self._scene.add_batched_meshes_simple(
            name,
            *BALL,
            np.tile([1.0, 0.0, 0.0, 0.0], (len(places), 1)),
            places,
            batched_scales=radii,
            batched_colors=np.tile(np.array(colour, np.uint8), (len(places), 1)),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _solids(
        self, name: str, places: Array, turns: Array, scales: Array, colour: tuple[int, int, int], solid: Any
    ) -> Any:
        vertices, faces = solid
        return self._scene.add_batched_meshes_simple(
            name,
            vertices,
            faces,
            turns,
            places,
            batched_scales=scales,
            batched_colors=np.tile(np.array(colour, np.uint8), (len(places), 1)),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _move_cables(self, state: ArmState) -> None:
        robot, joints, frames = state.robot, state.joints, state.frames
        pieces, owner = shapes.cables(robot, joints, frames)
        places, turns, scales = shapes.disks(robot, joints, frames)
        if self._cables is None:
            tones = CABLES[owner % len(CABLES)]
            self._cables = self._scene.add_line_segments(
                "/arm/cables", pieces.astype(np.float32), np.repeat(tones[:, None], 2, axis=1), thickness=0.0012
            )
            self._disks = self._solids("/arm/disks", places, turns, scales, DISKS, CYLINDER)
            return
        self._cables.points = pieces.astype(np.float32)
        self._disks.batched_positions = places.astype(np.float32)
        self._disks.batched_wxyzs = turns.astype(np.float32)

    def _point_at_nothing(self) -> None:
        for handle in (self._closest, self._said, self._bend):
            if handle is not None:
                handle.visible = False

    def _point_out(self, state: ArmState) -> None:
        """A line between the closest pair with its distance, and the joint nearest to its limit."""
        clearance, joints, bounds = state.clearance, state.joints, state.robot.bend_bounds
        (link,) = first_smallest(clearance)
        close = clearance[link] < state.horizon
        if close:
            found = state.contact(link)
            # From the body's surface on, not from its axis; where it cuts the obstacle there is no gap to show.
            inward = min(state.robot.body_radii[link] / max(found.distance, 1e-9), 1.0)
            ends = np.array([[found.on_axis + inward * (found.place - found.on_axis), found.place]], dtype=np.float32)
            gap, obstacle = at_least_mm(clearance[link], 1), found.obstacle
            words = f"{gap.removeprefix('-')} mm {'into' if gap.startswith('-') else 'to'} {obstacle}"
        else:
            ends, words = np.zeros((1, 2, 3), np.float32), ""
        share = used(state.angles, bounds)
        section, axis = first_largest(share)
        angle, limit = np.degrees([state.angles, on_side(state.angles, bounds)])[:, section, axis]
        bend = f"section {section + 1} {('alpha', 'beta')[axis]}: {abs(angle):.1f} of {limit:.1f}°"
        over = share[section, axis] > 1
        if self._closest is None:
            thick = {"thickness": 4.0, "thickness_units": "screen"}
            self._closest = self._scene.add_line_segments("/closest", ends, rgb(TIP), **thick)
            self._said = self._scene.add_label("/closest_label", words, anchor="bottom-left")
            self._bend = self._scene.add_label("/bend_label", bend, anchor="top-left")
        self._closest.points, self._closest.visible = ends, bool(close)
        self._said.text, self._said.position, self._said.visible = words, ends[0].mean(axis=0), bool(close)
        self._bend.text, self._bend.position = ("TOO LARGE: " if over else "") + bend, joints[section]
        self._bend.visible = bool(share[section, axis] > 0.5)
