"""The file of a calibration: read as it was written, refused where it is not one."""

import json

import numpy as np
import pytest
from calibration_makers import small_setting, static_arm, truth
from mechanics_makers import DOWN, poses, random_arm

from hognose.calibration import Calibration, calibrate
from hognose.errors import InputError


@pytest.fixture(scope="module")
def made():
    setting = small_setting()
    return setting, calibrate(static_arm(setting, truth(setting.mechanics, 0), 0, "jig"), setting, "jig")


def test_a_file_is_read_as_it_was_written(made, tmp_path):
    setting, found = made
    found.save(tmp_path / "arm.json")
    again = Calibration.load(tmp_path / "arm.json")
    assert again.to_json() == found.to_json()
    mechanics = setting.mechanics
    angles = poses(mechanics, np.random.default_rng(0), 3, 0.3)
    np.testing.assert_array_equal(again.motors(mechanics, angles, DOWN), found.motors(mechanics, angles, DOWN))
    commanded = found.applied(mechanics).hold(angles, DOWN).commanded_lengths
    np.testing.assert_array_equal(found.motors(mechanics, angles, DOWN), commanded - found.fit.zeros)


def test_another_robot_is_refused(made):
    _, found = made
    other = random_arm(2)
    with pytest.raises(InputError, match=r"calibration: it is of robot .*, not of .*; calibrate this robot"):
        found.motors(other, np.zeros((1, 6, 2)), DOWN)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"kind": "plan"}, "is no calibration; `hognose calibrate` writes calibration files"),
        ({"schema": 9}, "schema 9, expected 1; calibrate anew"),
        ({"zeros": None}, "has no 'zeros'; calibrate anew"),
        ({"zeros": [0.0] * 3}, r"covariance: expected numbers of shape \(9, 9\)"),
        ({"stiffness": ["stiff"] * 6}, "stiffness: expected numbers"),
        ({"prior": {"zero": 1.0, "luck": 2.0}}, "luck"),
        ({"chi2": "much"}, "could not convert"),
    ],
)
def test_damaged_files_are_named(made, tmp_path, change, said):
    given = made[1].to_json() | change
    file = tmp_path / "arm.json"
    file.write_text(json.dumps({key: value for key, value in given.items() if value is not None}), encoding="utf-8")
    with pytest.raises(InputError, match=said) as caught:
        Calibration.load(file)
    assert str(caught.value).startswith(str(file))


@pytest.mark.parametrize("content", [b"", b"[calibration]", b"\xff\xfe", b"[1, 2]"])
def test_what_is_no_json_is_named(tmp_path, content):
    (tmp_path / "arm.json").write_bytes(content)
    with pytest.raises(InputError, match=r"arm\.json: is no (JSON|calibration)"):
        Calibration.load(tmp_path / "arm.json")


def test_a_file_that_is_missing_is_named(tmp_path):
    with pytest.raises(InputError, match="missing"):
        Calibration.load(tmp_path / "missing.json")
