"""Arms to calibrate, whose truth is known here."""

import numpy as np
from mechanics_makers import DOWN, random_arm

from hognose.calibration import TROUGH, Accuracy, Hidden, Prior, Sensors, Setting, StaticArm

PRIOR = Prior()


def setting_of(mechanics, **more):
    """On a base that stays at 0."""
    return Setting(mechanics, DOWN, np.zeros(1), **more)


def small_setting(seed=1, **more):
    """An arm of six sections that differ in everything."""
    return setting_of(random_arm(seed), **more)


def truth(mechanics, seed, prior=PRIOR):
    """A truth as the prior says it: normal in zeros and logarithms of EA."""
    rng = np.random.default_rng([seed, 5])
    n = mechanics.robot.sections
    factors = np.exp(rng.normal(0.0, prior.stiffness, n))
    return Hidden(rng.normal(0.0, prior.zero, mechanics.robot.cables), factors, rng.normal(size=2 * n))


def static_arm(setting, hidden, seed=0, method="tip", accuracy=None):
    """An emulated arm in what a method wants: its jig, or a trough."""
    accuracy = setting.accuracy if accuracy is None else accuracy
    off = accuracy.jig if method == "jig" else TROUGH
    sensors = Sensors(accuracy, seed, method == "tip")
    return StaticArm(setting.mechanics, setting.gravity, hidden, sensors, off)


def unknowns(hidden):
    """Zeros and logarithms of the factors."""
    return np.concatenate([hidden.zeros, np.log(hidden.stiffness)])


EXACT = Accuracy(1e-6, 1e-9, 1e-9)
