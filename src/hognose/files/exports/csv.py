"""Plans as CSV."""

from __future__ import annotations

import csv
import io
from typing import Any

from numpy.typing import NDArray

from hognose.files.exports.format import Export
from hognose.planning.plan import Plan
from hognose.planning.plan_table import all_cells, to_table


def to_csv(plan: Plan) -> bytes:
    """The columns of the plan file, with a line of headings; numbers read back bit for bit."""
    return of_cells(all_cells(plan))


def of_cells(cells: dict[str, NDArray[Any]]) -> bytes:
    """Columns (T,) by name, with a line of headings."""
    from pyarrow.csv import WriteOptions, write_csv

    table, headings, rows = to_table(cells), io.StringIO(), io.BytesIO()
    csv.writer(headings, lineterminator="\n").writerow(table.column_names)  # quoted only where that is needed
    write_csv(table, rows, WriteOptions(include_header=False, quoting_style="needed"))
    return headings.getvalue().encode() + rows.getvalue()


EXPORT = Export(".csv", "the plan file's columns, in SI units", to_csv)
