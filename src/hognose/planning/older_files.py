"""Plan files of older schema versions: what they say, in words of today."""

from __future__ import annotations

import hashlib
from typing import Any

import pydantic_core

from hognose.errors import InputError
from hognose.planning.columns import Quantity
from hognose.planning.damage import ALTERED

#: The oldest schema that is read.
OLDEST = 1
#: What the metadata of schema 1 said: no digests, no number of rows, and nothing of retractions and files of obstacles,
#: for there were none.
_KEYS_1 = {
    "schema", "version", "good", "robot", "robot_fingerprint", "task", "way_points_m", "clearance_horizon_m", "checks",
}  # fmt: skip


def said_today(said: dict[str, Any], rows: int, schema: int) -> dict[str, Any]:
    """The metadata of a file of schema 1 as a file of today would have them; its checks are left out.

    Parameters
    ----------
    said
        The entry `hognose`.
    rows
        Of the table.
    schema
        The version of today.

    Raises
    ------
    InputError
        It has keys that no file of schema 1 has, or its verdict is not what its checks say.
    """
    further, missing = sorted(said.keys() - _KEYS_1), sorted(_KEYS_1 - said.keys())
    if further or missing:
        which = f"has no key {further[0]!r:.60}" if further else f"has a key {missing[0]!r}"
        raise InputError(f"the metadata of plan schema 1 {which}: {ALTERED}")
    checks = said["checks"]
    if said["good"] is not (bool(checks) and all(check["ok"] is True for check in checks)):
        raise InputError(f"the metadata's `good` is not what its checks say: {ALTERED}")
    obstacles = [None] * len(said["task"]["obstacle"])
    return said | {
        "schema": schema, "good": False, "checks": [], "rows": rows, "retracts": False, "geometry": obstacles,
    }  # fmt: skip


def fingerprint_as_written(robot: dict[str, Any]) -> str:
    """The digest that the robot of a file had when it was written, whatever keys robots have had since."""
    values = {"schema_version" if key == "schema" else key: value for key, value in robot.items()}
    for key in ("description", "source", "assumed"):
        values.pop(key, None)
    return hashlib.sha256(pydantic_core.to_json(values)).hexdigest()[:16]


def note(version: str, schema: int, lacking: list[Quantity]) -> str:
    """A sentence for people about a plan from such a file; it holds of later files of that plan, too."""
    anew = f"; {', '.join(quantity.shown for quantity in lacking)} computed anew" if lacking else ""
    return (
        f"from a file of Hognose {version} (schema {schema}), which has no digests: an alteration of it would not have "
        f"been noticed{anew}"
    )
