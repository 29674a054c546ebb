"""`hognose simulate`: a verdict, figures, and what the twin runs into."""

import pytest


def test_a_good_plan_is_followed(run, made):
    done = run("simulate", made / "good.parquet", "--json")
    assert (done.code, done.json["good"], done.json["stopped"], done.json["touched"]) == (0, True, None, [])
    assert done.json["tip_rms_m"] < 0.03e-3
    assert done.json["tip_rms_m"] <= done.json["tip_max_m"]
    assert done.json["smallest_tension_N"] > 5.0
    assert done.json["largest_contact_N"] == 0.0
    assert done.json["real_time_factor"] > 0
    told = run("simulate", made / "good.parquet")
    assert told.code == 0
    assert "GOOD: to the end" in told.out


def test_what_the_tip_sees_is_written(run, made, tmp_path):
    done = run("simulate", made / "good.parquet", "--camera", "tip.png", "--json")
    assert (done.code, done.json["files"]) == (0, ["tip.png"])
    assert (tmp_path / "tip.png").read_bytes().startswith(b"\x89PNG")


def test_what_stands_elsewhere_is_touched(run):
    done = run("simulate", "obstacle-array", "--shift", "board 2", "0", "30", "0")
    assert done.code == 1
    assert "NOT GOOD: contact" in done.out
    assert "touched board 2 with up to " in done.out


@pytest.mark.parametrize(
    ("tokens", "reason"),
    [
        (("--shift", "bord", "0", "1", "0"), "shifted: no obstacle is called 'bord'; there are"),
        (("--video", "arm.avi"), "arm.avi: a moving picture ends in .gif or .mp4"),
        (("--camera", "tip.jpg"), "tip.jpg: the camera's picture ends in .png"),
        (("--stiffness", "1e4"), "time step: 2 ms is too long for cables of EA 1e+09 N"),
    ],
)
def test_wrong_changes_are_named(run, made, tokens, reason):
    done = run("simulate", made / "good.parquet", *tokens)
    assert (done.code, done.out) == (2, "")
    assert reason in done.err


def xx_moves(run):
    done = run("simulate", "moving-obstacles", "--json")
    assert done.json["remarks"] == ["obstacles that move (hatch, wheel) are not there for the twin"]
