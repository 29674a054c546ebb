"""Choosing bodies of a file, surfaces without an inside, and notes of files of many bodies."""

from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from import_makers import exported, text_of, written
from pydantic import ValidationError

from hognose.errors import InputError
from hognose.planning import embedded
from hognose.planning.task import TaskSpec
from hognose.scene import Mesh, Scene
from hognose.scene.imports.gaps import widest_gap
from hognose.scene.imports.geometry import Body, Geometry
from hognose.scene.imports.other_formats import foreign
from hognose.scene.imports.selection import selected

NAMES = ["lid", "wall 1", "wall 2", "Tank [1]", "Tank [2]"]
SCALE = 1e-3


def many(names, faces_of=lambda k, faces: faces) -> bytes:
    """An OBJ file of boxes of 100 mm, 200 mm apart along x."""
    rows = []
    for k, name in enumerate(names):
        box = trimesh.creation.box((100, 100, 100))
        box.apply_translation([200 * k, 0, 0])
        text = text_of("obj", box.vertices, faces_of(k, box.faces + 8 * k)).decode()
        rows.append(f"o {name}\n{text}")
    return "".join(rows).encode()


def read(folder, data, **more: Any):
    return Mesh(file=str(written(folder, "obj", data)), units="mm", **more)


def names_of(item):
    return [name.removeprefix("file: ") for name in Scene.from_obstacles([item]).names]


@pytest.mark.parametrize(
    ("more", "left"),
    [
        ({}, NAMES),
        ({"bodies": ["lid", "wall*"]}, ["lid", "wall 1", "wall 2"]),
        ({"without": ["wall ?"]}, ["lid", "Tank [1]", "Tank [2]"]),
        ({"bodies": ["*"], "without": ["[A-Z]*"]}, ["lid", "wall 1", "wall 2"]),
        # A name is a name first, and a pattern only if there is none of that name.
        ({"without": ["Tank [1]"]}, ["lid", "wall 1", "wall 2", "Tank [2]"]),
        ({"bodies": ["wall 2", "lid"]}, ["lid", "wall 2"]),
    ],
)
def test_bodies_are_chosen_by_their_names(more, left, tmp_path):
    item = read(tmp_path, many(NAMES), **more)
    scene = Scene.from_obstacles([item])
    assert names_of(item) == left
    for k, name in enumerate(left):
        x = 0.2 * NAMES.index(name)
        np.testing.assert_allclose(scene.bounds[k], [[x - 0.05, -0.05, -0.05], [x + 0.05, 0.05, 0.05]], atol=1e-9)
    assert len(item.geometry.vertices) == 8 * len(left)
    dropped = [name for name in NAMES if name not in left]
    expected = [f"file: {len(dropped)} of 5 bodies left out, as asked: {', '.join(dropped)}"] if dropped else []
    assert item.remarks() == expected


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"bodies": ["lidd"]}, "`bodies`: there is no body 'lidd'; did you mean 'lid'? There are: lid, wall 1, "),
        ({"without": ["LID"]}, "`without`: there is no body 'LID'; did you mean 'lid'?"),
        ({"bodies": ["lid", "roof*"]}, "`bodies`: there is no body 'roof*'. There are: lid, wall 1, wall 2, Tank [1]"),
        ({"bodies": ["lid"], "without": ["l*"]}, "`bodies` and `without` leave none of its 5 bodies: lid, wall 1"),
    ],
)
def test_what_fits_no_body_is_refused_with_the_names_there_are(more, said, tmp_path):
    with pytest.raises(InputError) as caught:
        assert read(tmp_path, many(NAMES), **more).geometry
    assert said in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "file.obj"))


def test_a_body_without_a_name_cannot_be_chosen(tmp_path):
    item = Mesh(file=str(written(tmp_path, "stl", exported(trimesh.creation.box(), "stl"))), units="m", bodies=("lid",))
    with pytest.raises(InputError, match="there is no body 'lid': the file has one body, without a name"):
        assert item.geometry


@pytest.mark.parametrize("wrong", [[], [""], "lid", [1]])
def test_lists_of_names_must_be_such(wrong):
    with pytest.raises(ValidationError):
        Mesh.model_validate({"file": "a.obj", "units": "mm", "bodies": wrong})


