"""What `hognose run` does: drives, an executor with its record, and somebody at the terminal."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hognose.drive.bus import Bus
    from hognose.drive.clock import Clock
    from hognose.drive.conductor import Conductor
    from hognose.drive.emulator.faults import Fault
    from hognose.drive.executor import Executor
    from hognose.drive.network import Network
    from hognose.drive.record import RecordWriter
    from hognose.drive.senses import Senses
    from hognose.drive.settings import Settings
    from hognose.drive.stream import Cycle
    from hognose.drive.wishes import Wishes
    from hognose.planning import Plan

#: The network file; whether drives are emulated, and move a twin; and whether they are in this program.
Drives = tuple[Path | None, bool, bool, bool]
#: The step to end at; whether to go back, whether the arm stands somewhere along the plan, whether step by step, and
#: whether to release it at the end.
Way = tuple[float | None, bool, bool, bool, bool]


#: What drives said longer ago (s) is not what they are now.
_FRESH = 1.0


class Asked(NamedTuple):
    """The options of `hognose run`, as they are described there."""

    plan: str
    drives: Drives
    way: Way
    speed: float
    record: Path | None
    fault: tuple[str, ...]
    foxglove: int | None
    yes: bool
    json: bool


def operate(asked: Asked) -> int:
    """Run a plan; the exit code."""
    from hognose.cli.console import plan_of, say, say_json
    from hognose.drive.emulator.faults import Fault
    from hognose.drive.live.followed import followed
    from hognose.drive.live.foxglove_server import shown_in_foxglove
    from hognose.drive.recorded_run import RecordedRun
    from hognose.drive.wishes import Wishes

    file = asked.record or Path(f"{Path(asked.plan).stem}-{datetime.now():%Y%m%d-%H%M%S}.mcap")
    with ExitStack() as stack:
        plan, settings, wishes = plan_of(asked.plan, asked.json), _settings(asked), Wishes()
        _refuse(asked, file, plan)
        network, bus, clock, senses, inject = _opened(stack, plan, asked)
        faults = [Fault.parsed(text, network.nodes, network.board_node) for text in asked.fault]
        _refuse_unattended(asked.yes)

        def said(kind: str, words: str) -> None:
            if not asked.json:
                say(f"{kind.upper():>8}  {words}")

        run = RecordedRun(plan, network, bus, clock, file, settings, said, senses)
        writer = stack.enter_context(run.writer)
        stack.enter_context(followed(writer, run.executor, wishes))
        if asked.foxglove is not None:
            sys.stderr.write(f"{stack.enter_context(shown_in_foxglove(writer, asked.foxglove))}\n")
        conductor = _conductor(run.executor, wishes, asked.yes, asked.drives[3])
        run.at_cycle.append(lambda _: conductor.notice())
        run.at_cycle.append(partial(_break, faults, inject))
        with _ended_in_words(run.executor, writer), _interrupting(conductor):
            told = _go(run.executor, conductor, asked) | run.reached()
        writer.close(told["verdict"])
    told["record"] = str(file)
    if asked.json:
        say_json(told)
    else:
        off = told["tip_off_m"]
        seen = "" if off is None else f"the tip is {1e3 * off:.2f} mm from where the plan has it\n"
        say(f"{seen}{file}: `hognose log {file}` reads it\n{told['verdict']}")
    return 0 if told["good"] else 1


def _refuse(asked: Asked, file: Path, plan: Plan) -> None:
    """Raise an InputError if something that is asked for cannot be, before there is a record."""
    from hognose.errors import InputError

    until, back, _, _, release = asked.way
    last = len(plan.time) - 1
    if until is not None and not 0.0 <= until <= last:
        raise InputError(f"until: expected a step from 0 to {last}, got {until:g}")
    if release and not back:
        raise InputError("--release goes with --back: an arm is released at step 0, outside")
    if file.suffix.lower() != ".mcap":
        raise InputError(f"{file}: the name of a record must end in .mcap")


def _refuse_unattended(yes: bool) -> None:
    from hognose.errors import InputError

    if not yes and not sys.stdin.isatty():
        raise InputError("the arm moves only after a confirmation at a terminal; give --yes to go without")


def _settings(asked: Asked) -> Settings:
    from hognose.drive.settings import Settings
    from hognose.errors import InputError

    if not 0.0 < asked.speed <= 100.0:
        raise InputError(f"speed: expected per cent of the plan's own, above 0 and up to 100, got {asked.speed:g}")
    return Settings(0.01 * asked.speed, watches_tension=asked.drives[2])


def _break(faults: list[Fault], inject: Callable[[Fault], None], cycle: Cycle) -> None:
    """Let the faults happen whose step is reached."""
    for fault in [each for each in faults if each.time <= cycle.set_point.place]:
        faults.remove(fault)
        inject(replace(fault, time=0.0))


def _opened(
    stack: ExitStack, plan: Plan, asked: Asked
) -> tuple[Network, Bus, Clock, Senses | None, Callable[[Fault], None]]:
    """The drives that were asked for."""
    from hognose.errors import InputError

    network, emulated, twin, fast = asked.drives
    if not emulated and network is None:
        raise InputError("give either --network FILE, for drives that are there, or --emulated; neither is given")
    if emulated:
        from hognose.studies.rehearsal import emulated as rehearsed

        return rehearsed(stack, plan, twin, fast, network)
    if fast:
        raise InputError("--fast goes with --emulated: drives that are there take their time")
    if asked.fault:
        raise InputError("--fault goes with --emulated: drives that are there fail by themselves")
    from hognose.drive.buses import opened
    from hognose.drive.clock import RealClock
    from hognose.drive.network import load_network
    from hognose.drive.real_drives import real_interfaces, refuse_unattended
    from hognose.drive.serial_slider.adapter import with_slider

    assert network is not None, "one of both"
    found = load_network(network)
    refuse_unattended(found, asked.yes)
    if not twin and real_interfaces(found):
        raise InputError("--without-twin goes with emulated drives: the tensions of cables that are there are watched")
    clock = RealClock()
    bus = with_slider(opened(found), clock, found)
    stack.callback(bus.close)
    return found, bus, clock, None, lambda fault: None


def _conductor(executor: Executor, wishes: Wishes, yes: bool, fast: bool) -> Conductor:
    """What asks at the terminal; nobody is asked with --yes."""
    from hognose.cli.terminal import TypedLines
    from hognose.drive.conductor import Conductor

    return Conductor(executor, wishes, None if yes else TypedLines(executor.cycle if fast else 0.0))


def _confirm(conductor: Conductor, what: str) -> None:
    """Ask before something is done; an error if it is not confirmed."""
    from hognose.drive.conductor import HOW
    from hognose.errors import InputError

    if not conductor.confirmed(f"{what}. {HOW}"):
        raise InputError("not confirmed; the arm was left where it is")


def _confirm_real(network: Network) -> None:
    """Where drives are there, ask before anything is sent to them."""
    from hognose.cli.terminal import agreed
    from hognose.drive.real_drives import untested
    from hognose.errors import InputError

    if not (warning := untested(network)):
        return
    what = f"All {len(network.nodes)} are configured for a run, and started; none moves, or gets power, yet"
    if not agreed(f"{warning}{what}. Type yes to do it: "):
        raise InputError("not confirmed; nothing was sent")


def _go(executor: Executor, conductor: Conductor, asked: Asked) -> dict[str, Any]:
    """Arm, hold, and go; what came of it."""
    from hognose.cli.console import counting

    until, back, resume, step, release = asked.way
    there, plan, network = executor.end(until), executor.plan, executor.network
    if not asked.drives[1]:
        _confirm_real(network)
    with counting("finding and configuring drives", asked.json) as bar:
        executor.arm(bar)
    what = f"{network.robot.name} on {network.source} gets power, and its cables their tensions"
    _confirm(conductor, what)
    if resume:
        executor.recover()
    else:
        executor.hold()
        executor.tension()
    goal, start = 0.0 if back and resume else there, executor.place
    takes = abs(goal - start) * float(plan.task.spec.motion.period_s) / executor.rate
    _confirm(conductor, f"it goes through {plan.task.name}, from step {start:.1f} to {goal:g}, in {takes:.1f} s")
    outcome = conductor.go(goal, step)
    if back and not resume and outcome.trouble is None and outcome.place == there and not conductor.turned:
        goal, outcome = 0.0, conductor.go(0.0, step)
    if release and outcome.trouble is None and not conductor.turned:
        _confirm(conductor, "cables are paid out, and drives lose their power: the arm lies, or is in its jig")
        executor.release()
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


def _power(executor: Executor) -> str:
    """Which drives hold their positions, in words, by what they said last."""
    if not np.isfinite(executor.axes.heard).any():
        return "Whether drives have power is not known: none said so"
    axes, count = executor.axes, len(executor.axes)
    if axes.mute_for:
        return f"Whether drives hold is not known: {axes.mute_for}, and the master fell silent"
    silent = axes.clock.now() - axes.heard > _FRESH
    if silent.any():
        names = ", ".join(axes.network.axis_name(int(axis)) for axis in np.flatnonzero(silent)[:3])
        return f"Whether {silent.sum()} of {count} drives have power is not known: {names} said nothing for long"
    powered = sum(state.has_power for state in axes.states())
    if powered in (0, count):
        return "All drives hold, with power" if powered else "No drive has power"
    return f"{powered} of {count} drives hold, with power"


@contextmanager
def _ended_in_words(executor: Executor, writer: RecordWriter) -> Iterator[None]:
    """However a run ends, its record has a verdict, and who started it is told how the arm was left."""
    from hognose.drive.bus import BusError
    from hognose.drive.settings import Phase
    from hognose.errors import HognoseError, InfeasibleError

    try:
        yield
    except (HognoseError, KeyboardInterrupt) as error:
        words = str(error) or "interrupted"
        if isinstance(error, BusError):
            words += ". Drives hear nothing any more: they stop and hold by themselves"
        elif executor.phase is not Phase.OFF or isinstance(error, KeyboardInterrupt):
            words += f". {_power(executor)}"
        writer.close(f"NOT GOOD: {words}")
        if isinstance(error, BusError | KeyboardInterrupt):
            raise InfeasibleError(f"{words}; go on with --resume") from None
        raise


@contextmanager
def _interrupting(conductor: Conductor) -> Iterator[None]:
    """Ctrl-C is for the conductor; what ends the program otherwise stops all axes at once before."""

    def interrupt(number: int, frame: object) -> None:
        del frame
        if not conductor.interrupt(at_once=number != signal.SIGINT):
            raise KeyboardInterrupt

    numbers = [signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
    before = [(number, signal.signal(number, interrupt)) for number in numbers]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)
