"""Point clouds as text: columns are found or asked for, commas are what they are, and nothing is taken in silence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from text_makers import read, refusal

XYZ = np.array([[-100.25, 3.5, 2.0], [0.125, -7.0, 400.5], [30.0, 1250.5, -0.5]])


def table(separator=" ", heading="", columns="xyz", row="{}", numbers="{:g}", end="\n"):
    """The three points, with other columns (any letter but x, y, z) that count up from 100."""
    rows = [heading] if heading else []
    for k, point in enumerate(XYZ):
        held = dict(zip("xyz", point, strict=True))
        rows.append(row.format(separator.join(numbers.format(held.get(c, 100 + k)) for c in columns)))
    return end.join([*rows, ""])


@pytest.mark.parametrize(
    "text",
    [
        table(),
        table("\t"),
        table("  \t "),
        table(","),
        table(", "),
        table(";"),
        table(" ; "),
        table(end="\r\n"),
        table(end="\r"),
        table().rstrip(),
        "\ufeff" + table(","),
        table().replace("\n", "\n\n  \n"),
        table(",").replace("\n", "\n\n  \t\n"),
        "# a scan\n// of a wall\n" + table(row="{} # seen"),
        table(columns="xyzi"),
        table(",", columns="xyzirgb"),
        table(heading="x y z"),
        table(",", "X,Y,Z,intensity", "xyzi"),
        table(",", "intensity,laser_id,x,y,z", "ilxyz"),
        table(",", "z,y,x", "zyx"),
        table(";", '"i";"Z";"X";"Y"', "izxy"),
        table(",", '"X","Y","Z"', row='"{}"').replace(",", '","').replace('""', '"'),
        table(",", "Points_m_XYZ:0,Points_m_XYZ:1,Points_m_XYZ:2,i", "xyzi"),
        table(",", '"intensity","laser_id","azimuth","distance_m","Points:0","Points:1","Points:2"', "iladxyz"),
        table(",", "time,points[0],points[1],points[2]", "txyz"),
        table(",", "max,nx,ny,nz,pos_x,pos_y,pos_z", "mnnnxyz"),
        table(" ", "X [m] Y [m] Z [m] I", "xyzi"),
        table(";", "X [m];Y [m];Z [m];I", "xyzi"),
        table(",", "id,x(mm),y(mm),z(mm)", "ixyz"),
        table("\t", "x_coord\ty_coord\tz_coord\tname", "xyzn"),
        table(",", ",x,y,z", "ixyz"),
        "//X Y Z R G B\n" + table(columns="xyzrgb"),
        "# i x y z\n" + table(columns="ixyz"),
        "# x is east, y is north, z is up\n" + table(),
        "3\n" + table(columns="xyzi"),
        "1\n" + table().replace("\n", "\n2\n", 1),
        table(";", "X;Y;Z").replace(".", ","),
        table("\t").replace(".", ","),
        table(" ").replace(".", ","),
        table(";", row="{};a, b").replace(".", ","),
        table(";", numbers="{:.3f}").replace(".", ","),
        table(";", '"x";"y";"z"', row='"{}"').replace(";", '";"').replace('""', '"').replace(".", ","),
        table(numbers="{:e}"),
        table(";", numbers="{:e}").replace(".", ","),
        table(",", "name,x,y,z", "xyz", "wall 1,{}"),
        table(",", "name,x,y,z", "xyz", '"wall, left",{}'),
    ],
)
def test_layouts(text):
    for data in (text.encode(), text.lstrip("\ufeff").encode("utf-16")):
        found = read("csv", data)
        np.testing.assert_array_equal(found.points, XYZ)
        assert found.notes == ()


@pytest.mark.parametrize(
    ("heading", "metres"),
    [
        ("x,y,z", None),
        ("x [mm],y [mm],z [mm]", 1e-3),
        ("X (m),Y (m),Z (m)", 1.0),
        ("x_cm,y_cm,z_cm", 1e-2),
        ("Points_m_XYZ:0,Points_m_XYZ:1,Points_m_XYZ:2", 1.0),
        ("x in,y in,z in", 0.0254),
        ("x [mm],y [mm],z [m]", None),
        ("x_millimeter,y_millimeter,z_millimeter", 1e-3),
    ],
)
def test_units_of_headings(heading, metres):
    assert read("csv", table(",", heading)).metres == metres


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        ((2, 3, 4), table(columns="ixyz")),
        ((4, 3, 1), table(columns="ziyx").replace("\t", " ")),
        ((3, 4, 1), table(";", "c;b;a;d", "zixy")),
        (("east", "north", "height"), table(",", "point,east,north,height", "pxyz")),
        (("North", 4, 2), table(",", "name,h,north,e", "nzxy")),
        ((1, 2, 3), table(",", columns="xyzrgb", numbers="{:.0f}")),
        ((2, 3, 4), table(" ", "A title of some words", "ixyz")),
        ((2, 3, 4), table(" ", "Scan number 7 2026", "ixyz")),
    ],
)
def test_columns_that_are_asked_for(columns, text):
    whole = "." not in text
    np.testing.assert_array_equal(read("xyz", text, columns=columns).points, np.round(XYZ) if whole else XYZ)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("1 2 3\n4 5\n", "line 2 is '4 5'; expected x y z in 3 columns, as on line 1; is the file cut"),
        ("1 2 3\n4 5 6 7 8 9\n", "line 2 is '4 5 6 7 8 9'; expected x y z in 3 columns"),
        ("1,2,3\n4,5,\n", "line 2 is '4,5,': a coordinate is missing"),
        ("1,2,3\n\n4,,6\n", "line 3 is '4,,6': a coordinate is missing"),
        ("1 2 3\n4 five 6\n", "line 2: 'five' is not a number"),
        ("1 2 3\n4 5_0 6\n", "'5_0'"),
        ("1 2 3\n4 0x10 6\n", "'0x10'"),
        ("1 2 3\n\0 5 6\n", "line 2 holds a NUL byte"),
        (table(",", "a,b,c,d", "xyzi"), "1 'a', 2 'b', 3 'c', 4 'd': none seems to be x, y or z"),
        (table(",", "r,theta,phi"), "none seems to be x, y or z; say which hold them, by name or number: `columns"),
        (table(",", "x,y,height"), "none seems to be z"),
        (table(",", "x1,pos_x,x_coord,y,z", "aaxyz"), "2 seem to be x"),
        (table(" ", "Wall of tank 7", "xyzi"), "expected x y z, or the headings of 4 columns; `columns` chooses"),
        (table(" ", "A scan of the wall", "xyzi"), "line 2 has 4 columns, and 'A scan of the wall' before it does not"),
        ("A title\nx y z\n" + table(), "line 2 is 'x y z'; expected one line of headings"),
        ("4\n" + table(), "cut: line 1 says that 4 points follow, but there are 3"),
        ("2\n" + table(), "damaged: line 1 says that 2 points follow, but there are 3"),
        ("1\n" + table().replace("\n", "\n1\n", 1), "damaged: line 3 says that 1 points follow, but there are 2"),
        (
            table(";").replace(".", ",").replace("3,5", "3").replace("-7", "1.003,5"),
            "commas and points are both used in numbers",
        ),
        (table(";").replace(".", ",").replace("3,5", "1.003"), "commas and points are both used in numbers"),
        ("1,000;2,000;3,000\n4,250;5,000;6,125\n", "each comma has three digits behind it"),
        ("100,250 200,500 300,750\n", "each comma has three digits behind it"),
        ("0,5;2;3\n1,000,000;2;3\n", "commas and points are both used"),
        ("1,000,000;2;3\n", "line 1 is '1,000,000;2;3'; expected x y z"),
        ("1.003,5;2;3\n1;2;3\n", "line 1 is '1.003,5;2;3', expected x y z, or the headings of 3 columns"),
        ("1,5,2,5,3,5\n2,5,3,5,4,5\n", "6 whole numbers between commas: columns, or 3 numbers with decimal commas"),
        ("1,5,2,5,3,5,9\n2,5,3,5,4,5,9\n", "7 whole numbers between commas: columns, or fewer numbers with decimal"),
        (
            "0 5.5 6 7\n1 6 7 8.5\n2 7 8 9\n",
            "first of its 4 columns counts the lines, 0, 1, …: is it x, or their number?",
        ),
        ("1,5.5,6,7\n2,6,7,8\n", "first of its 4 columns counts the lines, 1, 2, …"),
        ("X,Y,Z\n-100,250,-90,250,400,500\n", "are 3, but line 2 has 6 columns; are its commas decimal points"),
        ('"X","Y","Z"\n"-100,250","-90,250","400,500"\n', "are 3, but line 2 has 6 columns"),
        ("X,Y,Z\n-100,25,-90,400\n", "are 3, but line 2 has 4 columns"),
        ("1,5,2,5,3,5\n2,3,4\n", "line 2 is '2,3,4'; expected x y z in 6 columns"),
        ("1'000 2 3\n4 5 6\n", 'is "1\'000 2 3", expected'),
        ("hello\nworld\n", "line 2 is 'world'; expected"),
    ],
)
def test_what_is_refused(text, complaint):
    assert complaint in refusal("csv", text)


@pytest.mark.parametrize(
    ("text", "columns", "x"),
    [
        ("0 5 6 7\n1 6 7 8\n", (2, 3, 4), [5, 6]),
        ("0 5 6 7\n1 6 7 8\n", (1, 2, 3), [0, 1]),
        ("0 5 6 7\n1 6 7 8\n3 6 7 8\n", None, [0, 1, 3]),
        ("2 5 6 7\n3 6 7 8\n", None, [2, 3]),
        ("0 5 6\n1 6 7\n", None, [0, 1]),
        ("x y z i\n0 5 6 1\n1 6 7 1\n", None, [0, 1]),
    ],
)
def test_a_first_column_that_counts_is_taken_if_it_is_asked_for_or_can_be_no_number_of_lines(text, columns, x):
    np.testing.assert_array_equal(read("txt", text, columns=columns).points[:, 0], x)


@pytest.mark.parametrize(
    ("columns", "complaint"),
    [
        ((1, 2, 5), "`columns` names the number 5, but there are 4 columns: 1 'i', 2 'x', 3 'y', 4 'z'"),
        (("x", "y", "w"), "`columns` names 'w', but none of the columns is called so: 1 'i', 2 'x'"),
        (("x", "x", "z"), "x, y and z would be in the same column"),
        ((1, 2, 1), "in the same column"),
    ],
)
def test_columns_that_are_not_there(columns, complaint):
    assert complaint in refusal("csv", table(",", "i,x,y,z", "ixyz"), columns=columns)


def test_a_title_is_said():
    assert read("xyz", "A scan of tank 7\n" + table()).notes == (
        "'A scan of tank 7' before its points taken for a title",
    )


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_empty_fields_may_be_no_returns(separator):
    text = "x,y,z,i\n1,2,3,4\n,,,5\n6,,7,8\n,1,2,3\n4,5, ,6\n7,8,9,\n".replace(",", separator)
    found = read("csv", text, drop_invalid=True).points
    np.testing.assert_array_equal(found[np.isfinite(found).all(axis=1)], [[1, 2, 3], [7, 8, 9]])
    assert len(found) == 6
    assert "line 3" in refusal("csv", text)


def ptx(scans, matrix=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))):
    text = ""
    for points in scans:
        text += f"{len(points)}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        text += "\n".join(" ".join(f"{x:.17g}" for x in row) for row in matrix) + "\n"
        text += "".join(" ".join(f"{x:.17g}" for x in point) + " 0.5\n" for point in points)
    return text


def test_ptx_puts_scans_where_their_matrices_say():
    turn = np.array([[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [10, 20, 30, 1.0]])  # x to y, and moved
    found = read("ptx", ptx([XYZ, XYZ[:1]], turn)).points
    expected = np.stack([10 - XYZ[:, 1], 20 + XYZ[:, 0], 30 + XYZ[:, 2]], axis=1)
    np.testing.assert_allclose(found, [*expected, expected[0]], atol=1e-12)
    with_none = read("ptx", ptx([np.concatenate([XYZ, np.zeros((2, 3))])], turn)).points
    np.testing.assert_array_equal(np.isnan(with_none).all(axis=1), [False] * 3 + [True] * 2)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda t: t.replace("3\n1\n", "4\n1\n", 1), "cut: a scan says it has 4 points, but ends after 3"),
        (lambda t: t.replace("3\n1\n", "2\n1\n", 1), "line 13: expected the head of a PTX scan"),
        (lambda t: t + "1 2 3 4\n", "line 14: expected the head of a PTX scan"),
        (lambda t: t[: t.rindex(" ")], "line 13: expected x y z and as many numbers as on the other lines"),
        (lambda t: t.replace("0.125", "a", 1), "line 12: 'a' is not a number"),
        (lambda t: t.replace("1 0 0\n", "1 0\n", 1), "line 1: expected the head of a PTX scan"),
    ],
)
def test_ptx_that_is_refused(change, complaint):
    assert complaint in refusal("ptx", change(ptx([XYZ])))


@given(
    seed=st.integers(0, 2**32 - 1),
    separator=st.sampled_from([" ", ";", "\t"]),
    comma=st.booleans(),
    rows=st.integers(1, 60),
)
@settings(max_examples=60, deadline=None)
def test_numbers_come_out_as_they_went_in_or_it_is_refused(seed, separator, comma, rows):
    points = np.random.default_rng(seed).normal(size=(rows, 3)) * 1000
    text = "\n".join(separator.join(f"{x:.6f}" for x in point) for point in points)
    text = text.replace(".", ",") if comma else text
    np.testing.assert_allclose(read("txt", text).points, points, atol=1e-6)
