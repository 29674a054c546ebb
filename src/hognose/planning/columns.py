"""The columns of a plan file: every quantity is declared once, and files, exports and documentation are made from that.

A script that has a further figure to show of every plan appends to `QUANTITIES`:

    QUANTITIES.append(Quantity("bend_{section}_rad", "rad", "bend angle by section", bends, ("section",)))

Another package names its quantity, or a list of such, under the entry points `hognose.columns`: then it is known
wherever plans are read or written, whatever else is loaded.
"""

from __future__ import annotations

import itertools
import math
import string
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import several
from hognose.errors import InputError
from hognose.extensions import added, words_of
from hognose.extensions import home as package_of
from hognose.planning.motion import Motion
from hognose.planning.motion_spec import LONGEST_MOTION
from hognose.robot import Robot

#: No cable bears more (N); load factors beyond this are all the same: the arm does not buckle.
LARGEST_TENSION, LARGEST_LOAD_FACTOR = 1e8, 1000.0
#: Where a quantity is from that no package adds, for a message.
_LIST = "hognose.planning.columns.QUANTITIES"


def _numbers(count: int, first: int = 1) -> list[str]:
    return [f"{number:02d}" for number in range(first, first + count)]


#: What a quantity can have a figure for at every step: how the names of columns call each, in the order of the array.
LABELS: dict[str, Callable[[Robot], Sequence[str]]] = {
    "joint": lambda robot: _numbers(robot.sections + 1, 0),
    "section": lambda robot: _numbers(robot.sections),
    "extending section": lambda robot: [_numbers(robot.sections)[i] for i in np.flatnonzero(robot.extending)],
    "link": lambda robot: _numbers(robot.sections),
    "cable": lambda robot: _numbers(robot.cables),
    "xyz": lambda robot: "xyz",
    "pose": lambda robot: ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"),
    "angle": lambda robot: ("alpha", "beta"),
}


@dataclass(frozen=True)
class Quantity:
    """Something that a plan has figures of at every step.

    Attributes
    ----------
    pattern
        The names of its columns, as in `joint_{joint}_{xyz}_m`; what stands first in it varies slowest.
    unit
        Of its figures, SI.
    meaning
        What it is, in a sentence without its end.
    of
        An attribute of `Motion`, or a function of one: its figures (T, …), or None where the robot has no such thing.
    each
        Axes of the array behind the steps, as keys of `LABELS`; the pattern names each once.
    whole
        Whether its figures are whole numbers, of 64 bits; double precision otherwise.
    stored
        Whether a reader needs it to make the motion. What is not stored follows from what is, and is held against it
        when it is read.
    since
        The schema version from which on every plan file has it; None if any may lack it.
    tolerance
        How far a figure that is read may be from what it follows from.
    largest
        Figures beyond this, either way, are damage.
    """

    pattern: str
    unit: str
    meaning: str
    of: str | Callable[[Motion], NDArray[Any] | None]
    each: tuple[str, ...] = ()
    whole: bool = False
    stored: bool = False
    since: int | None = None
    tolerance: float = 1e-9
    largest: float = LONGEST_MOTION

    def __post_init__(self) -> None:
        if sorted(self.named) != sorted(self.each) or not set(self.each) <= set(LABELS):
            raise InputError(
                f"quantity {self.pattern!r}: expected {{…}} around each of {self.each}, once, and of these only: "
                f"{', '.join(LABELS)}"
            )
        if self.stored and not isinstance(self.of, str):
            raise InputError(f"quantity {self.pattern!r}: what is stored is an attribute of Motion; `of` names it")

    @property
    def named(self) -> list[str]:
        """The axes, in the order of the pattern."""
        return [name for _, name, _, _ in string.Formatter().parse(self.pattern) if name is not None]

    @property
    def shown(self) -> str:
        """The pattern for people, as in `deviation_NN_m`."""
        return self.pattern.format(**{name: "xyz" if name == "xyz" else "NN" for name in self.named})

    @property
    def _function(self) -> str:
        """Where its figures come from, for a message."""
        if isinstance(self.of, str):
            return f"Motion.{self.of}"
        named = (getattr(self.of, name, None) for name in ("__module__", "__qualname__"))
        return "its function " + ".".join(name for name in named if isinstance(name, str))

    @property
    def type(self) -> np.dtype[Any]:
        """What its cells are."""
        return np.dtype(np.int64 if self.whole else np.float64)

    def shape(self, robot: Robot) -> tuple[int, ...]:
        """The axes of its array behind the steps."""
        return tuple(len(LABELS[name](robot)) for name in self.each)

    def values(self, motion: Motion) -> NDArray[Any] | None:
        """Its figures (T, …), or None where there is no such thing.

        Raises
        ------
        InputError
            They are not what was declared, or its function raises an error.
        """
        try:
            found = getattr(motion, self.of) if isinstance(self.of, str) else self.of(motion)
        except (Exception, SystemExit) as error:
            raise InputError(
                f"quantity {self.pattern!r}: {self._function} failed with {words_of(error)}; expected an array. Mend "
                f"it, or take the quantity out of {_home(self)}"
            ) from error
        if found is None and self.since is None:
            return None
        expected = (len(motion.time), *self.shape(motion.robot))
        if not isinstance(found, np.ndarray) or found.shape != expected or found.dtype != self.type:
            given = f"{found.dtype} {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
            raise InputError(f"quantity {self.pattern!r}: expected an array of {self.type} {expected}, got {given}")
        return found

    def columns(self, robot: Robot) -> Iterator[Column]:
        """Its columns, in the file's order."""
        named = self.named
        for labels in itertools.product(*(enumerate(LABELS[name](robot)) for name in named)):
            at = {name: place for name, (place, _) in zip(named, labels, strict=True)}
            words = {name: label for name, (_, label) in zip(named, labels, strict=True)}
            yield Column(self.pattern.format(**words), self, tuple(at[name] for name in self.each))


