"""`hognose report`."""

from __future__ import annotations

from pathlib import Path

from hognose.cli.options import Flag, OptionalOutput, PlanOrTask


def report(
    plan: PlanOrTask,
    /,
    *,
    output: OptionalOutput = None,
    animation: bool = True,
    video: Path | None = None,
    json: Flag = False,
) -> int:
    """Write one HTML page with the verdict, figures and an animation of a plan.

    Parameters
    ----------
    output
        The page to write; by default, the name of the plan with .html, in the current folder.
    animation
        Include an animation in the page.
    video
        Also write the animation to this file: .gif, or .mp4 if imageio-ffmpeg is installed.
    json
        Print the names of the written files as JSON.
    """
    from hognose.cli.console import counting, output_file, plan_of, say, say_json
    from hognose.report.animation import animate
    from hognose.report.report import write_report

    page = output_file(output, plan, ".html")
    loaded = plan_of(plan, json)
    with counting("drawing", json) as progress:
        written = write_report(
            loaded,
            page,
            times=loaded.task.spec.report.times_s or None,
            animation=animation,
            progress=progress,
        )
        if video is not None:
            written.append(animate(loaded, video, progress=progress))
    if json:
        say_json({"good": loaded.good, "files": [str(file) for file in written]})
    else:
        for file in written:
            say(f"{file}: {file.stat().st_size / 1e3:.0f} kB")
        if not loaded.good:
            say(loaded.summary())
    return 0 if loaded.good else 1
