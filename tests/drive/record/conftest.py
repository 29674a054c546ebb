"""A plan, and a record of a run through the beginning of it."""

import pytest
from record_makers import Made, write

import hognose


@pytest.fixture(scope="session")
def plan() -> hognose.Plan:
    return hognose.plan(hognose.load_task("pipe-tank"))


@pytest.fixture(scope="session")
def made(plan, tmp_path_factory) -> Made:
    return write(plan, tmp_path_factory.mktemp("record") / "run.mcap")
