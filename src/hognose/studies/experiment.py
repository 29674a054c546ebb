"""The experiments of the paper (section 5) on the twin: both cases, and one board that stands elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from matplotlib.figure import Figure

import hognose
from hognose.errors import InputError
from hognose.planning import Plan
from hognose.report.animation import Film, gif
from hognose.report.figures import instants
from hognose.report.style import png
from hognose.report.tip_camera import tip_pictures
from hognose.sim import Simulated, simulate
from hognose.studies.charts import body_errors, run_over_time, tip_off_path
from hognose.studies.pictures import instants_of
from hognose.studies.reached import reached
from hognose.studies.shifts import Shifted, shifted_runs

Rows = list[tuple[str, ...]]
Say = Callable[[str], None]

#: The cases of the paper, and the figure there that shows each on the prototype.
CASES = {"obstacle-array": "figure 12", "pipe-tank": "figure 13"}
#: What is shifted, along what, how far (m), and the force (N) at which motors hold, if they do.
BOARD, UP, SHIFTS, HELD_AT = "board 2", (0.0, 1.0, 0.0), (0.0, 0.020, 0.030, 0.035, 0.045), 5.0
#: The shift (m) whose run is shown as well.
SHOWN = 0.045
#: The paper's tip error in the pipe tank, simulated, m and m² (table 3): with interpolation, and without.
PAPER_RMSE, PAPER_RMSE_PLAIN, PAPER_VARIANCE = 0.2429e-3, 0.4674e-3, 0.0107e-6
#: Frames, and width and height of the videos for the page; colours of its pictures.
_FRAMES, _SIZE, _COLOURS = 36, (720, 405), 200


@dataclass(frozen=True, eq=False)
class Run:
    """A case on the twin: what it did, and the motion that it reached."""

    name: str
    done: Simulated
    motion: Plan

    @classmethod
    def of(cls, name: str) -> Run:
        """A bundled case, planned and simulated."""
        done = simulate(hognose.plan(hognose.load_task(name)))
        return cls(name, done, reached(done))

    def pictures(self) -> dict[str, bytes]:
        """The arm at four instants, what its tip saw then, the run over time and the video, by ending of the file."""
        times = instants_of(self.motion)
        return {
            ".png": small_png(instants(self.motion, times)),
            "-tip.png": png(tip_pictures(self.motion, times)),
            "-errors.png": small_png(run_over_time(self.done, self.motion)),
            ".gif": gif(self.motion, Film(_FRAMES, 6, _SIZE, shows="both")),
        }


def small_png(figure: Figure) -> bytes:
    """A figure as PNG of a few hundred colours, which is less than half as large."""
    from PIL import Image

    stream = BytesIO()
    with Image.open(BytesIO(png(figure))) as image:
        few = image.convert("RGB").quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(stream, format="PNG", optimize=True)
    return stream.getvalue()


def shifted(run: Run, progress: Callable[[int, int], None]) -> list[Shifted]:
    """The runs with the board shifted; an InputError if the case has none."""
    if BOARD not in run.done.plan.task.scene.names:
        raise InputError(f"{run.name}: there is no {BOARD!r} to shift")
    return shifted_runs(run.done.plan, BOARD, UP, SHIFTS, HELD_AT, progress)


def shown_shift(runs: Sequence[Shifted]) -> bytes:
    """The arm at four instants among shifted boards."""
    [run] = [each for each in runs if each.shift == SHOWN]
    motion = reached(run.done)
    return small_png(instants(motion, instants_of(motion)))


def paper_rows(runs: Sequence[Run]) -> Rows:
    """What the paper says of its cases beside what came out here; of both in its order."""
    boards, tank = runs
    planned, twin = tank.done.plan.tip_error, tank.done.tip_errors
    return [
        ("steps, obstacle array", "312", f"{len(boards.done.plan.time) - 1}", f"{len(boards.motion.time) - 1}"),
        ("steps, pipe tank", "303", f"{len(tank.done.plan.time) - 1}", f"{len(tank.motion.time) - 1}"),
        (
            "tip error, pipe tank, RMSE (mm)",
            f"{1e3 * PAPER_RMSE:.4f}; {1e3 * PAPER_RMSE_PLAIN:.4f} without interpolation",
            _small(1e3 * _rms(planned)),
            _small(1e3 * _rms(twin)),
        ),
        ("tip error, pipe tank, variance (mm²)", f"{1e6 * PAPER_VARIANCE:.4f}", _small(1e6 * planned.var()),
         _small(1e6 * twin.var())),
        ("both reach the target without contact", "yes, on the prototype",
         _yes(all(run.done.plan.good for run in runs)), _yes(all(run.done.good for run in runs))),
    ]  # fmt: skip


def error_rows(runs: Sequence[Run]) -> Rows:
    """What the twin's errors are in each case, a row a figure."""
    found: Rows = []
    for words, of in (
        ("tip off its plan, RMS (mm)", lambda run: _mm(_rms(run.done.tip_errors))),
        ("tip off its plan, largest (mm)", lambda run: _mm(run.done.tip_errors.max())),
        ("joints off their plan, RMS (deg)", lambda run: f"{np.degrees(_rms(_joint_errors(run.done))):.4f}"),
        ("tip off the path, largest (mm)", lambda run: _mm(tip_off_path(run.motion).max())),
        ("a joint off its plan, largest (mm)", lambda run: _mm(body_errors(run.done).max())),
        ("body off the path as planned, largest (mm)", lambda run: _mm(run.done.plan.body_deviation.max())),
        ("body off the path as reached, largest (mm)", lambda run: _mm(run.motion.body_deviation.max())),
        ("smallest clearance as planned (mm)", lambda run: f"{1e3 * run.done.plan.clearance.min():.2f}"),
        ("smallest clearance as reached (mm)", lambda run: f"{1e3 * run.motion.clearance.min():.2f}"),
        ("tensions (N)", lambda run: f"{run.done.lowest_tensions.min():.1f} to {run.done.highest_tensions.max():.1f}"),
        ("contact (N)", lambda run: f"{run.done.contact.max():.1f}"),
        ("ended", lambda run: run.done.stopped or "at the target"),
    ):
        found.append((words, *(of(run) for run in runs)))
    return found


