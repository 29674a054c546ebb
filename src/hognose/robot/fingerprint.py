"""A digest of all that makes a robot move as it does, which stays the same while robot files get further keys."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import pydantic_core
from pydantic import BaseModel

from hognose.robot.spec import RobotSpec

Keys = Mapping[str, Any]


def _keys(names: str) -> Keys:
    return {name: {} for name in names.split()}


#: Keys whose values are words about a robot.
_WORDS = {"description", "source", "assumed"}
#: Keys that have been in digests from the beginning, whatever their values. This does not grow with robot files: a key
#: that came later counts where its value is not the default, so that files of before have the digest they had.
_FIRST: Keys = {
    **_keys("schema_version name base_length tool_length"),
    "feed": _keys("min max speed"),
    "limits": _keys("joint_speed_deg_s joint_acceleration_deg_s2 cable_speed cable_travel motor_counts"),
    "section": {
        **_keys("count pitch half_lengths body_diameter bend_limit_deg link_mass cable_radius"),
        **_keys("cable_azimuths_deg cable_azimuth_step_deg"),
        "transmission": _keys("screw_lead drum_diameter gear_ratio counts_per_turn"),
    },
}


def fingerprint_of(spec: RobotSpec) -> str:
    """16 hexadecimal digits that two robots share if they move alike.

    They are the beginning of the SHA-256 of the robot as JSON, in SI units, without words and without keys that came
    later than `_FIRST` and have their default value.
    """
    return hashlib.sha256(pydantic_core.to_json(_counted(spec, _FIRST))).hexdigest()[:16]


def _counted(value: Any, first: Keys) -> Any:
    if isinstance(value, tuple):
        return [_counted(item, first) for item in value]
    if not isinstance(value, BaseModel):
        return value
    found: dict[str, Any] = {}
    for name, field in type(value).model_fields.items():
        own = getattr(value, name)
        if name in first or not (name in _WORDS or own == field.get_default(call_default_factory=True)):
            found[name] = _counted(own, first.get(name, {}))
    return found
