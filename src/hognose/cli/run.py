"""`hognose run`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from hognose.cli.options import Flag, PlanOrTask


def run(
    plan: PlanOrTask,
    /,
    *,
    network: Path | None = None,
    emulated: Flag = False,
    without_twin: Flag = False,
    fast: Flag = False,
    speed: float = 100.0,
    until: float | None = None,
    back: Flag = False,
    resume: Flag = False,
    step: Flag = False,
    release: Flag = False,
    record: Path | None = None,
    fault: Annotated[tuple[str, ...], Parameter(negative="")] = (),
    foxglove: int | None = None,
    yes: Flag = False,
    json: Flag = False,
) -> int:
    """Move an arm through a plan, on its drives over CAN; or emulated drives, which move its twin.

    Ctrl-C comes to rest along the path, and asks what then; twice, it stops all axes at once. Exit code 1 says that
    anything stopped it.

    Parameters
    ----------
    network
        The network file of the drives; with --emulated, of those that are emulated.
    emulated
        Drives that are emulated, as a process of their own, and move the twin of the arm.
    without_twin
        Emulated motors move nothing; MuJoCo is not needed.
    fast
        Emulated drives in this program, in no more time than it takes to compute.
    speed
        In per cent of the plan's own, up to 100.
    until
        The step to stop at, instead of the last one.
    back
        Go back again on the same way, to step 0.
    resume
        The arm stands somewhere along the plan, after a stop or a crash: go on from there, or back with --back.
    step
        Pause at every step, and ask.
    release
        Back at step 0, pay out all cables and take the drives' power: the arm must lie then, or be in its jig.
    record
        The record to write (.mcap); by default the plan's name with date and time, in this folder.
    fault
        Make an emulated drive fail, as NODE:KIND:STEP, such as 9:overcurrent:20; may be given several times.
    foxglove
        Show the run live in Foxglove, from this port (8765 is usual). It has no token: every program, and every page in
        a browser of this machine, can read along. Nobody can ask for anything there.
    yes
        Do not ask before drives get power, and before the arm moves; a pause is the end then.
    json
        Print what was commanded, reached and recorded, in SI units.
    """
    from hognose.cli.operate import Asked, operate

    drives = (network, emulated, not without_twin, fast)
    return operate(Asked(plan, drives, (until, back, resume, step, release), speed, record, fault, foxglove, yes, json))