@given(st.sets(st.integers(0, 6)), st.integers(1, 7))
def test_what_is_chosen_is_the_same_surface(chosen, count):
    kept = sorted(k for k in chosen if k < count)
    rng = np.random.default_rng(count)
    sizes = rng.integers(1, 5, count)
    ends = np.cumsum(sizes)
    bodies = tuple(Body(f"b{k}", int(ends[k] - sizes[k]), int(ends[k]), 0, 0, 1.0) for k in range(count))
    geometry = Geometry(rng.normal(size=(9, 3)), rng.integers(0, 9, (ends[-1], 3)).astype(np.int32), bodies, None)
    if not kept:
        with pytest.raises(InputError, match="leave none"):
            selected(geometry, None, ["*"])
        return
    found = selected(geometry, [f"b{k}" for k in kept], None)
    assert [body.name for body in found.bodies] == [f"b{k}" for k in kept]
    for body, k in zip(found.bodies, kept, strict=True):
        whole = geometry.faces[geometry.bodies[k].first : geometry.bodies[k].last]
        np.testing.assert_array_equal(found.vertices[found.faces[body.first : body.last]], geometry.vertices[whole])


def task_of(item):
    path = {"way_points": [[0, 0, -0.1], [0, 0, 0.3]]}
    return TaskSpec.model_validate({"name": "t", "robot": "sjtu-25dof", "path": path, "obstacle": [item]})


def test_a_plan_carries_what_was_chosen_only_and_takes_it_back(tmp_path):
    spec = task_of(read(tmp_path, many(NAMES), without=("wall*",), solid=False))
    entries = embedded.entries(spec)
    (tmp_path / "file.obj").unlink()
    again = TaskSpec.model_validate(spec.model_dump(by_alias=True))
    back = embedded.restored(again, embedded.digests(spec), entries)
    (item,) = back.obstacle
    assert isinstance(item, Mesh)
    assert names_of(item) == ["lid", "Tank [1]", "Tank [2]"]
    assert len(item.geometry.vertices) == 24
    assert (item.solid, item.without) == (False, ("wall*",))
    assert "2 of 5 bodies left out" in " ".join(item.remarks())


def duct(folder, **more):
    """A tube without ends along z, open at both: 200 mm wide, 600 mm long."""
    tube = trimesh.creation.cylinder(100, 600, sections=48)
    tube.update_faces(np.abs(tube.face_normals[:, 2]) < 0.5)
    return Mesh(file=str(written(folder, "stl", exported(tube, "stl"))), units="mm", **more)


def test_a_surface_has_no_inside_and_its_distances_stay(tmp_path):
    within, beside = [[0, 0, 0.0]], [[0.5, 0, 0]]
    solid, surface = (Scene.from_obstacles([duct(tmp_path, solid=solid)]) for solid in (True, False))
    assert solid.inside(within).tolist() == [0]
    assert surface.inside(within).tolist() == [-1]
    assert surface.inside(beside).tolist() == [-1]
    for place in (within, beside):
        assert surface.distance(place, place).value == solid.distance(place, place).value
    np.testing.assert_array_equal(surface.bounds, solid.bounds)


def test_what_lies_in_the_thickness_of_a_surface_is_in_it(tmp_path):
    scene = Scene.from_obstacles([duct(tmp_path, solid=False, tolerance=0.002)])
    assert scene.inside([[0.1, 0, 0], [0.1015, 0, 0], [0.1025, 0, 0], [0.05, 0, 0]]).tolist() == [0, 0, -1, -1]


def test_a_surface_beside_a_solid_leaves_that_its_inside(tmp_path):
    box = {"kind": "box", "center": (0, 0, 0), "size": (0.05, 0.05, 0.05)}
    spec = task_of(box).model_copy(update={"obstacle": (duct(tmp_path, solid=False), *task_of(box).obstacle)})
    assert Scene.from_obstacles(spec.obstacle).inside([[0, 0, 0], [0, 0, 0.1]]).tolist() == [1, -1]


