"""What else is known of an arm while it moves, besides its drives: pictures of the tip camera, and what it touches."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hognose.drive.executor import Executor
from hognose.drive.recorder import Recorder
from hognose.drive.stream import Cycle

Array = NDArray[np.float64]

#: A force (N) from which on a contact is one.
_TOUCH = 1.0
#: By how much (N) a contact may grow that is known already, so that the way out of it is open.
_MORE = 2.0


class Contact(NamedTuple):
    """What presses the arm the most: in words, and how hard (N)."""

    words: str
    force: float


class Picture(NamedTuple):
    """A picture of the tip camera: when it was taken (s, by the clock of the run), and the JPEG."""

    time: float
    jpeg: bytes


class Sensed(NamedTuple):
    """What came since it was asked for last.

    Attributes
    ----------
    pictures
    contact
        None where nothing is touched, or nothing is known of it yet.
    """

    pictures: tuple[Picture, ...] = ()
    contact: Contact | None = None


class Senses(Protocol):
    """A tip camera, and what feels contacts."""

    def look(self, now: float) -> Sensed:
        """What came by now (s, by the clock of the run); never waits."""
        ...

    def tip(self) -> Array | None:
        """Where the tip is now (3,) m in the frame of the task; None if it is not seen. May wait a moment."""
        ...


class Sensing:
    """Records pictures, and lets the arm come to rest along its path if it touches something.

    After such a stop the way back is open, as long as the contact does not grow.
    """

    def __init__(self, senses: Senses, recorder: Recorder, executor: Executor) -> None:
        self._senses, self._recorder, self._executor = senses, recorder, executor
        self._allowed = _TOUCH

    def cycle(self, cycle: Cycle) -> None:
        """Look; to be called with every cycle."""
        del cycle
        sensed = self._senses.look(self._executor.axes.clock.now())
        for picture in sensed.pictures:
            self._recorder.image(picture.time, picture.jpeg)
        if sensed.contact is None:
            return
        words, force = sensed.contact
        if self._executor.refuses:
            self._allowed = max(self._allowed, force + _MORE)
        elif force > (self._allowed if self._executor.goes_back else _TOUCH):
            self._allowed = force + _MORE
            self._executor.refuse_to_go_on(f"contact: {words} with {force:.1f} N")
        else:
            self._allowed = max(_TOUCH, min(self._allowed, force + _MORE))
