"""What is measured, against what is computed here by hand; and a verdict that says no."""

import dataclasses
import itertools
import math
import re

import numpy as np
import pytest
from evaluation_makers import bends, ring_case, small_case

from hognose.errors import InfeasibleError
from hognose.evaluation import measure, section_measure
from hognose.evaluation.measure import accuracy, measured, objections
from hognose.evaluation.section_families import equal_sections
from hognose.evaluation.section_measure import placed
from hognose.evaluation.subjects import follower_for, subjects_of, takes_part
from hognose.following import METHODS, OF_SECTIONS

QUICK = (1e-4, 1e-3)


def tip_by_hand(case, joints):
    """Every link turned to where the joints point, one after the other from the slider, each as long as it is."""
    tips = []
    for feed, row in zip(case.feeds[-len(joints) :], joints, strict=True):
        place, frame = case.path.point(float(feed)).copy(), np.eye(3)
        for link, length in enumerate(case.link_lengths):
            x, y, z = frame.T @ (row[link + 1] - row[link])
            alpha, beta = math.atan2(x, z), math.atan2(-y, math.hypot(x, z))
            ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
            about_y = np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]])
            about_x = np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])
            frame = frame @ about_y @ about_x
            place = place + length * frame[:, 2]
        tips.append(place)
    return np.array(tips)


@pytest.mark.parametrize("method", ["exact", "prediction", "interpolation", "balanced"])
def test_accuracy_is_what_a_hand_computes(method):
    case = small_case(steps=9)
    joints = follower_for(method, case).run(case.feeds)
    found = accuracy(case, joints, case.feeds)
    errors = [math.dist(a, b) for a, b in zip(tip_by_hand(case, joints), case.reference[0][:, -1], strict=True)]
    mean = sum(errors) / len(errors)
    assert found["tip_series_mm"] == pytest.approx([1e3 * error for error in errors], abs=1e-10)
    assert found["tip_rmse_mm"] == pytest.approx(1e3 * math.sqrt(sum(e * e for e in errors) / len(errors)), abs=1e-10)
    variance = sum((error - mean) ** 2 for error in errors) / len(errors)
    assert found["tip_variance_mm2"] == pytest.approx(1e6 * variance, abs=1e-12)
    assert found["tip_max_mm"] == max(found["tip_series_mm"])
    lengths = [abs(math.dist(a, b) - 0.091) for row in joints for a, b in itertools.pairwise(row)]
    assert found["link_error_mm"] == pytest.approx(1e3 * max(lengths), abs=1e-12)
    assert found["bend_max_rad"] <= bends(joints).max() + 1e-12
    assert found["bend_max_rad"] > 0.1


def test_body_deviation_is_that_of_the_nearest_points():
    case = small_case(steps=4)
    joints = follower_for("exact", case).run(case.feeds)
    found = accuracy(case, joints, case.feeds)
    curve = case.path.point(np.linspace(0.0, case.path.length, 40_001))
    worst = []
    for row in joints:
        parts = np.arange(8)[:, None] / 8
        body = np.concatenate([a + parts * (b - a) for a, b in itertools.pairwise(row)])
        worst.append(max(np.linalg.norm(curve - point, axis=1).min() for point in body))
    assert found["body_series_mm"] == pytest.approx([1e3 * value for value in worst], abs=1e-2)
    assert found["body_max_mm"] == max(found["body_series_mm"]) > 1.0
    assert 0.0 < found["body_rms_mm"] < found["body_max_mm"]


def test_published_iterative_search_measures_every_point_on_its_way():
    """Counted by walking here; that is about the length of a link over sd, for every link."""
    case = small_case(spacing=0.001)
    points = case.path.equal_distance_points(case.spacing)
    count = 0
    for feed in case.feeds:
        index = int(feed / case.spacing + 0.5)
        for length in case.link_lengths:
            start, found = index, index
            while True:
                found += 1
                count += 1
                if math.dist(points[found], points[start]) >= length:
                    break
            short, beyond = (length - math.dist(points[found - k], points[start]) for k in (1, 0))
            index = found - 1 if short < -beyond else found
    row = measured("iterative (published)", case, *QUICK)
    assert row.evaluations == pytest.approx(count / len(case.feeds), abs=1e-12)
    assert row.evaluations == pytest.approx(3 * 0.091 / case.spacing, rel=0.03)
    tuned = measured("iterative", case, *QUICK)
    assert row.evaluations is not None
    assert tuned.evaluations is not None
    assert 3 <= tuned.evaluations < row.evaluations / 10