def shift_rows(runs: Sequence[Shifted]) -> Rows:
    """Shift, first contact, largest force, tip error (RMS, largest, last), and how it ended: a row a shift."""
    rows: Rows = []
    for run in runs:
        first, errors = run.done.first_contact, run.done.tip_errors
        when = ("none", "") if first is None else (f"{first:.2f}", f"{run.done.contact.max():.0f}")
        off = (f"{1e3 * _rms(errors):.2f}", f"{1e3 * errors.max():.2f}", f"{1e3 * errors[-1]:.2f}")
        ended = run.done.stopped.split(": the smallest")[0] or "at the target"
        rows.append((f"{1e3 * run.shift:.0f}", *when, *off, ended))
    return rows


def stop_rows(runs: Sequence[Shifted]) -> Rows:
    """Shift, when and where motors held, force then, largest and left, and tip error: a row a shift that stopped it."""
    rows: Rows = []
    for run in runs:
        stop = None if run.held is None else run.held.contact_stop
        if stop is None:
            continue
        forces = (f"{stop.force:.1f}", f"{stop.peak:.1f}", f"{stop.remaining:.1f}")
        where = (f"{1e3 * run.shift:.0f}", f"{stop.time:.2f}", str(stop.link + 1))
        rows.append((*where, *forces, f"{1e3 * stop.tip_error:.2f}"))
    return rows


def _joint_errors(done: Simulated) -> np.ndarray:
    """By how much (P, n, 2) rad angles are not what they are planned to be."""
    return done.angles - done.commanded


def _rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def _mm(length: float) -> str:
    return f"{1e3 * length:.3f}"


def _small(value: float) -> str:
    return f"{value:.4f}" if value >= 1e-4 else "< 0.0001"


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"