def test_an_open_body_is_told_of_the_way_out_and_a_surface_that_it_is_one(tmp_path):
    (remark,) = duct(tmp_path).remarks()
    assert "file: not watertight: 96 open edges" in remark
    assert "say `solid = false`" in remark
    assert duct(tmp_path, solid=False).remarks() == [
        "file: taken as a surface: nothing counts as inside it (`solid = false`)"
    ]


def test_bodies_with_one_defect_are_one_note_and_each_on_request(tmp_path):
    names = [f"part {k}" for k in range(20)]
    item = read(tmp_path, many(names, lambda k, faces: faces[: 12 - (k % 2)]))
    (note,) = item.remarks()
    assert note.startswith(
        "file: 10 of 20 bodies (part 1, part 3, part 5, part 7, part 9, part 11 and 4 more) are not watertight: "
    )
    assert note.endswith(f"`hognose scene {item.file} --notes` lists all")
    every = item.remarks(every=True)
    assert [words.split(": ")[1] for words in every] == names[1::2]
    assert all("not watertight: 3 open edges" in words for words in every)


def test_one_body_of_several_is_named_in_its_note(tmp_path):
    item = read(tmp_path, many(NAMES, lambda k, faces: faces[:11] if k == 2 else faces))
    (note,) = item.remarks()
    assert note.startswith("file: wall 2: not watertight: 3 open edges")


def test_gaps_are_as_wide_as_they_are():
    sphere = trimesh.creation.icosphere(3, 1.0)
    assert widest_gap(sphere.vertices, sphere.faces) is None
    plate = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 1.001, 0], [2, 1.001, 0], [2, 2, 0], [0, 2, 0.0]])
    # Two halves of a square a little apart: its rim is as wide as a hole as it is.
    apart = widest_gap(plate, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]))
    assert apart is not None
    assert apart.width == pytest.approx(2.0, rel=0.01)
    box = trimesh.creation.box((1, 2, 3))
    crack = np.array(box.vertices[box.faces.ravel()])
    crack[:3] += [1e-4, 0, 0]
    moved = widest_gap(crack, np.arange(36).reshape(-1, 3))
    assert moved is not None
    assert 5e-5 < moved.width <= 1.01e-4
    hole = widest_gap(box.vertices, box.faces[1:])
    assert hole is not None
    assert hole.width > 0.3


@pytest.mark.parametrize(
    ("ending", "said"),
    [
        (".IGS", "IGES, whose surfaces often do not meet (.IGS) is not read: in the CAD system"),
        (".sldprt", "A SolidWorks document (.sldprt) is not read: open it in the CAD system it is of"),
        (".dwg", "An AutoCAD drawing (.dwg)"), (".fbx", "open it in Blender"), (".ifc", "A building model"),
        (".stpZ", "unpack it with gzip"), (".zip", "An archive (.zip) is not read: unpack it"),
        (".what", "the ending '.what' is of no known format."), ("", "the name has no ending that says its format."),
    ],
)  # fmt: skip
def test_files_that_are_not_read_are_told_how_to_be_converted(ending, said):
    assert said in foreign(ending)
    with pytest.raises(InputError, match=r"Expected a mesh: \.stl, \.obj"):
        assert Mesh(file=f"part{ending}", units="mm").geometry


@pytest.mark.parametrize(
    ("more", "left"),
    [
        ({"bodies": ["lid"]}, ["lid", "lid 2"]),
        ({"without": ["lid"]}, ["wall", "lid 3"]),
        ({"bodies": ["lid 2"]}, ["file"]),
        ({"bodies": ["lid"], "without": ["lid 2"]}, ["file"]),
        ({"bodies": ["lid 3"]}, ["file"]),
    ],
)
def test_a_name_stands_for_all_bodies_that_the_file_calls_so(more, left, tmp_path):
    rows = []
    for k, name in enumerate(["lid", "wall", "lid", "lid 3"]):
        box = trimesh.creation.box((100, 100, 100))
        text = text_of("stl ascii", box.vertices + np.array([200 * k, 0, 0]), box.faces).decode()
        rows.append(text.replace("solid a", f"solid {name}"))
    item = Mesh(file=str(written(tmp_path, "stl", "".join(rows).encode())), units="mm", **more)
    assert names_of(item) == left
