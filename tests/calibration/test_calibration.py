"""Zeros and stiffness of cables: what is hidden is found, and as exactly as is said."""

import re
from typing import Any

import numpy as np
import pytest
from calibration_makers import EXACT, PRIOR, setting_of, small_setting, static_arm, truth, unknowns
from mechanics_makers import DOWN, paper_arm, poses, random_arm

from hognose.calibration import (
    METHODS,
    Accuracy,
    Hidden,
    Model,
    Prior,
    Sensors,
    Setting,
    StaticArm,
    calibrate,
    fit,
    joint_errors,
    tolerance_lines,
    true_errors,
)
from hognose.calibration.poses import candidates, chosen
from hognose.errors import InfeasibleError, InputError
from hognose.robot.kinematics import axes_of_joints
from hognose.robot.tolerance import RobotTolerance


@pytest.mark.parametrize("clamped", [False, True])
def test_derivatives_are_those_of_what_is_shown(clamped):
    model, rng = Model(random_arm(1), DOWN), np.random.default_rng(0)
    angles = poses(model.nominal, rng, 3, 0.0 if clamped else 0.2)
    motors = model.nominal.hold(angles, DOWN).commanded_lengths
    size = model.unknowns + (2 * model.nominal.robot.sections if clamped else 0)
    theta = rng.normal(size=size) * np.where(np.arange(size) < model.cables, 2e-5, 0.05)
    theta[model.unknowns :] *= 1e-4

    def shown(at):
        if clamped:
            return model.clamped(at, motors)
        first = model.free(at, motors, angles)
        return model.free(at, motors, first.angles)  # spring constants of the pose itself

    seen = shown(theta)
    assert seen.stable.all()
    assert seen.tensions.min() > 1.0
    for i in range(size):
        step = np.zeros(size)
        step[i] = 1e-7 if i < model.cables or i >= model.unknowns else 1e-4
        high, low = shown(theta + step), shown(theta - step)
        for name, by in (("angles", "by_angles"), ("tensions", "by_tensions"), ("tips", "by_tips")):
            slope = (getattr(high, name) - getattr(low, name)).reshape(3, -1) / (2 * step[i])
            written = getattr(seen, by)
            # A spring constant follows the length of its cable, which the derivatives leave out: a strain's share.
            np.testing.assert_allclose(written[..., i], slope, rtol=0, atol=3e-3 * np.abs(written).max())


@pytest.mark.parametrize("method", METHODS)
def test_exact_sensors_find_the_truth(method):
    setting = small_setting(accuracy=EXACT, prior=Prior(5e-4, 0.12))
    hidden = truth(setting.mechanics, 3)
    found = calibrate(static_arm(setting, hidden, 0, method), setting, method)
    np.testing.assert_allclose(found.fit.zeros, hidden.zeros, rtol=0, atol=2e-8)
    np.testing.assert_allclose(found.fit.stiffness, hidden.stiffness, rtol=2e-5)
    assert true_errors(found, setting.mechanics, hidden, np.zeros((1, 6, 2)), DOWN)[0] < 1e-7


@pytest.mark.parametrize("method", METHODS)
def test_the_truth_is_where_the_covariance_says(method):
    """Squares of errors, weighted by the covariance, are χ² distributed; so are those of all residuals."""
    off, residuals, values, unknown = 0.0, 0.0, 0, 0
    for seed in range(6):
        setting = small_setting(1 + seed % 2)
        hidden = truth(setting.mechanics, seed)
        found = calibrate(static_arm(setting, hidden, seed, method), setting, method, 6).fit
        error = np.concatenate([found.zeros, np.log(found.stiffness)]) - unknowns(hidden)
        off += float(error @ np.linalg.solve(found.covariance, error))
        residuals, values, unknown = residuals + found.chi2, values + found.degrees, unknown + len(error)
        assert found.fits
    assert abs(off - unknown) < 4.0 * np.sqrt(2.0 * unknown)
    assert abs(residuals - values) < 4.0 * np.sqrt(2.0 * values)


def test_the_paper_arm_goes_where_it_shall():
    setting = setting_of(paper_arm())
    straight = np.zeros((1, 12, 2))
    for method, limit in (("jig", 0.3e-3), ("tip", 0.3e-3), ("tensions", 5e-3)):
        hidden = Hidden.drawn(setting.mechanics, 0)
        found = calibrate(static_arm(setting, hidden, 0, method), setting, method, 6)
        error = true_errors(found, setting.mechanics, hidden, straight, DOWN)[0]
        assert error < limit
        assert error < 3.5 * found.tip_spread(setting.mechanics, straight, DOWN)[0]


