"""Criteria as a script would add them to those of Hognose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from hognose.planning.checks import ALL, Check, Criterion, Shared, least, not_judged
from hognose.planning.motion import Motion
from hognose.ties import first_smallest


def height_above_floor(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No link comes closer to the floor, 0.5 m below the entrance, than 0.2 m."""
    lowest = np.minimum(motion.body[:, :-1, 1], motion.body[:, 1:, 1]) - motion.robot.body_radii
    step, link = first_smallest(lowest + 0.5)
    yield least(0.5 + lowest[step, link], 0.2, step=step, link=link)


FLOOR = Criterion("height_above_floor", "height above the floor", "m", height_above_floor)


def too_high(motion: Motion, shared: Shared) -> Iterator[Check]:
    """A floor so high that no plan keeps clear of it."""
    yield from (least(check.value, 0.6, step=check.step, link=5) for check in height_above_floor(motion, shared))


HIGH_FLOOR = Criterion("high_floor", "height above a floor", "m", too_high)
LOAD = Criterion("payload", "payload", "N", lambda motion, shared: [not_judged("the robot names no payload")])


@contextmanager
def appended(*criteria: Criterion) -> Iterator[None]:
    """With such criteria at the end of the list."""
    before = len(ALL)
    ALL.extend(criteria)
    try:
        yield
    finally:
        del ALL[before:]
