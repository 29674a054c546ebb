"""3MF that cannot be taken as it is meant: refused in words, whatever is wrong with it."""

import io
import re
import struct
import zipfile

import numpy as np
import pytest
from content_oracles import CORNERS, FACES, assert_is_the_box
from threemf_maker import archive, group, mesh, model, package, read, relations, solid

from hognose.errors import InputError
from hognose.scene import Mesh
from hognose.scene.imports import threemf, threemf_model, threemf_package

BEAMS = '<b:beamlattice minlength="0.1" radius="1"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice>'
FAR = np.where(FACES == 3, 8, FACES)

ONE = 'objectid="1"'
HUGE = FACES.astype(object) * 10**19
LISTED = "<triangles><x:t/></triangles>"

MODELS = {
    "an unknown unit": (model(solid(), unit='unit="parsec"'), "its unit is 'parsec', expected one of micron, mill"),
    "another root": ("<a/>", "begins with <a>, expected <http://schemas.*core/2015/02 model>"),
    "an item of nothing": (model(solid(), items=['objectid="5"']), "the build places object 5, which is not there"),
    "a component of nothing": (model(group(1, 'objectid="9"')), "object 1 places object 9, which is not there"),
    "an empty build": (model(solid(), items=[]), "places none of its objects .1.: its build is empty"),
    "its own component": (model(group(1, 'objectid="1"')), "object 1 has itself as a component"),
    "a circle": (
        model(solid(), group(2, 'objectid="3"'), group(3, 'objectid="1"', 'objectid="2"'), items=['objectid="3"']),
        "object 3 has itself as a component, directly or through others",
    ),
    "very deep": (
        model(solid(), *(group(k, f'objectid="{k - 1}"') for k in range(2, 300)), items=['objectid="299"']),
        "components within components, over 100 deep",
    ),
    "a bomb of components": (
        model(solid(), *(group(k, *[f'objectid="{k - 1}"'] * 10) for k in range(2, 60)), items=['objectid="59"']),
        "holds more than 20,000,000 triangles, counting all components",
    ),
    "a bomb of nothing": (
        model(solid(1, ""), *(group(k, *[f'objectid="{k - 1}"'] * 2) for k in range(2, 90)), items=['objectid="89"']),
        "holds more than 20,000,000 triangles, counting all components",
    ),
    "an unknown type": (model(solid(more='type="void"')), "object 1 has the type 'void', expected one of model, solid"),
    "two of one id": (model(solid(), solid()), "a second object with the id 1"),
    "an id that is no number": (model(solid("one")), "id 'one', expected a number"),
    "no objectid": (model(solid(), items=[""]), "objectid missing, expected a number"),
    "a vertex that is not there": (model(solid(shape=mesh(faces=FAR))), "names the vertex 8, but there are 8"),
    "a negative vertex": (model(solid(shape=mesh(faces=FACES - 1))), "names the vertex -1, but there are 8"),
    "a huge vertex": (model(solid(shape=mesh(faces=HUGE))), 'triangle v1="0" v2="1\\d*" .*, expected whole'),
    "a triangle of fractions": (model(solid(shape=mesh(faces=FACES / 2))), 'has the triangle v1="0.0" v2="0.5"'),
    "a corner short": (model(solid(shape=mesh().replace('v3="', 'w="', 1))), "expected whole numbers v1, v2 and v3"),
    "a decimal comma": (model(solid(shape=mesh().replace('"0.4"', '"0,4"'))), 'the vertex x="-0.1" y="0,4" z="0.2"'),
    "a coordinate short": (model(solid(shape=mesh().replace('z="', 'w="', 1))), "expected numbers x, y and z"),
    "a short transform": (model(solid(), items=['objectid="1" transform="1 2 3"']), "transform '1 2 3', expected 12"),
    "an infinite transform": (
        model(solid(), items=[f'objectid="1" transform="{"1e999 " * 12}"']),
        "which is not of finite numbers",
    ),
    "beams": (
        model(solid(shape=mesh(inside=BEAMS))),
        "line 1: object 1 has <beamlattice>, a shape that is not read .beamlattice/2017/02.",
    ),
    "displacement": (model(solid(shape="<d:displacementmesh/>")), "object 1 has <displacementmesh>, a shape"),
    "booleans": (model(solid(shape='<bo:booleanshape objectid="2"/>')), "object 1 has <booleanshape>, a shape"),
    "a level set": (model(solid(shape='<v:levelset functionid="2"/>')), "object 1 has <levelset>, a shape"),
    "alternatives": (model(solid(shape=mesh() + "<pa:alternatives/>")), "object 1 has <alternatives>, a shape"),
    "a stand-in for slices": (
        model(solid(more='s:slicestackid="9" s:meshresolution="lowres"')),
        "triangles that only stand for another shape .lowres.",
    ),
    "a stand-in": (model(solid(more='pa:modelresolution="obfuscated"')), "only stand for another shape .obfuscated."),
    "slices alone": (model(solid(shape="", more='s:slicestackid="9"')), "object 1 consists of slices"),
    "two shapes": (model(solid(shape=mesh() + '<components><component objectid="1"/></components>')), "more than one"),
    "two meshes": (model(solid(shape=mesh() + mesh())), "more than one shape"),
    "two lists": (model(solid(shape=mesh(inside="<vertices/>"))), "a second list of vertices"),
    "a stranger among vertices": (model(solid(shape=mesh().replace("<vertex", "<x:v/><vertex", 1))), "<v> among"),
    "a stranger among triangles": (model(solid(shape=f"<mesh>{LISTED}</mesh>")), "<t> among its triangles"),
    "an object out of place": (model(solid(), resources=f"<x:a>{solid(2)}</x:a>"), "<object> within <a>, where it has"),
    "an item out of place": (model(solid(), items=[f"{ONE}/><x:a><item {ONE}/></x:a><item {ONE}"]), "<item> within"),
    "a mesh of no namespace": (model(solid(shape='<mesh xmlns=""/>')), "object 1 has <mesh>, a shape that is not read"),
    "entities": (
        model(solid()).replace("<model", '<!DOCTYPE a [<!ENTITY b "b"><!ENTITY c "&b;&b;">]><model', 1),
        "has a document type declaration",
    ),
    "an unknown encoding": (model(solid()).replace("UTF-8", "KLINGON"), "damaged"),
    "no XML": ("solid box\n", "cut or damaged: line 1"),
    "cut XML": (model(solid())[:-20], "cut or damaged: line 1"),
    "nothing": ("", "cut or damaged: line 1"),
    "encrypted": ("%3McF\0\0\0", "is encrypted: the part '/3d/3dmodel.model' needs a key"),
    "a part that is not there": (
        model(items=['objectid="1" p:path="/3D/no.model"']),
        "refers to the part '/3d/no.model', which is not in the archive",
    ),
}  # fmt: skip
REQUIRED = {
    "b": "beamlattice/2017/02", "d": "3dmanufacturing/displacement/2023/10", "v": "3dmanufacturing/volumetric/2022/01",
    "bo": "3dmanufacturing/booleanoperations/2023/07", "sc": "securecontent/2019/04", "x": "urn:vendor:more", "q": "q",
}  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
def test_what_cannot_be_taken_is_refused_in_words(name):
    made, complaint = MODELS[name]
    with pytest.raises(InputError, match=complaint):
        read(package(made))


