"""Point clouds in formats of their own, and what a task asks of a cloud."""

import io
import struct
import sys

import laspy
import numpy as np
import pye57
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from text_makers import read, refusal

from hognose.errors import InputError, MissingExtraError
from hognose.scene import Points, Scene
from hognose.scene.imports import scan_packages
from hognose.scene.imports.scan import thinned

XYZ = np.random.default_rng(3).normal(size=(40, 3)).astype(np.float32).astype(float)
seeds = st.integers(0, 2**32 - 1)


def lzf(data):
    """Pack as LZF: three bytes that were there before become a reference, all others stay as they are."""
    packed, plain, at = b"", b"", 0
    while at < len(data):
        begin = data.rfind(data[at : at + 3], max(0, at - 8000), at + 2) if at + 3 <= len(data) else -1
        if begin < 0 or begin >= at:
            plain += data[at : at + 1]
            at += 1
            if len(plain) == 32 or at == len(data):
                packed, plain = packed + bytes([len(plain) - 1]) + plain, b""
            continue
        if plain:
            packed, plain = packed + bytes([len(plain) - 1]) + plain, b""
        length = 3
        while length < 260 and at + length < len(data) and data[begin + length] == data[at + length]:
            length += 1
        back = at - begin - 1
        head = bytes([(length - 2) << 5 | back >> 8]) if length < 9 else bytes([7 << 5 | back >> 8, length - 9])
        packed += head + bytes([back & 255])
        at += length
    return packed + (bytes([len(plain) - 1]) + plain if plain else b"")


def pcd(form, points=XYZ, kind="<f4", fields="x y z rgb", order="xyzr", more="", said=None):
    """A PCD file; `r` among its fields stands for two short numbers."""
    letter = {"f": "F", "i": "I", "u": "U"}[kind[1]]
    size = [kind[2] if c != "r" else "2" for c in order]
    head = f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {' '.join(size)}\nTYPE "
    head += " ".join(letter if c != "r" else "U" for c in order) + "\nCOUNT "
    head += " ".join("1" if c != "r" else "2" for c in order)
    head += f"\nWIDTH {said or len(points)}\nHEIGHT 1\n{more or 'VIEWPOINT 0 0 0 1 0 0 0'}\n"
    head += f"POINTS {said or len(points)}\nDATA {form}\n"
    row = np.zeros(len(points), [(c, kind) if c != "r" else (c, "<u2", (2,)) for c in order])
    for k, axis in enumerate("xyz"):
        row[axis] = points[:, k]
    if form == "ascii":
        flat = [[x for c in order for x in np.atleast_1d(each[c])] for each in row]
        return head.encode() + "\n".join(" ".join(f"{x:.9g}" for x in each) for each in flat).encode() + b"\n"
    if form == "binary":
        return head.encode() + row.tobytes()
    data = b"".join(np.ascontiguousarray(row[c]).tobytes() for c in order)
    packed = lzf(data)
    return head.encode() + struct.pack("<2I", len(packed), len(data)) + packed


FORMS = ["ascii", "binary", "binary_compressed"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "more",
    [
        {},
        {"kind": "<f8"},
        {"points": np.round(XYZ * 100), "kind": "<i2"},
        {"fields": "rgb z x y", "order": "rzxy"},
        {"fields": "_ X Y Z", "order": "rxyz"},
    ],
)
def test_pcd(form, more):
    points = more.get("points", XYZ)
    found = read("pcd", pcd(form, **more))
    np.testing.assert_allclose(found.points, points, atol=1e-7 if form == "ascii" else 0)
    assert found.notes == ()


@pytest.mark.parametrize("form", FORMS)
def test_columns_and_view_points_of_pcd(form):
    found = read("pcd", pcd(form, fields="a b c rgb", more="VIEWPOINT 1 0 0 1 0 0 0"), columns=("c", "a", 2))
    np.testing.assert_allclose(found.points, XYZ[:, [2, 0, 1]], atol=1e-7)
    assert found.notes == ("taken as written: its VIEWPOINT is not applied",)
    assert "none seems to be x" in refusal("pcd", pcd(form, fields="a b c rgb"))


