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
    from hognose.drive.conductor import Conductor
    from hognose.drive.executor import Executor
    from hognose.drive.network import Network
    from hognose.drive.record import RecordWriter
    from hognose.drive.stream import Cycle
    from hognose.drive.wishes import Wishes
    from hognose.planning import Plan


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
    record: Path | None = None,
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
    record
        The record to write (.mcap); by default the plan's name with date and time, in this folder.
    foxglove
        Show the run live in Foxglove, from this port (8765 is usual). It has no token: every program, and every page in
        a browser of this machine, can read along. Nobody can ask for anything there.
    yes
        Do not ask before drives get power, and before the arm moves; a pause is the end then.
    json
        Print what was commanded, reached and recorded, in SI units.
    """
    from hognose.cli.console import plan_of, say, say_json
    from hognose.drive.live.followed import followed
    from hognose.drive.live.foxglove_server import shown_in_foxglove
    from hognose.drive.wishes import Wishes

    file = record or Path(f"{Path(plan).stem}-{datetime.now():%Y%m%d-%H%M%S}.mcap")
    with ExitStack() as stack:
        made = plan_of(plan, json)
        drives, bus, clock = _opened(stack, made, network, emulated, not without_twin, fast)
        wishes = Wishes()
        executor, writer, cycle = _executor(stack, made, drives, bus, clock, (file, speed, not without_twin, json))
        stack.enter_context(followed(writer, executor, wishes))
        if foxglove is not None:
            sys.stderr.write(f"{stack.enter_context(shown_in_foxglove(writer, foxglove))}\n")
        conductor = _conductor(executor, wishes, yes, fast)
        cycle.append(lambda _: conductor.notice())
        told = _go(executor, conductor, until, back, resume, step)
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

    if not emulated and network is None:
        raise InputError("give either --network FILE, for drives that are there, or --emulated; neither is given")
    if emulated:
        from hognose.studies.rehearsal import emulated as rehearsed

        return rehearsed(stack, plan, twin, fast, network)
    if fast:
        raise InputError("--fast goes with --emulated: drives that are there take their time")
    from hognose.drive.buses import opened
    from hognose.drive.clock import RealClock
    from hognose.drive.emulator.board_line import port_of
    from hognose.drive.network import load_network
    from hognose.drive.network_spec import EMULATED
    from hognose.drive.serial_slider.adapter import with_slider

    assert network is not None, "one of both"
    found = load_network(network)
    real = [bus.interface for bus in found.spec.buses if bus.interface != EMULATED]
    if real:
        raise InputError(
            f"{network}: bus.interface {real[0]!r}: this version commands emulated drives only, on "
            f"the bus {EMULATED!r} of `hognose emulate`; docs/connect.md says why"
        )
    slider = found.spec.slider
    if slider is not None and slider.kind == "serial" and not port_of(slider.port):
        raise InputError(
            f"{network}: slider.port {slider.port!r}: this version commands emulated drives only, on a port "
            "socket://127.0.0.1:… of `hognose emulate`; docs/connect.md says why"
        )
    clock = RealClock()
    bus = with_slider(opened(found), clock, found)
    stack.callback(bus.close)
    return found, bus, clock


def _executor(
    stack: ExitStack, plan: Plan, network: Network, bus: Bus, clock: Clock, given: tuple[Path, float, bool, bool]
) -> tuple[Executor, RecordWriter, list[Callable[[Cycle], None]]]:
    """The executor, which records what it does and says it; its record; and what is called with every cycle."""
    from hognose.cli.console import say
    from hognose.drive.executor import Executor
    from hognose.drive.record import RecordWriter
    from hognose.drive.recorder import Recorder
    from hognose.drive.settings import Settings
    from hognose.errors import InputError

    file, speed, watches, quiet = given
    if not 0.0 < speed <= 100.0:
        raise InputError(f"speed: expected per cent of the plan's own, above 0 and up to 100, got {speed:g}")
    recorder = Recorder(clock)

    def said(kind: str, words: str, axis: int | None) -> None:
        recorder.event(kind, words, axis)
        if not quiet:
            say(f"{kind.upper():>8}  {words}")

    each_cycle: list[Callable[[Cycle], None]] = [recorder.cycle]

    def seen(cycle: Cycle) -> None:
        for call in each_cycle:
            call(cycle)

    executor = Executor(plan, network, bus, clock, Settings(0.01 * speed, watches_tension=watches), seen, said)
    content = network.spec.model_dump(mode="json", by_alias=True)
    writer = RecordWriter(file, plan, content, datetime.now().astimezone(), executor.cycle)
    stack.enter_context(writer)
    recorder.begin(writer, executor)
    return executor, writer, each_cycle


def _conductor(executor: Executor, wishes: Wishes, yes: bool, fast: bool) -> Conductor:
    """What asks at the terminal; nobody is asked with --yes."""
    from hognose.cli.terminal import TypedLines
    from hognose.drive.conductor import Conductor
    from hognose.errors import InputError

    if not yes and not sys.stdin.isatty():
        raise InputError("the arm moves only after a confirmation at a terminal; give --yes to go without")
    return Conductor(executor, wishes, None if yes else TypedLines(executor.cycle if fast else 0.0))


def _confirm(conductor: Conductor, what: str) -> None:
    """Ask before something is done; an error if it is not confirmed."""
    from hognose.drive.conductor import HOW
    from hognose.errors import InputError

    if not conductor.confirmed(f"{what}. {HOW}"):
        raise InputError("not confirmed; the arm was left where it is")


def _go(
    executor: Executor, conductor: Conductor, until: float | None, back: bool, resume: bool, step: bool
) -> dict[str, Any]:
    """Arm, hold, and go; what came of it."""
    there, plan, network = executor.end(until), executor.plan, executor.network
    executor.arm()
    _confirm(conductor, f"{network.robot.name} on {network.source} gets power, and its cables their tensions")
    if resume:
        executor.recover()
    else:
        executor.hold()
        executor.tension()
    goal, start = 0.0 if back and resume else there, executor.place
    takes = abs(goal - start) * float(plan.task.spec.motion.period_s) / executor.rate
    _confirm(conductor, f"it goes through {plan.task.name}, from step {start:.1f} to {goal:g}, in {takes:.1f} s")
    with _interrupting(conductor):
        outcome = conductor.go(goal, step)
        if back and not resume and outcome.trouble is None and outcome.place == there and not conductor.turned:
            goal, outcome = 0.0, conductor.go(0.0, step)
    good = outcome.trouble is None and outcome.place == goal and not conductor.turned
    why = conductor.turned or f"stopped at step {outcome.place:.2f}"
    why = why if outcome.trouble is None else outcome.trouble.words
    return {
        "good": good,
        "verdict": f"GOOD: at step {outcome.place:g}" if good else f"NOT GOOD: {why}",
        "step": outcome.place,
        "trouble": None if outcome.trouble is None else outcome.trouble.words,
        "bus_load": network.load,
        "cycle_s": executor.cycle,
        "commanded_counts": executor.commanded.tolist(),
        "measured_counts": executor.axes.position.tolist(),
    }


@contextmanager
def _interrupting(conductor: Conductor) -> Iterator[None]:
    """Ctrl-C is for the conductor."""

    def interrupt(number: int, frame: object) -> None:
        del number, frame
        conductor.interrupt()

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
