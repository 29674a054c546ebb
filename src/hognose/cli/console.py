"""What commands share: progress on the terminal, tables, and plans from files."""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hognose.plain_text import plain

if TYPE_CHECKING:
    from hognose.planning import Check, Plan


@contextmanager
def stages(title: str, quiet: bool) -> Iterator[Callable[[str], None]]:
    """A callable that shows the stage at hand on the terminal; silent for machines, pipes and `quiet`."""
    if quiet or not sys.stderr.isatty():
        yield lambda stage: None
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True)
    with console.status(Text(plain(title))) as status:
        yield lambda stage: status.update(Text(plain(f"{title}: {stage}")))


@contextmanager
def counting(title: str, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """A callable (done, total) that shows a progress bar on the terminal."""
    if quiet or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task(escape(plain(title)), total=None)
        yield lambda done, total: progress.update(bar, completed=done, total=total)


def plan_of(source: str, quiet: bool) -> Plan:
    """The plan of a plan file, verified, or the one made for a task, good or not; raises where none can be made.

    Of a search that found no route it raises, too: how far the arm gets is not the motion that was asked for.
    """
    from hognose.cli import compile_ahead
    from hognose.errors import InfeasibleError
    from hognose.files import load_task_or_plan
    from hognose.planning import Plan
    from hognose.route import plan

    compile_ahead.when_needed()
    with stages(f"checking {source}", quiet) as progress:
        loaded = load_task_or_plan(source, progress)
    if isinstance(loaded, Plan):
        return loaded
    try:
        with stages(f"planning {loaded.name}", quiet) as progress:
            return plan(loaded, progress)
    except InfeasibleError as error:
        if error.plan is None or loaded.spec.path.target is not None:
            raise
        return error.plan


def output_file(given: Path | None, source: str, suffix: str) -> Path:
    """The file to write: the one given, or the source's name with this suffix, in this folder.

    Raises
    ------
    InputError
        Another suffix, a folder that is missing, or the source itself.
    """
    from hognose.errors import InputError

    target = given if given is not None else Path(Path(source).stem + suffix)
    if target.suffix.lower() != suffix:
        raise InputError(f"{target}: the name of this file must end in {suffix}")
    refuse_target(target, source)
    return target


def refuse_target(target: Path, source: str) -> None:
    """Raise an InputError if a file's folder is missing, or if the file is the source that it is made from."""
    from hognose.errors import InputError

    if not target.parent.is_dir():
        raise InputError(f"{target}: cannot write: there is no folder {target.parent}; make it first")
    if target.exists() and Path(source).exists() and target.samefile(source):
        raise InputError(f"{target}: would replace what it is made from; name another file")


def new_file(target: Path, force: bool) -> Path:
    """The file to write, which must not be there unless it is to be replaced.

    Raises
    ------
    InputError
        It is there, or its folder is missing.
    """
    from hognose.errors import InputError

    if not target.parent.is_dir():
        raise InputError(f"{target}: cannot write: there is no folder {target.parent}; make it first")
    if os.path.lexists(target) and not force:
        raise InputError(
            f"{target}: is there already and was left as it is; give another name, or --force to replace it"
        )
    return target


def made_folder(folder: Path) -> Path:
    """The folder, made with those above it if it is not there; an InputError if that is not possible."""
    from hognose.errors import InputError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make the folder: {error.strerror}") from None
    return folder


def say(text: str) -> None:
    """Print for people."""
    sys.stdout.write(plain(text) + "\n")


def say_json(value: dict[str, Any]) -> None:
    """Print for machines: one JSON object."""
    sys.stdout.write(json.dumps(value).replace("\x7f", r"\u007f") + "\n")


def table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; columns of numbers are set right, and only the last column wraps."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    grid = Table(box=None, pad_edge=False, header_style="bold")
    for column, heading in enumerate(headings):
        cells = [row[column] for row in rows if row[column]]
        bare = [cell.rstrip("*").replace("±", "").removeprefix("≥ ").replace(".", "", 1) for cell in cells]
        numbers = bool(bare) and all(map(str.isdigit, bare))
        last = column == len(headings) - 1
        grid.add_column(heading, justify="right" if numbers else "left", no_wrap=not last, overflow="fold")
    for row in rows:
        grid.add_row(*(Text(plain(cell)) for cell in row))
    # Written by us, so that a closed pipe is not the end of the program inside rich.
    terminal, text = sys.stdout.isatty(), io.StringIO()
    Console(file=text, force_terminal=terminal, width=None if terminal else 200).print(grid)
    sys.stdout.write(text.getvalue())


def say_checks(checks: Sequence[Check]) -> None:
    """Print the table of checks."""
    words = {"passed": "ok", "failed": "FAILED"}
    rows = [
        [
            words.get(check.verdict, check.verdict),
            check.name,
            check.comparison,
            ", ".join([*check.place, check.detail] if check.detail else check.place),
        ]
        for check in checks
    ]
    table(("verdict", "check", "worst and limit", "where"), rows)


def plan_json(plan: Plan, **more: Any) -> dict[str, Any]:
    """The figures of a plan for machines, in the units that the names say."""
    from hognose.planning.base_words import base_figures, profile_figures
    from hognose.planning.checks.check import to_json

    return {
        "good": plan.good,
        "task": plan.task.name,
        "robot": plan.robot.name,
        "robot_fingerprint": plan.robot.fingerprint,
        "base": base_figures(plan.task),
        "profile": profile_figures(plan),
        "method": plan.task.spec.motion.method,
        "steps": len(plan.time) - 1,
        "duration_s": float(plan.time[-1]),
        "feed_m": float(plan.feed[-1]),
        "clearance_m": float(plan.clearance.min()),
        "body_deviation_m": float(plan.body_deviation.max()),
        "body_deviation_rms_m": float((plan.body_deviation**2).mean() ** 0.5),
        "clearance_is_lower_bound": bool(plan.clearance.min() >= plan.horizon),
        "certified_clearance_m": plan.certified_clearance,
        "remarks": plan.remarks,
        "checks": [to_json(check) for check in plan.checks],
        **more,
    }