@dataclass(frozen=True)
class Column:
    """One column: its name in the file, and the cells `values[:, *place]` of a quantity."""

    name: str
    quantity: Quantity
    place: tuple[int, ...] = ()


def _tensions(motion: Motion) -> NDArray[np.float64] | None:
    return None if motion.held is None else motion.held.tensions


def _commanded_lengths(motion: Motion) -> NDArray[np.float64] | None:
    return None if motion.held is None else motion.commanded_lengths


def _section_lengths(motion: Motion) -> NDArray[np.float64] | None:
    return motion.section_lengths[:, motion.robot.extending] if motion.robot.extends else None


def _load_factor(motion: Motion) -> NDArray[np.float64] | None:
    return None if motion.held is None else np.minimum(motion.held.load_factor, LARGEST_LOAD_FACTOR)


#: Everything that a plan has figures of, in the order of the file; what installed packages add comes behind it.
QUANTITIES: list[Quantity] = [
    Quantity(
        "time_s", "s", "time of the set-point: 0, then one control period (`motion.period_s`) a row",
        "time", stored=True, since=1,
    ),
    Quantity(
        "feed_m", "m",
        "how far the first joint is fed along the path, from 0: one `motion.step` a row, the last one shorter, or as "
        "the profile says; a retraction backwards",
        "feed", stored=True, since=1,
    ),
    Quantity(
        "joint_{joint}_{xyz}_m", "m", "joints and tip on the path, in the task's frame",
        "joints", ("joint", "xyz"), stored=True, since=1,
    ),
    Quantity(
        "{angle}_{section}_rad", "rad", "joint angles by section",
        "angles", ("section", "angle"), stored=True, since=1,
    ),
    Quantity(
        "cable_{cable}_m", "m", "absolute cable lengths, in the robot's cable order",
        "cable_lengths", ("cable",), stored=True, since=1,
    ),
    Quantity(
        "motor_{cable}_counts", "counts", "motor positions, zero at the straight arm",
        "motor_counts", ("cable",), whole=True, stored=True, since=1,
    ),
    Quantity(
        "base_{pose}", "m, 1", "pose of the first joint if a carrier takes it along: place and unit quaternion",
        "base_pose", ("pose",), stored=True,
    ),
    Quantity(
        "clearance_{link}_m", "m", "clearance by link; a value at `clearance_horizon_m` is a lower bound",
        "clearance", ("link",), stored=True, since=1,
    ),
    Quantity(
        "deviation_{link}_m", "m", "the largest distance of points along each link from the path",
        "body_deviation", ("link",), since=2,
    ),
    Quantity(
        "length_{extending section}_m", "m", "how long each section that extends is",
        _section_lengths, ("extending section",),
    ),
    Quantity(
        "tension_{cable}_N", "N", "tensions that hold the arm, closest to the pretension; where mechanics are known",
        _tensions, ("cable",), tolerance=1e-6, largest=LARGEST_TENSION,
    ),
    Quantity(
        "commanded_cable_{cable}_m", "m",
        "cable lengths without their stretch, of which motor positions are made; where mechanics are known",
        _commanded_lengths, ("cable",),
    ),
    Quantity(
        "buckling_load_factor", "1",
        "by how much all tensions and the weight would have to grow until the arm buckles, 1000 at most; where "
        "mechanics are known",
        _load_factor, tolerance=1e-6,
    ),
]  # fmt: skip


