"""What `[base]` of a task file says, and what it refuses: what is wrong, where, and what to try."""

import math
import re
import tomllib
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.files.task_toml import agrees, revised, written
from hognose.files.toml_source import validate
from hognose.planning import TaskSpec
from hognose.planning.base_spec import BaseSpec

HEAD = 'name = "t"\nunits = "mm"\nrobot = "sjtu-25dof"\n'
WAY = "way_points = [[0, 0, 0], [30, 95, 430], [-60, -50, 900]]"
STRAIGHT = "way_points = [[0, 0, 0], [0, 0, 900]]"
WORKSPACE = "workspace = {low = [-100, -100, -1300], high = [100, 100, 200]}"


def pillar(*center):
    place = ", ".join(map(str, center))
    return f'[[obstacle]]\nkind = "box"\nname = "pillar"\ncenter = [{place}]\nsize = [200, 200, 200]\n'


@pytest.fixture
def task_of(tmp_path):
    def loaded(base, path=WAY, obstacles=""):
        file = tmp_path / "task.toml"
        file.write_text(f"{HEAD}[base]\n{base}\n[path]\n{path}\n{obstacles}")
        return hognose.load_task(file)

    return loaded


@pytest.mark.parametrize(
    ("base", "words"),
    [
        ('kind = "cart"', "task.toml:4: base: a cart stands somewhere: give its `position`"),
        ('kind = "drum"', "task.toml:4: base: a drum has a `radius`"),
        ('kind = "drum"\nradius = 0', "task.toml:6: base.radius: input should be greater than 0, got 0"),
        ('kind = "drum"\nradius = 300\nnozzle = -1', "task.toml:7: base.nozzle: input should be greater than or equal"),
        ('kind = "drum"\nradius = 300\nspeed = 1', '`speed` goes with `kind = "arm"`, not with "drum"'),
        ("radius = 300", '`radius` goes with `kind = "drum"`, not with "slider"'),
        ("nozzle = 0", '`nozzle` goes with `kind = "drum"`, not with "slider"'),
        (WORKSPACE, '`workspace` goes with `kind = "arm"`, not with "slider"'),
        ("position = [0, 0, 0]", '`position` goes with `kind = "cart"`, not with "slider"'),
        ('kind = "arm"\nspeed = 0', "base.speed: input should be greater than 0, got 0"),
        ('kind = "arm"\nturn_speed_deg_s = -5', "base.turn_speed_deg_s: input should be greater than 0, got -5"),
        (
            "direction = [0, 0, 1]\nrotation_deg = [0, 0, 0]",
            "task.toml:4: base: give either `direction` or `rotation_deg`, not both",
        ),
        ("direction = [0, 0, 0]", "task.toml:5: base.direction: is zero; it must be a direction"),
        (
            f'kind = "arm"\n{WORKSPACE.replace("-1300", "300")}',
            "base.workspace: `low` must be below `high` along x, y and z; "
            "got (-100.0, -100.0, 300.0) mm and (100.0, 100.0, 200.0) mm",
        ),
        ('kind = "wheel"', "task.toml:5: base.kind: input should be 'slider', 'cart', 'drum' or 'arm', got 'wheel'"),
        ("directon = [0, 0, 1]", "task.toml:5: base.directon: unknown key; did you mean 'direction'?"),
    ],
)
def test_a_file_that_contradicts_itself_is_refused(task_of, base, words):
    with pytest.raises(InputError, match=re.escape(words)):
        task_of(base)


@pytest.mark.parametrize(
    ("base", "words"),
    [
        (
            'kind = "drum"\nradius = 100',
            "base.radius: round a drum of 100 mm joint 2 bends by 54.13 deg, at most 28.65 deg; take a radius of "
            "183.9 mm or more",
        ),
        (
            'kind = "drum"\nradius = 300\nnozzle = 1200',
            "base.nozzle: 1200 mm is not shorter than the arm, 1092 mm, so that nothing of it is on the drum; take a "
            "shorter nozzle, or the kind slider",
        ),
    ],
)
def test_a_drum_that_does_not_suit_the_arm_is_refused(task_of, base, words):
    with pytest.raises(InputError, match=re.escape(words)):
        hognose.plan(task_of(base))


@pytest.mark.parametrize(
    ("base", "first", "words"),
    [
        (
            'kind = "slider"',
            (0, 0, -1092),
            "base: at feed 0 the first joint, at (0, 0, -1092) mm, lies inside the obstacle 'pillar'; move the "
            "entrance or turn `direction`, so that the straight arm has space before the entrance",
        ),
        (
            'kind = "cart"\nposition = [0, 0, -1200]',
            (0, 0, -1200),
            "base.position: at feed 0 the first joint, at (0, 0, -1200) mm, lies inside the obstacle 'pillar'; move it "
            "into free space",
        ),
        (
            'kind = "arm"\ndirection = [1, 0, 0]',
            (-1092, 0, 0),
            "base: at feed 0 the first joint, at (-1092, 0, 0) mm, ",
        ),
        ('kind = "drum"\nradius = 300', (540, 0, 147), "turn the drum about the nozzle with `rotation_deg`"),
    ],
)
def test_a_base_inside_an_obstacle_is_refused_before_anything_is_planned(task_of, base, first, words):
    task = task_of(base, obstacles=pillar(*first))
    assert np.abs(task.base.start - np.array(first) / 1e3).max() < 0.1
    with pytest.raises(InputError, match=re.escape(words)):
        hognose.plan(task)


