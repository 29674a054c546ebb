"""What emulated motors move."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Plant(Protocol):
    """The arm behind the motors: ideal, or a twin of it."""

    def move(self, counts: Array, slider: float, dt: float) -> None:
        """Let a time (s) pass, in which motors go to positions (A,) in counts and the slider to a place in counts."""
        ...

    def sight(self) -> object:
        """What is to be told, now, to who watches the arm from outside; of a kind that can be pickled."""
        ...

    @property
    def tensions(self) -> Array:
        """What each motor pulls (A,) N."""
        ...


class NoArm:
    """Nothing hangs on the motors; every one pulls the same."""

    def __init__(self, axes: int, tension: float = 40.0) -> None:
        self.tensions: Array = np.full(axes, tension)

    def move(self, counts: Array, slider: float, dt: float) -> None:
        """See `Plant.move`."""
        del counts, slider, dt

    def sight(self) -> None:
        """See `Plant.sight`: nothing."""
