"""The twin as an arm to calibrate: it rests where statics say, and a calibration of it finds what is hidden."""

import numpy as np
import pytest
from model_makers import sprung_robot, task_on

from hognose.calibration import Accuracy, Arm, Hidden, Sensors, Setting, StaticArm, calibrate, start_of
from hognose.errors import InfeasibleError
from hognose.mechanics import Mechanics
from hognose.planning import Task, TaskSpec
from hognose.scene import Sphere
from hognose.sim.arm import TwinArm

pytestmark = pytest.mark.slow

EXACT = Accuracy(1e-9, 1e-9, 2e-5)


def setting_of(task: Task, back: float = 0.0, **more) -> Setting:
    at = start_of(task, back)
    return Setting(Mechanics.of(task.robot), task.gravity(at[None])[0], at, **more)


@pytest.mark.parametrize("kind", ["slider", "arm"])
def test_it_rests_where_statics_say(kind):
    task = task_on(kind, sprung_robot(), 3)
    setting = setting_of(task)
    mechanics, sensors = setting.mechanics, Sensors(EXACT, 0, sees_tip=True)
    hidden = Hidden.drawn(mechanics, 2, zero=1e-4)
    arms = [TwinArm(task, hidden, sensors), StaticArm(mechanics, setting.gravity, hidden, sensors)]
    bent = 0.2 * np.ones((1, task.robot.sections, 2)) * task.robot.bend_limits
    straight, there = (mechanics.hold(a, setting.gravity).commanded_lengths[0] for a in (0 * bent, bent))
    for held in (True, False):
        for arm in arms:
            assert isinstance(arm, Arm)
            assert arm.clamped == held
            for lengths in [straight] if held else [straight, 0.5 * (straight + there), there]:
                arm.command(lengths, setting.at, setting.pace)
            arm.settle()
            np.testing.assert_array_equal(arm.motors(), straight if held else there)
        np.testing.assert_allclose(arms[0].tensions(), arms[1].tensions(), rtol=0, atol=0.1)
        tips = [arm.tip() for arm in arms]
        assert tips[0] is not None
        np.testing.assert_allclose(tips[0], tips[1], rtol=0, atol=2e-5)
        for arm in arms:
            arm.release()


def test_a_twin_is_calibrated():
    task = task_on("slider", sprung_robot(), 1)
    setting = setting_of(task)
    hidden = Hidden.drawn(setting.mechanics, 0)
    found = calibrate(TwinArm(task, hidden, Sensors(setting.accuracy, 0, sees_tip=True)), setting, "tip", 4)
    error = np.concatenate([found.fit.zeros - hidden.zeros, np.log(found.fit.stiffness / hidden.stiffness)])
    assert found.fit.fits
    assert error @ np.linalg.solve(found.fit.covariance, error) < len(error) + 4.0 * np.sqrt(2.0 * len(error))


def test_what_it_touches_is_named():
    robot = sprung_robot()
    free = task_on("slider", robot, 1)
    below = free.base.start + 0.2 * free.base.direction + np.array([0.0, -0.045, 0.0])
    ball = Sphere(name="ball", center=tuple(below), diameter=0.04)
    spec = free.spec.model_dump(by_alias=True) | {"obstacle": [ball.model_dump()]}
    task = Task(TaskSpec.model_validate(spec), robot)
    setting = setting_of(task)
    hidden = Hidden.drawn(setting.mechanics, 0)
    with pytest.raises(InfeasibleError, match=r"calibration: link \d touches ball with .* N; move the base back"):
        calibrate(TwinArm(task, hidden, Sensors(setting.accuracy, 0, sees_tip=True)), setting, "tip", 8)
