"""Where a drive is: it must know it before it is enabled, and is told where the arm stands exactly as a plan does.

A drive whose encoder counts says 0 after its supply came on, wherever the arm is. Drives of maxon say in bit 15 of
their statusword whether their position is referenced since. `declare` tells them: homing by the method that needs no
switch, with no distance to move, so that the present position becomes the one that is declared.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hognose.drive import cia402
from hognose.drive.axes import Axes
from hognose.drive.bring_up import EPOS2_PRODUCTS, MAXON
from hognose.drive.bus import Bus
from hognose.drive.cia402 import State, state_of
from hognose.drive.clock import Clock
from hognose.drive.frames import Frame
from hognose.drive.neighbours import refuse_others
from hognose.drive.network import Network
from hognose.drive.sdo import Request, Script, SdoError, run_scripts
from hognose.errors import HognoseError, InfeasibleError, InputError

Counts = NDArray[np.int64]
#: A part of a script that gives a number.
Reads = Generator[Request, bytes, int]

#: So often a drive is asked before it is said that it does not do what it was told: about 1 s.
_PATIENCE = 1000
#: A motor that rests stays within so many counts.
_RESTS = 20
#: So long (s) drives may take to start anew.
_STARTS = 3.0
#: Starts a node anew (CiA 301).
_RESET_NODE = 0x81
_STATES = (State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON, State.SWITCHED_ON)


def refuse_not_homed(axes: Axes) -> None:
    """Raise an InfeasibleError that names the axes that do not know where they are, by what their drives said last."""
    network = axes.network
    lost = [
        network.axis_name(axis)
        for axis, (word, is_absolute) in enumerate(zip(axes.status.tolist(), network.is_absolute, strict=True))
        if has_bit(network, axis) and not is_absolute and not word & cia402.REFERENCED
    ]
    if not lost:
        return
    who = f"{_listed(lost)} {'does not know where it is' if len(lost) == 1 else 'do not know where they are'}"
    raise InfeasibleError(
        f"{'no axis knows where it is' if len(lost) == len(axes) else who}: the drive says that its position is not "
        "referenced, as after its supply was cut. Bring the arm to where a plan is, in its jig, and declare it: "
        '`hognose home PLAN --network FILE`; or give position = "absolute" for encoders that keep it'
    )


def has_bit(network: Network, axis: int) -> bool:
    """Whether an axis is a drive on the bus, which says whether it is homed; boards on serial ports do not."""
    slider = network.spec.slider
    return axis < len(network.spec.drives.nodes) or slider is None or slider.kind != "serial"


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:5])
    return shown if len(names) <= 5 else f"{shown} and {len(names) - 5} more"


def _told(network: Network, faults: Mapping[int, str]) -> list[str]:
    """What is wrong with nodes: a sentence for each, or for all of many with which the same is wrong."""
    who: dict[str, list[str]] = {}
    for node, words in sorted(faults.items()):
        who.setdefault(words, []).append(network.axis_name(network.nodes.index(node)))
    return [
        f"{each}: {words}" for words, names in who.items() for each in (names if len(names) <= 5 else [_listed(names)])
    ]


@dataclass
class _Homed:
    """What is known of a drive that is told where it is.

    Attributes
    ----------
    target : counts
        Where it is.
    before : counts
        Where it said that it was.
    mode
        Of operation, before.
    is_epos2
    was_homed
        Whether it said before that its position is referenced.
    """

    target: int
    before: int = 0
    mode: int = 0
    is_epos2: bool = False
    was_homed: bool = False

    @property
    def method(self) -> int:
        """The homing method that takes the present position (maxon; 37 in the newer CiA 402)."""
        return 35 if self.is_epos2 else 37

    @property
    def home_position(self) -> int:
        """The object that holds what the position is to be."""
        return 0x2081 if self.is_epos2 else 0x30B0

    @property
    def move_distance(self) -> int:
        """The object that holds how far the motor is to move then."""
        return 0x607C if self.is_epos2 else 0x30B1


@dataclass
class Homing:
    """Tells all drives of a network where they are.

    Attributes
    ----------
    network
    counts : (A,)
        Where the axes are, by the plan.
    """

    network: Network
    counts: Counts
    _drives: dict[int, _Homed] = field(default_factory=dict)

    def declare(self, bus: Bus, clock: Clock) -> None:
        """Take the present position of every drive for the one that the plan gives it; nothing moves.

        Drives have power for that, for less than a second, and hold their positions meanwhile. Either all are homed, or
        none: if one fails, all are started anew, so that none takes itself for homed.

        Raises
        ------
        InputError
            Somebody else is on the bus; or a drive is silent, powered, turning or no drive of maxon, or does not do
            it: a sentence for each.
        """
        if any(self.network.is_absolute):
            raise InputError(
                f'{self.network.source}: axes with position = "absolute" are not homed: their encoders keep where they '
                "are. Give what they say where the plan says 0 as `zeros`; `hognose home --zeros` reads them"
            )
        refuse_others(bus, clock, self.network)
        self._drives = {
            node: _Homed(int(self.counts[axis]))
            for axis, node in enumerate(self.network.nodes)
            if has_bit(self.network, axis)
        }
        self._run(bus, clock, self._look, "nothing was declared")
        if any(drive.was_homed for drive in self._drives.values()):
            # If this program is killed on the way, what it did not reach must not count by where it was homed before.
            self._start_anew(bus, clock)
            self._run(bus, clock, self._look, "nothing was declared")
        self._run(bus, clock, self._prepare, "nothing was declared")
        try:
            self._run(bus, clock, self._take, "")
        except InputError as error:
            left = self._start_anew(bus, clock)
            raise InputError(f"{error}\n  {left}") from None
        except BaseException:
            with suppress(HognoseError):
                self._start_anew(bus, clock)
            raise

    def _run(self, bus: Bus, clock: Clock, script: Callable[[int], Script], hint: str) -> None:
        """Run a script with every drive; an InputError with a sentence for each that fails."""
        faults = run_scripts(bus, clock, {node: script(node) for node in self._drives})
        if faults:
            told = _told(self.network, faults)
            raise InputError(f"{self.network.source}: " + "\n  ".join([*told, *([hint] if hint else [])]))

    def _look(self, node: int) -> Script:
        """See what a drive is, and that it rests without power; nothing is written."""
        drive = self._drives[node]
        vendor = yield from _read(0x1018, 1, "<I")
        product = yield from _read(0x1018, 2, "<I")
        if vendor != MAXON:
            raise SdoError(
                f"is no drive of maxon (vendor 0x{vendor:X}), whose homing this program does not know; home it "
                "with the program of its maker"
            )
        drive.is_epos2 = product in EPOS2_PRODUCTS
        word = yield from _read(0x6041, 0, "<H")
        state, drive.was_homed = state_of(word), bool(word & cia402.REFERENCED)
        if state not in _STATES:
            raise SdoError(
                f"is in {state.words}; drives are homed at rest and without power: nobody else may command it, and "
                "errors must be gone (cut its supply, and turn it on again)"
            )
        drive.mode = yield from _read(0x6060, 0, "<b")
        drive.before = yield from _read(0x6064, 0, "<i")

    def _prepare(self, node: int) -> Script:
        """Write how to home; and see that the motor still rests where it did."""
        drive = self._drives[node]
        yield from _rests(drive)
        yield Request(0x6060, 0, struct.pack("<b", cia402.HOMING))
        yield Request(0x6098, 0, struct.pack("<b", drive.method))
        yield Request(drive.home_position, 0, struct.pack("<i", drive.target))
        yield Request(drive.move_distance, 0, bytes(4))
        if (yield from _read(drive.move_distance, 0, "<i")) != 0:  # the one value by which a motor would move
            raise SdoError(f"0x{drive.move_distance:04X}:0: it was told to move by nothing, and says otherwise")

    def _take(self, node: int) -> Script:
        """Home a drive, and take its power again in any case."""
        drive = self._drives[node]
        try:
            yield from _rests(drive)
            for word in (cia402.SHUTDOWN, cia402.SWITCH_ON, cia402.ENABLE):
                yield Request(0x6040, 0, struct.pack("<H", word))
            yield from _until(lambda word: state_of(word) is State.OPERATION_ENABLED, "is not enabled")
            yield Request(0x6040, 0, struct.pack("<H", cia402.ENABLE | 0x10))
            yield from _until(lambda word: bool(word & cia402.HOMING_ATTAINED), "does not come to be homed")
        except SdoError as error:
            yield from _without_power(drive.mode)
            raise error from None
        yield from _without_power(drive.mode)
        says = yield from _read(0x6064, 0, "<i")
        if abs(says - drive.target) > _RESTS:
            raise SdoError(f"was told that it is at {drive.target:,} counts, and says {says:,}")
        if not (yield from _read(0x6041, 0, "<H")) & cia402.REFERENCED:
            raise SdoError("took the position, but does not say that it is referenced")

    def _start_anew(self, bus: Bus, clock: Clock) -> str:
        """Start all drives anew; in words, whether any still takes itself for homed."""
        bus.send([Frame(0x000, bytes([_RESET_NODE, node])) for node in self._drives])
        end = clock.now() + _STARTS
        left = set(self._drives)
        while left and clock.now() < end:
            left -= {frame.cob - 0x700 for frame in bus.receive() if frame.data == b"\0"}
            clock.wait(clock.now() + 0.005)
        found: dict[int, int] = {}

        def ask(node: int) -> Script:
            found[node] = yield from _read(0x6041, 0, "<H")

        run_scripts(bus, clock, {node: ask(node) for node in self._drives})
        kept = [
            self.network.axis_name(axis)
            for axis, node in enumerate(self.network.nodes)
            if node in self._drives and found.get(node, cia402.REFERENCED) & cia402.REFERENCED
        ]
        if not kept:
            return "so none was homed: all drives were started anew"
        return (
            f"all drives were started anew, but {_listed(kept)} may still take themselves for homed: cut their supply "
            "before you run anything"
        )


def _read(index: int, sub: int, form: str) -> Reads:
    """A number of an object dictionary."""
    (value,) = struct.unpack(form, (yield Request(index, sub)))
    return value


def _rests(drive: _Homed) -> Script:
    """Refuse a motor that is not where it was."""
    now = yield from _read(0x6064, 0, "<i")
    if abs(now - drive.before) > _RESTS:
        raise SdoError(f"is turning: {abs(now - drive.before):,} counts meanwhile")


def _until(is_so: Callable[[int], bool], words: str) -> Script:
    """Ask for the statusword until it is as it is to be."""
    word = 0
    for _ in range(_PATIENCE):
        word = yield from _read(0x6041, 0, "<H")
        if is_so(word):
            return
        if word & cia402.HOMING_ERROR and state_of(word) is State.OPERATION_ENABLED:
            raise SdoError("reports a homing error")
        if state_of(word) in (State.FAULT, State.FAULT_REACTION):
            break
    raise SdoError(f"{words}: it is in {state_of(word).words}")


def _without_power(mode: int) -> Script:
    """Take a drive's power, and give it back its mode."""
    yield Request(0x6040, 0, struct.pack("<H", cia402.SHUTDOWN))
    yield Request(0x6060, 0, struct.pack("<b", mode))


def zeros_of(bus: Bus, clock: Clock, network: Network, counts: Counts) -> Counts:
    """What to give as zeros (A,) where the arm stands as a plan's counts (A,) say: what drives say, less these.

    Raises
    ------
    InputError
        A drive does not answer: a sentence for each.
    """
    says = counts.copy()

    def ask(axis: int) -> Script:
        says[axis] = yield from _read(0x6064, 0, "<i")

    scripts = {node: ask(axis) for axis, node in enumerate(network.nodes) if has_bit(network, axis)}
    faults = run_scripts(bus, clock, scripts)
    if faults:
        raise InputError(f"{network.source}: " + "\n  ".join(_told(network, faults)))
    return says - (counts - network.zeros)
