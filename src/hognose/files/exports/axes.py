"""Plans as one CSV for each axis, for controllers that read tables of positions, velocities and times."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from hognose.files.exports.csv import of_cells
from hognose.files.exports.drive_axes import CARRIED, axes_of_plan
from hognose.files.exports.format import Content, Export
from hognose.planning.plan import Plan

#: The table of the axes in the archive.
INDEX = "axes.csv"
#: Files of an archive have a date, the same for the same plan.
_DATE = (1980, 1, 1, 0, 0, 0)
_VELOCITIES = (
    "velocities are means of the two steps around, 0 at both ends; a controller that draws cubics through them leaves "
    "the straight lines between steps a little, for which clearances are certified"
)
_LENGTHS = (
    "axes of lengths are for sections with drives of their own: leave them out where the cables alone make lengths"
)


def to_axes(plan: Plan) -> Content:
    """An archive with a table of the axes, and of each its times, positions and velocities."""
    axes, archive = axes_of_plan(plan), io.BytesIO()
    index = {
        "axis": np.array([axis.name for axis in axes], object),
        "unit": np.array([axis.unit for axis in axes], object),
        "si_per_unit": np.array([axis.scale for axis in axes]),
    }
    with zipfile.ZipFile(archive, "w") as packed:
        _add(packed, INDEX, of_cells(index))
        for axis in axes:
            cells = {
                "time_s": plan.time,
                f"position_{axis.unit}": axis.positions,
                f"velocity_{axis.unit}_s": axis.velocities(plan.time),
            }
            _add(packed, f"{axis.name}.csv", of_cells(cells))
    told = [_LENGTHS] if plan.robot.extends else []
    return Content(archive.getvalue(), remarks=(_VELOCITIES, *([CARRIED] if plan.task.base.follows else []), *told))


def _add(packed: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name, _DATE)
    entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
    packed.writestr(entry, content)


EXPORT = Export(".zip", "a CSV for each axis: times, positions in counts, velocities", to_axes)
