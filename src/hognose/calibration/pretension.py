"""Taking up slack and pretensioning, section by section from the base, with the motors under position control.

Only what cables pull against each other is controlled: tensions N a with Jᵀ N = 0, which no joint feels. The motors
move by N a / k for it, which leaves the pose as it is. The rest of the tensions is left to the balance of the joints.
Controlling the tension of every cable for itself would take all stiffness from the arm, and it would fall away. Only
where something holds the pose, each cable has its own tension.

An arm that hangs is taken up by position, every section to where it would be if nothing were off: pulling the first one
to its tension while the others are slack would pull it more than it bears. In a jig or a trough it is done by tension.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.arm import Accuracy, Arm, finite
from hognose.calibration.fit import Prior
from hognose.errors import InfeasibleError
from hognose.mechanics import Mechanics
from hognose.mechanics.advice import why_it_does_not_stand
from hognose.mechanics.remedies import Poses, where_it_buckles
from hognose.mechanics.stiffness import load_factors

Array = NDArray[np.float64]

#: Standard deviations of zeros by which cables are paid out first, and may be pulled in beyond where they belong.
_PAID_OUT, _PULLED_IN = 3.0, 5.0
#: No motor moves by more (m) before the tensions are read again.
_LARGEST_STEP = 5e-4
#: A section is taken up when its mean is this share of what it shall be, and pretensioned when it is off by less.
_TAKEN_UP, _EXACT = 0.5, 0.02
#: Shares of what is lacking that a pull of a section, and of all of them, is meant to give: EA may be twice as large.
_GAIN_OF_SECTION, _GAIN = 0.5, 0.7
#: Rounds, over a section besides those that the way of its motors takes, and over all sections, before it is given up.
_MOST_ROUNDS = 60


@dataclass(frozen=True, eq=False)
class Pretensioned:
    """An arm that is pretensioned.

    Attributes
    ----------
    motors : (c,) m
    tensions : (c,) N
    zeros : (c,) m
        First estimate: how far the motors are from where they would be if nothing were off.
    moves
        How often motors moved.
    """

    motors: Array
    tensions: Array
    zeros: Array
    moves: int


def pretension(
    arm: Arm,
    mechanics: Mechanics,
    gravity: Array,
    at: Array,
    pace: float,
    prior: Prior,
    accuracy: Accuracy,
    progress: Callable[[int, int], None] = lambda done, total: None,
    zeros: Array | None = None,
) -> Pretensioned:
    """Take up the slack of an arm that is about straight, and bring every section to its pretension.

    Parameters
    ----------
    arm
    mechanics
        Nominal.
    gravity : (3,) m/s²
        In the arm's own axes.
    at : (k,)
        Coordinates of the base, which stays there.
    pace : m/s
        Of the motors.
    prior, accuracy
    progress
        Called with the sections that are taken up, and how many there are.
    zeros : (c,) m, optional
        As a pretensioning before has found them, of an arm that was held then.

    Raises
    ------
    InputError
        A sensor reads what is no finite number.
    InfeasibleError
        No pretension holds the arm; a cable stays slack, or is pulled more than `tension_max`; or the arm would buckle.
    """
    return _Pretensioning(arm, mechanics, gravity, at, pace, prior, accuracy, zeros).done(progress)


def refuse_what_does_not_hold(mechanics: Mechanics, gravity: Array) -> None:
    """Raise an InfeasibleError if the pretension of an arm does not hold it straight: which section, and what would."""
    straight = np.zeros((1, mechanics.robot.sections, 2))
    why = why_it_does_not_stand(mechanics, Poses(straight, np.broadcast_to(gravity, (1, 3)), 0))
    if why:
        raise InfeasibleError(f"no pretension that holds the arm straight: {why}")


def null_space(matrix: Array) -> Array:
    """Orthonormal columns N (c, c-m) with M N = 0 for a matrix M (m, c) of full rank."""
    return np.linalg.svd(matrix)[2][len(matrix) :].T


class _Pretensioning:
    """The state of it: where the motors are, what the cables pull."""

    def __init__(
        self,
        arm: Arm,
        mechanics: Mechanics,
        gravity: Array,
        at: Array,
        pace: float,
        prior: Prior,
        accuracy: Accuracy,
        zeros: Array | None,
    ) -> None:
        refuse_what_does_not_hold(mechanics, gravity)
        self.arm, self.mechanics, self.gravity, self.at, self.pace = arm, mechanics, gravity, at, pace
        self.straight = np.zeros((1, mechanics.robot.sections, 2))
        held = mechanics.hold(self.straight, gravity)
        if arm.clamped:  # the jig carries the weight
            wanted = mechanics.pretension
            self.meant = held.cable_lengths[0] - wanted / held.spring_constants[0]
        else:
            wanted, self.meant = held.tensions[0], held.commanded_lengths[0]
        self.unfelt = null_space(mechanics.cable_jacobian(self.straight)[0].T)
        self.springs, self.wanted, self.noise = held.spring_constants[0], wanted, accuracy.tension
        self.softer = math.exp(-2.0 * prior.stiffness)
        self.farthest = self.meant - _PULLED_IN * prior.zero - 2.0 * (wanted / self.springs) * prior.stiffness
        self.slack = zeros is None
        self.motors = self.meant + (_PAID_OUT * prior.zero if zeros is None else -zeros)
        self.tensions, self.moves, self.answer = np.zeros(len(wanted)), 0, 1.0

    def done(self, progress: Callable[[int, int], None]) -> Pretensioned:
        sections = self.mechanics.robot.sections
        self.move(self.motors)
        for section in range(sections):
            if self.slack:
                self.take_up(section)
            progress(section + 1, sections)
        off = self.off()
        for _ in range(_MOST_ROUNDS):
            if (np.abs(off) <= np.maximum(_EXACT * self.wanted, 4.0 * self.noise)).all():
                self.refuse_slack(np.full(len(off), 4.0 * self.noise), np.ones(len(off), np.bool_))
                return Pretensioned(self.motors, self.tensions, self.meant - self.motors, self.moves)
            self.pull(_GAIN * off)
            off = self.off()
        raise self.no_end(self.worst(off), off, _MOST_ROUNDS)

    def no_end(self, section: int, off: Array, rounds: int) -> InfeasibleError:
        """The error of a section whose cables (c,) are still off by so much (N) after so many rounds."""
        worst = float(np.abs(off[self.mechanics.robot.cable_sections == section]).max())
        return InfeasibleError(
            f"pretension: after {rounds} rounds section {section + 1} is off by {worst:.3g} N; the last pull gave "
            f"{100 * self.answer:.0f} % of what the file's EA says. Is EA right? Does something touch the arm, or do "
            "its cables rub?"
        )

    def take_up(self, section: int) -> None:
        """Pull in a section's cables: to half of what they shall pull, or to where they belong."""
        own = self.mechanics.robot.cable_sections == section
        while not self.arm.clamped and (self.motors > self.meant)[own].any():
            pulled_in = np.maximum(self.motors - _LARGEST_STEP, self.meant)
            self.move(np.where(own, pulled_in, self.motors))
        if not self.arm.clamped:
            return
        most = _MOST_ROUNDS + math.ceil(float((self.motors - self.farthest)[own].max()) / _LARGEST_STEP)
        for _ in range(most):
            short = np.where(own, self.off(), 0.0)
            if (short <= _TAKEN_UP * self.wanted)[own].all():
                return
            self.pull(_GAIN_OF_SECTION * short)
        raise self.no_end(section, self.off(), most)

    def off(self) -> Array:
        """How much (c,) N the cables lack: where the arm is held each its own, else of what no joint feels."""
        short = self.wanted - self.tensions
        return short if self.arm.clamped else self.unfelt @ (self.unfelt.T @ short)

    def pull(self, lacking: Array) -> None:
        """Move the motors by what would give the tensions that are lacking (c,) N."""
        step = np.clip(lacking / self.springs, -_LARGEST_STEP, _LARGEST_STEP)
        wanted = self.motors - step
        if (wanted < self.farthest).any():
            self.refuse_slack(_TAKEN_UP * self.wanted, lacking > 0)
        wanted = np.maximum(wanted, self.farthest)
        said, before = self.springs * (self.motors - wanted), self.tensions
        self.move(wanted)
        self.answer = float(said @ (self.tensions - before)) / max(float(said @ said), 1e-12)

    def move(self, motors: Array) -> None:
        self.arm.command(motors, self.at, self.pace)
        self.arm.settle()
        self.motors, self.moves = motors, self.moves + 1
        self.tensions = finite("pretension", "the tension of cable", self.arm.tensions(), "N")
        self.refuse_too_much()

    def refuse_too_much(self) -> None:
        most = self.mechanics.tension_max
        cable = int(np.argmax(self.tensions))
        if self.tensions[cable] > most:
            raise InfeasibleError(
                f"pretension: {self.named(cable)} pulls {self.tensions[cable]:.4g} N, more than tension_max_N "
                f"{most:g} N; the motors were stopped. Is its zero off by more than was said, or the arm not straight?"
            )
        pulls = np.maximum(self.tensions, 0.0)[None]
        elastic, rest = self.mechanics.stiffness(self.straight, pulls, self.gravity)
        factor = float(load_factors(self.softer * elastic, rest)[0])
        if factor < 1.0 and not self.arm.clamped:
            section = where_it_buckles(
                self.mechanics, pulls, Poses(self.straight, np.broadcast_to(self.gravity, (1, 3)), 0)
            )[0]
            raise InfeasibleError(
                f"pretension: section {section + 1} would buckle with what the cables pull now (load factor "
                f"{factor:.3g} if EA is as low as it may be); take less pretension or stiffer cables"
            )

    def refuse_slack(self, least: Array, asked: NDArray[np.bool_]) -> None:
        """Raise if one of the cables (c,) that are asked for pulls less than the least (c,) N."""
        cable = int(np.argmin(np.where(asked, self.tensions / self.wanted, np.inf)))
        if self.tensions[cable] <= least[cable]:
            pulled = 1e3 * (self.meant - self.motors)[cable]
            raise InfeasibleError(
                f"pretension: {self.named(cable)} stays slack, with {self.tensions[cable]:.3g} N, though its motor is "
                f"{pulled:.2f} mm beyond where it should be; is it torn or off its drum, or its zero off by more than "
                "was said?"
            )

    def named(self, cable: int) -> str:
        return f"cable {cable + 1} (section {self.mechanics.robot.cable_sections[cable] + 1})"

    def worst(self, off: Array) -> int:
        return int(self.mechanics.robot.cable_sections[int(np.argmax(np.abs(off)))])
