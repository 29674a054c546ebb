"""The whole of it: pretension an arm, read it in poses or in a jig, and find zeros and stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import floats, instance, real, whole
from hognose.cached import read_only
from hognose.calibration.arm import Accuracy, Arm, Reading, read
from hognose.calibration.calibration import METHODS, Calibration
from hognose.calibration.fit import Fit, Prior, fit
from hognose.calibration.model import Model
from hognose.calibration.poses import candidates, careful, chosen
from hognose.calibration.pretension import Pretensioned, pretension
from hognose.errors import InfeasibleError, InputError
from hognose.mechanics import Mechanics

Array = NDArray[np.float64]

#: Poses that each method reads unless told, of a jig the levels of tension.
POSES = {"tensions": 24, "tip": 12, "jig": 2}
#: In a jig, the tensions read are so many times the pretension, as far as the limits let it.
_LEVELS = (0.5, 2.0)
#: After so many poses zeros and stiffness are found for the first times, so that the poses to come are held better.
_FIRST_FITS = (1, 2, 4, 8)
#: Set-points on the way from the straight arm to a pose: between far ones, lengths that go linearly fit no pose.
_WAY = np.linspace(0.0, 1.0, 11)[1:]


@dataclass(frozen=True, eq=False)
class Setting:
    """What an arm is calibrated with.

    Attributes
    ----------
    mechanics
        Nominal.
    gravity : (3,) m/s²
        In the arm's own axes.
    at : (k,)
        Coordinates of the base, which stays there.
    accuracy, prior
    pace : m/s
        Of the motors.
    is_free
        Of angles (T, n, 2) rad: in which of them the arm is clear of everything. In all unless given.
    """

    mechanics: Mechanics
    gravity: Array
    at: Array
    accuracy: Accuracy = field(default_factory=Accuracy)
    prior: Prior = field(default_factory=Prior)
    pace: float = 0.005
    is_free: Callable[[Array], NDArray[np.bool_]] | None = None

    def __post_init__(self) -> None:
        instance("mechanics", self.mechanics, Mechanics, "hognose.mechanics.Mechanics, as of `Mechanics.of(robot)`")
        instance("accuracy", self.accuracy, Accuracy, "a hognose.calibration.Accuracy")
        instance("prior", self.prior, Prior, "a hognose.calibration.Prior")
        for name, shape, unit in (("gravity", "(3,)", "m/s²"), ("at", "(k,)", "m")):
            object.__setattr__(self, name, read_only(floats(name, getattr(self, name), shape, unit)))
        known = {"accuracy": self.accuracy, "prior": self.prior}
        for what, value in [(f"{name}.{key}", v) for name, one in known.items() for key, v in vars(one).items()]:
            real(what, value, "a standard deviation above 0", lambda value: 0 < value < math.inf)
        real("pace", self.pace, "m/s above 0", lambda value: 0 < value < math.inf)
        Model(self.mechanics, self.gravity)  # refuses arms that are not calibrated

    @property
    def model(self) -> Model:
        """The arm whose zeros and stiffness are sought."""
        return Model(self.mechanics, self.gravity)


def calibrate(
    arm: Arm,
    setting: Setting,
    method: str = "tip",
    poses: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Calibration:
    """Pretension an arm and find zeros and stiffness of its cables.

    Parameters
    ----------
    arm
        Held straight, by a jig or a trough; one that hangs on all its cables is calibrated too, but not by a jig.
    setting
    method
        "tensions": from tensions alone; "tip": the tip is seen as well; "jig": the arm is clamped straight, and read at
        two levels of tension.
    poses
        How many the arm is read in, by default `POSES`; not for a jig.
    progress
        Called with what is done, and of how much.

    Raises
    ------
    InputError
        What is given is none of that, an unknown method, too few poses, a jig is wanted and the arm is not in one, or a
        sensor reads no number.
    InfeasibleError
        No pretension holds the arm, a cable stays slack or is pulled too much, or nothing was found.
    """
    instance("arm", arm, Arm, "what has all members of hognose.calibration.Arm, such as a StaticArm")
    instance("setting", setting, Setting, "a hognose.calibration.Setting")
    count = _poses(method, poses)
    if method == "jig" and not arm.clamped:
        raise InputError("method 'jig': the arm is not clamped; put it into its jig, or take 'tip' or 'tensions'")
    sections = setting.mechanics.robot.sections
    total = sections + count
    taken_up = _pretensioned(arm, setting, lambda done, of: progress(done, total))
    found: list[Reading] = []

    def after(reading: Reading) -> None:
        found.append(reading)
        progress(sections + len(found), total)

    if method == "jig":
        _in_jig(arm, setting, taken_up, after)
        result = fit(setting.model, found, setting.accuracy, setting.prior, taken_up.zeros)
        _let_go(arm, setting, result)
    else:
        if arm.clamped:
            arm.release()
            taken_up = _pretensioned(arm, setting, lambda done, of: None, taken_up.zeros)
        result = _in_poses(arm, setting, taken_up, count, method == "tip", after, found)
    return Calibration.made(setting.mechanics.robot, method, result, setting.accuracy, setting.prior, len(found))


def _poses(method: str, poses: int | None) -> int:
    if method not in METHODS:
        raise InputError(f"method: {method!r} is unknown; there are {', '.join(METHODS)}")
    if poses is None or method == "jig":
        return POSES[method]
    return whole("poses", poses, 1, 1000)


def _pretensioned(
    arm: Arm, setting: Setting, progress: Callable[[int, int], None], zeros: Array | None = None
) -> Pretensioned:
    s = setting
    return pretension(arm, s.mechanics, s.gravity, s.at, s.pace, s.prior, s.accuracy, progress, zeros)


def _in_jig(arm: Arm, setting: Setting, taken_up: Pretensioned, after: Callable[[Reading], None]) -> None:
    """Read the arm at two levels of tension."""
    mechanics = setting.mechanics
    straight = np.zeros((mechanics.robot.sections, 2))
    springs = mechanics.spring_constants(mechanics.robot.cable_lengths(straight))
    most = np.exp(-2.0 * setting.prior.stiffness) * mechanics.tension_max  # EA may be larger than is thought
    for number, level in enumerate(_LEVELS, 1):
        wanted = np.clip(level * mechanics.pretension, mechanics.tension_min, most)
        arm.command(taken_up.motors - (wanted - taken_up.tensions) / springs, setting.at, setting.pace)
        after(_checked(read(arm, straight, number), mechanics))


def _let_go(arm: Arm, setting: Setting, known: Fit) -> None:
    """Take the arm out of its jig, pretensioned so that it stays straight."""
    theta = np.concatenate([known.zeros, np.log(known.stiffness)])
    straight = np.zeros((1, setting.mechanics.robot.sections, 2))
    held = setting.model.arm(theta).hold(straight, setting.gravity)
    arm.command(held.commanded_lengths[0] - known.zeros, setting.at, setting.pace)
    arm.release()


def _in_poses(
    arm: Arm,
    setting: Setting,
    taken_up: Pretensioned,
    count: int,
    tips: bool,
    after: Callable[[Reading], None],
    found: list[Reading],
) -> Fit:
    """Read the arm in the poses that tell the most, with what is known until then."""
    model, accuracy, prior = setting.model, setting.accuracy, setting.prior
    mechanics, zeros = setting.mechanics, taken_up.zeros
    poses = chosen(model, candidates(model, setting.is_free), count, accuracy, prior, tips)
    # The least bent first: they are held best as long as little is known. Between poses it is straight again, so that
    # only the way from there has to be clear.
    for pose in poses[np.argsort(np.abs(poses).sum(axis=(1, 2)), kind="stable")]:
        way = (
            careful(mechanics, setting.gravity).hold(_WAY[:, None, None] * pose, setting.gravity).commanded_lengths
            - zeros
        )
        for lengths in way:
            arm.command(lengths, setting.at, setting.pace)
        reading = _checked(read(arm, pose, len(found) + 1), mechanics)
        for lengths in way[-2::-1]:
            arm.command(lengths, setting.at, setting.pace)
        if tips and reading.tip is None:
            raise InputError("method 'tip': the arm does not see its tip; take 'tensions', or clamp it in a jig")
        after(reading if tips else Reading(reading.motors, reading.tensions, None, False, pose))
        if len(found) in _FIRST_FITS and len(found) < len(poses):
            known = fit(model, found, accuracy, prior, zeros)
            zeros = known.zeros
            mechanics = model.arm(np.concatenate([zeros, np.log(known.stiffness)]))
    return fit(model, found, accuracy, prior, zeros)


def _checked(reading: Reading, mechanics: Mechanics) -> Reading:
    cable = int(np.argmax(reading.tensions))
    if reading.tensions[cable] > mechanics.tension_max:
        raise InfeasibleError(
            f"calibration: cable {cable + 1} (section {mechanics.robot.cable_sections[cable] + 1}) pulls "
            f"{reading.tensions[cable]:.4g} N, more than tension_max_N {mechanics.tension_max:g} N; the motors were "
            "stopped. Take less pretension, or calibrate in a jig first"
        )
    return reading
