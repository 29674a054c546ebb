"""Zeros and stiffness from readings: nonlinear least squares with what is known before, and its covariance.

All residuals are in standard deviations: of tensions and tips by how exactly they are measured, of the unknowns by how
well they are known before. So the sum of their squares at the end is a χ², with as many degrees of freedom as there
are measured values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.calibration.arm import Accuracy, Reading
from hognose.calibration.model import Model, Shown, stacked
from hognose.errors import InfeasibleError, InputError

Array = NDArray[np.float64]

#: Levenberg and Marquardt's steps, the first damping, and the step (in standard deviations) at which it has ended.
_MOST_STEPS, _DAMPING, _ENDED = 60, 1e-4, 1e-5
#: A χ² that is above its mean by so many of its standard deviations is no chance.
_UNLIKELY = 5.0


@dataclass(frozen=True)
class Prior:
    """What is known of an arm before: standard deviations.

    Attributes
    ----------
    zero : m
        Of every cable's zero.
    stiffness
        Of the logarithm of every section's EA; 0.12 is that of values anywhere within 20 %.
    """

    zero: float = 5e-4
    stiffness: float = 0.12


@dataclass(frozen=True, eq=False)
class Fit:
    """What readings say of an arm.

    Attributes
    ----------
    zeros : (c,) m
        By how much each cable is longer than its motor says.
    stiffness : (n,)
        Factor of EA of each section's own cables.
    covariance : (c+n, c+n)
        Of the zeros (m) and of the logarithms of the factors.
    chi2, degrees
        Sum of the squares of all residuals, and how many values were measured: about equal if the model is right.
    steps
        Of the least squares.
    """

    zeros: Array
    stiffness: Array
    covariance: Array
    chi2: float
    degrees: int
    steps: int

    @property
    def fits(self) -> bool:
        """Whether what was read can be explained by zeros, stiffness and how exactly it is measured."""
        return self.chi2 <= self.degrees + _UNLIKELY * np.sqrt(2.0 * self.degrees)


def fit(model: Model, readings: Sequence[Reading], accuracy: Accuracy, prior: Prior, start: Array | None = None) -> Fit:
    """Zeros and stiffness from readings.

    Parameters
    ----------
    model
    readings
    accuracy, prior
    start : (c,) m, optional
        Zeros from which to begin.

    Raises
    ------
    InputError
        No readings.
    InfeasibleError
        The least squares do not come to an end, or the arm of the model does not rest where the readings are from.
    """
    if not readings:
        raise InputError("readings: there are none; read the arm in at least one pose")
    problem = _Problem(model, readings, accuracy, prior)
    theta, shown = problem.first(start)
    error, J = problem.residuals(theta, shown)
    damping = _DAMPING
    for step in range(1, _MOST_STEPS + 1):
        A, b = J.T @ J, J.T @ error
        change = -np.linalg.solve(A + damping * np.diag(np.diag(A)), b)
        tried = theta + change * problem.scales
        seen = problem.shown(tried, shown)
        found, slopes = problem.residuals(tried, seen)
        if found @ found <= error @ error * (1 + 1e-12):
            theta, shown, error, J = tried, seen, found, slopes
            damping = max(0.1 * damping, 1e-12)
            if np.abs(change).max() < _ENDED:
                return problem.result(theta, shown, error, J, step)
        elif np.abs(change).max() < _ENDED:
            return problem.result(theta, shown, error, J, step)
        else:
            damping = max(10.0 * damping, 1e-8)
    raise InfeasibleError(
        f"calibration: the least squares did not end in {_MOST_STEPS} steps; take up the slack of all cables first, "
        "and read the arm only where no cable is slack"
    )


@dataclass(frozen=True, eq=False)
class _Problem:
    """The residuals of readings."""

    model: Model
    readings: Sequence[Reading]
    accuracy: Accuracy
    prior: Prior

    @cached_property
    def free(self) -> tuple[Array, Array, Array]:
        return stacked(self.readings, clamped=False)

    @cached_property
    def jig(self) -> tuple[Array, Array, Array]:
        return stacked(self.readings, clamped=True)

    @property
    def scales(self) -> Array:
        """Standard deviation (p,) of every unknown before."""
        model, prior = self.model, self.prior
        sections = model.nominal.robot.sections
        known = [np.full(model.cables, prior.zero), np.full(sections, prior.stiffness)]
        return np.concatenate([*known, np.full(2 * sections if len(self.jig[0]) else 0, self.accuracy.jig)])

    def first(self, start: Array | None) -> tuple[Array, tuple[Shown, ...]]:
        theta = np.zeros(len(self.scales))
        if start is not None:
            theta[: self.model.cables] = start
        return theta, self.shown(theta, None)

    def shown(self, theta: Array, last: tuple[Shown, ...] | None) -> tuple[Shown, ...]:
        """What the model shows, free and in the jig; sought from what it showed last."""
        model, out = self.model, []
        if len(self.free[0]):
            out.append(model.free(theta, self.free[0], self.free[2] if last is None else last[0].angles))
        if len(self.jig[0]):
            out.append(model.clamped(theta, self.jig[0]))
        return tuple(out)

    def residuals(self, theta: Array, shown: tuple[Shown, ...]) -> tuple[Array, Array]:
        """Residuals (m,) and their derivatives (m, p) by the unknowns in standard deviations."""
        scales, errors, slopes = self.scales, [theta / self.scales], [np.diag(1.0 / self.scales)]
        parts = [part for part in (self.free, self.jig) if len(part[0])]
        for part, seen in zip(parts, shown, strict=True):
            errors.append(((seen.tensions - part[1]) / self.accuracy.tension).ravel())
            slopes.append(self._rows(seen.by_tensions) / self.accuracy.tension)
        tips = [(place, each.tip) for place, each in enumerate(self._loose()) if each.tip is not None]
        if tips:
            at = [place for place, _ in tips]
            errors.append(((shown[0].tips[at] - np.array([tip for _, tip in tips])) / self.accuracy.tip).ravel())
            slopes.append(self._rows(shown[0].by_tips[at]) / self.accuracy.tip)
        return np.concatenate(errors), np.concatenate(slopes) * scales

    def _loose(self) -> list[Reading]:
        return [each for each in self.readings if not each.clamped]

    def _rows(self, derivatives: Array) -> Array:
        """Derivatives (m, p) by all unknowns of some (T, x, q) by the first q."""
        flat = derivatives.reshape(-1, derivatives.shape[2])
        return np.hstack([flat, np.zeros((len(flat), len(self.scales) - flat.shape[1]))])

    def result(self, theta: Array, shown: tuple[Shown, ...], error: Array, J: Array, steps: int) -> Fit:
        falling = [pose for seen in shown for pose in np.flatnonzero(~seen.stable)]
        if falling:
            raise InfeasibleError(
                f"calibration: in pose {falling[0] + 1} the arm of the model buckles or leans on a joint limit, so "
                "that nothing is learned there; take poses that bend less, or other pretension"
            )
        size, scales = self.model.unknowns, self.scales
        covariance = np.linalg.inv(J.T @ J) * np.outer(scales, scales)
        cables = self.model.cables
        return Fit(
            theta[:cables],
            np.exp(theta[cables:size]),
            covariance[:size, :size],
            float(error @ error),
            len(error) - len(theta),
            steps,
        )
