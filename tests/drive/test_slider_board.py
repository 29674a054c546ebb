"""What an emulated board does alone, as docs/slider-board.md asks of every board."""

import struct

import pytest
from slider_makers import NODE, rig_of

from hognose.drive.emulator.board import EmulatedBoard
from hognose.drive.emulator.faults import Fault
from hognose.drive.serial_slider.framing import Decoder, Message, framed
from hognose.drive.serial_slider.messages import BoardState, Configure, Flags, Kind, Latch, Result, Status, Target
from hognose.errors import InputError


class Asked:
    """A board alone, and what it answers."""

    def __init__(self):
        self.board, self.number, self.now = EmulatedBoard(), 0, 0.0
        self.tell(Kind.CONFIGURE, Configure(100, 5000, -100, 1000).payload())
        self.tell(Kind.ENABLE)

    def tell(self, kind, payload=b"", skip=0):
        """Its answer."""
        (answer,) = self.send(kind, payload, skip)
        status = Status.of(answer.payload)
        assert status is not None
        return status

    def send(self, kind, payload=b"", skip=0):
        self.number = (self.number + 1 + skip) % 256
        self.board.hear(framed(Message(kind, self.number, payload)), self.now)
        answers = Decoder().feed(self.board.say(self.now), self.now)
        assert all((each.kind, each.number) == (Kind.STATUS, self.number) for each in answers)
        return answers

    def latch(self, *targets, lost=0, delay=0):
        """The result of a LATCH for the last of some targets, behind which some more were lost."""
        for target in targets:
            assert self.send(Kind.TARGET, target.payload()) == []
        return self.tell(Kind.LATCH, Latch((self.number + lost) % 256, delay).payload(), lost).result

    def wait(self, seconds):
        for _ in range(round(1e3 * seconds)):
            self.now += 1e-3
            self.board.advance(1e-3, self.now)
        return self.board.axis.demanded


def test_a_board_takes_the_target_that_its_latch_names_and_no_other():
    asked = Asked()
    assert asked.latch(Target(500, 10, 10**6, 10**6), lost=1) is Result.NO_SUCH_TARGET
    assert asked.wait(0.02) == 0
    assert asked.latch(Target(500, 10, 10**6, 10**6), Target(30, 10, 10**6, 10**6)) is Result.DONE
    assert asked.wait(0.005) == pytest.approx(15)
    assert asked.wait(0.02) == 30
    assert asked.tell(Kind.LATCH, Latch(asked.number, 0).payload()).result is Result.NO_SUCH_TARGET
    assert asked.tell(Kind.ASK).lost == 1


def test_a_board_goes_steadily_and_never_faster_than_it_is_told():
    asked = Asked()
    assert asked.latch(Target(100, 10, 2000, 10**6)) is Result.DONE
    assert asked.wait(0.01) == pytest.approx(20)
    assert asked.wait(0.05) == 100
    assert asked.latch(Target(200, 10, 10**6, 10**6), delay=50) is Result.DONE
    assert asked.wait(0.004) == 100
    assert asked.latch(Target(300, 10, 10**6, 10**6)) is Result.DONE  # from where the one before has only begun
    assert asked.wait(0.005) == pytest.approx(200)
    status = asked.tell(Kind.STOP, struct.pack("<I", 2_000_000))
    assert status.state is BoardState.STOPPED
    assert asked.wait(0.02) == pytest.approx(200 + 0.5 * 20_000**2 / 2e6)
    assert asked.latch(Target(0, 10, 10**6, 10**6)) is Result.NOT_NOW


@pytest.mark.parametrize(
    "target", [Target(1001, 10, 9, 9), Target(-101, 10, 9, 9), Target(0, 0, 9, 9), Target(0, 1001, 9, 9),
               Target(0, 10, 0, 9), Target(0, 10, 9, 0)],
)  # fmt: skip
def test_a_board_refuses_targets_that_are_not_allowed(target):
    asked = Asked()
    assert asked.latch(target) is Result.NOT_ALLOWED
    assert asked.wait(0.05) == 0


def test_a_board_says_what_it_does_not_do():
    asked = Asked()
    assert asked.tell(0x55).result is Result.UNKNOWN_KIND
    assert asked.tell(Kind.STOP).result is Result.WRONG_LENGTH
    assert asked.tell(Kind.REFERENCE, bytes(4)).result is Result.NOT_NOW
    for wrong in (Configure(0, 1, 0, 1), Configure(1, 0, 0, 1), Configure(1, 1, 1, 1)):
        assert asked.tell(Kind.CONFIGURE, wrong.payload()).result is Result.NOT_ALLOWED
    asked.board.referenced = False
    assert asked.tell(Kind.DISABLE).state is BoardState.DISABLED
    assert asked.tell(Kind.ENABLE).result is Result.NOT_NOW
    assert asked.tell(Kind.STOP, bytes(4)).result is Result.NOT_NOW
    assert asked.tell(Kind.REFERENCE, struct.pack("<i", -77)).position == -77
    answer = asked.tell(Kind.ENABLE)
    assert (answer.result, answer.flags) == (Result.DONE, Flags.HOLDS | Flags.REFERENCED)
    asked.board.hear(b"\xa5\xff", asked.now)
    assert asked.tell(Kind.ASK).bad == 1
    asked.wait(0.2)
    silent = asked.tell(Kind.ASK)
    assert (silent.state, silent.error) == (BoardState.STOPPED, 0x8130)


@pytest.mark.parametrize(
    ("node", "kind", "said"),
    [
        (NODE, "underflow", "'underflow' is none of a slider's board; those are following_error,"),
        (3, "garbage", "'garbage' is one of a slider's board, and node 3 is none"),
        (40, "stuck", r"there is no node 40; nodes are \[1, 2, .*36, 126\]"),
    ],
)
def test_faults_that_cannot_be_are_refused(node, kind, said):
    with pytest.raises(InputError, match=said):
        rig_of().emulator.inject(Fault(node, kind))
