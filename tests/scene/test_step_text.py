"""What the text of a STEP file says it holds."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from import_makers import EXAMPLES
from step_makers import added, assembly, block, drawn, number_of, referring, step, tessellated, without_face

from hognose.errors import InputError
from hognose.scene.imports.step_text import step_text


def read(text):
    return step_text(text.encode())


def test_faces_are_counted_once_each():
    text = (EXAMPLES / "step_tank.step").read_text()
    assert read(text).faces == text.count("=ADVANCED_FACE(") == 34
    assert read(text).closed
    assert read(text).says_unit


def test_layout_comments_and_strings_do_not_matter():
    text = step(block("#7=ADVANCED_FACE(; /* it''s"), block("b"))
    wanted = read(text)
    assert wanted.faces == 12
    spread = re.sub(r"(?m)^(#\d+)=([A-Z_]+)\(", r"/* #9=ADVANCED_FACE(); * */ \1 =\n \2 (", text)
    assert read(spread) == wanted
    assert read(text.replace("\n", "\r\n")) == wanted
    assert read("".join(text.splitlines()).replace("DATA;", "DATA;\n")) == wanted


def test_a_face_that_a_shell_names_counts_whatever_it_is():
    text = step(block())
    assert read(text.replace("ADVANCED_FACE", "ADVANCED_FARCE", 1)).faces == 6
    assert read(without_face(text, number_of(text, "ADVANCED_FACE", 3))).faces == 5


def test_oriented_and_complex_faces_are_no_further_ones():
    text = step(block())
    face, shell = number_of(text, "ADVANCED_FACE"), number_of(text, "CLOSED_SHELL")
    turned = added(text, f"ORIENTED_FACE('',*,#old({face}),.F.)")
    alias = number_of(turned, "ORIENTED_FACE")
    turned = re.sub(rf"(#{shell}=CLOSED_SHELL.*)#{face},", rf"\1#{alias},", turned)
    assert f"#{alias}," in turned
    assert (read(turned).faces, read(turned).closed) == (6, True)
    complex_one = re.sub(rf"#{face}=ADVANCED_FACE(.*);", rf"#{face}=(ADVANCED_FACE() FACE_SURFACE\1 FACE());", text)
    assert complex_one != text
    assert read(complex_one) == read(text)


def test_open_shells_and_triangles_are_told_apart():
    opened = read(step(block()).replace("CLOSED_SHELL", "OPEN_SHELL"))
    assert (opened.faces, opened.closed) == (6, False)
    mixed = read(added(step(block()), *tessellated()))
    assert (mixed.faces, mixed.tessellated, mixed.closed) == (6, 4, False)


def test_letters_of_a_drawing_are_no_faces():
    """Dimensions and notes of AP242 may be drawn as triangles."""
    entities = [
        "COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)))",
        "TRIANGULATED_SURFACE_SET('',#1,3,(),(),((1,2,3)))",
        "TESSELLATED_GEOMETRIC_SET('',(#2))", "TESSELLATED_ANNOTATION_OCCURRENCE('',(),#3)",
    ]  # fmt: skip
    assert read(added(step(block()), *entities)).tessellated == 0
    assert read(added(step(block()), *entities[:3])).tessellated == 1


def test_other_files_are_named():
    assert read(added(step(), *referring("lid.stp", "it''s.stp", "lid.stp"))).documents == ("lid.stp", "it's.stp")
    third = step().replace("ENDSEC;\nDATA;", "ENDSEC;\nREFERENCE;\n#900=<parts/lid.stp#a>;\nENDSEC;\nDATA;")
    assert read(third).documents == ("parts/lid.stp",)
    assert read(step()).documents == ()


def test_solids_without_surfaces_are_named():
    entities = ["BLOCK('',$,1.,2.,3.)", "CSG_SOLID('',#1)"]
    assert read(added(step(), *entities)).not_made == ("BLOCK", "CSG_SOLID")


def test_places_of_parts_are_counted_through_all_levels():
    text = assembly(step(block()), (0.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    assert read(text).places == 2
    frame = number_of(text, "PRODUCT_DEFINITION", 1)
    # Three frames in a machine.
    use = f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#1,#old({frame}),$)"
    assert read(added(text, "PRODUCT_DEFINITION('design','',$,$)", use, use, use)).places == 3 + 3 * 2
    block_itself = number_of(text, "PRODUCT_DEFINITION")
    circle = added(text, f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#old({block_itself}),#old({frame}),$)")
    with pytest.raises(InputError, match="a product in it is a part of itself"):
        read(circle)


def test_a_slip_that_would_hide_other_entities_is_damage():
    text = step(block("a"), block("b"))
    middle = text.index("\n", len(text) // 2)
    for broken in (
        text.replace("PLANE('',", "PLANE(§',", 1), text[:middle] + "'" + text[middle:],
        text[:middle] + '\n"12=PLANE();' + text[middle:], text.replace("\n#30=", "\n30=", 1),
    ):  # fmt: skip
        with pytest.raises(InputError, match=r"damaged at line \d+ or after"):
            read(broken)
    commented = text[:middle] + "\n/* #7=PLANE(); #8=it's off; */" + text[middle:]
    assert read(commented) == read(text)
    assert read(text.replace("DATA;", "DATA('a',('B'));")) == read(text)
    assert read(text + "SIGNATURE; 'aGVs=' #1=( ENDSEC;") == read(text)


def test_a_missing_unit_is_noticed():
    assert not read(step().replace("LENGTH_UNIT()", "")).says_unit


def test_curves_are_no_faces():
    assert read(added(step(), *drawn())).faces == 6


@pytest.mark.parametrize("data", [b"ISO-10303-21;", b"ISO-10303-21; HEADER; ENDSEC; END-ISO-10303-21;"])
def test_without_data_it_is_no_step_file(data):
    with pytest.raises(InputError, match="it has no DATA section"):
        step_text(data)


pieces = st.sampled_from(
    ["#1=", "#", "'", "''", "/*", "*/", "*", "/", ";", "(", ")", ",", "ADVANCED_FACE(", "CLOSED_SHELL(", "#2", "DATA;",
     "REFERENCE;", "ENDSEC;", "<", ">", " ", "\n", "é", "9" * 30, "DOCUMENT_FILE('"]
)  # fmt: skip


@given(st.lists(pieces, max_size=60))
@settings(max_examples=300, deadline=None)
def test_no_text_is_too_odd(parts):
    step_text(("DATA;" + "".join(parts)).encode())


@pytest.mark.parametrize("piece", ["#1='", "#1=/*", "#1=((", "'", "/*", "REFERENCE;", "#1 ", "<", "A", "#1=A(/"])
def test_no_text_takes_long(piece):
    """A pattern that tries things in two ways would not be done with these within the age of the universe."""
    for around in ("DATA;{}", "{}DATA;", "DATA;#1=CLOSED_SHELL({}"):
        step_text(around.format(piece * 30_000).encode())
