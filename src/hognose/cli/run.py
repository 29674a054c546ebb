"""`hognose run`."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    from hognose.drive.bus import Bus
    from hognose.drive.clock import Clock
    from hognose.drive.executor import Executor
    from hognose.drive.network import Network
    from hognose.drive.record import RecordWriter
    from hognose.planning import Plan

#: What a person types for the arm to move.
_YES = "yes"


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
    record: Path | None = None,
    yes: Flag = False,
    json: Flag = False,
) -> int:
    """Move an arm through a plan, on its drives over CAN; or emulated drives, which move its twin.

    Ctrl-C comes to rest along the path; twice, it stops all axes at once. Exit code 1 says that anything stopped it.

    Parameters
    ----------
    network
        The network file of the drives.
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
    record
        The record to write (.mcap); by default the plan's name with date and time, in this folder.
    yes
        Do not ask before the arm moves.
    json
        Print what was commanded, reached and recorded, in SI units.
    """
    from hognose.cli.console import plan_of, say, say_json

    file = record or Path(f"{Path(plan).stem}-{datetime.now():%Y%m%d-%H%M%S}.mcap")
    with ExitStack() as stack:
        made = plan_of(plan, json)
        drives, bus, clock = _opened(stack, made, network, emulated, not without_twin, fast)
        executor, writer = _executor(stack, made, drives, bus, clock, (file, speed, not without_twin, json))
        told = _go(executor, until, back, resume, _asked(yes, made, drives))
        writer.close(told["verdict"])
    told["record"] = str(file)
    if json:
        say_json(told)
    else:
        say(f"{file}: `hognose log {file}` reads it\n{told['verdict']}")
    return 0 if told["good"] else 1


def _opened(
    stack: ExitStack, plan: Plan, network: Path | None, emulated: bool, twin: bool, fast: bool
) -> tuple[Network, Bus, Clock]:
    """The drives that were asked for."""
    from hognose.errors import InputError

    if emulated == (network is not None):
        raise InputError(
            "give either --network FILE, for drives that are there, or --emulated; "
            + ("both are given" if emulated else "neither is given")
        )
    if emulated:
        from hognose.studies.rehearsal import emulated as rehearsed

        return rehearsed(stack, plan, twin, fast)
    if fast:
        raise InputError("--fast goes with --emulated: drives that are there take their time")
    from hognose.drive.buses import opened
    from hognose.drive.clock import RealClock
    from hognose.drive.network import load_network
    from hognose.drive.network_spec import EMULATED

    assert network is not None, "one of both"
    found = load_network(network)
    real = [bus.interface for bus in found.spec.buses if bus.interface != EMULATED]
    if real:
        raise InputError(
            f"{network}: bus.interface {real[0]!r}: this version commands emulated drives only, on "
            f"the bus {EMULATED!r} of `hognose emulate`; docs/connect.md says why"
        )
    bus = opened(found)
    stack.callback(bus.close)
    return found, bus, RealClock()


def _executor(
    stack: ExitStack, plan: Plan, network: Network, bus: Bus, clock: Clock, given: tuple[Path, float, bool, bool]
) -> tuple[Executor, RecordWriter]:
    """The executor, which records what it does and says it; and its record."""
    from hognose.cli.console import say
    from hognose.drive.executor import Executor, Settings
    from hognose.drive.record import RecordWriter
    from hognose.drive.recorder import Recorder
    from hognose.errors import InputError

    file, speed, watches, quiet = given
    if not 0.0 < speed <= 100.0:
        raise InputError(f"speed: expected per cent of the plan's own, above 0 and up to 100, got {speed:g}")
    recorder = Recorder(clock)

    def said(kind: str, words: str, axis: int | None) -> None:
        recorder.event(kind, words, axis)
        if not quiet:
            say(f"{kind.upper():>8}  {words}")

    executor = Executor(
        plan, network, bus, clock, Settings(0.01 * speed, watches_tension=watches), recorder.cycle, said
    )
    content = network.spec.model_dump(mode="json", by_alias=True)
    writer = RecordWriter(file, plan, content, datetime.now().astimezone(), executor.cycle)
    stack.enter_context(writer)
    recorder.begin(writer, executor)
    return executor, writer


def _asked(yes: bool, plan: Plan, network: Network) -> Callable[[], None]:
    """Ask, before anything moves, at the terminal."""

    def ask() -> None:
        from hognose.errors import InputError

        if yes:
            return
        if not sys.stdin.isatty():
            raise InputError("the arm moves only after a confirmation at a terminal; give --yes to go without")
        try:
            said = input(
                f"{network.robot.name} on {network.source} will go through {plan.task.name}, {len(plan.time) - 1} "
                f"steps in {plan.time[-1]:.0f} s. Type {_YES} to go: "
            )
        except EOFError:
            said = ""
        if said.strip().lower() != _YES:
            raise InputError("not confirmed; nothing was moved")

    return ask


def _go(executor: Executor, until: float | None, back: bool, resume: bool, ask: Callable[[], None]) -> dict[str, Any]:
    """Arm, hold, and go; what came of it."""
    there = executor.end(until)
    executor.arm()
    ask()
    if resume:
        executor.recover()
    else:
        executor.hold()
        executor.tension()
    with _stopped_by_signals(executor):
        outcome = executor.run(0.0 if back and resume else there)
        if back and not resume and outcome.trouble is None and outcome.place == there:
            outcome = executor.run(0.0)
    good = outcome.trouble is None and outcome.place == (0.0 if back else there)
    why = outcome.trouble.words if outcome.trouble is not None else f"stopped at step {outcome.place:.2f}"
    return {
        "good": good,
        "verdict": f"GOOD: at step {outcome.place:g}" if good else f"NOT GOOD: {why}",
        "step": outcome.place,
        "trouble": None if outcome.trouble is None else outcome.trouble.words,
        "bus_load": executor.network.load,
        "cycle_s": executor.cycle,
        "commanded_counts": executor.commanded.tolist(),
        "measured_counts": executor.axes.position.tolist(),
    }


@contextmanager
def _stopped_by_signals(executor: Executor) -> Iterator[None]:
    """Ctrl-C comes to rest along the path; once more, it stops all axes at once."""
    asked: list[int] = []

    def stop(number: int, frame: object) -> None:
        del frame
        if asked:
            executor.stop_at_once()
        else:
            executor.stop()
        asked.append(number)

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
