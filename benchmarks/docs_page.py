"""Blocks of a page of the documentation that commands write, each its own; the prose between them is left alone.

A block stands between two comments, `<!-- begin NAME: COMMAND -->` and `<!-- end NAME -->`.
"""

from __future__ import annotations

import argparse
import os
import re
from pathlib import Path

import hognose
from hognose.errors import InputError
from hognose.evaluation.machine import machine
from hognose.write_whole import write_whole


def block(text: str, name: str) -> re.Match[str]:
    """The block of that name in a page: group 1 is what stands between its comments.

    Raises
    ------
    InputError
        The page has no such block, or more than one.
    """
    found = [*re.finditer(rf"(?<=<!-- begin {name}: )[^\n]*-->\n(.*?)(?=<!-- end {name} -->)", text, re.DOTALL)]
    if len(found) != 1:
        raise InputError(
            f"expected one block {name!r}, found {len(found)}; "
            f"write the lines '<!-- begin {name}: the command -->' and '<!-- end {name} -->' where it belongs"
        )
    return found[0]


def found_in(file: Path, name: str) -> tuple[str, re.Match[str]]:
    """The text of a page, and its block of that name; for finding out before anything is measured.

    Raises
    ------
    InputError
        The page cannot be read, or does not have exactly one such block.
    """
    try:
        text = file.read_text(encoding="utf-8")
        return text, block(text, name)
    except OSError as error:
        raise InputError(f"{file}: cannot read: {error.strerror}") from None
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def write_block(file: Path, name: str, content: str) -> None:
    """Replace one block of a page; errors as for `found_in`, and if the page cannot be written."""
    text, found = found_in(file, name)
    write_whole(file, (text[: found.start(1)] + f"\n{content.strip()}\n\n" + text[found.end(1) :]).encode())


def measured_with(quick: bool = False) -> str:
    """What the figures of this run rest on, as a sentence."""
    here = machine()
    processor = here["processor"] or "unknown processor"
    text = (
        f"Hognose {hognose.__version__}, Python {here['python']}, numba {here['numba']}; "
        f"{os.cpu_count()} cores of {processor} ({here['architecture']})."
    )
    return text + (" **A quick run: a trial of the command, with too few rounds to rely on.**" if quick else "")


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add `--docs FILE`."""
    parser.add_argument("--docs", type=Path, metavar="FILE", help="also write the results into this page (.md)")
