"""What a calibration has found of an arm: how to command it, how exactly, and the file it is kept in."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import file_name, floats
from hognose.calibration.arm import Accuracy
from hognose.calibration.fit import Fit, Prior
from hognose.calibration.model import Model
from hognose.errors import InputError
from hognose.mechanics import Mechanics
from hognose.read_whole import read_whole
from hognose.robot import Robot
from hognose.write_whole import write_whole

Array = NDArray[np.float64]

#: Of the files.
SCHEMA = 1
#: What calibrations are made from.
METHODS = ("tensions", "tip", "jig")
#: No file is larger (bytes): 900 cables.
_LARGEST = 64 * 1024 * 1024


@dataclass(frozen=True, eq=False)
class Calibration:
    """Zeros and stiffness of the cables of one arm.

    Attributes
    ----------
    robot, fingerprint
        Name of the robot, and its digest.
    method
        One of `METHODS`.
    fit
        Zeros, factors of EA, and their covariance.
    accuracy, prior
        What was assumed of sensors and arm.
    readings
        How many.
    date
        When it was made, as ISO 8601 in UTC.
    """

    robot: str
    fingerprint: str
    method: str
    fit: Fit
    accuracy: Accuracy
    prior: Prior
    readings: int
    date: str

    @classmethod
    def made(cls, robot: Robot, method: str, fit: Fit, accuracy: Accuracy, prior: Prior, readings: int) -> Calibration:
        """One that was made now."""
        date = datetime.now(UTC).isoformat(timespec="seconds")
        return cls(robot.name, robot.fingerprint, method, fit, accuracy, prior, readings, date)

    def applied(self, mechanics: Mechanics) -> Mechanics:
        """The mechanics with the stiffness that was found.

        Raises
        ------
        InputError
            They are another robot's.
        """
        self.refuse_another(mechanics.robot)
        return self._model(mechanics, np.zeros(3)).arm(self._theta)

    def motors(self, mechanics: Mechanics, angles: ArrayLike, gravity: ArrayLike) -> Array:
        """Motor positions (T, c) m that bring the arm to angles (T, n, 2) rad, with its zeros and stiffness.

        Gravity (3,) or (T, 3) m/s² is in the arm's own axes; `mechanics` are nominal.

        Raises
        ------
        InputError
            Those of another robot, wrong shapes, or values that are not finite.
        """
        return self.applied(mechanics).hold(angles, gravity).commanded_lengths - self.fit.zeros

    def tip_spread(self, mechanics: Mechanics, angles: ArrayLike, gravity: ArrayLike) -> Array:
        """How far (T,) m the tip is off with what is left of errors: standard deviation over all directions.

        Arguments and errors as in `motors`.
        """
        poses = floats("angles", angles, f"(T, {mechanics.robot.sections}, 2)", "rad")
        arm, downward = self.applied(mechanics), np.broadcast_to(gravity, (len(poses), 3))
        held = arm.hold(poses, downward)
        sound = held.is_held & (held.load_factor > 1.0)
        J = self._model(mechanics, downward).derived(arm, poses, held.tensions, sound).by_tips
        return np.sqrt(np.maximum(np.einsum("txp,pq,txq->t", J, self.fit.covariance, J), 0.0))

    def refuse_another(self, robot: Robot) -> None:
        """Raise an InputError if a robot is not the one that was calibrated."""
        if robot.fingerprint != self.fingerprint:
            raise InputError(
                f"calibration: it is of robot {self.robot} ({self.fingerprint}), not of {robot.name} "
                f"({robot.fingerprint}); calibrate this robot, or take the robot file that was calibrated"
            )

    @property
    def zero_errors(self) -> Array:
        """Standard deviations (c,) m of the zeros."""
        return np.sqrt(np.diag(self.fit.covariance)[: len(self.fit.zeros)])

    @property
    def stiffness_errors(self) -> Array:
        """Standard deviations (n,) of the factors of EA, as shares of them."""
        return np.sqrt(np.diag(self.fit.covariance)[len(self.fit.zeros) :])

    def save(self, path: Path | str) -> None:
        """Write it as JSON, whole or not at all.

        Raises
        ------
        InputError
            It cannot be written; says why.
        """
        write_whole(file_name("path", path), (json.dumps(self.to_json(), indent=1) + "\n").encode())

    def to_json(self) -> dict[str, Any]:
        """All of it, in SI units."""
        fit = asdict(self.fit)
        for name in ("zeros", "stiffness", "covariance"):
            fit[name] = fit[name].tolist()
        own = {"robot": self.robot, "fingerprint": self.fingerprint, "date": self.date, "method": self.method}
        known = {"accuracy": asdict(self.accuracy), "prior": asdict(self.prior)}
        return {"schema": SCHEMA, "kind": "calibration", **own, "readings": self.readings, **known, **fit}

    @classmethod
    def load(cls, path: Path | str) -> Calibration:
        """Read one from a file.

        Raises
        ------
        InputError
            It cannot be read, or is no calibration; says what is wrong.
        """
        name = file_name("path", path)
        try:
            given = json.loads(read_whole(Path(name), _LARGEST))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{name}: is no JSON: {error}; `hognose calibrate` writes calibration files") from None
        return cls._of(str(name), given)

    @classmethod
    def _of(cls, name: str, given: Any) -> Calibration:
        if not isinstance(given, dict) or given.get("kind") != "calibration":
            raise InputError(f"{name}: is no calibration; `hognose calibrate` writes calibration files")
        if given.get("schema") != SCHEMA:
            raise InputError(f"{name}: schema {given.get('schema')!r}, expected {SCHEMA}; calibrate anew, or update")
        try:
            zeros = floats(f"{name}: zeros", given["zeros"], "(c,)", "m", 1.0)
            factors = floats(f"{name}: stiffness", given["stiffness"], "(n,)", "", 1e3)
            size = len(zeros) + len(factors)
            covariance = floats(f"{name}: covariance", given["covariance"], f"({size}, {size})", "")
            fit = Fit(zeros, factors, covariance, float(given["chi2"]), int(given["degrees"]), int(given["steps"]))
            robot, fingerprint, method, date = (str(given[key]) for key in ("robot", "fingerprint", "method", "date"))
            accuracy, prior = Accuracy(**given["accuracy"]), Prior(**given["prior"])
            return cls(robot, fingerprint, method, fit, accuracy, prior, int(given["readings"]), date)
        except KeyError as error:
            raise InputError(f"{name}: has no {error.args[0]!r}; calibrate anew") from None
        except (TypeError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{name}: {error}; calibrate anew") from None

    @property
    def _theta(self) -> Array:
        return np.concatenate([self.fit.zeros, np.log(self.fit.stiffness)])

    @staticmethod
    def _model(mechanics: Mechanics, gravity: Array) -> Model:
        return Model(mechanics, gravity)