@pytest.mark.parametrize("prefix", REQUIRED)
def test_extensions_that_are_needed_are_named(prefix):
    made = model(solid(), head=f'requiredextensions="p {prefix} m"')
    said = f"needs extensions that are not read: {REQUIRED[prefix]}; export it without"
    with pytest.raises(InputError, match=re.escape(said)):
        read(package(made))


def test_other_parts_are_held_to_their_rules():
    root = model(items=['objectid="7" p:path="/a.model"'])
    for part, complaint in (
        (model(solid(7), items=[], unit='unit="inch"'), "part '/a.model' is in inch, but the file in meter"),
        (model(solid(7), items=['objectid="7"']), "part '/a.model' has a build of its own"),
        (model(group(7, 'objectid="1" p:path="/3D/3dmodel.model"'), items=[]), "part '/a.model' refers to other parts"),
        (model(solid(8), items=[]), "the build places object 7 of '/a.model', which is not there"),
        (model(solid(7), items=[], head='requiredextensions="b"'), "part '/a.model': needs extensions that are not"),
        (model(solid(7, mesh(faces=FAR)), items=[]), "object 7 of '/a.model' has a triangle that names the vertex 8"),
    ):
        with pytest.raises(InputError, match=complaint):
            read(package(root, {"a.model": part}))


def test_coordinates_that_are_no_numbers_are_refused_with_the_body(tmp_path):
    (tmp_path / "file.3mf").write_bytes(package(model(solid(shape=mesh(CORNERS * [1, np.inf, 1])))))
    with pytest.raises(InputError, match="'box': 36 of 36 corners or points have coordinates that are not finite"):
        assert Mesh(file=str(tmp_path / "file.3mf")).geometry


