"""`hognose watch`."""

from __future__ import annotations

import select
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hognose.cli.completers import runs
from hognose.cli.options import Flag

if TYPE_CHECKING:
    from hognose.cli.keys import NoKeys
    from hognose.cli.watching import Shown
    from hognose.drive.live.following import Following
    from hognose.drive.live.seen import Seen

#: Whoever waits looks up so often (s).
_AWAKE = 0.1
#: What is said to who leaves.
_LEFT = "left: the run goes on"


def watch(
    record: Annotated[Path | None, Parameter(completer=runs)] = None,
    /,
    *,
    every: float = 1.0,
    json: Flag = False,
) -> int:
    """Follow a run while it goes on, from another terminal of the same machine; pause, stop or retract it.

    Keys: p pauses it, space or s stops all axes at once, r retracts once that is confirmed at the terminal of the run,
    q leaves it alone. Ends with the run: exit code 0 if it was good, 1 otherwise.

    Parameters
    ----------
    record
        The record that is written; by default that of the newest run in this folder.
    every
        Without a terminal, and as JSON: a cycle every so many seconds of the run; 0 for all.
    json
        Print a JSON object a line: what the run is, cycles, every event, the end. SI units.
    """
    from hognose.cli.keys import NoKeys, keys
    from hognose.cli.watching import JsonLines, Lines, Screen
    from hognose.drive.live.seen import Seen
    from hognose.errors import InputError

    if not every >= 0.0:
        raise InputError(f"every: expected seconds, 0 or more, got {every:g}")
    try:
        with _followed(record) as following:
            seen = Seen(following.run)
            if json:
                return _watch(following, seen, JsonLines(seen, every), NoKeys())
            with keys() as keyboard:
                shown = Screen(keyboard.works) if sys.stdout.isatty() else Lines(seen, every)
                return _watch(following, seen, shown, keyboard)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(_LEFT) from None


def _followed(record: Path | None) -> Following:
    """The run of a record, or the newest that goes on in this folder; what is gone is said."""
    from hognose.drive.live.address import address_of, newest_addresses
    from hognose.drive.live.following import Following
    from hognose.errors import InputError

    addresses = newest_addresses() if record is None else [address_of(record)]
    gone: InputError | None = None
    for address in addresses:
        try:
            return Following(address, "hognose watch")
        except InputError as error:
            gone = gone or error
    assert gone is not None, "at least one was tried"
    raise gone


def _watch(following: Following, seen: Seen, shown: Shown, keyboard: NoKeys) -> int:
    """Show a run to its end, or until somebody leaves; the exit code."""
    from hognose.drive.wishes import Want

    wants = {"p": Want.PAUSE, " ": Want.STOP, "s": Want.STOP, "r": Want.RETRACT}
    while True:
        for came in following.take(0.0):
            shown.see(seen, seen.add(came))
        if following.ended or following.lost:
            return _end(following, seen, shown)
        shown.rest(seen)
        for key in keyboard.pressed().lower():
            if key == "q":
                shown.end(seen, f"{_LEFT}; `hognose watch {following.address.record}` follows it again", False)
                return 0
            if key in wants:
                following.ask(wants[key])
        if not following.lost:
            select.select([following, *keyboard.sources], [], [], _AWAKE)


def _end(following: Following, seen: Seen, shown: Shown) -> int:
    """Say how the run ended; the exit code."""
    log = f"`hognose log {following.address.record}` reads its record"
    if following.lost and following.is_there:
        words = f"the connection to the run was lost, but it goes on: `hognose watch {following.address.record}`"
    elif following.lost:
        milliseconds = 1e3 * float(seen.run["lost_after_s"])
        words = (
            "the program of the run is gone, and said no verdict. Drives that miss its heartbeats for "
            f"{milliseconds:g} ms stop and hold by themselves. {log}"
        )
    else:
        words = f"{seen.verdict or 'NOT GOOD: the run ended without a verdict'}\n{log}"
    shown.end(seen, words, following.lost)
    return 0 if seen.good and not following.lost else 1
