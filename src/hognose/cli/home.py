"""`hognose home`."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    from hognose.drive.network import Network
    from hognose.planning import Plan


def home(
    plan: PlanOrTask, /, *, network: Path, at: int = 0, zeros: Flag = False, yes: Flag = False, json: Flag = False
) -> int:
    """Tell the drives of an arm where they are: exactly where a plan is at a step. Nothing moves.

    Encoders that count know nothing of it after their supply came on, and `hognose run` refuses them until then. Bring
    the arm there first, in its jig, with its cables taut. Drives have power for less than a second, and hold.

    Parameters
    ----------
    network
        The network file of the drives.
    at
        The step of the plan at which the arm stands.
    zeros
        Encoders are absolute: declare nothing, but print what to write into the network file.
    yes
        Do not ask.
    json
        Print what was declared, in counts.
    """
    from hognose.cli.console import plan_of, say, say_json
    from hognose.drive.buses import opened
    from hognose.drive.clock import RealClock
    from hognose.drive.homing import Homing, zeros_of
    from hognose.drive.real_drives import refuse_unattended

    made = plan_of(plan, json)
    drives = _drives(made, network, at)
    if not zeros:
        refuse_unattended(drives, yes)
        if not yes:
            _ask(made, drives, at)
    counts = (drives.counts_of(made) if zeros else drives.declared_counts(made))[at]
    with ExitStack() as stack:
        bus = opened(drives)
        stack.callback(bus.close)
        if zeros:
            found = zeros_of(bus, RealClock(), drives, counts).tolist()
        else:
            Homing(drives, counts).declare(bus, RealClock())
            found = counts.tolist()
    if json:
        say_json({"good": True, "step": at, "zeros" if zeros else "counts": found})
    elif zeros:
        cables = len(drives.spec.drives.nodes)
        slider = f"\n[slider]\nzero = {found[cables]}" if len(found) > cables else ""
        say(f"in the network file, if the arm stands as {made.task.name} at step {at}:\n[drives]")
        say(f'position = "absolute"\nzeros = {found[:cables]}{slider}')
    else:
        count = len(found) - (drives.board_node is not None)
        say(f"GOOD: {count} drives say that they are where {made.task.name} is at step {at}")
    return 0


def _drives(plan: Plan, network: Path, at: int) -> Network:
    """The drives of a network file that can be where a plan is at a step."""
    from hognose.drive.network import load_network
    from hognose.errors import InputError

    drives = load_network(network)
    drives.refuse(plan)
    last = len(plan.time) - 1
    if not 0 <= at <= last:
        raise InputError(f"at: expected a step of the plan from 0 to {last}, got {at}")
    return drives


def _ask(plan: Plan, network: Network, at: int) -> None:
    """Say what is about to be declared, and ask for it at the terminal."""
    from hognose.cli.terminal import agreed
    from hognose.drive.real_drives import untested
    from hognose.errors import InputError

    if not sys.stdin.isatty():
        raise InputError("positions are declared only after a confirmation at a terminal; give --yes to go without")
    if not agreed(
        f"{untested(network)}{network.robot.name} on {network.source}: all {len(network.nodes)} drives will take "
        f"themselves to be where {plan.task.name} is at step {at}. The arm must stand exactly so, in its jig, cables "
        "taut; nothing moves. Type yes if it does: "
    ):
        raise InputError("not confirmed; nothing was declared")
