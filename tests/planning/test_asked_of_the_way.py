"""What is asked of a way besides its way-points: a direction of the tip, places via, boxes to be kept out of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hognose
from hognose.planning import Plan, Task, TaskSpec

ROBOT = hognose.load_robot("sjtu-25dof")
WAY = [(0.0, 0.0, 0.0), (0.02, 0.01, 0.2), (0.03, 0.04, 0.4)]


def planned(obstacle: tuple[Any, ...] = (), **path: Any) -> Plan:
    """The plan along three way-points, good or not."""
    said = {"way_points": WAY, "detour": False, **path}
    motion = {"step": 0.02, "period_s": 1.0}
    data = {"name": "asked", "robot": "sjtu-25dof", "path": said, "motion": motion, "obstacle": obstacle}
    return good_or_not(Task(TaskSpec.model_validate(data), ROBOT))


def good_or_not(task: Task) -> Plan:
    try:
        return hognose.plan(task)
    except hognose.InfeasibleError as error:
        made = error.plan
    assert made is not None
    return made


@pytest.fixture(scope="module")
def plain() -> Plan:
    return planned()


@pytest.mark.parametrize("cone", [3.0, 20.0, 90.0])
@pytest.mark.parametrize("part", [0.99, 1.01])
def test_the_tip_points_within_its_cone_or_the_plan_is_not_good(plain, cone, part):
    tip = plain.body[-1, -1] - plain.body[-1, -2]
    tip = tip / np.linalg.norm(tip)
    across = np.cross(tip, (0.3, 0.8, 0.1))
    across = across / np.linalg.norm(across)
    off = np.radians(part * cone)
    wished = tuple((7.0 * (np.cos(off) * tip + np.sin(off) * across)).tolist())
    plan = planned(tip_direction=wished, tip_cone_deg=cone)
    assert plan.check("tip_direction").value == pytest.approx(np.radians(part * cone))
    assert plan.good == (part < 1)
    assert plain.good


def test_the_nose_of_a_section_that_bends_points_where_its_end_does():
    # By the closed form of arcs, T' = 2 (u·T) u - T with the direction u of each chord, not by the library's frames.
    leaning = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    way = [leaning @ place for place in ((0.0, 0.0, 0.0), (0.002, 0.0, 0.02), (0.014, 0.006, 0.045))]
    path: dict[str, Any] = {"way_points": [tuple(place.tolist()) for place in way], "detour": False}
    motion = {"method": "fitted", "step": 0.002, "period_s": 1.0}
    base = {"direction": tuple(leaning[:, 2].tolist())}
    robot = hognose.load_robot("metabot-3arc")

    def planned_so(**asked: Any) -> Plan:
        data = {"name": "nose", "robot": robot.name, "base": base, "path": path | asked, "motion": motion}
        return good_or_not(Task(TaskSpec.model_validate(data), robot))

    plan = planned_so()
    nose, chords = leaning[:, 2], np.diff(plan.joints[-1], axis=0)
    chords /= np.linalg.norm(chords, axis=1, keepdims=True)
    for chord in chords:
        nose = 2 * (chord @ nose) * chord - nose
    along = chords[-1]
    assert np.degrees(np.arccos(along @ nose)) > 5.0
    exactly = planned_so(tip_direction=tuple(nose.tolist()), tip_cone_deg=1.0)
    assert exactly.check("tip_direction").value < 1e-7
    assert exactly.check("tip_direction").ok
    along_the_chord = planned_so(tip_direction=tuple(along.tolist()), tip_cone_deg=1.0)
    assert not along_the_chord.check("tip_direction").ok


@pytest.mark.parametrize(("off", "good"), [(0.0, True), (0.9e-6, True), (2e-6, False), (0.003, False)])
def test_places_via_are_passed_or_the_plan_is_not_good(plain, off, good):
    path = plain.path
    behind = path.length - ROBOT.length
    places = path.point(ROBOT.length + np.array([0.2, 0.55]) * behind)
    aside = np.cross(path.tangent(ROBOT.length + 0.55 * behind), (0.6, 0.8, 0.0))
    places[1] += off * aside / np.linalg.norm(aside)
    plan = planned(via=[tuple(place) for place in places.tolist()])
    check = plan.check("path_through_via")
    assert check.value == pytest.approx(off, rel=0.02, abs=1e-12)
    assert (check.ok, plan.good) == (good, good)
    assert good or "via 2 at" in check.detail


def test_places_via_are_passed_in_their_order(plain):
    places = plain.path.point(ROBOT.length + np.array([0.1, 0.3]))
    right, wrong = [tuple(place) for place in places.tolist()], [tuple(place) for place in places[::-1].tolist()]
    assert planned(via=right).good
    check = planned(via=wrong).check("path_through_via")
    assert not check.ok
    assert "another order" in check.sentence


def test_boxes_to_be_kept_out_of_are_obstacles(plain):
    box = {"center": (0.1, 0.02, 0.2), "size": (0.05, 0.04, 0.1)}
    kept, stands = planned(keep_out=(box,)), planned(obstacle=({"kind": "box", "name": "keep-out 1", **box},))
    assert kept.scene.names == stands.scene.names == ("keep-out 1",)
    assert np.array_equal(kept.clearance, stands.clearance)
    assert kept.clearance.min() < plain.clearance.min()