def bent_case(joints=None):
    """Three sections that bend along their length, or at joints, on the path of the small case."""
    case = small_case(steps=7)
    return dataclasses.replace(case, family="arcs", model=equal_sections(3, 0.091, 0.5, joints))


@pytest.mark.parametrize("label", list(OF_SECTIONS))
@pytest.mark.parametrize("joints", [None, 4])
def test_methods_of_other_sections_give_valid_rows_with_their_tips_on_the_path(label, joints):
    row = measured(label, bent_case(joints), *QUICK)
    assert (row.valid, row.why, row.arm_m) == (True, "", pytest.approx(0.273))
    assert row.tip_max_mm is not None
    assert row.body_in_mm is not None
    assert row.body_max_mm is not None
    assert row.tip_max_mm < 1e-6
    assert 0.0 < row.body_in_mm < row.body_max_mm < 10.0
    assert row.on_path is (label == "exact")


@pytest.mark.parametrize("joints", [None, 4])
def test_ends_by_plain_rotations_are_those_of_the_model(joints):
    model, angles = equal_sections(3, 0.091, 0.5, joints), np.random.default_rng(3).uniform(-1.0, 1.0, (20, 3, 2))
    ends, _ = model.positions(angles, np.zeros(20), np.full(3, 0.091))
    assert np.abs(placed(model, angles, np.zeros((20, 3))) - ends).max() < 1e-15


def test_a_section_that_is_not_where_it_belongs_is_said():
    case = bent_case()
    follower = follower_for("exact", case)
    joints = follower.run(case.feeds)
    assert section_measure.objections(case, follower, joints, case.feeds) == ("", section_measure.SLACK)
    aside = joints + np.array([0.0, 1e-4, 0.0])
    why, _ = section_measure.objections(case, follower, aside, case.feeds)
    assert "a link is off by 0.1 mm" in why
    assert "an end is 0.1 mm off the path" in why
    assert re.search(r"the tip is 0\.(09\d*|1) mm off the path", why)
    tight = dataclasses.replace(case, bend_limit=0.05)
    assert "a joint bends by" in section_measure.objections(tight, follower, joints, case.feeds)[0]


@pytest.mark.parametrize("label", [label for label in subjects_of() if takes_part(label, "cases")])
def test_every_method_gives_a_whole_row(label):
    case = small_case(steps=7)
    row = measured(label, case, *QUICK)
    assert (row.method, row.family, row.case, row.links, row.spacing_mm) == (label, "cases", "pipe-tank", 3, 2.0)
    assert row.solved, row.why
    assert 1 <= row.steps <= row.all_steps == 7
    assert len(row.tip_series_mm) == len(row.body_series_mm) == len(row.time_series_us) == row.steps
    figures = dataclasses.asdict(row)
    assert 0.0 < figures["median_us"] <= figures["p95_us"] <= figures["worst_us"] == max(row.time_series_us)
    assert 0.0 < figures["time_us"] < math.inf
    assert row.on_path == (label not in ("balanced", "fabrik", "ccd", "jacobian"))
    assert row.valid == (row.why == "")
    if row.on_path:
        assert row.valid, row.why
        # Every link may be off by half a point, and tilts the ones behind it.
        assert figures["tip_max_mm"] <= 3 * 3 * 0.5 * row.spacing_mm


def test_series_are_kept_for_the_two_cases_only():
    row = measured("exact", small_case("helix", "a"), *QUICK)
    assert row.valid
    assert row.tip_series_mm == row.body_series_mm == row.time_series_us == ()


def test_a_slow_method_follows_the_last_steps_only(monkeypatch):
    monkeypatch.setattr(measure, "affordable_steps", lambda *_: 2)
    case = small_case(steps=9)
    row = measured("exact", case, *QUICK)
    assert (row.steps, row.all_steps, row.valid) == (2, 9, True)
    joints = METHODS["exact"](case.path, case.link_lengths).run(case.feeds[-2:])
    assert row.body_series_mm == accuracy(case, joints, case.feeds[-2:])["body_series_mm"]


