"""Draw the pictures of the documentation: `python docs/make_pictures.py`, or only those named: `… feed insertion`."""

from __future__ import annotations

import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Polygon, Rectangle

import hognose

FOLDER = Path(__file__).parent / "pictures"
INK, SOFT, ACCENT = "#1d2733", "#8a97a6", "#c2410c"
BODY, SOLID = "#f3ede6", "#cfd8e3"


def conventions() -> None:
    """Frames, feed and angles: two sections in the x–z plane, where only alpha turns."""
    figure = Figure(figsize=(9.2, 4.0), dpi=150)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(-1.4, 7.8)
    axes.set_ylim(-1.2, 2.8)
    axes.plot([-1.2, 7.6], [0, 0], color=SOFT, lw=1, ls=(0, (6, 4)), zorder=0)
    axes.text(7.6, -0.22, "straight run of the slider, +z", ha="right", color=SOFT, fontsize=9)
    axes.add_patch(Rectangle((-0.75, -0.28), 0.75, 0.56, fc="#e6ebf1", ec=INK, lw=1.2))
    axes.text(-0.375, 0.5, "slider", ha="center", fontsize=9, color=INK)
    tilts = np.radians([15.0, 33.0])
    joints = np.zeros((3, 2))
    for i, tilt in enumerate(tilts):
        joints[i + 1] = joints[i] + 3.0 * np.array([np.cos(tilt), np.sin(tilt)])
        _link(axes, joints[i], tilt)
        middle = joints[i] + 1.5 * np.array([np.cos(tilt), np.sin(tilt)])
        axes.text(
            middle[0],
            middle[1],
            f"link {i + 1}",
            ha="center",
            va="center",
            rotation=np.degrees(tilt),
            fontsize=9,
            color=INK,
        )
    for i, (x, y) in enumerate(joints):
        axes.plot(x, y, "o", ms=7, mfc="white", mec=ACCENT, mew=1.8, zorder=5)
        axes.text(
            x + (0.2 if i == 2 else 0.05),
            y - 0.4,
            f"joints[{i}]" + (" = tip" if i == 2 else ""),
            ha="left" if i == 2 else "center",
            fontsize=9,
            color=ACCENT,
        )
    previous = 0.0
    for i, tilt in enumerate(tilts):
        start, reach = joints[i], 2.1
        end = start + reach * 1.2 * np.array([np.cos(previous), np.sin(previous)])
        axes.plot(*zip(start, end, strict=True), color=INK, lw=0.8, ls=":", zorder=4)
        axes.add_patch(
            Arc(
                tuple(start),
                2 * reach,
                2 * reach,
                theta1=np.degrees(previous),
                theta2=np.degrees(tilt),
                lw=1.4,
                color=INK,
                zorder=6,
            )
        )
        bisector = previous + 0.3 * (tilt - previous)
        place = start + (reach + 0.22) * np.array([np.cos(bisector), np.sin(bisector)])
        axes.text(place[0], place[1], rf"$\alpha_{i + 1}$", ha="center", va="center", fontsize=11, color=INK, zorder=7)
        previous = tilt
    _arrow(axes, (-1.2, -0.62), (0.0, -0.62), ACCENT)
    axes.text(-1.2, -0.95, "feed: position of joints[0] on the run", fontsize=9, color=ACCENT)
    origin = (-1.0, 1.55)
    _arrow(axes, origin, (origin[0] + 0.75, origin[1]), INK)
    _arrow(axes, origin, (origin[0], origin[1] + 0.75), INK)
    axes.plot(*origin, "o", ms=8, mfc="white", mec=INK)
    axes.plot(*origin, ".", ms=4, color=INK)
    for text, dx, dy in (("z", 0.9, 0.0), ("x", 0.0, 0.9), ("y, towards you", 0.42, -0.25)):
        axes.text(origin[0] + dx, origin[1] + dy, text, ha="center", va="center", fontsize=10, color=INK)
    axes.text(
        0.45,
        2.3,
        r"$R_y(\alpha_i)\,R_x(\beta_i)$ turns link $i$ against link $i-1$;"
        "\n"
        r"$\alpha > 0$ bends towards +x, $\beta > 0$ towards −y",
        fontsize=9.5,
        color=INK,
        va="center",
    )
    figure.savefig(FOLDER / "conventions.png")


