"""An evaluation as one page of HTML, and as a page of documentation with its figures beside it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from html import escape
from pathlib import Path

from hognose.errors import InputError
from hognose.evaluation.content import PICTURES, Block, Code, Heading, Picture, content
from hognose.evaluation.subjects import method_of
from hognose.evaluation.suite import Results
from hognose.evaluation.summary import Table
from hognose.following import METHODS, OF_SECTIONS
from hognose.report import page as html
from hognose.report.style import png
from hognose.write_whole import write_whole

Progress = Callable[[int, int], None]
_TITLE = "Evaluation of the following methods"
#: Pictures of the documentation, beside the page.
_FOLDER, _PREFIX = "pictures", "evaluation-"


def command_for(results: Results, docs: str | None = None) -> str:
    """The command that measures and writes the same again."""
    words = ["hognose", "bench"] + (["--quick"] if results.quick else [])
    words += ["--seed", str(results.seed)] if results.seed != 1 else []
    measured = dict.fromkeys(method_of(label) for label in results.methods)
    if len(measured) < len({*METHODS, *OF_SECTIONS}):
        words += [word for name in measured for word in ("--method", name)]
    words += ["--docs", docs] if docs is not None else []
    return shlex.join(words)


def write_page(results: Results, folder: Path, progress: Progress = lambda done, total: None) -> list[Path]:
    """Write `evaluation.html`, which needs nothing but itself, into a folder; returns the file."""
    pictures = drawn(results, progress)
    parts = [f"<h1>{escape(_TITLE)}</h1>"]
    parts += [_as_html(block, pictures) for block in content(results, command_for(results))]
    file = folder / "evaluation.html"
    write_whole(file, html.page(_TITLE, [part for part in parts if part]).encode())
    return [file]


def write_docs(results: Results, file: Path, progress: Progress = lambda done, total: None) -> list[Path]:
    """Write a page of Markdown, and its figures into the folder `pictures` beside it; returns the files."""
    pictures = drawn(results, progress)
    folder = file.parent / _FOLDER
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make the folder: {error.strerror}") from None
    written = []
    for name, data in pictures.items():
        written.append(folder / f"{_PREFIX}{name}.png")
        write_whole(written[-1], data)
    command = command_for(results, f"{file.parent.name}/{file.name}" if file.parent.name else file.name)
    blocks = [_as_markdown(block, pictures) for block in content(results, command)]
    text = "\n\n".join([f"# {_TITLE}", *(block for block in blocks if block)]) + "\n"
    write_whole(file, text.encode())
    return [file, *written]


def drawn(results: Results, progress: Progress = lambda done, total: None) -> dict[str, bytes]:
    """All figures that there are rows for, as PNG, by name."""
    made = {}
    for done, (name, picture) in enumerate(PICTURES.items()):
        progress(done, len(PICTURES))
        figure = picture.make(results)
        if figure is not None:
            made[name] = png(figure)
    progress(len(PICTURES), len(PICTURES))
    return made


def _as_html(block: Block, pictures: dict[str, bytes]) -> str:
    match block:
        case Heading():
            return html.heading(block.text)
        case Code():
            return f"<pre>{escape(block.text)}</pre>"
        case Picture():
            if block.name not in pictures:
                return ""
            return html.picture("image/png", pictures[block.name], block.title, block.caption.replace("`", ""))
        case Table():
            rows = [[cell.replace("`", "") for cell in row] for row in block.rows]
            return html.table(block.head, rows, block.numbers) if rows else ""
        case list():
            return "<ul>\n" + "\n".join(f"<li>{_marked(text)}</li>" for text in block) + "\n</ul>"
        case str():
            return f"<p>{_marked(block)}</p>"


def _marked(text: str) -> str:
    """Escaped text with **bold**, *emphasis* and `code` as HTML."""
    text = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", escape(text))
    return re.sub(r"`(.+?)`", r"<code>\1</code>", re.sub(r"\*(.+?)\*", r"<em>\1</em>", text))


def _as_markdown(block: Block, pictures: dict[str, bytes]) -> str:
    match block:
        case Heading():
            return f"## {block.text}"
        case Code():
            return f"```sh\n{block.text}\n```"
        case Picture():
            if block.name not in pictures:
                return ""
            image = f"![{block.title}]({_FOLDER}/{_PREFIX}{block.name}.png)"
            return f"{image}\n\n*{block.title}.* {block.caption}"
        case Table():
            return _markdown_table(block) if block.rows else ""
        case list():
            return "\n".join(f"- {text}" for text in block)
        case str():
            return block


def _markdown_table(table: Table) -> str:
    lines = [table.head, tuple("---:" if i in table.numbers else "---" for i in range(len(table.head))), *table.rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
