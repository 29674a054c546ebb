"""Pictures of what the twin reached: the arm at chosen instants, what its tip saw, and both as moving pictures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hognose.errors import InputError
from hognose.planning import Plan
from hognose.report.animation import animate, check_name
from hognose.report.style import png
from hognose.report.tip_camera import tip_pictures
from hognose.sim import Simulated
from hognose.studies.reached import reached
from hognose.write_whole import write_whole

Progress = Callable[[int, int], None]
#: Width and height of the moving picture of the camera, pixels.
_CAMERA = (480, 360)


def instants_of(motion: Plan) -> list[float] | None:
    """The instants (s) that the task wants shown, as far as the motion came, and where it ended if it came no further.

    None if the task names none: then four are spread evenly.
    """
    wanted, end = motion.task.spec.report.times_s, float(motion.time[-1])
    if not wanted:
        return None
    within = [time for time in wanted if time <= end]
    return within if len(within) == len(wanted) else [*within, end]


def refuse_names(video: Path | None, camera: Path | None) -> None:
    """Raise an InputError, before anything is computed, if a file cannot be written: by its ending or its folder.

    An MP4 without its package is a MissingExtraError.
    """
    if video is not None:
        check_name(video)
    if camera is not None and camera.suffix.lower() != ".png":
        try:
            check_name(camera)
        except InputError:
            raise InputError(
                f"{camera}: the camera's picture ends in .png (at the instants of the task), .gif or .mp4 (all the way)"
            ) from None
    for file in (video, camera):
        if file is not None and not file.parent.is_dir():
            raise InputError(f"{file}: cannot write: there is no folder {file.parent}; make it first")


def write_pictures(
    done: Simulated, video: Path | None, camera: Path | None, progress: Progress | None = None
) -> list[Path]:
    """Write what the twin reached as a video, and what its tip saw, where files are given; returns those.

    Parameters
    ----------
    done
    video, camera
        As of `write_video` and `write_camera`.
    progress
        Called with the frames that are done, and how many there are.
    """
    motion, written = reached(done), []
    if video is not None:
        written.append(write_video(motion, video, progress))
    if camera is not None:
        written.append(write_camera(motion, camera, progress))
    return written


def write_video(motion: Plan, file: Path, progress: Progress | None = None) -> Path:
    """Write the arm on its way, with what its tip sees in a corner, as .gif or .mp4; errors as of `animate`."""
    return animate(motion, file, shows="both", progress=progress)


def write_camera(motion: Plan, file: Path, progress: Progress | None = None) -> Path:
    """Write what the camera on the tip sees: as .png at the instants of the task, as .gif or .mp4 the whole way."""
    if file.suffix.lower() == ".png":
        write_whole(file, png(tip_pictures(motion, instants_of(motion))))
        return file
    return animate(motion, file, shows="camera", size=_CAMERA, progress=progress)
