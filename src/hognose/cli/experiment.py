"""`hognose demo --experiment`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hognose.studies.whole_experiment import Experiment


def experiment(folder: Path, seed: int, quiet: bool) -> int:
    """Do the whole experiment and write its page, records, plans and figures into a folder; the exit code.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C; says where is what was done.
    """
    from hognose.arguments import whole
    from hognose.cli import compile_ahead
    from hognose.cli.console import counting, made_folder, say, say_json
    from hognose.studies.experiment_page import PAGE, write_page
    from hognose.studies.whole_experiment import whole_experiment

    whole("seed", seed, 0)
    compile_ahead.when_needed()
    made_folder(folder)
    drawn: dict[str, list[str]] = {}
    files: list[str] = []

    def done(found: Experiment) -> None:
        files[:] = [str(file) for file in (write_page(found, drawn), *found.save())]

    def said(words: str) -> None:
        if not quiet:
            say(words)

    try:
        with counting("running in and out", quiet) as bar:
            found = whole_experiment(
                folder, seed=seed, progress=lambda gone, of: bar(round(gone), round(of)), said=said, done=done
            )
    except KeyboardInterrupt:
        if not files:
            raise
        raise KeyboardInterrupt(f"interrupted; the cases that were done are in {folder / PAGE}") from None
    if quiet:
        say_json({**found.to_json(), "files": files})
    else:
        say(f"{folder / PAGE}: what was reached and seen; it took {found.seconds:.0f} s\n{found.verdict}")
    return 0 if found.good else 1
