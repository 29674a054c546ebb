"""Making a run one that can be followed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hognose.drive.executor import Executor
from hognose.drive.live.address import Address
from hognose.drive.live.server import Limits, Live
from hognose.drive.record import RecordWriter
from hognose.drive.record.messages import TOPICS
from hognose.drive.record.writer import motion_digest
from hognose.drive.wishes import Want, Wishes
from hognose.version import __version__


@contextmanager
def followed(writer: RecordWriter, executor: Executor, wishes: Wishes, limits: Limits | None = None) -> Iterator[Live]:
    """Serve what a record gets while it is written, and write beside it where that is; yields the server.

    Parameters
    ----------
    writer
        Closed by its owner, with the verdict, before this ends.
    executor
    wishes
        Where what followers want is put.
    limits

    Raises
    ------
    InputError
        The file beside the record cannot be written, or no port can be listened on.
    """
    live = Live(opening(writer, executor), wishes, limits)
    try:
        address = Address(live.port, live.token, os.getpid(), writer.path)
        address.write()
        try:
            writer.also = live.take
            yield live
        finally:
            writer.also = None
            address.remove()
    finally:
        live.close()


def opening(writer: RecordWriter, executor: Executor) -> dict[str, Any]:
    """What followers are told of a run at first; docs/watch.md explains it."""
    plan, network = executor.plan, executor.network
    return {
        "version": __version__,
        "record": str(writer.path.absolute()),
        "start_ns": writer.start,
        "task": plan.task.name,
        "robot": plan.robot.name,
        "cables": plan.robot.cables,
        "steps": len(plan.time) - 1,
        "step_s": float(plan.task.spec.motion.period_s),
        "cycle_s": executor.cycle,
        "motion_sha256": motion_digest(plan),
        "nodes": list(network.nodes),
        "tension_band_N": network.spec.watch.tension_band_N,
        "lost_after_s": network.spec.watch.lost_after_s,
        "wants": [each.value for each in Want],
        "topics": [
            {"topic": topic, "schema": name, "encoding": "cdr", "definition": text}
            for topic, (name, text) in TOPICS.items()
        ],
    }
