"""A page of HTML that needs nothing but itself: its look, its figures inside it, and every text escaped."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

_LOOK = """
:root { color-scheme: light dark; --paper: #ffffff; --ink: #23292f; --faint: #5c6670; --line: #d9dee4;
  --good: #1d7a46; --good-bed: #e8f5ed; --bad: #b3202a; --bad-bed: #fceced; }
@media (prefers-color-scheme: dark) { :root { --paper: #16191d; --ink: #e4e8ec; --faint: #9aa4ae;
  --line: #343b43; --good: #6fd39b; --good-bed: #16301f; --bad: #ff8f96; --bad-bed: #3a171a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 62rem; color: var(--ink);
  background: var(--paper);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
h1 { font-size: 1.7rem; margin: 0; line-height: 1.2; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; }
.sub { color: var(--faint); margin: .25rem 0 1.2rem; }
.verdict { padding: .8rem 1rem; border-left: 5px solid; border-radius: 4px; font-size: 1.05rem; }
.verdict strong { margin-right: .5rem; }
.good { color: var(--good); } .bad { color: var(--bad); font-weight: 600; }
.verdict.good { background: var(--good-bed); } .verdict.bad { background: var(--bad-bed); font-weight: 400; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .38rem .8rem .38rem 0; vertical-align: top;
  border-bottom: 1px solid var(--line); }
thead th { color: var(--faint); font-weight: 600; font-size: .85rem; }
tbody th { font-weight: 500; }
.number { text-align: right; white-space: nowrap; }
thead .number { white-space: normal; vertical-align: bottom; }
a { color: inherit; }
ul { margin: .3rem 0; padding-left: 1.2rem; }
figure { margin: 1.4rem 0 2rem; }
figure img { display: block; width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
figcaption { color: var(--faint); margin-top: .5rem; font-size: .92rem; max-width: 50rem; }
figcaption b { color: var(--ink); }
footer { color: var(--faint); font-size: .85rem; margin-top: 3rem; padding-top: .6rem;
  border-top: 1px solid var(--line); }
@media print { :root { --paper: #ffffff; --ink: #000000; --faint: #444444; --line: #bbbbbb; --good: #12562f;
  --bad: #8e1119; --good-bed: #ffffff; --bad-bed: #ffffff; }
  body { max-width: none; padding: 0; font-size: 10.5pt; }
  figure, tr, .verdict { break-inside: avoid; } h2 { break-after: avoid; } .moving { display: none; } }
"""


def page(title: str, parts: Iterable[str]) -> str:
    """Return a whole page; `title` is text, the parts are HTML."""
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_LOOK}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def heading(text: str) -> str:
    """Return a heading within the page."""
    return f"<h2>{escape(text)}</h2>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int] = ()) -> str:
    """Return a table of texts; the columns in `numbers` are set to the right, the first names its row.

    A cell that reads "passed" or "failed" is coloured as well.
    """
    right = ' class="number"'
    marks = {"passed": ' class="good"', "failed": ' class="bad"'}

    def cell(column: int, text: str) -> str:
        mark = right if column in numbers else marks.get(text, "")
        name = 'th scope="row"' if column == 0 else "td"
        return f"<{name}{mark}>{escape(text)}</{name[:2]}>"

    top = "".join(
        f'<th scope="col"{right if column in numbers else ""}>{escape(text)}</th>' for column, text in enumerate(head)
    )
    lines = "\n".join("<tr>" + "".join(cell(i, text) for i, text in enumerate(row)) + "</tr>" for row in rows)
    start = f"<thead><tr>{top}</tr></thead>\n" if head else ""
    return f'<div class="wide"><table>\n{start}<tbody>\n{lines}\n</tbody>\n</table></div>'


def bullets(texts: Iterable[str]) -> str:
    """Return a list of texts."""
    return "<ul>\n" + "\n".join(f"<li>{escape(text)}</li>" for text in texts) + "\n</ul>"


def picture(kind: str, data: bytes, title: str, caption: str, *, moving: bool = False) -> str:
    """Return a figure with its image inside the page; `kind` is the image's media type."""
    inside = b64encode(data).decode("ascii")
    mark = ' class="moving"' if moving else ""
    return (
        f'<figure{mark}><img alt="{escape(title)}" src="data:{kind};base64,{inside}">\n'
        f"<figcaption><b>{escape(title)}.</b> {escape(caption)}</figcaption></figure>"
    )
