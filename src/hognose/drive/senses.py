"""What else is known of an arm while it moves, besides its drives: pictures of the tip camera, and what it touches."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hognose.drive.executor import Executor
from hognose.drive.recorder import Recorder
from hognose.drive.settings import Phase
from hognose.drive.stream import Cycle

Array = NDArray[np.float64]

#: A force (N) from which on a contact is one.
_TOUCH = 1.0
#: Times the force of a contact that is known already to which it may grow, so that the way out of it is open.
_MORE = 2.0
#: After so many steps without a contact, none is known any more: a cycle without one says little, as senses may be
#: slower than cycles.
_FREE = 1.0


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

    What it touches while it stands is known from then on, and so is what it came to rest by. The way back is open for
    a contact that is known, until its force is twice what it was; it is known no longer once the arm went a step
    without it, or is back at step 0. Until then it is not let further in. On the way in, any contact stops it.
    """

    def __init__(self, senses: Senses, recorder: Recorder, executor: Executor) -> None:
        self._senses, self._recorder, self._executor = senses, recorder, executor
        self._known, self._place, self._free_since = 0.0, executor.place, math.inf
        self._words = ""

    def cycle(self, cycle: Cycle) -> None:
        """Look; to be called with every cycle."""
        sensed = self._senses.look(self._executor.axes.clock.now())
        for picture in sensed.pictures:
            self._recorder.image(picture.time, picture.jpeg)
        place = cycle.set_point.place
        gone, self._place = place - self._place, place
        if sensed.contact is not None and sensed.contact.force > _TOUCH:
            self._feel(sensed.contact, gone)
            self._free_since = place
        elif abs(self._free_since - place) >= _FREE or place == 0.0:
            self._known, self._free_since = 0.0, math.inf
            if self._executor.obstructed == self._words:  # it may be so for another reason
                self._executor.obstructed = ""

    def _feel(self, contact: Contact, gone: float) -> None:
        """What follows from a contact, after a cycle in which the arm has gone some way (steps) along its plan."""
        executor, tensions = self._executor, self._executor.phase is Phase.TENSION
        stands = gone == 0.0 and not tensions  # while it is tensioned axes move, and the place does not
        if executor.refuses or stands:
            self._know(contact)
            return
        goes_in = gone > 0.0 and not tensions
        if contact.force > (_TOUCH if goes_in else max(_TOUCH, _MORE * self._known)):
            self._know(contact)
            executor.refuse_to_go_on(f"contact: {contact.words} with {contact.force:.1f} N")

    def _know(self, contact: Contact) -> None:
        self._known = max(self._known, contact.force)
        if self._executor.obstructed in ("", self._words):
            self._words = f"contact: {contact.words} with {contact.force:.1f} N; only the way back is open"
            self._executor.obstructed = self._words