def test_the_archive_must_say_where_to_begin():
    for parts, complaint in (
        ({"3D/3dmodel.model": model(solid())}, "does not say which of its parts is the model"),
        ({"_rels/.rels": "<a/>", "3D/3dmodel.model": model(solid())}, "does not say which of its parts is the model"),
        ({"_rels/.rels": relations("/a.model"), "3D/3dmodel.model": ""}, "refers to the part '/a.model', which is not"),
        ({"_rels/.rels": relations("/a.model", "/b.model")}, "names 2 parts as its model: /a.model, /b.model"),
        ({"_rels/.rels": relations("/a")[:-9]}, "cut or damaged: line 1"),
        ({"_rels/.rels": relations("/a"), "a": model(solid()), "A": ""}, "has the part 'A' twice"),
    ):
        with pytest.raises(InputError, match=complaint):
            read(archive(parts))


def test_an_archive_that_is_cut_or_changed_is_refused():
    whole = package(model(solid()))
    for length in range(0, len(whole), 7):
        with pytest.raises(InputError, match=r"cut|not a 3MF file"):
            read(whole[:length])
    start = whole.index(b"3D/3dmodel.model") + len(b"3D/3dmodel.model")
    changed = bytearray(whole)
    changed[start + 40] ^= 0x10
    with pytest.raises(InputError, match=r"the part '/3d/3dmodel\.model' cannot be unpacked"):
        read(bytes(changed))
    stored = archive({"_rels/.rels": relations("/a"), "a": model(solid())}, zipfile.ZIP_STORED)
    with pytest.raises(InputError, match="cannot be unpacked: Bad CRC-32"):
        read(stored.replace(b'x="-0.1"', b'x="-0.2"', 1))
    for method in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        with pytest.raises(InputError, match="is not packed as 3MF files are"):
            read(archive({"_rels/.rels": relations("/a"), "a": model(solid())}, method))


def test_a_part_with_a_password_is_refused():
    data = bytearray(package(model(solid())))
    for head, flags in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        at = data.rindex(head) + flags
        data[at] |= 1
    with pytest.raises(InputError, match=r"is encrypted: the part '/3d/3dmodel\.model' needs a password"):
        read(bytes(data))


def test_what_unpacks_to_too_much_is_refused_before_it_is_unpacked(monkeypatch):
    made = model(solid())
    data = package(made)
    monkeypatch.setattr(threemf_package, "LARGEST_PART", len(made) + len(relations("/3D/3dmodel.model")))
    assert_is_the_box(read(data))
    monkeypatch.setattr(threemf_package, "LARGEST_PART", len(made) + len(relations("/3D/3dmodel.model")) - 1)
    with pytest.raises(InputError, match="unpacks to more than 0 MB"):
        read(data)
    monkeypatch.undo()
    # A bomb that says it is small gives no more than it says, and its check sum is wrong.
    bomb = bytearray(package(model(solid(), resources=" " * 10_000_000)))
    at = bomb.rindex(b"PK\1\2")
    bomb[at + 24 : at + 28] = struct.pack("<I", 1000)
    with pytest.raises(InputError, match="cut or damaged"):
        read(bytes(bomb))
    bomb[at + 24 : at + 28] = struct.pack("<I", 20_000_000)
    with pytest.raises(InputError, match=r"has 10,\d\d\d,\d\d\d bytes, expected 20,000,000"):
        read(bytes(bomb))


def test_too_many_triangles_are_refused(monkeypatch):
    for module in (threemf, threemf_model):
        monkeypatch.setattr(module, "MOST_ELEMENTS", 12)
    with pytest.raises(InputError, match="holds more than 12 triangles"):
        read(package(model(solid(), group(2, 'objectid="1"', 'objectid="1"'), items=['objectid="2"'])))
    monkeypatch.setattr(threemf_model, "MOST_ELEMENTS", 11)
    with pytest.raises(InputError, match="more than 11 triangles"):
        read(package(model(solid())))


def test_an_archive_of_folders_and_other_parts_is_read():
    buffer = io.BytesIO(package(model(solid()), {"Metadata/thumbnail.png": b"\x89PNG"}))
    with zipfile.ZipFile(buffer, "a") as file:
        file.mkdir("3D/Textures")
    assert_is_the_box(read(buffer.getvalue()))
