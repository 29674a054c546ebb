"""Taking up slack: what it ends in, and what it stops at."""

import re
from dataclasses import replace

import numpy as np
import pytest
from calibration_makers import setting_of, small_setting, static_arm, truth
from mechanics_makers import DOWN, paper_arm

from hognose.calibration import Hidden, pretension
from hognose.calibration.pretension import null_space, refuse_what_does_not_hold
from hognose.errors import InfeasibleError


def pretensioned(arm, setting, **more):
    given = (setting.mechanics, setting.gravity, setting.at, setting.pace, setting.prior, setting.accuracy)
    return pretension(arm, *given, **more)


def nothing_hidden(mechanics, **zeros):
    """A truth that is as the file says, but for zeros (m) of cables by their number."""
    n, off = mechanics.robot.sections, np.zeros(mechanics.robot.cables)
    for name, value in zeros.items():
        off[int(name.removeprefix("cable_")) - 1] = value
    return Hidden(off, np.ones(n), np.zeros(2 * n))


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_every_section_gets_its_pretension_and_the_arm_stays(seed):
    setting = small_setting(seed)
    mechanics = setting.mechanics
    arm, seen = static_arm(setting, truth(mechanics, seed), seed), []
    held = pretensioned(arm, setting, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, 6) for i in range(6)]
    np.testing.assert_allclose(held.tensions, mechanics.pretension, atol=1.5)  # in the trough, each cable its own
    arm.release()
    then = pretensioned(arm, setting, zeros=held.zeros)
    wanted = mechanics.hold(np.zeros((1, 6, 2)), DOWN).tensions[0]
    unfelt = null_space(mechanics.cable_jacobian(np.zeros((1, 6, 2)))[0].T)
    np.testing.assert_allclose(unfelt.T @ then.tensions, unfelt.T @ wanted, atol=3.0)
    assert np.abs(arm.angles).max() < 0.1
    np.testing.assert_allclose(then.motors + then.zeros, mechanics.hold(np.zeros((1, 6, 2)), DOWN).commanded_lengths[0])


def test_tensions_that_are_held_at_every_cable_would_hold_no_pose():
    """Without position control only the geometric stiffness is left, and it is negative."""
    mechanics = paper_arm()
    held = mechanics.hold(np.zeros((1, 12, 2)), DOWN)
    elastic, geometric = mechanics.stiffness(np.zeros((1, 12, 2)), held.tensions, DOWN)
    assert np.linalg.eigvalsh(elastic + geometric)[0, 0] > 0
    assert np.linalg.eigvalsh(geometric)[0, -1] < 0  # in every direction


def test_a_torn_cable_is_named():
    setting = small_setting()
    arm = static_arm(setting, nothing_hidden(setting.mechanics, cable_8=0.05))
    with pytest.raises(InfeasibleError, match=r"pretension: cable 8 \(section 2\) stays slack, with .* is it torn"):
        pretensioned(arm, setting)


def test_a_cable_that_pulls_too_much_stops_the_motors():
    setting = small_setting()
    arm = static_arm(setting, nothing_hidden(setting.mechanics, cable_8=-8e-3))
    with pytest.raises(
        InfeasibleError, match=r"cable 8 \(section 2\) pulls \d+(\.\d)? N, more than tension_max_N 195 N"
    ):
        pretensioned(arm, setting)


@pytest.mark.parametrize("seed", range(3))
def test_an_arm_that_hangs_slack_is_taken_up(seed):
    setting = setting_of(paper_arm())
    mechanics = setting.mechanics
    arm = static_arm(setting, Hidden.drawn(mechanics, seed), seed)
    arm.release()
    before = mechanics.hold(np.zeros((1, 12, 2)), DOWN).commanded_lengths[0]
    arm.command(before + 1.5e-3, setting.at, setting.pace)
    assert arm.tensions().min() < 1.0
    done = pretensioned(arm, setting)
    assert done.tensions.min() > 1.0
    assert np.abs(arm.angles).max() < np.radians(5.0)


@pytest.mark.parametrize(
    ("cables", "said"),
    [
        (
            {"axial_stiffness_N": 25e3, "pretension_N": 60.0},
            r"section \d+ buckles: pretension 60 N is above [\d.]+ N; lower it, or take EA ≥ [\d.]+ kN",
        ),
        (
            {"axial_stiffness_N": 3e3, "pretension_N": 20.0, "tension_max_N": 140.0},
            r"section \d+ buckles even with all cables at tension_min_N, 10 N: take EA ≥ [\d.]+ kN",
        ),
        (
            {"pretension_N": 10.0, "tension_min_N": 5.0, "tension_max_N": 12.0},
            r"no tensions hold section \d+: raise tension_max_N to [\d.]+ N, or make links and tool lighter",
        ),
        (
            {"axial_stiffness_N": tuple(np.linspace(20e3, 30e3, 12)), "pretension_N": tuple(np.linspace(70, 40, 12))},
            r"pretensions are too high; lower all to [\d.]+ % of themselves, but none below tension_min_N of [\d.]+ N, "
            r"or take [\d.]+ times the EA in all sections",
        ),
    ],
)
def test_pretension_that_holds_no_arm_says_what_would(cables, said):
    with pytest.raises(InfeasibleError, match=said):
        refuse_what_does_not_hold(paper_arm(**cables), DOWN)


@pytest.mark.parametrize("alike", [True, False])
def test_what_would_hold_holds(alike):
    stiff = 25e3 if alike else tuple(np.linspace(20e3, 30e3, 12))
    soft = paper_arm(axial_stiffness_N=stiff, pretension_N=60.0 if alike else tuple(np.linspace(70, 40, 12)))
    with pytest.raises(InfeasibleError) as caught:
        refuse_what_does_not_hold(soft, DOWN)
    lower = r"is above ([\d.]+) N" if alike else r"lower all to ([\d.]+) %"
    more = r"EA ≥ ([\d.]+) kN" if alike else r"take ([\d.]+) times the EA"
    allowed, stiffer = (float(re.findall(words, str(caught.value))[0]) for words in (lower, more))
    pretension = np.full(36, 0.999 * allowed) if alike else soft.pretension * allowed / 100
    refuse_what_does_not_hold(replace(soft, pretension=np.maximum(pretension, soft.tension_min)), DOWN)
    EA = np.full(36, 1e3 * stiffer) if alike else soft.axial_stiffness * stiffer
    refuse_what_does_not_hold(replace(soft, axial_stiffness=EA), DOWN)


def with_stiffness(setting, factor):
    hidden = Hidden.drawn(setting.mechanics, 1)
    return replace(hidden, stiffness=np.full(setting.mechanics.robot.sections, factor))


@pytest.mark.parametrize("factor", [0.7, 1.5, 2.0])
def test_pretension_is_reached_though_ea_is_far_from_the_file_s(factor):
    setting = small_setting()
    held = pretensioned(static_arm(setting, with_stiffness(setting, factor), 1), setting)
    np.testing.assert_allclose(held.tensions, setting.mechanics.pretension, atol=1.5)


@pytest.mark.parametrize(("factor", "seen"), [(3.0, 2.86), (4.0, 4.0)])
def test_pretension_ends_with_an_error_if_ea_is_several_times_the_file_s(factor, seen):
    setting = small_setting()
    with pytest.raises(InfeasibleError, match=r"off by [\d.]+ N; the last pull gave .* Is EA right\?") as caught:
        pretensioned(static_arm(setting, with_stiffness(setting, factor), 1), setting)
    gave = float(str(caught.value).split("pull gave ")[1].split(" %")[0])
    assert gave == pytest.approx(100 * seen, rel=0.05)
