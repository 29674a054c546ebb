"""The box of the oracles in every way that glTF can say it."""

import numpy as np
from content_oracles import CORNERS, FACES, QUADS
from scipy.spatial.transform import Rotation

MIDDLE, SIZE = (CORNERS.max(0) + CORNERS.min(0)) / 2, np.ptp(CORNERS, axis=0)
UNIT = (CORNERS - MIDDLE) / SIZE  # corners at -0.5 and 0.5
TURN = Rotation.from_euler("xyz", [20, -50, 130], degrees=True)
SHIFT, SCALE = np.array([0.3, -1.0, 2.0]), np.array([2.0, 0.5, 1.5])
STRIPS = QUADS[:, [1, 2, 0, 3]]


def before(corners=CORNERS):
    """Where corners are before they are scaled, turned and shifted."""
    return TURN.inv().apply(corners - SHIFT) / SCALE


def moves(names="TRS"):
    """The properties of a node that scale, turn and shift."""
    made = {"T": ("translation", SHIFT), "R": ("rotation", TURN.as_quat()), "S": ("scale", SCALE)}
    return {made[name][0]: made[name][1].tolist() for name in names}


def matrix_of(turn, shift):
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, shift
    return made.T.ravel().tolist()


def plain(g):
    return g.node(g.primitive(CORNERS, FACES))


def without_indices(g):
    g.node(g.primitive(CORNERS[FACES].reshape(-1, 3)))


def strips(g):
    g.node(*(g.primitive(CORNERS, strip, mode=5) for strip in STRIPS))


def one_strip_that_goes_on_elsewhere(g):
    row = [corner for strip in STRIPS for corner in (strip[0], *strip, strip[-1])]
    g.node(g.primitive(CORNERS, row[1:-1], mode=5))


def strip_without_indices(g):
    g.node(*(g.primitive(CORNERS[strip], mode=5) for strip in STRIPS))


def fans(g):
    g.node(*(g.primitive(CORNERS, quad, mode=6) for quad in QUADS))


def fan_without_indices(g):
    g.node(*(g.primitive(CORNERS[quad], mode=6) for quad in QUADS))


def several_materials_over_one_accessor(g):
    corners = g.accessor(CORNERS, "f4")
    g.node(*(g.primitive(corners, half, material=k) for k, half in enumerate((FACES[:5], FACES[5:]))))


def six_materials_with_corners_of_their_own(g):
    g.node(*(g.primitive(CORNERS[quad], [0, 1, 2, 0, 2, 3], material=k) for k, quad in enumerate(QUADS)))


def a_little_of_a_large_accessor(g):
    rng = np.random.default_rng(0)
    many, at = rng.uniform(-9, 9, (500, 3)), rng.permutation(500)[:8]
    many[at] = CORNERS
    g.node(g.primitive(g.accessor(many, "f4"), at[FACES]))


def rows_with_gaps(g):
    g.node(g.primitive(g.accessor(CORNERS, "f4", gap=20), FACES))


def rows_with_gaps_and_a_shift(g):
    g.node(g.primitive(g.accessor(CORNERS, "f4", gap=7, shift=5), g.accessor(FACES.ravel(), "u4", shift=12)))


def sparse_over_zeros(g):
    g.node(g.primitive(g.sparse(8, range(8), CORNERS, "f4"), FACES))


def sparse_over_a_base(g, index="u2"):
    wrong = CORNERS.copy()
    wrong[[1, 4, 7]] = 9.0
    g.node(g.primitive(g.sparse(8, [1, 4, 7], CORNERS[[1, 4, 7]], "f4", index=index, base=wrong), FACES))


def sparse_indices(g):
    row = FACES.ravel()
    g.node(g.primitive(CORNERS, g.sparse(36, np.flatnonzero(row), row[row > 0], "u2")))


def matrix(g):
    g.node(g.primitive(before(), FACES), matrix=matrix_of(TURN.as_matrix() * SCALE, SHIFT))


def translation_rotation_scale(g):
    g.node(g.primitive(before(), FACES), **moves())


def three_nodes_deep(g):
    g.node(g.primitive(before(), FACES), **moves("S"))
    g.tree["nodes"] += [{"children": [0], **moves("R")}, {"children": [1], **moves("T"), "name": "above"}]
    g.tree["scenes"] = [{"nodes": [2]}]


def mirrored_by_a_scale(g):
    g.node(g.primitive(CORNERS * [-1, 1, 1], FACES[:, ::-1]), scale=[-1, 1, 1])


