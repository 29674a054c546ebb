"""Draw the picture of a MuJoCo model for the documentation: `python docs/make_mujoco_picture.py`.

MuJoCo draws it with OpenGL, on a machine without a screen through EGL (`MUJOCO_GL=egl`).
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from PIL import Image

import hognose
from hognose.files.exports.mjcf import mjcf
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import document

mj: Any = mujoco  # its names are made at run time
FILE = Path(__file__).parent / "pictures" / "mujoco.png"
#: Of each of the two views, in pixels; and the part of the motion at which the arm is shown.
SIZE, PART = (480, 720), 0.65


def main() -> None:
    """Draw the obstacle array from both cameras, side by side."""
    plan = hognose.plan(hognose.load_task("obstacle-array"))
    model = mj.MjModel.from_xml_string(document(mjcf(Subject.of_plan(plan))[0]).decode())
    data = mj.MjData(model)
    mj.mj_resetDataKeyframe(model, data, round(PART * (model.nkey - 1)))
    mj.mj_forward(model, data)
    views = []
    with mj.Renderer(model, *SIZE) as renderer:
        for camera in ("overview", "tip_camera"):
            renderer.update_scene(data, camera=camera)
            views.append(renderer.render())
    Image.fromarray(np.concatenate(views, axis=1)).save(FILE, optimize=True)


if __name__ == "__main__":
    main()