def _link(axes: Axes, start: np.ndarray, tilt: float) -> None:
    along, across = np.array([np.cos(tilt), np.sin(tilt)]), np.array([-np.sin(tilt), np.cos(tilt)])
    corners = [start + a * along + b * across for a, b in ((0.25, -0.2), (2.75, -0.2), (2.75, 0.2), (0.25, 0.2))]
    axes.add_patch(Polygon(corners, closed=True, fc=BODY, ec=INK, lw=1.2, zorder=2))
    axes.plot(*zip(start, start + 3.0 * along, strict=True), color=INK, lw=1.0, zorder=1)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    axes.add_patch(
        FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=11, lw=1.4, color=color, shrinkA=0, shrinkB=0)
    )


def feed() -> None:
    """The run, the path and the arm at three feeds; z to the right, x upwards, in mm."""
    lengths = np.full(6, 91.0)
    path = _planar([[0, 0], [230, 84], [465, -40]]).with_run(lengths.sum() / 1e3)
    figure, axes = _canvas(9.2, 5.6, (-640, 580), (-590, 152))
    run = lengths.sum()
    drawn = _flat(path.point(np.linspace(0, path.length, 400)))
    arrived = hognose.follow(path.reversed(), lengths / 1e3, [0.0])[0, -1, 2] + run / 1e3
    feeds = (0.0, 0.25, arrived)
    for row, (at, name) in enumerate(zip(feeds, ("feed 0", "under way", "arrived"), strict=True)):
        down = np.array([0.0, -235.0 * row])
        joints = _flat(hognose.follow(path, lengths / 1e3, [at])[0]) + down
        axes.plot(*(drawn + down).T, color=SOFT, lw=1.2, ls=(0, (5, 3)), zorder=1)
        for low, high in ((-170, -46), (46, 150)):
            axes.add_patch(Rectangle((-5, down[1] + low * 0.6), 10, (high - low) * 0.6, fc=SOLID, ec=INK, lw=0.8))
        axes.add_patch(Rectangle((joints[0, 0] - 60, down[1] - 22), 60, 44, fc="#e6ebf1", ec=INK, lw=1.0, zorder=3))
        _arm(axes, joints, 15.0)
        axes.text(-636, down[1] + 62, name, fontsize=10, color=INK, va="center")
        if row:
            _arrow(axes, (-run, down[1] - 48), (joints[0, 0], down[1] - 48), ACCENT)
            axes.text(-run, down[1] - 74, f"feed {1e3 * at:.0f} mm", fontsize=9, color=ACCENT, va="center")
    axes.text(-run / 2, 40, "straight run, as long as the arm", ha="center", fontsize=9, color=SOFT)
    axes.text(16, 78, "entrance", fontsize=9, color=INK)
    axes.text(215, 96, "path", fontsize=9, color=SOFT)
    axes.text(drawn[-1, 0] + 8, drawn[-1, 1] - 4, "target", fontsize=9, color=INK, va="top")
    axes.plot(*drawn[-1], "o", ms=6, mfc="white", mec=ACCENT, mew=1.6)
    figure.savefig(FOLDER / "feed.png")


def first_crossing() -> None:
    """The next joint is where the path first leaves the circle of the link's length; in mm."""
    path = _planar([[0, 0], [70, 42], [150, 10], [150, -60], [70, -62]])
    length, start = 0.091, 0.02
    figure, axes = _canvas(7.2, 5.1, (-80, 200), (-98, 100))
    drawn = _flat(path.point(np.linspace(0, path.length, 400)))
    joints = _flat(hognose.follow(path, [length], [start])[0])
    axes.plot(*drawn.T, color=SOFT, lw=1.4, ls=(0, (5, 3)), zorder=1)
    axes.add_patch(Circle(tuple(joints[0]), 1e3 * length, fill=False, ec=ACCENT, lw=1.0, zorder=1))
    _arm(axes, joints, 4.0)
    away = np.linalg.norm(drawn - joints[0], axis=1) - 1e3 * length
    later = drawn[np.flatnonzero((away[1:] * away[:-1] < 0) & (away[1:] < 0))[-1]]
    axes.plot(*later, "X", ms=9, color=SOFT)
    axes.text(joints[0, 0] - 6, joints[0, 1] + 5, "$C_i$", ha="right", fontsize=12, color=INK)
    axes.text(joints[1, 0] + 7, joints[1, 1] + 3, "$C_{i+1}$: the first crossing", fontsize=10, color=INK)
    axes.text(later[0] + 8, later[1] - 10, "a later crossing: not on this link", fontsize=9, color=SOFT)
    axes.text(-44, -50, "circle of radius $L_i$", fontsize=9, color=ACCENT)
    figure.savefig(FOLDER / "first-crossing.png")


