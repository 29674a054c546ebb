"""Places that are so far from all obstacles that their unit or their frame is probably another one."""

from __future__ import annotations

import numpy as np
import pytest
from planning_makers import altered

from hognose.planning import Task
from hognose.planning.out_of_place import outside

BOX = {"kind": "box", "center": [0.0, 0.0, 0.0], "size": [0.2, 0.2, 0.2]}


def test_how_far_places_are_outside_boxes_is_the_way_to_the_closest_point_in_them():
    random = np.random.default_rng(3)
    low, places = random.normal(size=(7, 3)), 3 * random.normal(size=(50, 3))
    boxes = np.stack([low, low + random.uniform(0, 2, (7, 3))], axis=1)
    closest = np.clip(places, boxes[:, None, 0], boxes[:, None, 1])
    np.testing.assert_allclose(outside(boxes, places), np.linalg.norm(places - closest, axis=2), atol=1e-15)


@pytest.mark.parametrize(("beyond", "said"), [(-1e-4, False), (1e-4, True)])
def test_way_points_beyond_an_arms_length_of_every_obstacle_are_remarked_upon(tasks, beyond, said):
    task = tasks["obstacle-array"]
    away = 0.1 + task.robot.length + beyond
    places = [[away, 0.0, 0.0], [away + 0.1, 0.05, 0.5]]
    changed = Task(altered(task.spec, {"obstacle": [BOX], "path.way_points": places}), task.robot)
    remarks = [words for words in changed.remarks if words.startswith("all way-points are 1092 mm or more from")]
    assert len(remarks) == said
    assert all("check the file's `units`" in words and "(100, 100, 100) mm" in words for words in remarks)
    assert Task(altered(changed.spec, {"obstacle": []}), task.robot).remarks == []
