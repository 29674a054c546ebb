"""What the arm stands on and how its feed goes over time, for people and for programs."""

from __future__ import annotations

from typing import Any

import numpy as np

from hognose.planning.motion import Motion
from hognose.planning.task import Task
from hognose.wording import mm, point

#: An entry of a direction that differs less than this from a whole number is shown as that.
_WHOLE = 1e-9
_AXES = "xyz"


def base_words(task: Task) -> str:
    """What the arm stands on: kind, direction, and what is given of it, as `slider along +z`."""
    said = task.spec.base
    parts = [f"{_NAMES[said.kind]} along {_direction(said.along)}"]
    if said.rotation_deg is not None:
        parts.append("turned by ({:g}, {:g}, {:g})°".format(*said.rotation_deg))
    if said.position is not None:
        parts.append(f"first joint at {point(said.position, 'g')} at feed 0")
    if said.radius is not None:
        parts.append(f"radius {_mm(said.radius)} mm")
        parts.append(f"nozzle {_mm(said.nozzle)} mm" if said.nozzle else "no nozzle")
        parts.append(f"a coil of {mm(task.base.farthest, '.1f')} to feed")
    if said.workspace is not None:
        parts.append(f"first joint from {point(said.workspace.low, 'g')} to {point(said.workspace.high, 'g')}")
    limits = (
        ("speed", said.speed, 1e3, "mm/s"),
        ("acceleration", said.acceleration, 1e3, "mm/s²"),
        ("turns at", said.turn_speed_deg_s, 1.0, "°/s"),
        ("turn acceleration", said.turn_acceleration_deg_s2, 1.0, "°/s²"),
    )
    parts += [f"{what} {factor * given:.9g} {unit}" for what, given, factor, unit in limits if given is not None]
    return "; ".join(parts)


def profile_words(motion: Motion) -> str:
    """How the feed goes over time, as `constant: 3.5 mm every 150 ms`."""
    said = motion.task.spec.motion
    period = f"every {1e3 * said.period_s:.9g} ms"
    if said.profile_of(motion.retracts) == "constant":
        return f"constant: {_mm(said.step)} mm {period}"
    return f"fastest: from rest to rest, a set-point {period}; acceleration builds up over {said.smoothing_time:.9g} s"


def base_figures(task: Task) -> dict[str, Any]:
    """What the task file says of its base, in SI units and degrees, and its words; what is not given is left out."""
    said = task.spec.base.model_dump(exclude_none=True, exclude={"direction"})
    return {**said, "direction": list(task.spec.base.along), "words": base_words(task)}


def profile_figures(motion: Motion) -> dict[str, Any]:
    """How the feed goes over time: kind, period (s), step (m) or smoothing (s), and its words."""
    said = motion.task.spec.motion
    kind = said.profile_of(motion.retracts)
    own = {"step": said.step} if kind == "constant" else {"smoothing_s": said.smoothing_time}
    return {"kind": kind, "period_s": said.period_s, **own, "words": profile_words(motion)}


def _direction(along: tuple[float, float, float]) -> str:
    """A unit vector in words: an axis of the task where it is one."""
    whole = np.round(along)
    if np.abs(whole - along).max() < _WHOLE:
        axis = int(np.argmax(np.abs(whole)))
        return f"{'+' if whole[axis] > 0 else '-'}{_AXES[axis]}"
    return "({:z.3f}, {:z.3f}, {:z.3f})".format(*along)


def _mm(length: float) -> str:
    return f"{1e3 * length:.9g}"


_NAMES = {"slider": "slider", "cart": "slider on a cart", "drum": "drum", "arm": "carrier of six axes"}