def sagitta() -> None:
    """One link of 91 mm on a curve of 180 mm radius, joints on the path and joints beside it; in mm."""
    radius, half = 180.0, 45.5
    sag = radius - np.sqrt(radius**2 - half**2)
    figure, axes = _canvas(9.2, 2.9, (-62, 208), (-25, 60))
    turn = np.linspace(-0.31, 0.31, 100)
    for middle, lift, title, note in (
        (0.0, 0.0, "exact", "the whole sagitta,\non one side"),
        (130.0, sag / 2, "balanced", "half of it,\non both sides"),
    ):
        # Four times as high as it is, so that the sagitta can be seen.
        arc = np.column_stack([middle + radius * np.sin(turn), 4 * (radius * (np.cos(turn) - 1) + sag)])
        axes.plot(*arc.T, color=SOFT, lw=1.4, ls=(0, (5, 3)), zorder=1)
        joints = np.array([[middle - half, 4 * lift], [middle + half, 4 * lift]])
        axes.plot(*joints.T, color=INK, lw=2.0, zorder=3)
        axes.plot(*joints.T, "o", ms=7, mfc="white", mec=ACCENT, mew=1.8, zorder=4)
        _arrow(axes, (middle, 4 * lift), (middle, 4 * sag), ACCENT)
        axes.text(middle + 3, 2 * (lift + sag), f"{sag - lift:.1f} mm", fontsize=9, color=ACCENT, va="center")
        if lift:
            for x in joints[:, 0]:
                _arrow(axes, (x, 0.0), (x, 4 * lift), ACCENT)
            axes.text(joints[1, 0] + 4, 2 * lift, f"{lift:.1f} mm", fontsize=9, color=ACCENT, va="center")
        axes.text(middle, 50, title, fontsize=11, color=INK, ha="center", va="center", family="monospace")
        axes.text(middle, 35, note, fontsize=9, color=INK, ha="center", va="center")
    axes.text(
        -60, -19, "a link of 91 mm on a path of 180 mm radius; heights four times enlarged", fontsize=8, color=SOFT
    )
    figure.savefig(FOLDER / "sagitta.png")


def clearance() -> None:
    """A link at two set-points, an obstacle, and what is known of the motion between them; in mm."""
    figure, axes = _canvas(9.2, 3.7, (-25, 240), (-42, 64.5))
    obstacle = np.array([112.0, 44.0])
    axes.add_patch(Circle(tuple(obstacle), 14.0, fc=SOLID, ec=INK, lw=1.0))
    axes.text(obstacle[0], obstacle[1], "obstacle", ha="center", va="center", fontsize=8, color=INK)
    links = (np.array([[0.0, -4.0], [91.0, 0.0]]), np.array([[124.0, 1.0], [214.0, -12.0]]))
    for link, name in zip(links, ("step t", "step t + 1"), strict=True):
        _capsule(axes, link, 11.0)
        axes.text(link[:, 0].mean(), link[:, 1].mean(), name, ha="center", va="center", fontsize=9, color=INK)
    for link, name, side in zip(links, ("$d_0$", "$d_1$"), (-6, 7), strict=True):
        along = link[1] - link[0]
        part = np.clip(np.dot(obstacle - link[0], along) / np.dot(along, along), 0, 1)
        near = link[0] + part * along
        reach = obstacle - near
        size = np.linalg.norm(reach)
        start, end = near + 11.0 * reach / size, obstacle - 14.0 * reach / size
        _arrow(axes, tuple(start), tuple(end), ACCENT)
        _arrow(axes, tuple(end), tuple(start), ACCENT)
        axes.text(
            (start[0] + end[0]) / 2 + side, (start[1] + end[1]) / 2 + 2, name, fontsize=11, color=ACCENT, ha="center"
        )
    _arrow(axes, (0.0, -28.0), (124.0, -28.0), INK)
    axes.text(62, -35, "no point moves farther than $m$", fontsize=9, color=INK, ha="center", va="center")
    axes.text(
        -22,
        46,
        r"in between: clearance $\geq (d_0 + d_1 - m)\,/\,2$;"
        "\nsteps are halved until this is close to what was seen",
        fontsize=10,
        color=INK,
        va="center",
    )
    figure.savefig(FOLDER / "clearance.png")


def _canvas(width: float, height: float, across: tuple[float, float], up: tuple[float, float]) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), dpi=150)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(*across)
    axes.set_ylim(*up)
    return figure, axes


def _planar(points: list[list[float]]) -> hognose.Path:
    """A path in the x–z plane through points (z, x) in mm that starts along z."""
    return hognose.Path.through([[x / 1e3, 0, z / 1e3] for z, x in points], 3, (0, 0, 1))