@given(data=st.binary(max_size=300), repeats=st.integers(1, 40))
@settings(max_examples=60, deadline=None)
def test_packed_bytes_come_out_as_they_went_in(data, repeats):
    whole = (data * repeats)[:3000]
    whole += bytes(-len(whole) % 12)
    points = np.frombuffer(whole, "<u4").reshape(-1, 3) if whole else np.empty((0, 3), "<u4")
    if len(points):
        found = read("pcd", pcd("binary_compressed", points, "<u4", "x y z", "xyz"))
        np.testing.assert_array_equal(found.points, points)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("said", [1, 39, 41, 4_000_000_000])
def test_pcd_with_another_count_is_refused(form, said):
    assert f"{said:,} points" in refusal("pcd", pcd(form, said=said))


@pytest.mark.parametrize("form", FORMS)
def test_every_cut_of_a_pcd_is_refused(form):
    data = pcd(form)
    for end in range(len(data) - (2 if form == "ascii" else 1)):
        if form != "ascii" or b" " in data[end:]:
            refusal("pcd", data[:end])


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (
            lambda t: t.replace("DATA ascii", "DATA text"),
            "its DATA are 'text', expected ascii, binary or binary_compressed",
        ),
        (lambda t: t.replace("DATA ascii", ""), "its header has no line `DATA`"),
        (lambda t: t.replace("SIZE 4", "SIZE 3"), "FIELDS, SIZE and TYPE"),
        (lambda t: t.replace("COUNT 1", "COUNT 0"), "COUNT"),
        (lambda t: t.replace("WIDTH 40", "WIDTH 39"), "POINTS of its header is not WIDTH times HEIGHT"),
        (lambda t: t.replace("VERSION", "VERSO"), "line 2 is 'VERSO 0.7'"),
        (lambda t: t.replace("HEIGHT 1", "HEIGHT one"), "HEIGHT of its header is 'one'"),
        (lambda t: t + "1,5 2 3 0 0\n", "line 52: '1,5' is written with a decimal comma"),
    ],
)
def test_headers_of_pcd_that_are_refused(change, complaint):
    assert complaint in refusal("pcd", change(pcd("ascii").decode()))


def las(suffix, points=XYZ):
    made = laspy.LasData(laspy.LasHeader(point_format=3, version="1.2"))
    made.header.scales = np.full(3, 1e-6)
    made.x, made.y, made.z = points.T
    made.return_number[:] = 1
    buffer = io.BytesIO()
    made.write(buffer, do_compress=suffix == "laz")
    return buffer.getvalue()


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_las_and_laz(suffix):
    data = las(suffix)
    found = read(suffix, data)
    np.testing.assert_allclose(found.points, XYZ, atol=6e-7)
    assert (found.metres, found.notes) == (None, ())
    for said in (39, 41):
        wrong = bytearray(data)
        wrong[107:111] = struct.pack("<I", said)
        assert any(words in refusal(suffix, bytes(wrong)) for words in ("its header says", "cut", "damaged"))
    refusal(suffix, data[:-30])
    assert "does not begin with `LASF`" in refusal(suffix, b"x" + data)
    assert "leave `columns` out" in refusal(suffix, data, columns=(1, 2, 3))


def test_a_las_whose_box_is_not_that_of_its_points_says_so():
    data = bytearray(las("las"))
    data[179:187] = struct.pack("<d", 1e6)  # the largest x
    assert read("las", bytes(data)).notes == (
        "its header says that its points reach elsewhere than they do; is it whole?",
    )


def e57(folder, scans):
    made = pye57.E57(str(folder / "made.e57"), mode="w")
    for data, rotation, translation in scans:
        made.write_scan_raw(data, rotation=rotation, translation=translation)
    made.close()
    return (folder / "made.e57").read_bytes()


def columns(points, **more):
    return {f"cartesian{axis}": points[:, k].copy() for k, axis in enumerate("XYZ")} | more


