"""Following with sections of any kinds: stacks of joints, hinges, arcs, mixed with rigid links.

A section that bends along its length begins where the one before ends, in that one's direction. Given its beginning P
with the frame R, its angles (α, β) and the path's parameter u are found together from three equations,

    P + R e(α, β) - r(u) + λ L across(T(α, β) - t(u) - ē(u)) = 0 ,

with e its end, T the direction there, t the path's tangent, and `across` what is perpendicular to t. With λ = 0 the end
is on the path. Ends on the path alone let the direction ring: an error of the direction comes back with the opposite
sign at the next end, times (k - 1)/(k + 1) in a stack of k joints, undamped in an arc. With λ = c (k - 1)/k the factor
is (1/2 - c)/(1/2 + c) of an arc, and the body lies closer to the path although its ends are a little beside it. ē is by
how much the direction of a section's end that is on the path differs from the tangent where nothing rings: see
`hognose.following.aim`.

Newton's method starts from the angles of the step before, or from the first point of the path at which the section can
end, which is searched for in strides. Derivations: docs/following.md. Source: own. Their weakness: arms of four
sections or fewer on sharp paths, where the body leaves the path by much, and limits of angles, which are not kept.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.errors import InfeasibleError
from hognose.following.aim import aimed
from hognose.following.arc import arc_solved, arcs_advanced, carry
from hognose.following.chain import base_frames, carried_frames
from hognose.following.crossing import OVERRUN, REACH, Traced, traced
from hognose.following.exact import straight_start
from hognose.following.follower import Array, Follower, Limits
from hognose.following.given import axes_of_base, check_along, check_lengths
from hognose.following.recall import blank_memory, recalled, remember
from hognose.following.section_search import FARTHEST, Arm, sought
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at
from hognose.robot.sections import MixedSections
from hognose.robot.sections.chain import (
    BY_ALPHA,
    BY_BETA,
    END,
    ROWS,
    TURN_ALPHA,
    TURN_BETA,
    X,
    Z,
    crossed,
    end_of,
    frame_after,
)
from hognose.wording import point

#: Newton's method ends with a step so small (rad, and in section lengths), with the law of λ = 0 and else; or after so
#: many. The last step is carried out to first order.
_LAST, _LAST_AIMED, _MOST = 1e-8, 1e-12, 30
#: No step turns more than this (rad).
_LONGEST = 0.5


@kernel(inline="always")
def _outer(frame: NDArray, work: NDArray, row: int, k: int) -> float:
    """Coordinate k of a row of `work`, which is seen from the section's beginning."""
    return work[row, 0] * frame[0, k] + work[row, 1] * frame[1, k] + work[row, 2] * frame[2, k]


@kernel(fastmath={"contract"})
def _solved(
    curve: Traced,
    arm: Arm,
    i: int,
    weight: float,
    start: NDArray,
    frame: NDArray,
    guess: tuple[float, float, float],
    found: NDArray,
    work: NDArray,
) -> bool:
    """Newton's method for section i from a guess of u, α and β; `found` (6,) gets them and the place of the end.

    Then `work` has the section's end, its frame carried on by the last step.
    """
    breaks, coefficients, _, evaluations = curve
    table, first, _, lengths, _, inverse, _ = arm
    u, alpha, beta = guess
    last, segment = coefficients.shape[0] - 1, segment_at(breaks, u)
    path, columns = np.empty((3, 3)), np.empty((4, 3))
    for _ in range(_MOST):
        end_of(table, first[i], first[i + 1], alpha, beta, work)
        while segment < last and u >= breaks[segment + 1]:
            segment += 1
        while segment > 0 and u < breaks[segment]:
            segment -= 1
        evaluations[0] += 1
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
        path[0, 0], path[0, 1], path[0, 2] = px, py, pz
        path[1, 0], path[1, 1], path[1, 2] = vx, vy, vz
        path[2, 0], path[2, 1], path[2, 2] = ax, ay, az
        for k in range(3):
            columns[0, k], columns[1, k] = _outer(frame, work, BY_ALPHA, k), _outer(frame, work, BY_BETA, k)
            columns[2, k] = -path[1, k]
            found[3 + k] = start[k] + _outer(frame, work, END, k)
            columns[3, k] = found[3 + k] - path[0, k]
        if weight > 0.0:
            seen = np.empty((ROWS, 3))
            for row in (Z, TURN_ALPHA, TURN_BETA):
                for k in range(3):
                    seen[row, k] = _outer(frame, work, row, k)
            aimed(curve, u, path, inverse[i], lengths[i], weight, columns, seen)
        ox, oy, oz = _normal(columns, 1, 2)
        determinant = columns[0, 0] * ox + columns[0, 1] * oy + columns[0, 2] * oz
        if determinant == 0.0 or math.isnan(determinant):
            return False
        d_alpha = -(columns[3, 0] * ox + columns[3, 1] * oy + columns[3, 2] * oz) / determinant
        ox, oy, oz = _normal(columns, 2, 0)
        d_beta = -(columns[3, 0] * ox + columns[3, 1] * oy + columns[3, 2] * oz) / determinant
        ox, oy, oz = _normal(columns, 0, 1)
        du = -(columns[3, 0] * ox + columns[3, 1] * oy + columns[3, 2] * oz) / determinant
        turn = max(abs(d_alpha), abs(d_beta))
        scale = min(1.0, _LONGEST / turn) if turn > 0.0 else 1.0
        u, alpha, beta = u + scale * du, alpha + scale * d_alpha, beta + scale * d_beta
        size = max(turn, abs(du) * math.sqrt(vx * vx + vy * vy + vz * vz) / lengths[i])
        if size < (_LAST_AIMED if weight > 0.0 else _LAST):
            found[0], found[1], found[2] = u, alpha, beta
            for k in range(3):
                if weight > 0.0:
                    found[3 + k] += columns[0, k] * d_alpha + columns[1, k] * d_beta
                else:
                    found[3 + k] = path[0, k] + du * (path[1, k] + du * path[2, k])
            work[TURN_ALPHA] = d_alpha * work[TURN_ALPHA] + d_beta * work[TURN_BETA]
            for row in range(X, Z + 1):
                crossed(work, row, TURN_ALPHA, work[row, 0], work[row, 1], work[row, 2])
            return True
    return False


