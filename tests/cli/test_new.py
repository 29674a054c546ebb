"""`hognose new`: a task file that plans at once, or one sentence for each thing that is wrong."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import hognose
from hognose.files import bundled_tasks
from hognose.files.new_task_text import base_table

STEP_TANK = bundled_tasks()["step-tank"].with_name("step_tank.step")
#: Metres in each unit.
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
#: What suits a box that spans 0.1 m on all sides of the origin, in metres: the arm passes beside it.
ENTRANCE, TARGET = (0.3, 0.0, -0.05), (0.25, 0.05, 0.5)
ARM = ("--robot", "sjtu-25dof")


def asked(entrance: Any = ENTRANCE, target: Any = TARGET, units: str = "mm") -> list[str]:
    """Options for two places in m."""
    ends = {"--entrance": entrance, "--target": target}
    return [
        *(word for option, place in ends.items() for word in (option, *(repr(c / UNITS[units]) for c in place))),
        *("--units", units),
    ]


@pytest.fixture
def vessel(tmp_path) -> tuple[str, ...]:
    """The vessel of the example, and what suits it."""
    (tmp_path / "vessel.step").write_bytes(STEP_TANK.read_bytes())
    return ("--space", "vessel.step", *ARM, *asked((0, 0, 0), (0.06, 0.06, 0.96)))


@pytest.fixture
def box(tmp_path) -> tuple[str, ...]:
    """A cube in a file that does not say its unit, and what suits it."""
    trimesh.creation.box((0.2, 0.2, 0.2)).export(tmp_path / "box.stl")
    return ("--space", "box.stl", "--space-units", "m", *ARM)


def test_it_writes_a_task_that_plans_at_once(run, tmp_path, vessel):
    done = run("new", "my vessel.toml", *vessel, "--direction", "0", "0", "1")
    assert (done.code, done.err) == (0, "")
    assert "vessel.step: 8,524 triangles; numbers in m, as the file says" in done.out
    assert sum("yes" in line.split() for line in done.out.splitlines()) == 8
    assert "entrance: 79.927 mm from vessel: lid; the arm needs 27.5 mm" in done.out
    assert "target: 39.95 mm from vessel: bottom; the arm needs 27.5 mm" in done.out
    assert "way: 963.75 mm in a straight line; sjtu-25dof reaches 1092 mm" in done.out
    assert "written to my vessel.toml; next:\n  hognose plan 'my vessel.toml' " in done.out
    planned = run("plan", "my vessel.toml")
    assert planned.code == 0
    assert planned.out.startswith("my vessel: sjtu-25dof, ")
    plan = hognose.Plan.load(tmp_path / "my vessel.parquet")
    np.testing.assert_allclose(plan.joints[0, -1], 0, atol=1e-9)
    np.testing.assert_allclose(plan.joints[-1, -1], [0.06, 0.06, 0.96], atol=1e-6)


def test_it_says_all_as_json_in_metres(run, vessel):
    said = run("new", "a.toml", *vessel, "--json").json
    assert (said["good"], said["file"], said["next"]) == (
        True,
        "a.toml",
        ["hognose plan a.toml", "hognose view a.toml"],
    )
    assert said["straight_m"] == pytest.approx(np.linalg.norm([0.06, 0.06, 0.96]), rel=1e-12)
    assert said["reach_m"] == pytest.approx(1.092)
    scene = hognose.load_task("a.toml").scene
    for end, place in (("entrance", (0, 0, 0)), ("target", (0.06, 0.06, 0.96))):
        witness = scene.witness(place, place)
        assert said[f"{end}_distance_m"] == witness.distance
        assert said[f"{end}_needed_m"] == pytest.approx(0.0275)
        assert said[f"{end}_closest_to"] == witness.obstacle
    assert [item["name"] for item in said["space"]["items"]] == list(scene.names)


@pytest.mark.parametrize("units", UNITS)
def test_the_task_is_the_same_in_every_unit(run, box, units):
    assert run("new", "a.toml", *box, *asked(units=units)).code == 0
    assert tomllib.loads(Path("a.toml").read_text())["units"] == units
    task = hognose.load_task("a.toml")
    np.testing.assert_allclose(task.way_points, [ENTRANCE, TARGET], rtol=0, atol=1e-12)
    assert task.margin == pytest.approx(0.005, rel=1e-5)
    assert task.robot.name == "sjtu-25dof"
    assert 0.9 * 0.0035 < task.spec.motion.step <= 0.0035
    np.testing.assert_allclose(task.scene.bounds, [[[-0.1] * 3, [0.1] * 3]], atol=1e-6)


def options_of(text: str) -> list[int]:
    """The lines that are a key in a comment."""
    return [number for number, line in enumerate(text.splitlines()) if re.match(r"# \w+ = ", line)]


@pytest.mark.parametrize("more", [(), ("--no-solid", "--margin", "2", "--direction", "0", "0", "7")])
def test_every_line_that_is_commented_out_is_valid(run, vessel, more):
    assert run("new", "a.toml", *vessel, *more).code == 0
    text = Path("a.toml").read_text()
    said = hognose.load_task("a.toml").spec.model_dump()
    keys = []
    for number in options_of(text):
        lines = text.splitlines()
        lines[number] = lines[number].removeprefix("# ")
        keys.append(lines[number].split()[0])
        if keys[-1] == "way_points":
            lines = [line for line in lines if not re.match("(entrance|target) =", line)]
        Path("b.toml").write_text("\n".join(lines))
        other = hognose.load_task("b.toml").spec.model_dump()
        assert (other == said) == (keys[-1] in ("tip_cone_deg", "position", "rotation_deg")), keys[-1]
    solid = [] if more else ["solid"]
    assert keys == [
        *("kind", "via", "tip_direction", "tip_cone_deg", "way_points", "profile"),
        *("cad", "registration", "registration_deg", "calibration_deg", "timing_s"),
        *("position", "rotation_deg", *solid, "without", "motion"),
    ]


def test_what_is_asked_for_is_in_the_file(run, vessel, tmp_path):
    done = run("new", "a.toml", *vessel, "--margin", "2.5", "--no-solid")
    assert done.code == 0
    task = hognose.load_task("a.toml")
    assert task.margin == pytest.approx(0.0025, rel=1e-12)
    assert not task.scene.solid.any()
    assert list(tmp_path.glob(".*")) == []


def test_files_are_named_as_seen_from_the_task(run, tmp_path, vessel):
    (tmp_path / "tasks" / "new").mkdir(parents=True)
    assert run("robot", "sjtu-25dof", "--write", "my arm.toml").code == 0
    words = ["my arm.toml" if word == "sjtu-25dof" else word for word in vessel]
    assert run("new", "tasks/new/a.toml", *words).code == 0
    said = tomllib.loads((tmp_path / "tasks/new/a.toml").read_text())
    assert (said["robot"], said["obstacle"][0]["file"]) == ("../../my arm.toml", "../../vessel.step")
    task = hognose.load_task(tmp_path / "tasks/new/a.toml")
    assert task.robot.fingerprint == hognose.load_robot("sjtu-25dof").fingerprint
    assert len(task.scene.names) == 8


#: The cube in every kind of file, what has to be said of it, and how many bodies or clouds it is then.
MESHES = {
    "stl": ("--space-units", "m"), "obj": ("--space-units", "m"), "ply": ("--space-units", "m"),
    "off": ("--space-units", "m"), "glb": (), "3mf": (), "dae": (),
}  # fmt: skip
CLOUDS = ("xyz", "csv", "pts", "ply", "pcd", "obj", "off", "glb")


@pytest.mark.parametrize("suffix", MESHES)
def test_any_mesh_can_be_the_space(run, tmp_path, suffix):
    cube = trimesh.creation.box((0.2, 0.2, 0.2))
    scene = trimesh.Scene(cube.copy().apply_scale(1000))
    scene.units = "mm"
    if suffix == "dae":
        (tmp_path / "cube.dae").write_text(dae(cube))
    else:
        (scene if suffix == "3mf" else cube).export(tmp_path / f"cube.{suffix}")
    done = run("new", "a.toml", "--space", f"cube.{suffix}", *MESHES[suffix], *ARM, *asked())
    assert (done.code, done.err) == (0, "")
    assert "size 200 × 200 × 200 mm" in done.out
    task = hognose.load_task("a.toml")
    assert task.scene.inside([[0, 0, 0]])[0] == 0
    np.testing.assert_allclose(task.scene.bounds[0], [[-0.1] * 3, [0.1] * 3], atol=1e-6)


def dae(mesh: Any) -> str:
    """A mesh as COLLADA, in metres."""
    places = " ".join(f"{x:g}" for x in mesh.vertices.ravel())
    corners = " ".join(str(k) for k in mesh.faces.ravel())
    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/>'
        '<up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="s">'
        f'<float_array id="f" count="{mesh.vertices.size}">{places}</float_array><technique_common><accessor '
        f'source="#f" count="{len(mesh.vertices)}" stride="3"><param name="X" type="float"/><param name="Y" '
        'type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input '
        f'semantic="POSITION" source="#s"/></vertices><triangles count="{len(mesh.faces)}"><input semantic="VERTEX" '
        f'source="#v" offset="0"/><p>{corners}</p></triangles></mesh></geometry></library_geometries>'
        '<library_visual_scenes><visual_scene id="w"><node name="cube"><instance_geometry url="#g"/></node>'
        '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    )


@pytest.mark.parametrize("suffix", CLOUDS)
def test_any_scan_can_be_the_space(run, tmp_path, suffix):
    corners = trimesh.creation.box((0.2, 0.2, 0.2)).vertices
    rows = "\n".join(" ".join(f"{c:g}" for c in row) for row in corners) + "\n"
    heads = {
        "pts": "8\n",
        "ply": "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "end_header\n",
        "pcd": "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 8\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 8\nDATA ascii\n",
        "off": "OFF\n8 0 0\n",
    }
    if suffix == "obj":
        rows = "".join(f"v {row}\n" for row in rows.splitlines())
    (tmp_path / f"scan.{suffix}").write_text(heads.get(suffix, "") + rows)
    if suffix == "glb":
        trimesh.PointCloud(corners).export(tmp_path / "scan.glb")
    words = ("new", "a.toml", "--space", f"scan.{suffix}", "--space-units", "m", *ARM, *asked())
    refused = run(*words)
    assert refused.code == 2
    assert f"--space: scan.{suffix} holds points; give --diameter" in refused.err
    done = run(*words, "--diameter", "6")
    assert (done.code, done.err) == (0, "")
    assert "8 points" in done.out
    task = hognose.load_task("a.toml")
    np.testing.assert_allclose(task.scene.bounds[0], [[-0.103] * 3, [0.103] * 3], atol=1e-6)


def test_a_file_that_is_there_is_left_alone_unless_it_is_to_be_replaced(run, tmp_path, vessel):
    (tmp_path / "a.toml").write_text("mine")
    (tmp_path / "link.toml").symlink_to("nowhere.toml")
    for name in ("a.toml", "link.toml"):
        done = run("new", name, *vessel)
        assert done.code == 2
        assert (
            f"{name}: is there already and was left as it is; give another name, or --force to replace it" in done.err
        )
    assert (tmp_path / "a.toml").read_text() == "mine"
    assert not (tmp_path / "nowhere.toml").exists()
    assert run("new", "a.toml", *vessel, "--force").code == 0
    assert hognose.load_task("a.toml").name == "a"


#: What is wrong, what is said besides the vessel, and what is answered.
WRONG: dict[str, tuple[tuple[str, ...], str]] = {
    "a target inside a body": (
        ("--target", "60", "60", "1005"),
        "--target: (60, 60, 1005) mm lies inside 'vessel: bottom', 4.9 mm deep; the file goes from (-330.05",
    ),
    "a target too close": (
        ("--target", "60", "60", "980"),
        "--target: (60, 60, 980) mm is 19.95 mm from 'vessel: bottom', and the arm needs 27.5 mm there",
    ),
    "a target out of reach": (
        ("--target", "60", "60", "2005"),
        "--target: (60, 60, 2005) mm is 2006.8 mm from the entrance, and arm and slider of sjtu-25dof reach 1092 mm",
    ),
    "an entrance inside a body": (("--entrance", "200", "0", "-5"), "--entrance: (200, 0, -5) mm lies inside"),
    "an entrance with the far wall behind it": (
        ("--entrance", "0", "0", "900"),
        "--direction: at the start the arm lies straight behind the entrance, from (0.0, 0.0, -335.0) mm, and would be "
        "0 mm from 'vessel: baffle' at ",
    ),
    "one place for both": (("--entrance", "60", "60", "960"), "--target: 60 60 960 mm is the entrance, too"),
    "no direction": (("--direction", "0", "0", "0"), "--direction: 0 0 0 is no direction; expected three numbers"),
    "a direction that is no number": (("--direction", "nan", "0", "0"), "--direction: nan 0 0 is no direction"),
    "a place that is no number": (("--target", "0", "nan", "0"), "--target: expected three coordinates in mm"),
    "a place beyond all": (("--target", "0", "1e9", "0"), "none beyond 10,000,000, got 0 1e+09 0; --units says"),
    "two coordinates": (("--target", "0", "1"), "--target: expected three numbers, got 2\nTry: hognose new --help"),
    "a word for a coordinate": (("--target", "0", "1", "x"), 'unable to convert "x" into float'),
    "an unknown unit": (("--units", "ft"), "--units"),
    "a unit that does not fit": (
        ("--units", "m"),
        "--target: (60000, 60000, 960000) mm is 962696 mm outside the space, more than the arm's length of 1092 mm; "
        "the file goes from (-330.05, -330.03, -10.05) mm to (330.05, 330.03, 1010) mm. Give it in the frame of that "
        "file and in m, another unit with --units",
    ),
    "a frame that does not fit": (
        ("--entrance", "1e3", "2e3", "0"),
        "--entrance: (1000, 2000, 0) mm is 1799 mm outside the space",
    ),
    "a negative margin": (("--margin", "-1"), "--margin: expected a length in mm, 0 or more, got -1"),
    "an endless margin": (("--margin", "inf"), "--margin: expected a length in mm, 0 or more, got inf"),
    "no diameter": (("--diameter", "0"), "--diameter: expected a length in mm, above 0, got 0"),
    "a diameter for a mesh": (("--diameter", "3"), "--diameter: vessel.step holds a mesh and no points; leave it out"),
    "a unit for STEP": (("--space-units", "mm"), "--space-units: STEP files say their unit, vessel.step too"),
    "a space that is not there": (("--space", "none.step"), "none.step: no such file"),
    "a space that is a task": (("--space", "task.toml"), "--space: task.toml: "),
    "a space without an ending": (("--space", "vessel"), "--space: vessel: is no file of a space. Expected .stl"),
    "a drawing": (("--space", "what.dwg"), "--space: what.dwg: An AutoCAD drawing (.dwg) is not read"),
    "an unknown robot": (("--robot", "sjtu-25dog"), "Did you mean 'sjtu-25dof'?"),
}


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("use", WRONG)
def test_what_is_wrong_is_one_message_and_nothing_is_written(run, tmp_path, vessel, use, as_json):
    more, reason = WRONG[use]
    (tmp_path / "what.dwg").write_bytes(b"AC1027")
    (tmp_path / "task.toml").write_text("name = 'a'")
    before = {file.name for file in tmp_path.iterdir()}
    words = list(vessel)
    at = words.index(more[0]) if more[0] in words else len(words)
    end = next((k for k in range(at + 1, len(words)) if words[k].startswith("--")), len(words))
    done = run("new", "a.toml", *words[:at], *words[end:], *(["--json"] if as_json else []), *more)
    assert done.code == 2
    said = done.json["error"] if as_json else done.err
    assert reason in said
    assert (done.err if as_json else done.out) == ""
    assert {file.name for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize("option", ["--space", "--robot", "--entrance", "--target"])
def test_what_is_missing_is_named(run, vessel, option):
    words = list(vessel)
    at = words.index(option)
    end = next((k for k in range(at + 1, len(words)) if words[k].startswith("--")), len(words))
    done = run("new", "a.toml", *words[:at], *words[end:])
    assert done.code == 2
    assert done.err == f"hognose: {option} is missing\nTry: hognose new --help\n"


def test_all_that_is_missing_is_named_at_once(run):
    done = run("new", "a.toml", "--space=a.stl", "--robot", "sjtu-25dof", "--entrance", "1", "2")
    assert (
        done.err == "hognose: --entrance: expected three numbers, got 2\n--target is missing\nTry: hognose new --help\n"
    )
    lines = ["FILE", "--space", "--robot", "--entrance", "--target"]
    assert (
        run("new").err == "hognose: " + "".join(f"{each} is missing\n" for each in lines) + "Try: hognose new --help\n"
    )


@pytest.mark.parametrize(
    ("entrance", "target", "option"),
    [
        # Radius 22.5 mm beside the cube, whose half side is 100 mm: 3 mm are left.
        ((0.1255, 0.0, 0.0), (0.3, 0.0, 0.6), "--entrance"),
        ((0.1255, 0.0, 0.6), (0.3, 0.0, 1.17), "--direction"),
        ((0.3, 0.0, -0.05), (0.1255, 0.0, 0.05), "--target"),
        ((0.0, 0.0, -0.1255), (0.5, 0.0, 0.3), "--entrance"),
    ],
)
def test_the_margin_decides_what_is_too_close(run, tmp_path, box, entrance, target, option):
    words = ("new", "a.toml", *box, *asked(entrance, target), "--margin")
    refused = run(*words, "3.01")
    assert refused.code == 2
    assert refused.err.startswith(f"hognose: {option}: ")
    assert refused.err.count("\n") == 1
    assert not (tmp_path / "a.toml").exists()
    assert run(*words, "2.99").code == 0
    plan = planned("a.toml")
    assert plan.clearance[0 if option != "--target" else -1].min() == pytest.approx(0.003, abs=2e-5)


def planned(task: str) -> hognose.Plan:
    """The motion of a task straight from its entrance to its target, good or not."""
    spec = hognose.load_task(task).spec
    ends = spec.path.model_copy(
        update={"way_points": spec.path.stops, "target": None, "entrance": (0.0, 0.0, 0.0), "detour": False}
    )
    there = hognose.Task(spec.model_copy(update={"path": ends}), hognose.load_robot("sjtu-25dof"))
    try:
        return hognose.plan(there)
    except hognose.InfeasibleError as error:
        if error.plan is None:
            raise
        return error.plan


@pytest.mark.parametrize(("beyond", "code"), [(-1e-3, 0), (1e-3, 2)])
def test_the_arm_and_the_slider_decide_what_is_too_far(run, box, beyond, code):
    target = (ENTRANCE[0], 0.0, ENTRANCE[2] + 1.092 + beyond)
    done = run("new", "a.toml", *box, *asked(target=target))
    assert done.code == code
    assert ("is 1093 mm from the entrance, and arm and slider of sjtu-25dof reach 1092 mm" in done.err) == bool(code)


@pytest.mark.parametrize(("beyond", "code"), [(-1e-3, 0), (1e-3, 2)])
def test_an_arms_length_outside_the_space_is_another_frame(run, box, beyond, code):
    away = 0.1 + 1.092 + beyond
    done = run("new", "a.toml", *box, *asked((0, away, 0), (0.02, away - 0.2, 0.4)))
    assert done.code == code
    assert ("--entrance: (0, 1193, 0) mm is 1093 mm outside the space" in done.err) == bool(code)


def test_a_unit_that_nobody_says_is_asked_for(run, tmp_path, box):
    words = [word for word in box if word not in ("--space-units", "m")]
    done = run("new", "a.toml", *words, *asked())
    assert done.code == 2
    assert (
        "--space: box.stl does not say the unit of its numbers; give --space-units. "
        "Its longest side is 0.0002 m in mm, 0.002 m in cm, 0.2 m in m, 0.00508 m in in."
    ) in done.err
    assert not Path("a.toml").exists()


def test_all_that_is_wrong_is_said_at_once(run, vessel):
    words = [*vessel[: vessel.index("--entrance")], "--entrance", "200", "0", "-5", "--target", "0", "0", "1200"]
    done = run("new", "a.toml", *words)
    assert done.code == 2
    assert [line.split(": ")[0] for line in done.err.removeprefix("hognose: ").splitlines()] == [
        "--target",
        "--entrance",
    ]


@pytest.mark.parametrize(
    ("name", "folder", "reason"),
    [
        ("a.txt", "", "a.txt: the name of a task file must end in .toml"),
        ("none/a.toml", "", "none/a.toml: cannot write: there is no folder none; make it first"),
        ("a\x1b.toml", "", "the file's name holds a control character"),
    ],
)
def test_a_file_that_cannot_be_written_is_said(run, vessel, name, folder, reason):
    done = run("new", name, *vessel)
    assert done.code == 2
    assert reason in done.err


def test_the_direction_is_written_only_where_it_is_not_the_default():
    for direction in ((0, 0, 1), (-0.0, 0.0, 2e-3)):
        assert tomllib.loads("\n".join(base_table(direction))) == {"base": {}}
    for direction in ((0, 0, -1), (1e-9, 0, 1), (0.5, 0.5, 0.7), (-1, 0, 0)):
        assert tomllib.loads("\n".join(base_table(direction))) == {"base": {"direction": list(direction)}}


def test_a_slanted_direction_is_the_base_of_the_task(run, box):
    done = run("new", "a.toml", *box, *asked(), "--direction", "0", "0.1", "1")
    assert done.code == 0, done.err
    assert hognose.load_task("a.toml").base.direction @ [0, 0.1, 1] == pytest.approx(np.hypot(0.1, 1))


def test_steps_suit_short_links_and_slow_sliders(run, box, tmp_path):
    run("robot", "sjtu-25dof", "--write", "arm.toml")
    text = (tmp_path / "arm.toml").read_text()
    assert text.count("speed = 50.0") == 1
    (tmp_path / "arm.toml").write_text(text.replace("speed = 50.0", "speed = 11.0"))
    assert run("new", "a.toml", *["arm.toml" if word == "sjtu-25dof" else word for word in box], *asked()).code == 0
    motion = hognose.load_task("a.toml").spec.motion
    assert motion.step == pytest.approx(0.0016, rel=1e-9)
    assert run("plan", "a.toml").code == 0