def test_out_of_its_jig_an_arm_is_straight_and_pretensioned():
    setting = small_setting()
    arm = static_arm(setting, truth(setting.mechanics, 4), 4, "jig")
    calibrate(arm, setting, "jig")
    assert not arm.clamped
    assert np.abs(arm.angles).max() < np.radians(0.2)
    held = setting.mechanics.hold(np.zeros((1, 6, 2)), DOWN)
    np.testing.assert_allclose(arm.tensions(), held.tensions[0], atol=3.0)


def test_an_arm_that_hangs_on_its_cables_is_calibrated_too():
    """If its zeros are about right from the start."""
    setting = small_setting(prior=Prior(1e-4, 0.12))
    hidden = truth(setting.mechanics, 0, setting.prior)
    arm = static_arm(setting, hidden)
    arm.release()
    found = calibrate(arm, setting, "tip", 8)
    assert np.abs(found.fit.zeros - hidden.zeros).max() < 5.0 * found.zero_errors.max()


def test_what_the_model_does_not_know_is_told():
    setting = small_setting(1)
    hidden = truth(setting.mechanics, 0)

    class Rubbing(StaticArm):
        """Cables that lose a part of what they pull on the way to the sensor."""

        def tensions(self):
            return np.where(np.arange(setting.mechanics.robot.cables) % 2, 0.95, 1.0) * super().tensions()

    arm = Rubbing(setting.mechanics, DOWN, hidden, Sensors(setting.accuracy, 0, sees_tip=True))
    assert not calibrate(arm, setting, "tip").fit.fits


def test_poses_tell_more_than_any_others():
    model = Model(random_arm(0), DOWN)
    found = candidates(model)
    np.testing.assert_array_equal(found[0], 0)
    assert (np.abs(found) <= model.nominal.robot.bend_limits).all()
    taken = chosen(model, found, 6, Accuracy(), PRIOR, True)

    def volume(these):
        held = model.nominal.hold(these, DOWN)
        seen = model.derived(model.nominal, these, held.tensions, np.ones(len(these), bool))
        scales = np.repeat([PRIOR.zero, PRIOR.stiffness], [model.cables, model.unknowns - model.cables])
        J = np.concatenate([seen.by_tensions / 0.2, seen.by_tips / 2e-4], axis=1).reshape(-1, model.unknowns) * scales
        return np.linalg.slogdet(np.eye(model.unknowns) + J.T @ J)[1]

    best, rng = volume(taken), np.random.default_rng(0)
    for _ in range(20):
        others = found[np.concatenate([[0], 1 + rng.choice(len(found) - 1, 5, replace=False)])]
        assert volume(others) < best


def test_joint_errors_cover_the_covariance():
    setting = small_setting()
    found = calibrate(static_arm(setting, truth(setting.mechanics, 1), 1, "tip"), setting, "tip")
    arm, errors = found.applied(setting.mechanics), joint_errors(found, setting.model)
    some = candidates(setting.model)[:20]
    held = arm.hold(some, DOWN)
    turned = setting.model.derived(arm, some, held.tensions, np.ones(len(some), bool)).by_angles
    covariance = turned @ found.fit.covariance @ np.swapaxes(turned, 1, 2)
    joints, axes = arm.robot.joint_positions(some), axes_of_joints(some)
    for link in range(1, joints.shape[1]):
        away = joints[:, link, None] - joints[:, :link]
        J = np.cross(axes[:, :link], away[:, :, None]).reshape(len(some), -1, 3)
        true = np.swapaxes(J, 1, 2) @ covariance[:, : 2 * link, : 2 * link] @ J
        said = (errors[:link] ** 2 * (away**2).sum(axis=2)).sum(axis=1)
        assert (np.linalg.eigvalsh(true)[:, -1] <= said * (1 + 1e-6)).all()
    lines = tolerance_lines(found, setting.model)
    given = [float(word) for word in lines.split("[")[2].split("]")[0].split(",")]
    assert (np.array(given) >= np.degrees(errors)).all()
    RobotTolerance.model_validate({"calibration_deg": given, "cable_zero": 0.0})


@pytest.mark.parametrize(
    ("method", "poses", "said"),
    [
        ("guess", None, "method: 'guess' is unknown; there are tensions, tip, jig"),
        ("tip", 0, "poses: expected a whole number from 1 to 1000, got 0"),
        ("jig", None, "method 'jig': the arm is not clamped; put it into its jig"),
    ],
)
def test_wrong_use_is_named(method, poses, said):
    setting = small_setting()
    arm = static_arm(setting, truth(setting.mechanics, 0))
    arm.release()
    with pytest.raises(InputError, match=said):
        calibrate(arm, setting, method, poses)


def test_a_tip_that_is_not_seen_is_named():
    setting = small_setting()
    with pytest.raises(InputError, match="the arm does not see its tip; take 'tensions'"):
        calibrate(static_arm(setting, truth(setting.mechanics, 0), 0, "tensions"), setting, "tip")


