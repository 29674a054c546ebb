"""`hognose run`."""

from __future__ import annotations

from pathlib import Path

from hognose.cli.options import Flag, PlanOrTask, Several


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
    fault: Several = (),
    foxglove: int | None = None,
    yes: Flag = False,
    json: Flag = False,
) -> int:
    """Move an arm through a plan on its drives over CAN, or on emulated ones. Ctrl-C pauses and asks; twice, it stops.

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
        The step to stop at, not the last one.
    back
        Go back again on the same way, to step 0.
    resume
        The arm stands along the plan, after a stop or a crash: go on from there, or back with --back.
    step
        Pause at every step, and ask.
    release
        Back at step 0, pay out all cables and take the drives' power: the arm must lie then, or be in its jig.
    record
        The record to write (.mcap); by default the plan's name with date and time, in this folder.
    fault
        Make an emulated drive fail, as NODE:KIND:STEP, such as 9:overcurrent:20; may be given several times.
    foxglove
        Show the run live in Foxglove, from this port (8765 is usual). It has no token: all on this machine can read it.
    yes
        Do not ask before drives get power, and before the arm moves; a pause is the end then.
    json
        Print what was commanded, reached and recorded, in SI units.
    """
    from hognose.cli.operate import Asked, operate

    asked = (network, emulated, not without_twin, fast), (until, back, resume, step, release), speed, record, fault
    return operate(Asked(plan, *asked, foxglove, yes, json))
