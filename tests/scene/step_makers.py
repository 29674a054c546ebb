"""STEP files as CAD systems write them, and as they should not, from the writer of the examples."""

import re

from import_makers import STEP

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
_HEAD, _END = "\nDATA;\n", "\nENDSEC;\nEND-ISO-10303-21;\n"


def block(name="block", at=(0.0, 0.0, 0.0), size=100.0, height=100.0):
    corners = ((0.0, 0.0), (size, 0.0), (size, size), (0.0, size))
    return STEP["Body"](name, at, X, Y, height, corners)


def step(*bodies) -> str:
    return STEP["step_file"](list(bodies) or [block()])


def added(text: str, *entities: str) -> str:
    """More entities at the end: what they call #1, #2 … are they themselves, and #old(12) is the file's own 12."""
    last = max(int(number) for number in re.findall(r"^#(\d+)=", text, re.MULTILINE) or ["0"])
    made = []
    for number, entity in enumerate(entities, 1):
        entity = re.sub(r"#(\d+)", lambda found: f"#{last + int(found[1])}", entity)
        entity = re.sub(r"#old\((\d+)\)", r"#\1", entity)
        made.append(f"#{last + number}={entity};")
    return text.replace(_END, "\n" + "\n".join(made) + _END)


def number_of(text: str, kind: str, which: int = 0) -> int:
    """The number of one of the entities of a kind."""
    return int(re.findall(rf"^#(\d+)=\(?{kind}\(", text, re.MULTILINE)[which])


def coloured(text: str, face: int, context: int) -> str:
    """With a colour of its own on one face."""
    return added(
        text,
        "COLOUR_RGB('',1.,0.,0.)", "FILL_AREA_STYLE_COLOUR('',#1)", "FILL_AREA_STYLE('',(#2))",
        "SURFACE_STYLE_FILL_AREA(#3)", "SURFACE_SIDE_STYLE('',(#4))", "SURFACE_STYLE_USAGE(.BOTH.,#5)",
        "PRESENTATION_STYLE_ASSIGNMENT((#6))", f"STYLED_ITEM('',(#7),#old({face}))",
        f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#8),#old({context}))",
    )  # fmt: skip


def without_face(text: str, number: int) -> str:
    """One face less, in its shell too, which says that it is closed all the same."""
    text = re.sub(rf"^#{number}=ADVANCED_FACE.*\n", "", text, flags=re.MULTILINE)
    return re.sub(rf"(?<=[(,])#{number}(,|(?=\)\);))", "", text)


def assembly(text: str, *places: tuple[float, float, float]) -> str:
    """The first body's product as a part of another product, "frame", once at each place, turned about z by 90°."""
    product, shape = number_of(text, "PRODUCT_DEFINITION"), number_of(text, "ADVANCED_BREP_SHAPE_REPRESENTATION")
    context, design = number_of(text, "GEOMETRIC_REPRESENTATION_CONTEXT"), number_of(text, "PRODUCT_DEFINITION_CONTEXT")
    discipline = number_of(text, "PRODUCT_CONTEXT")
    origin = int(re.search(rf"^#{shape}=\w+\('[^']*',\(#(\d+)", text, re.MULTILINE)[1])  # pyright: ignore[reportOptionalSubscript]
    entities = [
        f"PRODUCT('frame','frame','',(#old({discipline})))", "PRODUCT_DEFINITION_FORMATION('','',#1)",
        f"PRODUCT_DEFINITION('design','',#2,#old({design}))", "PRODUCT_DEFINITION_SHAPE('','',#3)",
        f"SHAPE_REPRESENTATION('frame',(#old({origin})),#old({context}))", "SHAPE_DEFINITION_REPRESENTATION(#4,#5)",
        "DIRECTION('',(0.,0.,1.))", "DIRECTION('',(0.,1.,0.))",
    ]  # fmt: skip
    for k, (x, y, z) in enumerate(places, 1):
        n = len(entities)
        entities += [
            f"CARTESIAN_POINT('',({x},{y},{z}))", f"AXIS2_PLACEMENT_3D('',#{n + 1},#7,#8)",
            f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('NAUO{k}','NAUO{k}','',#3,#old({product}),$)",
            f"PRODUCT_DEFINITION_SHAPE('','',#{n + 3})", f"ITEM_DEFINED_TRANSFORMATION('','',#old({origin}),#{n + 2})",
            f"(REPRESENTATION_RELATIONSHIP('','',#old({shape}),#5)REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"
            f"(#{n + 5})SHAPE_REPRESENTATION_RELATIONSHIP())",
            f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{n + 6},#{n + 4})",
        ]  # fmt: skip
    return added(text, *entities)


def product(name: str, shape: str, *entities: str) -> list[str]:
    """Entities of a product; the last of `entities` is put into a representation of a kind, with a context in mm."""
    n = len(entities)
    return [
        *entities,
        "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))", "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))",
        f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#{n + 1},#{n + 2}))"
        "REPRESENTATION_CONTEXT('',''))",
        f"{shape}('{name}',(#{n}),#{n + 3})", "APPLICATION_CONTEXT('')", f"PRODUCT_CONTEXT('',#{n + 5},'mechanical')",
        f"PRODUCT('{name}','{name}','',(#{n + 6}))", f"PRODUCT_DEFINITION_FORMATION('','',#{n + 7})",
        f"PRODUCT_DEFINITION_CONTEXT('part definition',#{n + 5},'design')",
        f"PRODUCT_DEFINITION('design','',#{n + 8},#{n + 9})", f"PRODUCT_DEFINITION_SHAPE('','',#{n + 10})",
        f"SHAPE_DEFINITION_REPRESENTATION(#{n + 11},#{n + 4})",
    ]  # fmt: skip


TETRAHEDRON = ((1, 3, 2), (1, 2, 4), (2, 3, 4), (3, 1, 4))
POINTS = "COORDINATES_LIST('',4,((0.,0.,0.),(100.,0.,0.),(0.,100.,0.),(0.,0.,100.)))"


def tessellated(name="tet") -> list[str]:
    """A solid of triangles (AP242)."""
    faces = [f"TRIANGULATED_FACE('',#1,4,(),$,(),(({a},{b},{c})))" for a, b, c in TETRAHEDRON]
    solid = f"TESSELLATED_SOLID('{name}',(#2,#3,#4,#5),$)"
    return product(name, "TESSELLATED_SHAPE_REPRESENTATION", POINTS, *faces, solid)


def drawn(name="wire") -> list[str]:
    """A polyline and a point, as of a sketch."""
    corners = ["CARTESIAN_POINT('',(0.,0.,0.))", "CARTESIAN_POINT('',(10.,0.,0.))", "CARTESIAN_POINT('',(10.,10.,0.))"]
    items = ["POLYLINE('',(#1,#2,#3))", "GEOMETRIC_CURVE_SET('',(#4))"]
    return product(name, "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION", *corners, *items)


def referring(*names: str) -> list[str]:
    """Other files that are referred to."""
    return ["DOCUMENT_TYPE('geometry')", *(f"DOCUMENT_FILE('{name}','','',#1,'','')" for name in names)]
