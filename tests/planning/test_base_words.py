"""What reports, pages and JSON say of the base, of the profile, and of what is assumed."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from planning_makers import variant

import hognose
from hognose.planning.assumed import assumed_values
from hognose.planning.base_spec import BaseSpec
from hognose.planning.base_words import base_figures, base_words, profile_figures, profile_words

WORKSPACE = {"low": [-0.3, -0.3, -1.3], "high": [0.3, 0.3, 0.4]}
SAID = {
    "slider along +z": {},
    "slider along -y": {"direction": [0, -1, 0]},
    "slider along (0.600, 0.000, -0.800)": {"direction": [0.6, 0, -0.8]},
    "slider along +x; turned by (0, 90, 0)°": {"rotation_deg": [0, 90, 0]},
    "slider on a cart along +z; first joint at (1, 0, -1500) mm at feed 0": {
        "kind": "cart",
        "position": [0.001, 0, -1.5],
    },
    "drum along +z; radius 280 mm; no nozzle; a coil of 1": {"kind": "drum", "radius": 0.28},
    "drum along +z; radius 280 mm; nozzle 200 mm; a coil of 896.0 mm to feed": {
        "kind": "drum",
        "radius": 0.28,
        "nozzle": 0.2,
    },
    "carrier of six axes along +z; first joint from (-300, -300, -1300) mm to (300, 300, 400) mm; speed 250 mm/s; "
    "acceleration 400 mm/s²; turns at 45 °/s; turn acceleration 90 °/s²": {
        "kind": "arm",
        "workspace": WORKSPACE,
        "speed": 0.25,
        "acceleration": 0.4,
        "turn_speed_deg_s": 45,
        "turn_acceleration_deg_s2": 90,
    },
}


def of(changes: dict[str, Any], robot: dict[str, Any] | None = None, retracts: bool = False) -> Any:
    """A motion of the drum's task with other values; what is said of it needs no figures."""
    task = variant(hognose.load_task("drum"), changes, robot)
    return SimpleNamespace(task=task, robot=task.robot, retracts=retracts)


@pytest.mark.parametrize(("words", "base"), SAID.items())
def test_every_base_is_said(words, base):
    task = variant(hognose.load_task("drum"), {"base": base})
    assert base_words(task).startswith(words)
    figures = base_figures(task)
    assert figures.pop("words") == base_words(task)
    assert np.linalg.norm(figures["direction"]) == pytest.approx(1.0, abs=1e-15)
    along = figures["direction"]
    if "rotation_deg" in base:
        del figures["direction"]
    assert BaseSpec.model_validate(figures).along == pytest.approx(along, abs=1e-15)


def test_the_profile_is_that_of_the_way():
    told = {"motion.profile": "fastest", "motion.retraction_profile": "constant", "motion.period_s": 0.02}
    assert profile_words(of(told)) == (
        "fastest: from rest to rest, a set-point every 20 ms; acceleration builds up over 0.2 s"
    )
    assert profile_words(of(told, retracts=True)) == "constant: 3.5 mm every 20 ms"
    assert profile_figures(of(told)) | {"words": ""} == {
        "kind": "fastest", "period_s": 0.02, "smoothing_s": 0.2, "words": "",
    }  # fmt: skip


def test_what_is_assumed_is_of_robot_task_and_defaults():
    known = {"assumed": [], "feed.acceleration": 0.1}
    assert assumed_values(of({}, known)) == []
    assert assumed_values(of({}, known | {"assumed": ["limits"]})) == ["robot: limits"]
    fast, carrier = {"motion.profile": "fastest"}, {"kind": "arm"}
    unsaid = {"assumed": [], "feed.acceleration": None}
    assert assumed_values(of({}, unsaid)) == []
    assert assumed_values(of(fast, unsaid)) == ["robot: feed acceleration 0.1 m/s²"]
    assert assumed_values(of(fast | {"base": carrier}, unsaid)) == [
        "base: carrier speed 50 mm/s, feed.speed of the robot",
        "base: carrier acceleration 0.1 m/s²",
    ]
    given = carrier | {"speed": 0.1, "acceleration": 0.2}
    assert assumed_values(of(fast | {"base": given}, unsaid)) == []


def test_assumed_tolerances_are_said_once_where_they_count():
    of_robot = {"assumed": ["tolerance"], "feed.acceleration": 0.1, "tolerance": {"sag": 0.002, "calibration_deg": 0.1}}
    assert assumed_values(of({}, of_robot)) == ["tolerance: sag 2 mm", "tolerance: calibration 0.1°"]
    known = {"tolerance": {"sag": 0.001, "cad": 0.001, "assumed": ["cad"]}}
    assert assumed_values(of(known, of_robot)) == ["tolerance: CAD 1 mm", "tolerance: calibration 0.1°"]


@pytest.mark.parametrize("own", [None, 0.5])
def test_an_assumed_timing_counts_where_an_obstacle_has_none_of_its_own(own):
    task = hognose.load_task("moving-obstacles")
    obstacles = [item.model_copy(update={"timing_s": own}) if item.motion else item for item in task.spec.obstacle]
    task = variant(task, {"obstacle": obstacles, "tolerance": {"timing_s": 0.2, "assumed": ["timing_s"]}})
    motion: Any = SimpleNamespace(task=task, robot=task.robot, retracts=False)
    said = assumed_values(motion)
    assert ("tolerance: timing 0.2 s of moving obstacles" in said) == (own is None)
