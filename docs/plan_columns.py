"""The table of columns in plan-file.md, made from their declarations: `python docs/plan_columns.py` writes it anew."""

from __future__ import annotations

from pathlib import Path

import hognose
from hognose.planning.columns import QUANTITIES, Quantity
from hognose.robot import Robot

PAGE = Path(__file__).parent / "plan-file.md"
BEGIN, END = "<!-- columns: made by plan_columns.py -->\n", "<!-- end of columns -->\n"
#: The names in the table are those of this robot.
ROBOT = "sjtu-25dof"


def table() -> str:
    """Markdown with a row for every quantity."""
    robot = hognose.load_robot(ROBOT)
    head = "| columns | unit | for each | type | what |\n|---|---|---|---|---|\n"
    return head + "".join(_row(quantity, robot) for quantity in QUANTITIES)


def _row(quantity: Quantity, robot: Robot) -> str:
    names = [f"`{column.name}`" for column in quantity.columns(robot)] or [f"`{quantity.shown}`"]
    which = names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"
    kind = "int64" if quantity.whole else "double"
    what = quantity.meaning + ("" if quantity.since else "; not in every file")
    what += "" if quantity.stored else "; follows from the others"
    return f"| {which} | {quantity.unit} | {' × '.join(('step', *quantity.each))} | {kind} | {what} |\n"


def with_table(page: str) -> str:
    """The page with the table as it must be."""
    before, _, rest = page.partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