def test_scans_of_an_e57_are_where_their_poses_put_them(tmp_path):
    half = np.sqrt(0.5)
    state = np.zeros(40, np.int32)
    state[5:8] = 2
    data = e57(
        tmp_path,
        [
            (columns(XYZ), np.array([1.0, 0, 0, 0]), np.zeros(3)),
            (columns(XYZ, cartesianInvalidState=state), np.array([half, 0, 0, half]), np.array([10.0, 20, 30])),
        ],
    )
    found = read("e57", data)
    turned = np.stack([10 - XYZ[:, 1], 20 + XYZ[:, 0], 30 + XYZ[:, 2]], axis=1)
    turned[5:8] = np.nan
    np.testing.assert_allclose(found.points, [*XYZ, *turned], atol=1e-6)
    assert found.metres == 1.0
    assert "cut or damaged: it says it is" in refusal("e57", data[:-1])
    broken = bytearray(data)
    broken[len(data) // 2] ^= 255
    assert "cut or damaged" in refusal("e57", bytes(broken))
    (tmp_path / "scan.e57").write_bytes(data)
    asked = {"file": str(tmp_path / "scan.e57"), "diameter": 0.01}
    with pytest.raises(InputError, match=r"3 of 80 .* not finite .* say `drop_invalid = true`"):
        assert Points(**asked).geometry
    item = Points(**asked, drop_invalid=True)
    assert len(item.triangles()) == 77
    assert item.remarks() == ["scan: 3 points that are invalid returns (0 0 0, NaN or infinity) dropped"]


@pytest.mark.parametrize(("ending", "package", "extra"), [("laz", "laspy", "las"), ("e57", "pye57", "e57")])
def test_a_missing_extra_is_named(ending, package, extra, monkeypatch, tmp_path):
    monkeypatch.setattr(scan_packages, "find_spec", lambda name: None)
    data = las("laz") if ending == "laz" else b"ASTM-E57" + bytes(8) + struct.pack("<Q", 24)
    (tmp_path / f"a.{ending}").write_bytes(data)
    with pytest.raises(MissingExtraError, match=rf"a\.{ending}: .* {package}; .*'hognose\[{extra}\]'"):
        assert Points(file=str(tmp_path / f"a.{ending}"), units="m", diameter=0.01).geometry


def test_a_process_that_crashes_is_a_damaged_file(monkeypatch, tmp_path):
    crash = tmp_path / "crash.py"
    crash.write_text("import os; os.abort()")
    monkeypatch.setattr(scan_packages.scan_child, "__file__", str(crash))
    assert "laspy crashed on it" in refusal("las", las("las"))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "none"))
    assert "cannot start" in refusal("las", las("las"))


def test_readers_that_are_not_needed_are_not_imported():
    assert "pye57" not in vars(scan_packages)
    assert "laspy" not in vars(scan_packages)


def cloud(tmp_path, points, heading="", **more):
    file = tmp_path / "scan.csv"
    rows = "\n".join(",".join(f"{x:.17g}" for x in point) for point in np.asarray(points, float))
    file.write_text((heading + "\n" if heading else "") + rows)
    return Points(**{"file": str(file), "units": "mm", "diameter": 0.01} | more)


def test_invalid_returns_are_kept_refused_or_dropped_and_counted(tmp_path):
    points = [[1, 2, 3], [0, 0, 0], [4, 5, 6], [0, 0, 0], [0, 0, 7]]
    assert len(cloud(tmp_path, points).geometry.vertices) == 4  # 0 0 0 is a point, once
    item = cloud(tmp_path, points, drop_invalid=True)
    np.testing.assert_array_equal(item.geometry.vertices, [[1, 2, 3], [4, 5, 6], [0, 0, 7]])
    assert item.geometry.notes == ("2 points that are invalid returns (0 0 0, NaN or infinity) dropped",)
    mixed = [*points, [np.nan, 1, 2], [1, np.inf, 2]]
    with pytest.raises(InputError, match=r"2 of 7 .* not finite"):
        assert cloud(tmp_path, mixed).geometry
    assert len(cloud(tmp_path, mixed, drop_invalid=True).geometry.vertices) == 3
    with pytest.raises(InputError, match="all 2 points are invalid"):
        assert cloud(tmp_path, [[0, 0, 0], [np.nan, 0, 0]], drop_invalid=True).geometry