@kernel(inline="always")
def _normal(columns: NDArray, a: int, b: int) -> tuple[float, float, float]:
    """The cross product of two rows."""
    return (
        columns[a, 1] * columns[b, 2] - columns[a, 2] * columns[b, 1],
        columns[a, 2] * columns[b, 0] - columns[a, 0] * columns[b, 2],
        columns[a, 0] * columns[b, 1] - columns[a, 1] * columns[b, 0],
    )


@kernel(fastmath={"contract"}, error_model="numpy")
def sections_advanced(
    curve: Traced,
    arm: Arm,
    tracks: bool,
    bases: NDArray,
    axes: NDArray,
    feeds: NDArray,
    memory: tuple[NDArray, NDArray, NDArray],
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `axes` (1 or T, 3, 3) are the base's, in rows."""
    breaks, coefficients, fastest, _ = curve
    steps, segments, parameters = memory
    lengths, weights, lone = arm[3], arm[4], arm[6]
    top_speed, shortest, sections = fastest.max(), lengths.min(), lengths.size
    found, work, frame, start = np.empty(6), np.empty((ROWS, 3)), np.empty((3, 3)), np.empty(3)
    for t in range(feeds.size):
        remembers, change, per_feed = recalled(steps[0], feeds[t], tracks)
        remembers = remembers and abs(change) < FARTHEST * shortest
        before = bases[t]
        segment = segment_at(breaks, before)
        start[0], start[1], start[2], _, _, _, _, _, _ = evaluate(coefficients, segment, before - breaks[segment])
        frame[:] = axes[min(t, axes.shape[0] - 1)]
        joints[t, 0], parameters[t, 0] = start, before
        for i in range(sections):
            placed, weight = False, weights[i]
            u = before + steps[0, 0, i] + steps[0, 1, i] * change
            if remembers and lone[i]:
                segment, found[0], found[3], found[4], found[5] = arc_solved(
                    curve,
                    lengths[i],
                    start[0],
                    start[1],
                    start[2],
                    frame[2, 0],
                    frame[2, 1],
                    frame[2, 2],
                    u,
                    segments[i],
                )
                placed = segment >= 0
            elif remembers:
                alpha, beta = steps[1, 0, i] + steps[1, 1, i] * change, steps[2, 0, i] + steps[2, 1, i] * change
                placed = _solved(curve, arm, i, weight, start, frame, (u, alpha, beta), found, work)
                placed = placed and max(abs(found[1]), abs(found[2])) < math.pi
            near = found[0] > before and (found[0] - before) * top_speed < REACH * lengths[i]
            if not (placed and near and found[0] <= breaks[-1] + OVERRUN):
                placed = sought(curve, arm, i, before, start, frame, found, work)
                u, alpha, beta = found[0], found[1], found[2]
                if placed and lone[i]:
                    segment = segment_at(breaks, u)
                    segment, found[0], found[3], found[4], found[5] = arc_solved(
                        curve,
                        lengths[i],
                        start[0],
                        start[1],
                        start[2],
                        frame[2, 0],
                        frame[2, 1],
                        frame[2, 2],
                        u,
                        segment,
                    )
                    placed = segment >= 0
                elif placed:
                    placed = _solved(curve, arm, i, weight, start, frame, (u, alpha, beta), found, work)
                if not placed:
                    steps[0, 0, sections] = math.nan
                    return t, i
            remember(steps[0], i, found[0] - before, per_feed)
            if lone[i]:
                segments[i] = segment
                carry(frame, start, found)
            else:
                remember(steps[1], i, found[1], per_feed)
                remember(steps[2], i, found[2], per_feed)
                frame_after(frame, work)
            before = found[0]
            parameters[t, i + 1] = before
            for k in range(3):
                start[k] = found[3 + k]
                joints[t, i + 1, k] = start[k]
        steps[0, 0, sections] = feeds[t]
    return -1, -1


def arm_of(model: MixedSections, link_lengths: Array, aim: float) -> Arm:
    """Sections of lengths (n,) m as kernels take them, with the c of the law."""
    weights = aim * (1.0 - model.curvature_shares) * link_lengths
    weights[-1] = 0.0  # the tip is on the path
    shares, lone = np.ascontiguousarray(model.curvature_shares), model.lone_arcs & (weights == 0)
    return model.table, model.first, model.gains, link_lengths, weights, shares, lone


class SectionFollower(Follower):
    """What following methods that take sections of any kinds have in common.

    Parameters
    ----------
    path, link_lengths, spacing, bend_limits
        As in `Follower`.
    model
        The sections.
    axes : (3, 3), optional
        Of the base, in columns, the third along the path; unless given, those that turn least from the task's.
    carried
        Whether the base goes along the path wherever that leads, and its axes turn the shortest way from those at the
        start to the path's direction; else they stay as they are given.
    """

    #: c of the law: no more than half, with which nothing rings.
    aim: ClassVar[float] = 0.0
    #: Whether a pose needs nothing of the path but what is behind the tip, so that a path may grow: see `growing`.
    grows: ClassVar[bool] = True

    def __init__(
        self,
        path: Path,
        model: MixedSections,
        link_lengths: ArrayLike,
        spacing: float = 0.0005,
        bend_limits: Limits = None,
        axes: Array | None = None,
        carried: bool = False,
    ) -> None:
        self.model, self.axes = model, None if axes is None else np.ascontiguousarray(axes_of_base(axes).T[None])
        self.carried = carried
        super().__init__(path, link_lengths, spacing, bend_limits)

    def _prepare(self) -> None:
        sections = self.link_lengths.size
        check_lengths(self.link_lengths, self.model)
        self._arm = arm_of(self.model, self.link_lengths, self.aim)
        self._steps, self._segments = np.stack([blank_memory(sections)] * 3), np.zeros(sections, np.int64)
        self._traced = traced(self.curve, self._evaluations)
        self._run_length = straight_start(self.curve)
        if self.axes is not None:
            check_along(self.axes[0, 2], self.curve.tangent(np.zeros(1))[0])
        self._start = base_frames(self.curve, np.zeros(1)) if self.axes is None else self.axes

    @property
    def tolerance(self) -> float:
        """Rounding only."""
        return 1e-12

    def run_with_axes(self, feeds: ArrayLike) -> tuple[Array, Array]:
        """As `run`; also the axes (T, 3, 3) of the base, in columns, from which the first section begins along z."""
        joints = self.run(feeds)
        return joints, np.swapaxes(np.broadcast_to(self._stood, (len(joints), 3, 3)), 1, 2).copy()

    def tip_arc(self, feed: float) -> float:
        """Arc length (m) of the tip on the path at a feed; errors as in `step`."""
        self.step(feed)
        return float(self.curve.arc_length(np.minimum(self._parameters[0, -1:], self.curve.breaks[-1]))[0])

    def _axes_off_run(self, path: Path, feeds: Array) -> Array:
        """Axes (1 or T, 3, 3) of the base, in rows, at feeds (T,) m of which not all are on the straight run."""
        if self.carried:
            return carried_frames(path, feeds, self._start[0])
        return base_frames(path, feeds) if self.axes is None else self.axes

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        begins = point(joints[step, link], "g")
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm: section {link + 1} "
            f"({1e3 * float(self.link_lengths[link]):g} mm), which begins at {begins}, has no posture that the method "
            f"{self.name!r} asks for: it places sections one after the other, and here the path ends too early or "
            "bends too sharply for them. Feed less, lengthen the path, or take 'fitted', which fits the whole arm."
        )

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        self._parameters = np.empty((feeds.size, self.link_lengths.size + 1))
        on_run = feeds.max(initial=0.0) <= self._run_length
        bases = self.curve.breaks[0] + feeds if on_run else self.curve.parameter(feeds)
        self._stood = self._start if on_run else self._axes_off_run(self.curve, feeds)
        memory = (self._steps, self._segments, self._parameters)
        advance = arcs_advanced if self._arm[-1].all() else sections_advanced
        return advance(self._traced, self._arm, self.tracks, bases, self._stood, feeds, memory, joints)


class ExactSections(SectionFollower):
    """The ends of all sections on the path."""

    name = "exact"


class AimedSections(SectionFollower):
    """Ends and directions of sections aimed at the path, so that directions do not ring; the tip on the path."""

    name = "aim"
    glides = False
    aim: ClassVar[float] = 0.35
