"""Writes `step_tank.step`, the tank of example 5, as a CAD system would: `python examples/make_step_tank.py`.

A STEP file (AP214) of bodies that are each a flat region pulled along its normal: plates with holes, pipes and rods.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

Vector = tuple[float, float, float]
Pair = tuple[float, float]

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Circle:
    center: Pair
    radius: float


#: The border of a region or of a hole in it: a circle, or corners anticlockwise.
Loop = Circle | tuple[Pair, ...]


@dataclass(frozen=True)
class Body:
    """A region in the plane through `origin` spanned by `x` and `y`, pulled along their normal by `height`."""

    name: str
    origin: Vector
    x: Vector
    y: Vector
    height: float
    outline: Loop
    holes: tuple[Loop, ...] = ()


def tank() -> list[Body]:
    """A round vessel that lies along z, with a manhole, a baffle and three tubes across it; mm."""
    manhole, passage = Circle((0.0, 0.0), 80.0), Circle((70.0, 70.0), 85.0)
    flange = ((-45.0, -45.0), (45.0, -45.0), (45.0, 45.0), (-45.0, 45.0))
    return [
        Body("shell", (0, 0, 0), X, Y, 1000.0, Circle((0, 0), 300.0), (Circle((0, 0), 292.0),)),
        Body("lid", (0, 0, -10), X, Y, 10.0, Circle((0, 0), 330.0), (manhole,)),
        Body("bottom", (0, 0, 1000), X, Y, 10.0, Circle((0, 0), 330.0)),
        Body("baffle", (0, 0, 400), X, Y, 8.0, Circle((0, 0), 292.0), (passage, Circle((-150.0, -80.0), 40.0))),
        Body("tube 1", (-270, -30, 640), Y, Z, 540.0, Circle((0, 0), 30.0), (Circle((0, 0), 26.0),)),
        Body("tube 2", (-270, 170, 700), Y, Z, 540.0, Circle((0, 0), 30.0), (Circle((0, 0), 26.0),)),
        Body("tube 3", (-150, -200, 800), Z, X, 400.0, Circle((0, 0), 25.0), (Circle((0, 0), 21.0),)),
        Body("pedestal", (-60, -60, 940), X, Y, 60.0, flange),
    ]


def step_file(bodies: Sequence[Body]) -> str:
    """The text of a STEP file in mm that holds these bodies, each a product of its own."""
    writer = _Writer()
    for body in bodies:
        writer.body(body)
    return "\n".join([_HEAD, *writer.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


_HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('a tank with internals'),'2;1');
FILE_NAME('step_tank.step','2026-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;"""


