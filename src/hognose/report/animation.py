"""The motion of a plan as a moving picture: GIF anywhere, MP4 where ffmpeg's package is installed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.typing import NDArray

from hognose.errors import InputError, MissingExtraError
from hognose.report.canvas import HALO, draw_marks, draw_step, prepare
from hognose.report.style import FAINT, HEAD, INK, LINKS, PATH, POINT, TIP, new_figure, rgb
from hognose.report.tip_camera import tip_picture
from hognose.wording import at_least_mm
from hognose.write_whole import write_whole

if TYPE_CHECKING:
    from PIL.Image import Image

    from hognose.planning.plan import Plan
    from hognose.report.camera import Camera

Progress = Callable[[int, int], None]
Pixels = NDArray[np.uint8]
#: The arm in its space, what the camera on its tip sees, or both: the latter in a corner of the former.
Shows = Literal["arm", "camera", "both"]

#: How long the last frame stands before the picture starts again, ms.
_REST = 1200
#: How many colours a GIF has of the arm in its space, besides its accents, and how many of what the camera sees.
_COLOURS, _SHADES = 96, 144
#: In how many frames those are looked for.
_LOOKED_AT, _SHADES_IN = 3, 12
_DPI = 120.0
#: Share of the width that the tip's camera gets in a corner, and of the width and height that is left free beside it.
_CORNER, _BESIDE = 0.235, (0.016, 0.10)


@dataclass(frozen=True)
class Film:
    """How a motion is shown.

    Attributes
    ----------
    frames
        How many, spread evenly over the plan; no more than it has steps.
    fps
        Frames a second; a GIF keeps its times in hundredths of a second.
    size
        Width and height, pixels; an MP4's are rounded down to even numbers.
    camera
        Where to look from; without it one that sees the whole motion.
    shows
        ``"arm"``, ``"camera"`` for what the camera on its tip sees, or ``"both"``: that in a corner.
    """

    frames: int = 90
    fps: float = 15
    size: tuple[int, int] = (960, 540)
    camera: Camera | None = None
    shows: Shows = "arm"

    def steps(self, plan: Plan) -> list[int]:
        """The steps of a plan that are shown; an InputError if a number cannot be."""
        if self.frames < 1:
            raise InputError(f"frames = {self.frames}: a moving picture has at least one.")
        if not 0 < self.fps <= 50:
            raise InputError(f"fps = {self.fps:g}: take more than 0 and at most 50 frames a second.")
        if min(self.size) < 64:
            raise InputError(f"size = {self.size[0]} × {self.size[1]} pixels: take at least 64 each way.")
        last = len(plan.time) - 1
        return [int(step) for step in np.linspace(0, last, min(self.frames, last + 1)).round()]

    def drawn(self, plan: Plan, progress: Progress | None) -> Iterator[Pixels]:
        """The pictures (height, width, 3); what was drawn of how many is told after each."""
        steps = self.steps(plan)
        return _counted(self.some(plan, steps), len(steps), progress)

    def some(self, plan: Plan, steps: Iterable[int]) -> Iterator[Pixels]:
        """The pictures (height, width, 3) of some steps."""
        if self.shows == "camera":
            return (tip_picture(plan, step, self.size) for step in steps)
        return drawn_frames(plan, steps, self.size, self.camera, tip=self.shows == "both")


def animate(
    plan: Plan,
    path: Path | str,
    *,
    frames: int = 90,
    fps: float = 15,
    size: tuple[int, int] = (960, 540),
    camera: Camera | None = None,
    shows: Shows = "arm",
    progress: Progress | None = None,
) -> Path:
    """Write the motion of a plan as a moving picture.

    Parameters
    ----------
    plan
    path
        Ends in ``.gif`` or ``.mp4``. Nothing is written before all is drawn.
    frames, fps, size, camera, shows
        As of `Film`.
    progress
        Called with the number of frames done and the number of all.

    Returns
    -------
    path
        The file written.

    Raises
    ------
    InputError
        If the file's ending, the number of frames, their rate or their size cannot be.
    MissingExtraError
        If an MP4 is asked for and ``imageio-ffmpeg`` is not installed.
    """
    path = Path(path)
    make = {".gif": gif, ".mp4": mp4}[check_name(path)]
    write_whole(path, make(plan, Film(frames, fps, size, camera, shows), progress))
    return path


def check_name(path: Path) -> str:
    """The ending of a moving picture's name; errors as of `animate`, if it cannot be written."""
    ending = path.suffix.lower()
    if ending not in (".gif", ".mp4"):
        raise InputError(f"{path}: a moving picture ends in .gif or .mp4, not {path.suffix or 'in nothing'!r}.")
    if ending == ".mp4":
        _ffmpeg()
    return ending


def gif(plan: Plan, film: Film | None = None, progress: Progress | None = None) -> bytes:
    """Return the motion of a plan as the bytes of a GIF that repeats; errors as of `animate`."""
    from PIL import Image

    film = film or Film()
    steps = film.steps(plan)
    palette = _palette(_colours_of(film, plan, steps))
    pictures = [
        Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        for pixels in film.drawn(plan, progress)
    ]
    pause = max(2, round(100 / film.fps)) * 10
    stream = BytesIO()
    pictures[0].save(
        stream,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=[pause] * (len(pictures) - 1) + [_REST],
        loop=0,
        optimize=False,
    )
    return stream.getvalue()