def mirrored_by_a_matrix_twice_over(g):
    g.node(g.primitive(-CORNERS, FACES[:, ::-1]), matrix=matrix_of(-np.eye(3)[[1, 0, 2]], [0, 0, 0]))
    g.tree["nodes"].append({"children": [0], "matrix": matrix_of(np.eye(3)[[1, 0, 2]], [0, 0, 0])})
    g.tree["scenes"] = [{"nodes": [1]}]


def morphed_by_weights_of_the_mesh(g):
    target = {"POSITION": g.accessor(CORNERS - UNIT, "f4")}
    nothing = {"POSITION": g.accessor(9 * CORNERS, "f4"), "NORMAL": 0}
    g.node(g.primitive(UNIT * 0.5 + CORNERS * 0.5, FACES, targets=[nothing, target]), mesh={"weights": [0, 0.5]})


def morphed_by_weights_of_the_node(g):
    target = {"POSITION": g.sparse(8, range(8), CORNERS - UNIT, "f4")}
    g.node(g.primitive(UNIT, FACES, targets=[target]), mesh={"weights": [7]}, weights=[1])


def morph_targets_at_rest(g):
    g.node(g.primitive(CORNERS, FACES, targets=[{"POSITION": g.accessor(CORNERS, "f4")}]))


def one_instance(g):
    attributes = {
        "TRANSLATION": g.accessor([SHIFT], "f4"),
        "ROTATION": g.accessor([TURN.as_quat()], "f4"),
        "SCALE": g.accessor([SCALE], "f4"),
        "_ID": g.accessor([1], "u1"),
    }
    g.node(g.primitive(before(), FACES), extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    g.tree["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]


def an_instance_of_a_mirrored_node(g):
    attributes = {"TRANSLATION": g.accessor([[-1.0, 0, 0]], "f4")}
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    g.node(g.primitive((CORNERS - [1, 0, 0]) * [-1, 1, 1], FACES[:, ::-1]), scale=[-1, 1, 1], extensions=instancing)


def named_by_its_mesh(g):
    g.node(g.primitive(CORNERS, FACES), name="", mesh={"name": "box"})


def a_name_that_opencascade_made_up(g):
    g.node(g.primitive(CORNERS, FACES), name="=>[0:1:1:2]", mesh={"name": "box"})


def one_scene_that_is_not_said_to_be_shown(g):
    plain(g)
    del g.tree["scene"]


def extensions_of_looks_alone(g):
    plain(g)
    g.tree["extensionsRequired"] = ["KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"]
    g.tree["meshes"][0]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": []}}


def fields_of_no_use_here(g):
    plain(g)
    g.tree["cameras"], g.tree["extras"] = [{"type": "perspective"}], [1, {"a": None}]
    g.tree["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 999


def lines(g):
    plain(g)
    g.tree["meshes"][0]["primitives"] += [g.primitive(CORNERS, mode=mode) for mode in (1, 2, 3)]


def nothing_to_place(g):
    plain(g)
    g.tree["meshes"][0]["primitives"].append({"attributes": {"COLOR_0": 0}})


def another_scene(g):
    plain(g)
    g.node(g.primitive(CORNERS + 5, FACES), name="hidden")
    g.tree["nodes"].append({"mesh": 1})
    g.tree["scenes"].append({"nodes": [1, 0]})


def a_mesh_that_no_node_has(g):
    plain(g)
    g.tree["meshes"].append(g.tree["meshes"][0])


def animations(g):
    plain(g)
    g.tree["animations"] = [{"channels": []}, {}]


def unknown_extensions(g):
    plain(g)
    g.tree["nodes"][0]["extensions"] = {"XX_more": {}, "KHR_node_visibility": {"visible": False}}
    g.tree["accessors"][0]["extensions"] = {"AA_values": {}}


def no_scene(g):
    plain(g)
    del g.tree["scene"], g.tree["scenes"]


SAME = [
    plain, without_indices, strips, one_strip_that_goes_on_elsewhere, strip_without_indices, fans, fan_without_indices,
    several_materials_over_one_accessor, six_materials_with_corners_of_their_own, a_little_of_a_large_accessor,
    rows_with_gaps, rows_with_gaps_and_a_shift, sparse_over_zeros, sparse_over_a_base, sparse_indices, matrix,
    translation_rotation_scale, three_nodes_deep, mirrored_by_a_scale, mirrored_by_a_matrix_twice_over,
    morphed_by_weights_of_the_mesh, morphed_by_weights_of_the_node, morph_targets_at_rest, one_instance,
    an_instance_of_a_mirrored_node, named_by_its_mesh, a_name_that_opencascade_made_up,
    one_scene_that_is_not_said_to_be_shown, extensions_of_looks_alone, fields_of_no_use_here,
]  # fmt: skip