@dataclass
class _Writer:
    lines: list[str] = field(default_factory=list)

    def put(self, text: str) -> str:
        """Add one entity; what others call it by."""
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def body(self, body: Body) -> None:
        faces = _Faces(self, body).all()
        shell = self.put(f"CLOSED_SHELL('',({','.join(faces)}))")
        solid = self.put(f"MANIFOLD_SOLID_BREP('{body.name}',{shell})")
        length = self.put("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = self.put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid_angle = self.put("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        exact = self.put(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{length},'distance_accuracy_value','')")
        context = self.put(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({exact}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
        )
        place = self.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
        shape = self.put(f"ADVANCED_BREP_SHAPE_REPRESENTATION('{body.name}',({place},{solid}),{context})")
        application = self.put("APPLICATION_CONTEXT('automotive_design')")
        discipline = self.put(f"PRODUCT_CONTEXT('',{application},'mechanical')")
        product = self.put(f"PRODUCT('{body.name}','{body.name}','',({discipline}))")
        formation = self.put(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        design = self.put(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
        definition = self.put(f"PRODUCT_DEFINITION('design','',{formation},{design})")
        defined = self.put(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.put(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")

    def point(self, at: Vector) -> str:
        return self.put(f"CARTESIAN_POINT('',{_numbers(at)})")

    def direction(self, along: Vector) -> str:
        return self.put(f"DIRECTION('',{_numbers(along)})")

    def axes(self, origin: Vector, z: Vector, x: Vector) -> str:
        return self.put(f"AXIS2_PLACEMENT_3D('',{self.point(origin)},{self.direction(z)},{self.direction(x)})")

    def edge(self, start: str, end: str, curve: str) -> str:
        return self.put(f"EDGE_CURVE('',{start},{end},{curve},.T.)")

    def oriented(self, edge: str, forward: bool) -> str:
        return self.put(f"ORIENTED_EDGE('',*,*,{edge},{_flag(forward)})")

    def loop(self, edges: Sequence[str]) -> str:
        return self.put(f"EDGE_LOOP('',({','.join(edges)}))")

    def face(self, bounds: Sequence[str], surface: str, same: bool) -> str:
        """A face whose first bound is the outer one."""
        kinds = ["FACE_OUTER_BOUND"] + ["FACE_BOUND"] * (len(bounds) - 1)
        held = [self.put(f"{kind}('',{bound},.T.)") for kind, bound in zip(kinds, bounds, strict=True)]
        return self.put(f"ADVANCED_FACE('',({','.join(held)}),{surface},{_flag(same)})")


class _Faces:
    """The faces of one extruded body."""

    def __init__(self, writer: _Writer, body: Body) -> None:
        self.writer, self.body = writer, body
        self.normal = _cross(body.x, body.y)

    def all(self) -> list[str]:
        writer, body = self.writer, self.body
        sides, bottoms, tops = [], [], []
        for index, loop in enumerate((body.outline, *body.holes)):
            draw = self.circle if isinstance(loop, Circle) else self.polygon
            made, bottom, top = draw(loop, index > 0)  # pyright: ignore[reportArgumentType]
            sides += made
            bottoms.append(bottom)
            tops.append(top)
        low = writer.put(f"PLANE('',{writer.axes(self.at((0, 0), 0), self.normal, body.x)})")
        high = writer.put(f"PLANE('',{writer.axes(self.at((0, 0), body.height), self.normal, body.x)})")
        return [*sides, writer.face(bottoms, low, False), writer.face(tops, high, True)]

    def at(self, place: Pair, height: float) -> Vector:
        body = self.body
        u, v = place
        along = zip(body.origin, body.x, body.y, self.normal, strict=True)
        a, b, c = (o + u * x + v * y + height * n for o, x, y, n in along)
        return a, b, c

    def vertex(self, place: Pair, height: float) -> str:
        return self.writer.put(f"VERTEX_POINT('',{self.writer.point(self.at(place, height))})")

    def line(self, start: Vector, along: Vector) -> str:
        vector = self.writer.put(f"VECTOR('',{self.writer.direction(along)},1.)")
        return self.writer.put(f"LINE('',{self.writer.point(start)},{vector})")

    def circle(self, loop: Circle, is_hole: bool) -> tuple[list[str], str, str]:
        writer, height = self.writer, self.body.height
        seam_place = (loop.center[0] + loop.radius, loop.center[1])
        ends = [self.vertex(seam_place, h) for h in (0.0, height)]
        rims = []
        for end, h in zip(ends, (0.0, height), strict=True):
            frame = writer.axes(self.at(loop.center, h), self.normal, self.body.x)
            rims.append(writer.edge(end, end, writer.put(f"CIRCLE('',{frame},{_number(loop.radius)})")))
        seam = writer.edge(ends[0], ends[1], self.line(self.at(seam_place, 0.0), self.normal))
        frame = writer.axes(self.at(loop.center, 0.0), self.normal, self.body.x)
        surface = writer.put(f"CYLINDRICAL_SURFACE('',{frame},{_number(loop.radius)})")
        turns = [(rims[0], not is_hole), (seam, True), (rims[1], is_hole), (seam, False)]
        side = writer.face([writer.loop([writer.oriented(*turn) for turn in turns])], surface, not is_hole)
        bottom = writer.loop([writer.oriented(rims[0], is_hole)])
        top = writer.loop([writer.oriented(rims[1], not is_hole)])
        return [side], bottom, top

    def polygon(self, loop: tuple[Pair, ...], is_hole: bool) -> tuple[list[str], str, str]:
        writer, height, count = self.writer, self.body.height, len(loop)
        corners = tuple(reversed(loop)) if is_hole else loop
        low, high = ([self.vertex(place, h) for place in corners] for h in (0.0, height))
        rims: list[list[str]] = [[], []]
        posts = [writer.edge(low[k], high[k], self.line(self.at(corners[k], 0.0), self.normal)) for k in range(count)]
        sides = []
        for k in range(count):
            after = (k + 1) % count
            along = _unit(_minus(self.at(corners[after], 0.0), self.at(corners[k], 0.0)))
            for rim, row, h in zip(rims, (low, high), (0.0, height), strict=True):
                rim.append(writer.edge(row[k], row[after], self.line(self.at(corners[k], h), along)))
            surface = writer.put(
                f"PLANE('',{writer.axes(self.at(corners[k], 0.0), _cross(along, self.normal), along)})"
            )
            sides.append((k, after, surface))
        made = []
        for k, after, surface in sides:
            turns = [(rims[0][k], True), (posts[after], True), (rims[1][k], False), (posts[k], False)]
            made.append(writer.face([writer.loop([writer.oriented(*turn) for turn in turns])], surface, True))
        bottom = writer.loop([writer.oriented(edge, False) for edge in reversed(rims[0])])
        top = writer.loop([writer.oriented(edge, True) for edge in rims[1]])
        return made, bottom, top


def _number(value: float) -> str:
    text = f"{value:.12g}"
    return text.replace("e", "E") if "." in text or "e" in text else text + "."


def _numbers(values: Sequence[float]) -> str:
    return f"({','.join(_number(value + 0.0) for value in values)})"


def _flag(true: bool) -> str:
    return ".T." if true else ".F."


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _unit(a: Vector) -> Vector:
    size = math.hypot(*a)
    return (a[0] / size, a[1] / size, a[2] / size)


if __name__ == "__main__":
    Path(__file__).with_name("step_tank.step").write_text(step_file(tank()), encoding="ascii")
