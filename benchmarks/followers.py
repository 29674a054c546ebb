"""What followers cost a run: `python -m benchmarks.followers` prints how long it takes to record a cycle and to go on.

Followers are processes of their own, as `hognose watch` is. A cycle is recorded every 20 ms. What a run does behind
that is a loop here, which takes longer if the thread of the server is at work meanwhile.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

import hognose
from hognose.drive.live.address import Address
from hognose.drive.live.server import Live
from hognose.drive.record import CycleRow, RecordWriter
from hognose.drive.wishes import Wishes

CYCLES, EVERY, BEHIND = 1000, 0.02, 10_000
CHILD = """
import sys
from pathlib import Path
from hognose.drive.live.address import address_of
from hognose.drive.live.following import Following
with Following(address_of(Path(sys.argv[1]))) as following:
    while not (following.ended or following.lost):
        following.take(1.0)
"""


def main() -> None:
    """Print a row for each number of followers."""
    plan = hognose.plan(hognose.load_task("obstacle-array"))
    print("followers  median us  99 % us  largest us")
    for followers in (None, 0, 1, 3):
        took = 1e6 * np.array(costs(plan, followers))
        name = "no server" if followers is None else str(followers)
        print(f"{name:>9} {np.median(took):10.0f} {np.quantile(took, 0.99):8.0f} {took.max():11.0f}")


def costs(plan: hognose.Plan, followers: int | None) -> list[float]:
    """How long (s) each cycle took to record, with so many followers; None without a server."""
    cables, found = plan.robot.cables, []
    still = np.zeros(cables)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        with RecordWriter(file, plan, {}, datetime.now(UTC)) as writer:
            live, children = None, []
            if followers is not None:
                live = Live({"cables": cables}, Wishes())
                writer.also = live.take
                Address(live.port, live.token, 1, file).write()
                children = [subprocess.Popen([sys.executable, "-c", CHILD, str(file)]) for _ in range(followers)]
                while len(live._outboxes) < followers:
                    time.sleep(0.01)
            for k in range(CYCLES):
                status = np.full(cables, 0x1637, np.uint16)
                counts = plan.motor_counts[k % len(plan.motor_counts)]
                row = CycleRow(EVERY * k, "RUN", 0.0, counts, counts, still, still, still, status, 0.0, 0.0, 0.0)
                began = time.perf_counter()
                writer.cycle(row)
                for _ in range(BEHIND):
                    pass
                found.append(time.perf_counter() - began)
                time.sleep(EVERY)
            if live is not None:
                live.close()
            for child in children:
                child.wait()
    return found


if __name__ == "__main__":
    main()
