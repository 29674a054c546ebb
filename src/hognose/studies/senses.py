"""What is seen of the twin behind emulated drives: pictures of its tip camera, and what it touches."""

from __future__ import annotations

import io
import multiprocessing
import os
import signal
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.senses import Contact, Picture, Sensed
from hognose.planning import Plan
from hognose.planning.plan_file import read
from hognose.report.tip_camera import camera_at, photograph
from hognose.scene import Scene
from hognose.sim import Twin

Array = NDArray[np.float64]

#: Width and height of a picture in pixels, and how well it is kept.
SIZE, QUALITY = (320, 240), 85
#: A picture is taken so often (s), and the twin in another process is asked for what it touches.
EVERY, LOOKS_EVERY = 1.0, 0.05
#: The process of the drives says within this (s) where the tip is, or it is not known: drives want to be heard.
_PATIENCE = 0.05
#: The process that draws is waited for so long (s) at most, and makes way for drives and program by so much.
_STARTING, _NICE = 60.0, 10


class Sight(NamedTuple):
    """The twin as it is: coordinates (k,) of its base, angles (n, 2) rad, tip (3,) m, and what it touches."""

    at: Array
    angles: Array
    tip: Array
    contact: Contact | None


def sight_of(twin: Twin) -> Sight:
    """What is to be seen of a twin now."""
    return Sight(twin.base, twin.angles, twin.joints[-1], contact_of(twin))


def contact_of(twin: Twin) -> Contact | None:
    """The link that is pressed the most, and by which obstacle; None if none is."""
    forces: dict[tuple[int, str], float] = {}
    for touch, force in twin.touches:
        forces[touch.link, touch.obstacle] = forces.get((touch.link, touch.obstacle), 0.0) + force
    if not forces:
        return None
    link, obstacle = max(forces, key=lambda each: forces[each])
    return Contact(f"link {link + 1} is pressed by {obstacle}", forces[link, obstacle])


class TipCamera:
    """Draws what the camera on the tip sees.

    Parameters
    ----------
    plan
    scene
        What is there; as planned unless given.
    """

    def __init__(self, plan: Plan, scene: Scene | None = None) -> None:
        self._task, self._scene = plan.task, scene or plan.task.scene

    def jpeg(self, sight: Sight) -> bytes:
        """A picture."""
        from PIL import Image

        pixels = photograph(self._scene, camera_at(self._task, sight.at, sight.angles, sight.tip), SIZE)
        out = io.BytesIO()
        Image.fromarray(pixels).save(out, "JPEG", quality=QUALITY)
        return out.getvalue()


class TwinSenses:
    """What is seen of a twin in this program; see `hognose.drive.senses.Senses`."""

    def __init__(self, twin: Twin, camera: TipCamera, every: float = EVERY) -> None:
        self._twin, self._camera, self._every, self._next = twin, camera, every, 0.0

    def look(self, now: float) -> Sensed:
        """See `Senses.look`; draws a picture where it is time for one."""
        contact, pictures = contact_of(self._twin), ()
        if now >= self._next:
            self._next = now + self._every
            pictures = (Picture(now, self._camera.jpeg(sight_of(self._twin))),)
        return Sensed(pictures, contact)

    def tip(self) -> Array:
        """See `Senses.tip`."""
        return self._twin.joints[-1]


class DistantSenses:
    """What is seen of a twin in the process of the drives; pictures are drawn in a process of their own.

    Neither the drives nor the program that commands them wait for a picture.
    """

    def __init__(self, process: EmulatorProcess, plan_file: Path, every: float = EVERY) -> None:
        """Start the process that draws, and wait until it is ready: at first it takes much of the processor's time."""
        self._drives, self._every = process, every
        self._asked, self._looked, self._pictured = False, -np.inf, -np.inf
        self._busy, self._taken = True, 0.0
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_draw, args=(plan_file, theirs), daemon=True)
        self._process.start()
        theirs.close()
        self._pipe.poll(_STARTING)
        self._drawn()

    def look(self, now: float) -> Sensed:
        """See `Senses.look`."""
        pictures = self._drawn()
        sight = self._drives.sight() if self._asked else None
        if isinstance(sight, Sight):
            self._asked = False
            if not self._busy and now - self._pictured >= self._every:
                self._pictured = self._taken = now
                self._busy = True
                with suppress(OSError):  # it died: there are no more pictures, and that is all
                    self._pipe.send(sight)
        if not self._asked and now - self._looked >= LOOKS_EVERY:
            self._asked, self._looked = True, now
            self._drives.ask()
        return Sensed(pictures, sight.contact if isinstance(sight, Sight) else None)

    def tip(self) -> Array | None:
        """See `Senses.tip`."""
        if self._asked:  # what is on its way is older
            self._drives.sight(_PATIENCE)
        self._drives.ask()
        sight = self._drives.sight(_PATIENCE)
        self._asked = not isinstance(sight, Sight)
        return sight.tip if isinstance(sight, Sight) else None

    def _drawn(self) -> tuple[Picture, ...]:
        try:
            if not self._pipe.poll():
                return ()
            jpeg = self._pipe.recv()
        except (EOFError, OSError):
            return ()
        self._busy = False
        return () if jpeg is None else (Picture(self._taken, jpeg),)

    def close(self) -> None:
        """End the process that draws."""
        self._process.terminate()
        self._process.join()
        self._pipe.close()


def _draw(plan_file: Path, pipe: Connection) -> None:
    """Draw a picture for every sight that comes, until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that runs the plan
    if hasattr(os, "nice"):
        os.nice(_NICE)
    plan = Plan.of(read(plan_file).motion)  # who runs it has judged it
    camera = TipCamera(plan)
    camera.jpeg(Sight(plan.at[0], plan.angles[0], plan.body[0, -1], None))  # the first one takes longest
    pipe.send(None)  # it is ready
    try:
        while True:
            pipe.send(camera.jpeg(pipe.recv()))
    except (EOFError, OSError):
        return