def test_columns_of_a_task(tmp_path):
    item = cloud(tmp_path, [[9, 1, 2, 3], [9, 4, 5, 6]], "range,a,b,c", columns=("c", "b", 2))
    np.testing.assert_array_equal(item.geometry.vertices, [[3, 2, 1], [6, 5, 4]])
    for wrong in ((1, 2), (1, 2, 0), ("", 1, 2), (1, 2, 2.5), 3):
        with pytest.raises(ValueError, match="columns"):
            Points.model_validate({"file": "a.csv", "units": "m", "diameter": 1.0, "columns": wrong})


@pytest.mark.parametrize(
    ("units", "said"), [("m", None), ("mm", "scan: its numbers are read as mm, but the file says m")]
)
def test_headings_that_name_another_unit_are_noted(units, said, tmp_path):
    item = cloud(tmp_path, [[1, 2, 3], [4, 5, 60]], "x [m],y [m],z [m]", units=units)
    assert [words for words in item.remarks() if "but the file says" in words] == ([said] if said else [])


@given(seed=seeds, distance=st.floats(1e-3, 3.0), spread=st.sampled_from([0.0, 0.01, 1.0, 1e5]))
@settings(max_examples=80, deadline=None)
def test_no_point_is_farther_than_asked_from_the_one_that_stands_for_it(seed, distance, spread):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(rng.integers(1, 120), 3)) * rng.choice([0.1, 1.0, 3.0]) + spread
    few = thinned(points, distance)
    assert 1 <= len(few) <= len(points)
    nearest = np.linalg.norm(points[:, None] - few, axis=2).min(axis=1)
    assert nearest.max() <= distance
    box = np.array([points.min(axis=0), points.max(axis=0)])
    assert (few >= box[0]).all()
    assert (few <= box[1]).all()


@given(seed=seeds, thin=st.floats(0.5, 40.0), scale=st.floats(0.2, 5.0))
@settings(max_examples=25, deadline=None)
def test_what_is_thinned_is_never_freer(seed, thin, scale, tmp_path_factory):
    rng = np.random.default_rng(seed)
    folder = tmp_path_factory.mktemp("thin")
    points = rng.uniform(-60, 60, (200, 3))
    placed = {
        "scale": scale,
        "rotation_deg": tuple(rng.uniform(-180, 180, 3)),
        "position": tuple(rng.uniform(-1, 1, 3)),
    }
    item = cloud(folder, points, **placed)
    fewer = item.model_copy(update={"thin": thin / 1e3, "_geometry": None})
    fewer = cloud(folder, points, thin=thin / 1e3, **placed)
    whole, less = Scene.from_obstacles([item]), Scene.from_obstacles([fewer])
    starts = rng.uniform(-0.3, 0.3, (60, 3)) + placed["position"]
    ends = starts + rng.normal(size=(60, 3)) * 0.05
    exact, grown = whole.distance(starts, ends).value, less.distance(starts, ends).value
    assert (grown <= exact + 1e-12).all()
    assert (grown >= exact - 2 * thin / 1e3 - 1e-12).all()
    assert (less.inside(starts)[whole.inside(starts) >= 0] >= 0).all()


def test_thinning_is_noted_and_thins(tmp_path):
    grid = np.stack(np.meshgrid(*[np.arange(0, 30.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
    item = cloud(tmp_path, grid, thin=0.005)
    kept = len(item.geometry.vertices)
    assert kept < len(grid) / 60
    assert item.geometry.notes == (f"thinned from 27,000 to {kept:,} points",)
    assert item.growth == pytest.approx(0.005 + 0.005)
    fine = thinned(np.array([[1e300, 0, 0], [0, 0, 0]]), 1e-9)
    assert len(fine) == 2