def quantities() -> tuple[Quantity, ...]:
    """All quantities: those of `QUANTITIES` and those of installed packages, in this order.

    Raises
    ------
    InputError
        What is no quantity, or one of a package that a file of another installation would have to have; says which.
    """
    return tuple(quantity for _, given in _groups() for quantity in given)


def _groups() -> Iterator[tuple[str, list[Quantity]]]:
    """Quantities by where they are from."""
    expected = "a hognose.planning.columns.Quantity"
    yield _LIST, several(_LIST, QUANTITIES, Quantity, expected)
    for name, given in added("columns").items():
        home = f"the entry {name!r} of hognose.columns in the package {package_of('columns', name)}"
        if not isinstance(given, Quantity | list | tuple):  # what can be gone through once would be there once
            raise InputError(f"{home}: expected {expected}, or a list of them, got {type(given).__name__}")
        found = several(home, [given] if isinstance(given, Quantity) else given, Quantity, expected)
        for quantity in found:
            if quantity.stored or quantity.since is not None:
                raise InputError(
                    f"{home}: quantity {quantity.pattern!r} is declared with stored or since, as if every plan file "
                    "had it; files of other installations lack it: leave both out"
                )
        yield home, found


def _home(quantity: Quantity) -> str:
    """Where a quantity is from, for a message."""
    return next((home for home, given in _groups() if any(each is quantity for each in given)), _LIST)


def columns_of(robot: Robot) -> tuple[Column, ...]:
    """All columns that plans of a robot can have, in the file's order.

    Raises
    ------
    InputError
        Two quantities have columns of one name.
    """
    found: dict[str, Column] = {}
    for column in itertools.chain.from_iterable(quantity.columns(robot) for quantity in quantities()):
        if column.name in found:
            both = found[column.name].quantity, column.quantity
            said = " and ".join(f"{quantity.pattern!r} from {_home(quantity)}" for quantity in both)
            raise InputError(f"two quantities have a column {column.name!r}: {said}")
        found[column.name] = column
    return tuple(found.values())


def cells_of(motion: Motion) -> dict[str, NDArray[Any]]:
    """The cells (T,) of all columns that a motion has and Hognose knows, in the file's order."""
    values = {id(quantity): quantity.values(motion) for quantity in quantities()}
    found: dict[str, NDArray[Any]] = {}
    for column in columns_of(motion.robot):
        whole = values[id(column.quantity)]
        if whole is not None:
            found[column.name] = whole[(slice(None), *column.place)]
    return found


def differing(quantity: Quantity, read: NDArray[Any], motion: Motion) -> tuple[Column, int, float] | None:
    """Where figures that were read are farther than they may be from what they follow from.

    Returns
    -------
    tuple or None
        The column, the step, and by how much, at the worst place; infinitely far from a figure that there is not.
    """
    expected = quantity.values(motion)
    if not read.size:
        return None
    off = np.full(read.shape, math.inf) if expected is None else np.abs(read.astype(float) - expected)
    worst = np.unravel_index(np.argmax(off), off.shape)
    if off[worst] <= quantity.tolerance:
        return None
    column = next(c for c in quantity.columns(motion.robot) if c.place == tuple(int(k) for k in worst[1:]))
    return column, int(worst[0]), float(off[worst])
