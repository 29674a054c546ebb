"""Reading tasks and robots, writing and reading plans, exports."""

from hognose.files.exports import export
from hognose.files.loading import (
    bundled_robots,
    bundled_tasks,
    describes_robot,
    load_robot,
    load_task,
    load_task_or_plan,
    with_method,
)

__all__ = [
    "bundled_robots",
    "bundled_tasks",
    "describes_robot",
    "export",
    "load_robot",
    "load_task",
    "load_task_or_plan",
    "with_method",
]