def test_a_target_beyond_what_a_drum_can_feed_names_the_length_of_its_coil(task_of):
    task = task_of('kind = "drum"\nradius = 300\nnozzle = 400', STRAIGHT)
    words = f"the drum, which feeds its coil of {1e3 * task.base.farthest:.3f} mm and no more"
    with pytest.raises(InfeasibleError, match=re.escape(words)):
        hognose.plan(task)


@given(seed=st.integers(0, 2**32 - 1), tilt=st.sampled_from([None, 90.0, -90.0, 90.0 - 1e-7, -90.0 + 1e-12]))
def test_a_base_says_as_it_stands_the_axes_it_is_given(seed, tilt):
    random = np.random.default_rng(seed)
    if tilt is None:
        axes = Rotation.random(rng=random).as_matrix()
    else:  # where turns about x and about z are nearly the same
        about_x, about_z = random.uniform(-180, 180, 2)
        axes = Rotation.from_euler("xyz", [about_x, tilt, about_z], degrees=True).as_matrix()
    said = BaseSpec(kind="arm", speed=0.1).as_it_stands(axes)
    assert (said.kind, said.speed) == ("arm", 0.1)
    assert said.R_task_base is not None
    np.testing.assert_allclose(said.R_task_base, axes, atol=1e-12)
    assert said.as_it_stands(axes) is said


BASES = [
    "direction = [0.5, 0.0, -1.0]",
    "rotation_deg = [10.0, -20.0, 30.0]",
    'kind = "cart"\nposition = [1.5, 2.0, -1200.0]\ndirection = [0.0, 0.1, 1.0]',
    'kind = "drum"\nradius = 250.0\nnozzle = 200.0',
    'kind = "drum"\nradius = 250.0\nnozzle = 0.0',
    f'kind = "arm"\nspeed = 250.0\nturn_speed_deg_s = 45.0\n{WORKSPACE}',
    'kind = "arm"\n[base.workspace]\nlow = [0.0, 0.0, 0.0]\nhigh = [1.0, 1.0, 1.0]',
]


@pytest.mark.parametrize("base", BASES)
def test_a_base_is_written_as_it_was_read(task_of, base, tmp_path):
    spec = task_of(base).spec
    again = tmp_path / "again.toml"
    again.write_text(written(spec))
    assert agrees(hognose.load_task(again).spec.model_dump(), spec.model_dump())
    text = f"{HEAD}[base] # where it stands\n{base}\n[path]\n{WAY}\n"
    assert revised(text, spec) == text


@pytest.mark.parametrize("before", BASES)
@pytest.mark.parametrize("after", BASES)
def test_a_base_is_changed_in_place_to_any_other(task_of, before, after):
    spec = task_of(after).spec
    made = revised(f"{HEAD}[base] # where it stands\n{before}\n[path]\n{WAY}\n", spec)
    assert "# where it stands" in made
    table = tomllib.loads(made)["base"]
    assert set(table) - {"kind"} == set(tomllib.loads(f"[base]\n{after}")["base"]) - {"kind"}
    assert table.get("kind", "slider") == spec.base.kind


NUMBERS = st.floats(-9.0, 9.0).map(lambda number: number if abs(number) > 1e-6 else 0.0)


@given(
    position=st.tuples(NUMBERS, NUMBERS, NUMBERS),
    units=st.sampled_from(["mm", "cm", "m", "in"]),
    digits=st.integers(1, 17),
)
def test_where_a_cart_stands_is_written_with_few_digits_and_read_as_the_same_place(position, units, digits):
    position = tuple(float(f"{number:.{digits}g}") for number in position)
    told = tomllib.loads(HEAD.replace("mm", "m") + f"[path]\n{WAY}")
    told |= {"base": {"kind": "cart", "position": position}, "path": {"way_points": [[0, 0, 0], [0, 0, 0.9]]}}
    spec = validate(told, TaskSpec, "told")
    text = revised(f'name = ""\nunits = "{units}"\n', spec)
    read = validate(tomllib.loads(text), TaskSpec, "text")
    assert read.base.position is not None
    for there, was in zip(read.base.position, position, strict=True):
        assert abs(there - was) <= math.ulp(was)
    written_ones = tomllib.loads(text)["base"]["position"]
    if units != "in":  # a decimal point that moves makes no digits
        assert all(len(Decimal(repr(number)).normalize().as_tuple().digits) <= digits for number in written_ones)
    assert revised(text, read) == text


def test_a_cart_in_mm_is_written_as_people_write_it(task_of, tmp_path):
    spec = task_of('kind = "cart"\nposition = [0.1, 0, -1150]', STRAIGHT).spec
    assert "position = [0.1, 0.0, -1150.0]" in written(spec)
    assert "position = [0.0001, 0.0, -1.15]" in revised('name = ""\nunits = "m"\n', spec)
    told = spec.model_copy(update={"base": spec.base.model_copy(update={"position": (0.0, 0.0, -1.15)})})
    assert "position = [0.0, 0.0, -1150.0]" in written(told)


def test_a_cart_that_touches_the_entrance_still_does_when_it_is_written_and_read(task_of, tmp_path):
    task = task_of('kind = "cart"\nposition = [0, 0, -1300]\ndirection = [0.1, 0.2, 0.9]', STRAIGHT)
    begin = -task.robot.length * np.array(task.spec.base.along)
    told = task.spec.base.model_copy(update={"position": tuple(begin.tolist())})
    file = tmp_path / "again.toml"
    file.write_text(written(task.spec.model_copy(update={"base": told})))
    assert len(hognose.load_task(file).way_points) == 2
