"""Who else is on the bus: heard and asked for before any drive is written to, so that nobody else commands them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hognose.drive.alike import sentences
from hognose.drive.bus import Bus
from hognose.drive.buses import Buses
from hognose.drive.clock import Clock
from hognose.drive.frames import Frame
from hognose.drive.masters import commanding
from hognose.drive.network import Network
from hognose.drive.network_spec import MASTER
from hognose.drive.sdo import REPLY, REQUEST
from hognose.drive.serial_slider.adapter import SliderBus
from hognose.errors import InputError

#: So long (s) it is listened for others: longer than their heartbeats and SYNCs take, as those of masters are set.
LISTENS = 0.3
#: So many nodes are asked at once, so often (s): a queue of ten frames, as Linux has it, does not run over.
_AT_ONCE, _PAUSE = 4, 2e-3
#: What every node is asked for: its serial number.
_ASKED = bytes([0x40, 0x18, 0x10, 4, 0, 0, 0, 0])
#: Base identifiers of what nodes say: emergencies, PDOs, replies, heartbeats.
_SAYS = (0x080, 0x180, 0x280, 0x380, 0x480, REPLY, 0x700)


def refuse_others(
    bus: Bus, clock: Clock, network: Network, others: Callable[[Frame], None] = lambda frame: None
) -> None:
    """Listen to the bus and ask all node ids who is there; nothing is written to anyone.

    Parameters
    ----------
    bus
    clock
    network
    others
        Called with every frame that came.

    Raises
    ------
    InputError
        Somebody else commands drives, two nodes have the same id, or a node is on the bus that the network file does
        not know: a sentence for each.
    """
    heard = _heard(bus, clock, network, others)
    known = {*network.nodes, *(node for spec in network.spec.buses for node in spec.others)}
    found = [*_masters(heard, network), *_twins(heard), *_strangers(heard, known)]
    found += _misplaced(bus)
    if found:
        raise InputError(f"{network.source}: " + "\n  ".join(found))


def _can_of(bus: Bus) -> Bus:
    """The bus of the drives, without the slider's board."""
    return bus.can if isinstance(bus, SliderBus) else bus


def _misplaced(bus: Bus) -> list[str]:
    can = _can_of(bus)
    return can.misplaced if isinstance(can, Buses) else []


def _heard(bus: Bus, clock: Clock, network: Network, others: Callable[[Frame], None]) -> list[Frame]:
    """All that came while every node id was asked."""
    found: list[Frame] = []
    can = _can_of(bus)
    ask = can.send_everywhere if isinstance(can, Buses) else can.send
    asked = iter([*network.nodes, *(node for node in range(1, MASTER + 1) if node not in network.nodes)])
    end, next_time = clock.now() + LISTENS, clock.now()
    while clock.now() < end:
        if clock.now() >= next_time:
            next_time = clock.now() + _PAUSE
            some = [node for node, _ in zip(asked, range(_AT_ONCE), strict=False)]
            ask([Frame(REQUEST + node, _ASKED) for node in some])
        for frame in bus.receive():
            found.append(frame)
            others(frame)
        clock.wait(min(end, clock.now() + _PAUSE))
    return found


def _masters(heard: Iterable[Frame], network: Network) -> list[str]:
    """What somebody else who commands drives says, in words."""
    found: dict[str, str] = {}
    for words in filter(None, (commanding(frame, network.nodes) for frame in heard)):
        found.setdefault(words.partition(" (")[0], words)
    if not found:
        return []
    return [f"there is another master on the bus: somebody {', '.join(found.values())}. End the other program first"]


def _twins(heard: Iterable[Frame]) -> list[str]:
    """Nodes that answered in more than one way."""
    replies: dict[int, set[bytes]] = {}
    for cob, data in heard:
        if REPLY < cob <= REPLY + MASTER and data[1:4] == _ASKED[1:4]:
            replies.setdefault(cob - REPLY, set()).add(data)
    return [
        f"two drives answer as node {node}: give each a node id of its own"
        for node, answers in sorted(replies.items())
        if len(answers) > 1
    ]


def _strangers(heard: Iterable[Frame], known: set[int]) -> list[str]:
    """Nodes that the network file does not know, and what was heard of each."""
    found: dict[int, set[str]] = {}
    for cob, _ in heard:
        base, node = cob & 0x780, cob & 0x7F
        if base in _SAYS and node and node != MASTER and node not in known:
            found.setdefault(node, set()).add(_what(base))
    said = {
        node: f"on the bus, but not in the file: {', '.join(sorted(ways))}. What is a drive needs its place in "
        "drives.nodes, or is to be turned off; what is something else, such as a sensor, belongs in bus.others"
        for node, ways in found.items()
    }
    return sentences(said, lambda node: f"node {node}", "others")


def _what(base: int) -> str:
    return {0x700: "sends heartbeats", REPLY: "answers", 0x080: "reports errors"}.get(base, "sends PDOs")