def test_what_cannot_be_followed_is_a_row_that_says_why():
    case = dataclasses.replace(small_case(), link_lengths=np.full(3, 0.25))
    row = measured("prediction", case, *QUICK)
    assert (row.solved, row.valid, row.time_us, row.tip_series_mm) == (False, False, None, ())
    assert "link 2 (250 mm) cannot reach the path" in row.why


class Answering:
    """A follower that answers with given joints."""

    tolerance = 1e-12

    def __init__(self, keeps_to_path):
        self.keeps_to_path = keeps_to_path


@pytest.mark.parametrize("keeps_to_path", [True, False])
def test_where_they_belong_joints_are_valid(keeps_to_path):
    case = small_case()
    why, allowance = objections(case, Answering(keeps_to_path), case.reference[0], case.feeds)  # pyright: ignore
    assert why == ""
    assert allowance == pytest.approx(3e-9 if keeps_to_path else 0.0455)


def test_a_stretched_link_is_not_valid():
    case = small_case()
    joints = case.reference[0].copy()
    joints[2, 3] += 1e-6 * (joints[2, 3] - joints[2, 2]) / 0.091
    why, _ = objections(case, Answering(False), joints, case.feeds)  # pyright: ignore
    assert why == "a link is off by 0.001 mm, more than 1e-06 mm"


def test_a_bend_beyond_the_limit_is_not_valid():
    case = small_case(limit=0.05)
    why, _ = objections(case, Answering(True), case.reference[0], case.feeds)  # pyright: ignore
    assert why.startswith("a joint bends by 0.")
    assert why.endswith("its limit is 0.05 rad")


def test_joints_on_another_crossing_are_not_valid():
    """A link that is as long as it should be, on the path, but leads to where the ring comes back."""
    case = dataclasses.replace(ring_case(0.06, links=1), bend_limit=math.pi)
    joints, arcs = case.reference
    later = np.arange(arcs[-1, 1] + 1e-3, case.path.length, 1e-6)
    second = later[np.linalg.norm(case.path.point(later) - joints[-1, 0], axis=1) <= 0.091][0]
    link = case.path.point(second) - joints[-1, 0]
    wrong = joints.copy()
    wrong[-1, 1] = joints[-1, 0] + 0.091 * link / np.linalg.norm(link)
    for keeps_to_path, allowed in ((True, "3e-06"), (False, "45.5")):
        why, _ = objections(case, Answering(keeps_to_path), wrong, case.feeds)  # pyright: ignore
        assert why.startswith("a joint is 11")
        assert why.endswith(f"mm from where it belongs, more than {allowed} mm")


def test_off_the_path_half_a_link_is_allowed_and_no_more():
    case = small_case()
    beside = case.reference[0] + np.array([0.0, 0.045, 0.0])
    assert objections(case, Answering(False), beside, case.feeds)[0] == ""  # pyright: ignore
    beside += np.array([0.0, 0.001, 0.0])
    assert "a joint is 46 mm" in objections(case, Answering(False), beside, case.feeds)[0]  # pyright: ignore


def test_a_method_that_cannot_go_on_is_no_reason_to_stop(monkeypatch):
    def failing(label, case, begin):
        raise InfeasibleError("no way")

    monkeypatch.setattr("hognose.evaluation.timing.follower_for", failing)
    row = measured("exact", small_case(), *QUICK)
    assert (row.solved, row.valid, row.why) == (False, False, "no way")


class _Broken(METHODS["exact"]):
    """A method under development."""

    name = "broken"
    fault = ""

    def _advance(self, feeds, joints):
        done = super()._advance(feeds, joints)
        if self.fault == "raises":
            raise IndexError("boom")
        if self.fault == "far away":
            joints += 1.0
        if self.fault == "in one place":
            joints[:] = 0.0
        return done


@pytest.mark.parametrize(
    ("fault", "words"),
    [("raises", "IndexError: boom"), ("far away", "InputError"), ("in one place", "InputError"), ("", "")],
)
def test_whatever_a_method_under_development_does_is_a_row(monkeypatch, fault, words):
    monkeypatch.setitem(METHODS, "broken", _Broken)
    monkeypatch.setattr(_Broken, "fault", fault)
    row = measured("broken", small_case(), *QUICK)
    assert words in row.why
    assert row.valid == (not fault)
