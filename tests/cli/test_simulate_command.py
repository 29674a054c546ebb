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
    assert (done.code, done.json["pictures"]) == (0, ["tip.png"])
    assert (tmp_path / "tip.png").read_bytes().startswith(b"\x89PNG")


def test_what_stands_elsewhere_is_touched(run):
    done = run("simulate", "obstacle-array", "--shift", "board 2", "0", "30", "0")
    assert done.code == 1
    assert "NOT GOOD: contact" in done.out
    assert "touched board 2 from 16." in done.out


@pytest.mark.parametrize(
    ("tokens", "reason"),
    [
        (("--shift", "bord", "0", "1", "0"), "shifted: no obstacle is called 'bord'; there are"),
        (("--video", "arm.avi"), "arm.avi: a moving picture ends in .gif or .mp4"),
        (("--camera", "tip.jpg"), "tip.jpg: the camera's picture ends in .png"),
        (("--video", "nowhere/arm.gif"), "nowhere/arm.gif: cannot write: there is no folder nowhere; make it first"),
        (("--camera", "nowhere/tip.png"), "nowhere/tip.png: cannot write: there is no folder nowhere; make it first"),
        (("--stiffness", "1e4"), "time step: 0.0625 ms, the shortest, is too long for cables of EA 1e+09 N"),
        (("--stiffness", "0"), "stiffness: expected a factor above 0 and up to 1e+06, got 0.0"),
        (("--mass", "-1"), "mass: expected a factor above 0"),
        (("--friction", "2"), "friction: expected a coefficient from 0 to 1, got 2.0"),
        (("--lag", "-1"), "lag: expected seconds from 0 to 10, got -1.0"),
        (("--zeros", "1000"), "zeros: expected a standard deviation from 0 to 20 mm, got 1000 mm"),
        (("--shift", "board 2", "0", "1"), "--shift: expected a name and three numbers, got a name and two numbers"),
        (("--zero", "4"), "--zero: expected two numbers, got 1"),
        (("--zeros", "-1"), "zeros: expected a standard deviation from 0 to 20 mm"),
        (("--zeros", "1", "--seed", "-1"), "seed: expected a whole number from 0 on, got -1"),
        (("--zero", "99", "1"), "zero: no cable 99; "),
        (("--stop-at-contact", "0"), "stop_at_contact: expected a number above 0 N, got 0.0"),
        (("--log", "log.txt"), "unknown format '.txt' of a log; expected .csv, .parquet, .json"),
    ],
)
def test_wrong_changes_are_named(run, made, tokens, reason):
    done = run("simulate", made / "good.parquet", *tokens)
    assert (done.code, done.out) == (2, "")
    assert reason in done.err


@pytest.mark.parametrize("command", [("simulate", "--video", "no/a.gif"), ("mechanics", "--figure", "no/a.png")])
def test_a_missing_folder_is_refused_before_anything_is_read(run, command):
    name, *option = command
    done = run(name, "no-such-plan.parquet", *option)
    assert (done.code, done.out) == (2, "")
    assert "there is no folder no; make it first" in done.err


def test_a_log_is_written_to_every_end(run, made, tmp_path, monkeypatch):
    log = tmp_path / "log.csv"
    done = run("simulate", made / "good.parquet", "--log", log, "--json")
    assert (done.code, done.json["file"]) == (0, str(log))
    assert len(log.read_text().splitlines()) == done.json["periods"] + 1
    touched = ("--shift", "board 2", "0", "45", "0", "--stop-at-contact", "5")
    done = run("simulate", "obstacle-array", *touched, "--log", log)
    assert done.code == 1
    rows = len(log.read_text().splitlines()) - 1
    assert f"{log}: {rows} rows" in done.out
    assert "all motors held; after 1 s " in done.out
    monkeypatch.setattr("hognose.sim.run._Run.go", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    done = run("simulate", made / "good.parquet", "--log", log)
    assert done.code == 130
    assert f"interrupted; what was done is in {log}, 1 rows" in done.err
    assert len(log.read_text().splitlines()) == 2


def test_an_arm_that_is_not_as_planned(run, made):
    other_arm = ("--json", "--zeros", "0.05", "--zero", "4", "0.1", "--lag", "0.1", "--seed")
    done, other = (run("simulate", made / "good.parquet", *other_arm, seed) for seed in ("3", "4"))
    assert done.json["tip_max_m"] > 0.1e-3
    assert other.json["tip_max_m"] != done.json["tip_max_m"]


def test_nothing_replaces_the_plan_or_another_file(run, made, tmp_path):
    plan, before = tmp_path / "plan.parquet", (made / "good.parquet").read_bytes()
    plan.write_bytes(before)
    (tmp_path / "linked.gif").symlink_to(plan)
    for option, name in (("--log", "./plan.parquet"), ("--video", "linked.gif"), ("--camera", "linked.gif")):
        done = run("simulate", plan, option, name)
        assert (done.code, done.out) == (2, "")
        assert "would replace what it is made from; name another file" in done.err
    done = run("simulate", plan, "--video", "a.gif", "--camera", f"../{tmp_path.name}/a.gif")
    assert (done.code, done.out) == (2, "")
    assert "--video and --camera name the same file" in done.err
    assert plan.read_bytes() == before


def test_a_plan_that_is_none_is_said_to_be_none(run, made):
    told, done = run("simulate", made / "tight.toml"), run("simulate", made / "tight.toml", "--json")
    lines = told.out.splitlines()
    assert told.code == done.code == 1
    assert any(line.startswith("the plan itself is NOT GOOD: clearance") for line in lines)
    assert lines[-1] == "NOT GOOD: the plan itself"
    assert lines[-2] == "assumed: cables"
    assert (done.json["good"], done.json["stopped"], done.json["touched"]) == (False, None, [])
    assert all("clearance" in sentence for sentence in done.json["plan_failed"])
    assert done.json["assumed"] == ["cables"]
