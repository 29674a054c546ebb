"""Whether a plan was made for a task: what in it is not what the task and its robot say."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

from hognose.planning import embedded
from hognose.planning.plan import Check, Plan
from hognose.planning.task import Task

#: So many differences are named.
_NAMED = 8
#: What no motion depends on. Robots and geometry are compared by what they hold, wherever their files lie.
_APART_OF_ROBOT, _APART_OF_TASK = {"description", "source", "assumed"}, {"description", "report", "robot"}


def made_for(plan: Plan, task: Task) -> Plan:
    """The plan with one check more: that its robot, space, way and motion are those of a task.

    The plan's own metadata says for what it was made; a task and a robot that were altered in there agree with
    themselves, and only the source shows it.
    """
    found = differences(plan, task)
    detail = "differences"
    if found:
        more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
        detail = f"differences, plan against task, in SI units: {', '.join(found[:_NAMED])}{more}"
    check = Check("made_for_task", "made for this task", not found, float(len(found)), 0.0, "1", detail=detail)
    return dataclasses.replace(plan, checks=(*plan.checks, check))


def differences(plan: Plan, task: Task) -> list[str]:
    """What differs between the task that a plan holds and another one, key by key, the plan's value first."""
    robots = _between("robot", _robot_of(plan.task), _robot_of(task))
    return [*robots, *_between("task", _spec_of(plan.task), _spec_of(task))]


def _robot_of(task: Task) -> dict[str, Any]:
    return task.robot.spec.model_dump(by_alias=True, exclude=_APART_OF_ROBOT)


def _spec_of(task: Task) -> dict[str, Any]:
    spec = task.spec.model_dump(by_alias=True, exclude=_APART_OF_TASK)
    for item, digest in zip(spec["obstacle"], embedded.digests(task.spec), strict=True):
        if digest is not None:
            item["content"] = digest[:16]
            item.pop("file")
    return spec


def _between(key: str, one: Any, other: Any) -> Iterator[str]:
    if isinstance(one, dict) and isinstance(other, dict):
        for name in dict.fromkeys((*one, *other)):
            yield from _between(f"{key}.{name}", one.get(name), other.get(name))
    elif isinstance(one, list | tuple) and isinstance(other, list | tuple):
        if len(one) != len(other):
            yield f"{key}: {len(one)} against {len(other)}"
            return
        for number, (mine, theirs) in enumerate(zip(one, other, strict=True), 1):
            yield from _between(f"{key}[{number}]", mine, theirs)
    elif one != other:
        yield f"{key}: {one!r} against {other!r}"