def _flat(points: np.ndarray) -> np.ndarray:
    return 1e3 * points[..., [2, 0]]


def _arm(axes: Axes, joints: np.ndarray, radius: float) -> None:
    for start, end in pairwise(joints):
        _capsule(axes, np.stack([start, end]), radius)
    axes.plot(*joints.T, "o", ms=4.5, mfc="white", mec=ACCENT, mew=1.3, zorder=5)


def _capsule(axes: Axes, link: np.ndarray, radius: float) -> None:
    """A link's body: everything within a radius of the line between its joints."""
    along = (link[1] - link[0]) / np.linalg.norm(link[1] - link[0])
    heading = np.arctan2(along[1], along[0])
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 30) + heading
    cap = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    outline = np.concatenate([link[0] + cap, link[1] - cap])
    axes.add_patch(Polygon(outline, closed=True, fc=BODY, ec=INK, lw=1.0, zorder=2))


def cases() -> None:
    """The bundled tasks at the instants of their reports."""
    from hognose.report.figures import instants

    other_arms = ("test-box", "pipe-jungle", "engine-stage", "feeder-slot", "baffled-tank")
    for name in ("obstacle-array", "pipe-tank", "step-tank", "find-a-way", *other_arms):
        plan = hognose.plan(hognose.load_task(name))
        instants(plan, plan.task.spec.report.times_s).savefig(FOLDER / f"{name}.png")


def partial() -> None:
    """The boiler with a second manhole that is too narrow: how far the arm gets."""
    from hognose.planning import Task
    from hognose.report.figures import instants

    task = hognose.load_task("find-a-way")
    narrow = [item.model_dump() for item in task.spec.obstacle]
    narrow[2]["hole"][0]["diameter"] = 0.052
    spec = type(task.spec).model_validate({**task.spec.model_dump(by_alias=True), "obstacle": narrow})
    try:
        hognose.plan(Task(spec, task.robot))
    except hognose.InfeasibleError as error:
        instants(error.plan, [20, float(error.plan.time[-1])]).savefig(FOLDER / "find-a-way-partial.png")
    else:
        raise RuntimeError("the boiler with the narrow manhole has a route: the page says that there is none")


def scan() -> None:
    """A laser scan of a wall with a hole and a tube behind it, every point a ball, and an arm that goes through."""
    from hognose.report.figures import instants

    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-250, 250, (9000, 2)), 300 + rng.normal(size=9000)])
    wall = wall[np.hypot(wall[:, 0] - 40, wall[:, 1] - 60) > 75]
    turn, along = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(-250, 250, 3000)
    tube = np.column_stack([along, 40 * np.cos(turn) - 40, 40 * np.sin(turn) + 560])
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(Path(folder) / "scan.xyz", np.concatenate([wall, tube]), fmt="%.2f")
        (Path(folder) / "scan.toml").write_text(
            'name = "scan"\nunits = "mm"\nrobot = "sjtu-25dof"\n[path]\n'
            "way_points = [[0, 0, 0], [40, 60, 300], [-20, 100, 560], [-40, 20, 900]]\n"
            '[[obstacle]]\nkind = "points"\nfile = "scan.xyz"\nunits = "mm"\ndiameter = 8\n'
        )
        plan = hognose.plan(hognose.load_task(Path(folder) / "scan.toml"))
    instants(plan, [15, 38]).savefig(FOLDER / "laser-scan.png")


def insertion() -> None:
    """The arm going into the pipe tank, as the README shows it."""
    from hognose.report.animation import animate

    plan = hognose.plan(hognose.load_task("pipe-tank"))
    animate(plan, FOLDER / "insertion.gif", frames=48, fps=12, size=(800, 400))


def mechanics() -> None:
    """Tensions, load factor and sag of the obstacle array."""
    from hognose.planning.loads import loads
    from hognose.report import mechanics

    figure = mechanics.mechanics(loads(hognose.plan(hognose.load_task("obstacle-array"))))
    figure.savefig(FOLDER / "mechanics.png", dpi=130)


DRAWINGS = {
    drawing.__name__.replace("_", "-"): drawing
    for drawing in (conventions, feed, first_crossing, sagitta, clearance, cases, partial, scan, insertion, mechanics)
}

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    wanted = sys.argv[1:] or list(DRAWINGS)
    if unknown := set(wanted) - set(DRAWINGS):
        sys.exit(f"no such picture: {', '.join(sorted(unknown))}; there are {', '.join(DRAWINGS)}")
    for name in wanted:
        DRAWINGS[name]()
