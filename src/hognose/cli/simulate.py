"""`hognose simulate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    from hognose.sim import Simulated


def simulate(
    plan: PlanOrTask,
    /,
    *,
    stiffness: float = 1.0,
    mass: float = 1.0,
    shift: Annotated[tuple[tuple[str, float, float, float], ...], Parameter(negative="")] = (),
    video: Path | None = None,
    camera: Path | None = None,
    json: Flag = False,
) -> int:
    """Move a twin of the arm through a plan: cables that only pull, weight, and contact, integrated by MuJoCo.

    The exit code is 1 if the twin was stopped, because the arm buckled or an axis crossed a surface, or if it touched
    something. Values of the cables that are assumed are marked in the robot file.

    Parameters
    ----------
    stiffness
        Factor of the cables' EA, against what was planned with.
    mass
        Factor of all masses.
    shift
        An obstacle that stands elsewhere: its name, and how far along x, y and z in mm.
    video
        Write the arm on its way, with what a camera on its tip sees, into this file: .gif, or .mp4 if imageio-ffmpeg
        is installed.
    camera
        Write what a camera on the tip sees into this file: .png at the instants of the task, .gif or .mp4 all the way.
    json
        Print the figures as JSON, in SI units.
    """
    from hognose.cli.console import counting, plan_of, say, say_json
    from hognose.sim import Changes
    from hognose.sim import simulate as simulated

    if video is not None or camera is not None:
        from hognose.studies.pictures import refuse_names

        refuse_names(video, camera)
    found = plan_of(plan, json)
    changes = Changes(stiffness, mass, None, {name: (x / 1e3, y / 1e3, z / 1e3) for name, x, y, z in shift})
    with counting(f"simulating {found.task.name}", json) as progress:
        done = simulated(found, changes, progress)
    files: list[str] = []
    if video is not None or camera is not None:
        from hognose.studies.pictures import write_pictures

        with counting("drawing", json) as progress:
            files = [str(file) for file in write_pictures(done, video, camera, progress)]
    good = not done.stopped and not done.touched
    if json:
        say_json({"good": good, **done.to_json(), **({"files": files} if files else {})})
    else:
        say(_summary(done, good))
        for file in files:
            say(f"{file}: {Path(file).stat().st_size / 1e3:.0f} kB")
    return 0 if good else 1


def _summary(done: Simulated, good: bool) -> str:
    told = done.to_json()
    off = 1e3 * done.tip_errors
    lines = [
        f"{done.plan.task.name}: {len(done.angles) - 1} of {len(done.plan.time) - 1} periods, "
        f"{told['real_time_factor']:.0f} x real time",
        f"tip off the plan by {(off**2).mean() ** 0.5:.3f} mm in root mean square, {off.max():.3f} mm at most",
        f"tensions {done.tensions.min():.1f} to {done.tensions.max():.1f} N",
    ]
    if done.touched:
        lines.append(f"touched {', '.join(done.touched)} with up to {done.contact.max():.1f} N")
    lines.append(f"{'GOOD' if good else 'NOT GOOD'}: {done.stopped or ('contact' if done.touched else 'to the end')}")
    return "\n".join(lines)