def mp4(plan: Plan, film: Film | None = None, progress: Progress | None = None) -> bytes:
    """Return the motion of a plan as the bytes of an MP4 (H.264); errors as of `animate`."""
    ffmpeg = _ffmpeg()
    film = film or Film()
    film = replace(film, size=(film.size[0] // 2 * 2, film.size[1] // 2 * 2))
    pictures = film.drawn(plan, progress)
    with tempfile.TemporaryDirectory() as folder:
        aside = Path(folder) / "motion.mp4"
        writer = ffmpeg.write_frames(str(aside), film.size, fps=film.fps, macro_block_size=2, quality=7)
        writer.send(None)
        try:
            for pixels in pictures:
                writer.send(np.ascontiguousarray(pixels))
        finally:
            writer.close()
        return aside.read_bytes()


def _ffmpeg() -> Any:
    try:
        return import_module("imageio_ffmpeg")
    except ImportError:
        raise MissingExtraError(
            "An MP4 needs the package imageio-ffmpeg: pip install 'hognose[sim]'. A GIF needs nothing more."
        ) from None


def drawn_frames(
    plan: Plan, steps: Iterable[int], size: tuple[int, int], camera: Camera | None = None, *, tip: bool = False
) -> Iterator[Pixels]:
    """Yield the picture (height, width, 3) of each step; what does not move is prepared once.

    With `tip`, what the camera on the tip sees is laid into a corner.
    """
    figure = new_figure(size[0] / _DPI, size[1] / _DPI, _DPI)
    axes = figure.add_axes((0, 0, 1, 1))
    stage = prepare(axes, plan, camera=camera)
    draw_marks(axes, stage, plan)
    words = axes.text(0.015, 0.975, "", transform=axes.transAxes, fontsize=HEAD, color=INK, va="top", zorder=9)
    words.set_path_effects(HALO)
    canvas = FigureCanvasAgg(figure)
    for step in steps:
        artists = draw_step(axes, stage, plan, step)
        words.set_text(caption(plan, step))
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].copy()
        if tip:
            _lay_into_corner(pixels, tip_picture(plan, step, _corner_size(size)))
        yield pixels
        for artist in artists:
            artist.remove()


def _corner_size(size: tuple[int, int]) -> tuple[int, int]:
    wide = round(_CORNER * size[0])
    return wide, round(0.75 * wide)


def _lay_into_corner(pixels: Pixels, inset: Pixels) -> None:
    """Lay a small picture into the upper left of a large one, below its caption, in place."""
    top, left = round(_BESIDE[1] * pixels.shape[0]), round(_BESIDE[0] * pixels.shape[1])
    height, width = inset.shape[:2]
    pixels[top - 1 : top + height + 1, left - 1 : left + width + 1] = np.round(255 * rgb([FAINT])[0])
    pixels[top : top + height, left : left + width] = inset


def caption(plan: Plan, step: int) -> str:
    """Return what is written into a frame: the time, the feed, and the smallest clearance at that step."""
    least, horizon = float(plan.clearance[step].min()), plan.horizon
    near = f"≥ {horizon * 1e3:g}" if least >= horizon else at_least_mm(least, 1)
    return f"t = {plan.time[step]:.1f} s    feed {plan.feed[step] * 1e3:.0f} mm    clearance {near} mm"


def _counted(pictures: Iterable[Pixels], total: int, progress: Progress | None) -> Iterator[Pixels]:
    for done, pixels in enumerate(pictures, start=1):
        yield pixels
        if progress is not None:
            progress(done, total)


def _colours_of(film: Film, plan: Plan, steps: Sequence[int]) -> NDArray[np.int_]:
    """Return the colours (k, 3) that are frequent in some frames; the camera's dark ones are looked for apart."""
    last, found = len(steps) - 1, []
    few, more = (
        [steps[min(k * len(steps) // (count - 1), last)] for k in range(count)] for count in (_LOOKED_AT, _SHADES_IN)
    )
    if film.shows != "camera":
        found.append(_frequent(replace(film, shows="arm").some(plan, few), _COLOURS))
    if film.shows != "arm":
        colours = _SHADES if found else _SHADES + _COLOURS
        found.append(_frequent((tip_picture(plan, step, _corner_size(film.size)) for step in more), colours, 8))
    return np.concatenate(found)


def _frequent(pictures: Iterable[Pixels], colours: int, rounds: int = 0) -> NDArray[np.int_]:
    """Return colours (k, 3) that pictures have, drawn closer to theirs in some rounds."""
    from PIL import Image

    together = Image.fromarray(np.concatenate(list(pictures)))
    found = together.quantize(colours, method=Image.Quantize.MEDIANCUT, kmeans=rounds, dither=Image.Dither.NONE)
    return np.reshape(found.getpalette() or [], (-1, 3))[:colours]


def _palette(others: NDArray[np.int_]) -> Image:
    """Return one set of colours for all frames, so that what stands still stays the same to the bit.

    The few bright accents cover too few pixels to be found; they are set beforehand.
    """
    from PIL import Image

    accents = np.round(rgb(["white", INK, PATH, POINT, TIP, *LINKS]) * 255).astype(int)
    apart = np.abs(others[:, None] - accents).max(axis=2).min(axis=1) > 8
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([accents, others[apart]]).ravel().tolist())
    return palette
