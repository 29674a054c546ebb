"""The three bundled tasks, planned once."""

import pytest

import hognose
from hognose.planning import Plan, Task

NAMES = ("obstacle-array", "pipe-tank", "detour")


@pytest.fixture(scope="session")
def tasks() -> dict[str, Task]:
    return {name: hognose.load_task(name) for name in NAMES}


@pytest.fixture(scope="session")
def plans(tasks: dict[str, Task]) -> dict[str, Plan]:
    return {name: hognose.plan(task) for name, task in tasks.items()}


@pytest.fixture(scope="session")
def boards(plans: dict[str, Plan]) -> Plan:
    return plans["obstacle-array"]