@pytest.mark.parametrize("given", [{"accuracy": Accuracy(tension=0.0)}, {"prior": Prior(zero=np.nan)}, {"pace": -1.0}])
def test_settings_that_make_no_sense_are_refused(given):
    with pytest.raises(InputError, match=r"above 0, got (0\.0|nan|-1\.0)"):
        small_setting(**given)


def test_no_readings_and_no_poses_are_named():
    setting = small_setting()
    with pytest.raises(InputError, match="readings: there are none"):
        fit(setting.model, [], setting.accuracy, setting.prior)
    shut = Setting(setting.mechanics, DOWN, np.zeros(1), is_free=lambda angles: np.zeros(len(angles), bool))
    with pytest.raises(InfeasibleError, match=r"of 161 poses 1 are held .* clear of obstacles; move the base back"):
        calibrate(static_arm(setting, truth(setting.mechanics, 0)), shut)


@pytest.mark.parametrize(
    ("sensor", "after", "said"),
    [
        ("tensions", 1, r"^pretension: the tension of cable 3 reads nan N; look at the sensor"),
        ("tensions", -2, r"^reading 1: the tension of cable 3 reads nan N"),
        ("tensions", -1, r"^reading 2: the tension of cable 3 reads nan N"),
        ("motors", 2, r"^reading 2: motor 3 reads nan m"),
        ("tip", 1, r"^reading 1: the tip is at \[.*nan\] m, which is no place"),
    ],
)
def test_a_sensor_that_reads_no_number_is_named_with_its_reading(sensor, after, said):
    """The sensor breaks at that call of it, counted from the last one where it is negative."""
    setting, method = small_setting(), "jig"
    hidden = truth(setting.mechanics, 1)

    def calibrated(breaks):
        arm, calls = static_arm(setting, hidden, method=method), []
        whole = getattr(arm, sensor)

        def broken():
            calls.append(whole() if sensor != "tip" else np.zeros(3))
            if len(calls) == breaks:
                calls[-1][2] = np.nan
            return calls[-1]

        setattr(arm, sensor, broken)
        try:
            calibrate(arm, setting, method)
        except InputError as error:
            return len(calls), str(error)
        return len(calls), ""

    calls, why = calibrated(0)
    assert why == ""
    assert re.search(said, calibrated(after if after > 0 else calls + 1 + after)[1])


#: Without their types: for arguments that are wrong.
_calibrate: Any = calibrate
_setting: Any = Setting
_accuracy: Any = Accuracy
_drawn: Any = Hidden.drawn


@pytest.mark.parametrize(
    ("use", "said"),
    [
        (lambda s: _calibrate(None, s), "arm: expected what has all members of hognose.calibration.Arm.*, got None"),
        (lambda s: _calibrate(static_arm(s, truth(s.mechanics, 0)), None), "setting: expected a .*Setting, got None"),
        (lambda s: _calibrate(static_arm(s, truth(s.mechanics, 0)), s, "tip", 2.5), "poses: .* 1 to 1000, got 2.5"),
        (lambda s: _setting("x", DOWN, np.zeros(1)), "mechanics: expected hognose.mechanics.Mechanics.*, got 'x'"),
        (lambda s: _setting(s.mechanics, DOWN, np.zeros(1), prior="x"), "prior: expected a .*Prior, got 'x'"),
        (lambda s: _setting(s.mechanics, DOWN, np.zeros(1), accuracy=1), "accuracy: expected a .*Accuracy, got 1"),
        (lambda s: _setting(s.mechanics, DOWN[:2], np.zeros(1)), r"gravity: .* shape \(3,\), got shape \(2,\)"),
        (lambda s: _setting(s.mechanics, DOWN, [np.nan]), "at: .* not finite"),
        (lambda s: _setting(s.mechanics, DOWN, [0.0], pace="x"), "pace: expected m/s above 0, got 'x'"),
        (lambda s: _setting(s.mechanics, DOWN, [0.0], _accuracy(tip=None)), "accuracy.tip: .* above 0, got None"),
        (lambda s: Hidden.drawn(s.mechanics, -1), "seed: expected a whole number from 0 on, got -1"),
        (lambda s: Hidden.drawn(s.mechanics, 0, share=1.0), "share: expected a share from 0 to below 1, got 1.0"),
        (lambda s: _drawn("x", 0), "mechanics: expected hognose.mechanics.Mechanics.*, got 'x'"),
        (lambda s: Sensors(s.accuracy, -1, sees_tip=True), "seed: expected a whole number from 0 on, got -1"),
    ],
)
def test_arguments_that_are_none_are_named(use, said):
    with pytest.raises(InputError, match=said):
        use(small_setting())
