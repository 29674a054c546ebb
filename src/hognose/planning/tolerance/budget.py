"""The budget of tolerances: how far points of the body can be from where they are planned to be.

Bounded parts add. Random parts are independent and given as standard deviations; k = 2 of theirs is taken, in the
worst direction. Shifting the base by σ along each axis spreads a point p by σ in every direction; turning it by σ about
each axis through a point a spreads it by σ |p - a| at most. Both angles of a joint at c, each off by σ about axes at
right angles, spread it by σ |p - c| at most. The whole spread is the root of the sum of the squares:

    s(p)² = σ_shift² + σ_turn² |p - a|² + Σ_j σ_j² |p - c_j|² + σ_zero² |dp/dλ|² .

All but the last term depend on the places of p and of the joints only. See `docs/tolerances.md`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.kernels import kernel
from hognose.mechanics import Held, Mechanics, why_unknown
from hognose.planning.gravity import DOWN
from hognose.planning.tolerance.jacobian import by_zeros, joint_axes, largest
from hognose.planning.tolerance.left_over import LEFT_OVER, left_over
from hognose.planning.tolerance.sections import (
    refuse_flat,
    refuse_unknown_mechanics,
    refuse_unknown_sections,
    weights_of,
)
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Robot
from hognose.robot.base import FORWARD, Base, joints_on, straight_joints
from hognose.robot.cable_gains import angles_per_length
from hognose.robot.tolerance import RobotTolerance

Array = NDArray[np.float64]

#: So many standard deviations of the random parts are taken (GUM: an expanded uncertainty at about 95 %).
COVERAGE = 2.0
#: The parts, in the order in which they are shown; the first two are bounds, the others spreads.
PARTS = ("cad", "sag", "registration", "registration_deg", "calibration_deg", "cable_zero", *LEFT_OVER)
#: The parts as people read them.
WORDS = {
    "cad": "CAD",
    "sag": "sag",
    "registration": "registration",
    "registration_deg": "registration",
    "calibration_deg": "calibration",
    "cable_zero": "cable zeros",
    "axial_stiffness_percent": "EA",
    "mass_percent": "masses",
    "friction": "friction",
}
#: Those of them that are several things.
PLURAL = {"cable_zero", "mass_percent"}
DEGREES = 180.0 / math.pi


@kernel(fastmath={"contract"})
def _spread(vertices: NDArray, pivot: NDArray, weights: NDArray, shift: float, turn: float, out: NDArray) -> None:
    """√(shift + turn |p - a|² + Σ w |p - c|²) (m, p+1) of vertices (m, p+1, 3), over the joints c before each.

    Σ w |p - c|² = |p|² Σ w - 2 p · Σ w c + Σ w |c|², with places from a.
    """
    for m in range(vertices.shape[0]):
        whole, lx, ly, lz, squares = 0.0, 0.0, 0.0, 0.0, 0.0
        for v in range(vertices.shape[1]):
            x, y, z = vertices[m, v, 0] - pivot[0], vertices[m, v, 1] - pivot[1], vertices[m, v, 2] - pivot[2]
            square, w = x * x + y * y + z * z, weights[v]
            bent = max(whole * square - 2.0 * (x * lx + y * ly + z * lz) + squares, 0.0)
            out[m, v] = math.sqrt(shift + turn * square + bent)
            whole, squares = whole + w, squares + w * square
            lx, ly, lz = lx + w * x, ly + w * y, lz + w * z


@kernel(fastmath={"contract"})
def _change(moved: NDArray, weights: NDArray, turn: float, out: NDArray) -> None:
    """√(turn e² + Σ w (e + e_c)²) (m, p+1) of vertices that move by e (m, p+1), over the joints c before each."""
    for m in range(moved.shape[0]):
        whole, linear, squares = 0.0, 0.0, 0.0
        for v in range(moved.shape[1]):
            e, w = moved[m, v], weights[v]
            out[m, v] = math.sqrt((turn + whole) * e * e + 2.0 * linear * e + squares)
            whole, linear, squares = whole + w, linear + w * e, squares + w * e * e


@dataclass(frozen=True, eq=False)
class Budget:
    """What is given of the tolerances of a task and its robot.

    Attributes
    ----------
    robot
    cad : m
        Bound of how far obstacles are from where they are drawn.
    sag : (n,) m
        Bound of what is left of the sag at the end of every link.
    shift, turn : m, rad
        Standard deviations of the base's place along each axis and of its turn about each.
    pivot : (3,) m
        Where the base's place was measured.
    joints : (n,) rad
        Standard deviations of the zeros of each joint's angles.
    zero : m
        Standard deviation of the zero of each cable's length.
    stiffness, mass
        Standard deviations of EA and of the masses, as shares of them.
    friction
        Coefficient of the cables in their holes; 0 where mechanics are not known.
    mechanics
        None if nothing is taken for what they leave over.
    gravity : (3,) m/s²
        In the frame of the task.
    assumed
        Parts whose values nobody measured.
    """

    robot: Robot
    cad: float
    sag: Array
    shift: float
    turn: float
    pivot: Array
    joints: Array
    zero: float
    stiffness: float
    mass: float
    friction: float
    mechanics: Mechanics | None
    gravity: Array
    assumed: frozenset[str]

    @classmethod
    def of(cls, spec: ToleranceSpec, robot: Robot, start: Array, gravity: ArrayLike = DOWN) -> Budget | None:
        """The budget of a task's and a robot's tolerances, with the first joint (3,) m at feed 0; None without any.

        Raises
        ------
        InputError
            Values for another number of sections than the arm has; or sections of which it is not known what
            tolerances take.
        """
        given = {name: spec.of_robot(name, robot.spec.tolerance) for name in RobotTolerance.model_fields}
        assumed = set(spec.assumed)
        for name, (value, of_task) in given.items():
            if name in assumed and not of_task and not value:
                raise InputError(
                    f"tolerance.assumed: {name!r} goes with a value of `{name}`, and neither the task nor its robot "
                    f"{robot.name} gives one; leave it out"
                )
            said = {"tolerance", f"tolerance.{name}"} & set(robot.assumed)
            if not of_task and said:
                assumed.add(name)
        sag = given["sag"][0]
        zero, stiffness, mass = (
            float(np.max(given[name][0])) for name in ("cable_zero", "axial_stiffness_percent", "mass_percent")
        )
        cables, known = robot.spec.cables, not why_unknown(robot)
        friction = cables.friction if cables is not None and known else 0.0
        if friction and {"cables", "cables.friction"} & set(robot.assumed):
            assumed.add("friction")
        rising = np.cumsum(robot.link_lengths) / robot.length
        made = cls(
            robot,
            spec.cad,
            _each("sag", sag, robot) if isinstance(sag, tuple) else sag * rising,
            spec.registration,
            float(np.radians(spec.registration_deg)),
            start if spec.registration_at is None else np.array(spec.registration_at),
            np.radians(_each("calibration_deg", given["calibration_deg"][0], robot)),
            zero,
            0.01 * stiffness,
            0.01 * mass,
            friction,
            Mechanics.of(robot) if known and (stiffness or mass or friction) else None,
            np.asarray(gravity, np.float64),
            frozenset(assumed),
        )
        if not made.given:
            return None
        refuse_unknown_sections(robot, made.zero > 0)
        refuse_flat(robot, made.zero > 0, made.mechanics is not None)
        if stiffness or mass:
            refuse_unknown_mechanics(robot, "axial_stiffness_percent" if stiffness else "mass_percent")
        return made

    @property
    def given(self) -> tuple[str, ...]:
        """The parts that are not zero, as keys of `PARTS`; friction alone, which no tolerance is, is none."""
        sizes = (self.cad, self.sag.max(), self.shift, self.turn, self.joints.max(), self.zero)
        sizes = (*sizes, self.stiffness, self.mass, self.friction if any(sizes) or self.stiffness or self.mass else 0)
        return tuple(name for name, size in zip(PARTS, sizes, strict=True) if size > 0)

    @cached_property
    def bounded(self) -> Array:
        """What is taken (p,) m of the clearance of each chord for the bounded parts."""
        return self.cad + self.sag[self.robot.outline.sections]

    def left_over(
        self, base: Base, angles: Array, at: Array, joints: Array, held: Held | None = None
    ) -> dict[str, Array]:
        """Spread (T, n+1) m of joints and tip by what is left although the weight is made up for; see `left_over`."""
        if self.mechanics is None:
            return {}
        axes = joint_axes(base, angles, at)
        gravity = base.aligned(np.broadcast_to(self.gravity, (len(at), 3)), at)
        # EA that is too small moves the arm by more than EA that is too large by as much, which is what counts here.
        shares = (self.stiffness / (1.0 - COVERAGE * self.stiffness), self.mass)
        return left_over(self.mechanics, shares, self.friction, angles, gravity, axes, joints, held)

    def turned(self, vertices: Array) -> Array:
        """Distances (m, p+1) m of vertices (m, p+1, 3) m from where the base's place was measured, times σ."""
        return self.turn * np.linalg.norm(vertices - self.pivot, axis=2)

    def bent(self, vertices: Array) -> Array:
        """Spread (m, p+1) m of vertices (m, p+1, 3) m by the joints before them."""
        out = np.empty(vertices.shape[:2])
        _spread(vertices, self.pivot, self._weights, 0.0, 0.0, out)
        return out

    def spread(self, vertices: Array) -> Array:
        """Spread (m, p+1) m of vertices (m, p+1, 3) m by everything but the zeros of cables."""
        out = np.empty(vertices.shape[:2])
        _spread(vertices, self.pivot, self._weights, self.shift**2, self.turn**2, out)
        return out

    def change(self, moved: Array) -> Array:
        """How much (m, p+1) m that spread grows at most where each vertex moves by up to (m, p+1) m.

        The spread is the norm of a linear function of all places, that of the change is the norm of a function of their
        changes.
        """
        out = np.empty_like(moved)
        _change(moved, self._weights, self.turn**2, out)
        return out

    @cached_property
    def _weights(self) -> Array:
        """What the joint at each vertex (c+1,) rad² of the outline counts for; 0 where there is none."""
        outline = self.robot.outline
        chords = np.arange(len(self.robot.chord_sections)) if outline.lines is None else outline.lines.on_line[:-1]
        found = np.zeros(len(outline.sections) + 1)
        found[chords] = weights_of(self.robot, self.joints)
        return found

    def of_base(self, points: Array, away: Array | float = 0.0) -> Array:
        """What is taken (...) m of the clearance of places on the base that are up to so far (...) m from points.

        The points are (..., 3) m. No joint comes before the places, so only what is measured of the base counts.
        """
        far = np.linalg.norm(points - self.pivot, axis=-1) + away
        return self.cad + COVERAGE * np.hypot(self.shift, self.turn * far)

    def of_mount(self, base: Base, starts: Array, ends: Array, radii: Array) -> Array:
        """What is taken (q,) m of the clearance of capsules that contain the mount; they are as of `Base.behind`."""
        beside = radii - (base.mount.radius if base.mount else 0.0)  # so far from their axes the mount may be
        return np.maximum(self.of_base(starts, beside), self.of_base(ends, beside))

    def straight(self, base: Base, way: float) -> Array:
        """What is taken (n,) m of every link's clearance by the straight arm, fed as far as it goes.

        A base without end follows as far as a way (m). This is more than in any other pose, but for zeros of cables,
        which count as in a straight arm, and for a carrier that is beside the path with the first joint.
        """
        robot, farthest = self.robot, base.farthest if math.isfinite(base.farthest) else way
        arcs = np.append(0.0, np.cumsum(robot.link_lengths))
        line = arcs[:, None] * np.array(FORWARD)
        far = np.linalg.norm(base.start - self.pivot) + farthest + arcs
        if base.straight:  # on the straight run, an end is farthest; behind it, the body may go any way
            entrance = float(np.linalg.norm(base.start + base.run * base.direction - self.pivot))
            behind = entrance + np.maximum(farthest + arcs - base.run, 0.0)
            far = np.maximum(np.linalg.norm(base.start - self.pivot), behind)
        levers = np.maximum(arcs[:, None] - arcs[:-1], 0.0)
        bent = np.linalg.norm(levers * self.joints, axis=1)
        if not robot.straight_links:
            begins = np.append(0.0, np.cumsum(robot.model.arcs(robot.link_lengths)))[:-1]
            levers = np.maximum(arcs[:, None] - begins, 0.0)
            bent = np.linalg.norm(levers * np.sqrt(weights_of(robot, self.joints)), axis=1)
        spread = [np.full_like(arcs, self.shift), self.turn * far, bent]
        if self.zero:
            none = np.zeros((1, robot.sections, 2))
            axes = np.broadcast_to(np.eye(3)[[1, 0]], (1, robot.sections, 2, 3))
            spread.append(self.zero * largest(by_zeros(axes, line[None], angles_per_length(robot, none)))[0])
        none, at = np.zeros((1, robot.sections, 2)), base.coordinates(np.zeros(1), straight_joints(base, robot))
        spread += [part[0] for part in self.left_over(base, none, at, joints_on(base, robot, none, at)).values()]
        return self.cad + self.sag + COVERAGE * along_chords(np.linalg.norm(spread, axis=0)[None])[0]

    def label(self, name: str) -> str:
        """A part and what is given of it, in words: `registration 0.05°`."""
        return f"{WORDS[name]} {self.size_words(name)}{' (assumed)' if name in self.assumed else ''}"

    def size_words(self, name: str) -> str:
        """What is given of a part, with its unit."""
        sizes = {
            "cad": (self.cad, 1e3),
            "sag": (float(self.sag.max()), 1e3),
            "registration": (self.shift, 1e3),
            "registration_deg": (self.turn, DEGREES),
            "calibration_deg": (float(self.joints.max()), DEGREES),
            "cable_zero": (self.zero, 1e3),
            "axial_stiffness_percent": (self.stiffness, 1e2),
            "mass_percent": (self.mass, 1e2),
            "friction": (self.friction, 1.0),
        }
        size, factor = sizes[name]
        return f"{factor * size:.3g}{ {DEGREES: '°', 1e3: ' mm', 1e2: ' %', 1.0: ''}[factor] }"

    def words(self, taken: float, parts: Mapping[str, float]) -> str:
        """What is taken (m) in all, and which of the parts (m) is the largest, in words."""
        worst = max(parts, key=lambda name: parts[name])
        is_largest = f"{'are' if worst in PLURAL else 'is'} {1e3 * parts[worst]:.1f} of the {1e3 * taken:.1f} mm"
        return f"{self.label(worst)} {is_largest} that tolerances take"


def along_chords(spread: Array) -> Array:
    """The largest spread (m, p) m of the points of each chord, from that at its ends (m, p+1) m.

    The errors of a point are linear in its place on the chord, so that their norm is largest at an end.
    """
    return np.maximum(spread[:, :-1], spread[:, 1:])


def _each(name: str, value: float | tuple[float, ...], robot: Robot) -> Array:
    """One value for each section."""
    if isinstance(value, tuple):
        if len(value) != robot.sections:
            raise InputError(
                f"tolerance.{name}: {len(value)} values, but the arm has {robot.sections} sections; give one for each, "
                "or a single one for all"
            )
        return np.array(value, dtype=np.float64)
    return np.full(robot.sections, value, dtype=np.float64)
