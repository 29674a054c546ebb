"""Messages on a serial line come out as they went in, whatever is lost, damaged or between them."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hognose.drive.serial_slider.framing import AROUND, LONGEST, START, UNFINISHED, Decoder, Message, crc16, framed
from hognose.drive.serial_slider.messages import (
    Ability,
    BoardState,
    Configure,
    Flags,
    Kind,
    Latch,
    Result,
    Status,
    Target,
    Welcome,
)

PAGE = Path(__file__).parents[2] / "docs" / "slider-board.md"
HEX = re.compile(r"A5( [0-9A-F]{2})+(?= |$)")
WELCOME = Welcome(
    1, Ability.BRAKE | Ability.END_SWITCHES, BoardState.UNCONFIGURED, Flags.REFERENCED, 1126, 0, "slider"
)  # fmt: skip
MESSAGES = st.builds(
    Message,
    st.integers(0, 255),
    st.integers(0, 255),
    st.one_of(st.binary(max_size=LONGEST), st.just(bytes([START]) * 9)),
)
QUIET = st.binary(max_size=30).map(lambda data: data.replace(bytes([START]), b"x"))


def test_the_checksum_is_the_standard_s():
    assert crc16(b"123456789") == 0x29B1
    assert crc16(b"") == 0xFFFF


def test_the_bytes_of_the_page_are_what_is_said():
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    found = [HEX.search(line) for line in lines if line.startswith(("host ", "board "))]
    told = [bytes.fromhex(each.group().strip()) for each in found if each is not None]
    assert told == [
        framed(each)
        for each in (
            Message(Kind.HELLO, 1, bytes([1])),
            Message(Kind.WELCOME, 1, WELCOME.payload()),
            Message(Kind.CONFIGURE, 2, Configure(100, 5000, -1000, 1_100_000).payload()),
            Message(
                Kind.STATUS, 2, Status(Result.DONE, BoardState.DISABLED, Flags.REFERENCED, 0, 0, 0, 0, 0).payload()
            ),
            Message(Kind.TARGET, 42, Target(123_456, 30, 29_168, 583_350).payload()),
            Message(Kind.LATCH, 43, Latch(42, 48).payload()),
            Message(Kind.STATUS, 43, Status(Result.DONE, BoardState.ENABLED, Flags(7), 122_756, 47, 0, 0, 0).payload()),
            Message(Kind.STOP, 44, (583_350).to_bytes(4, "little")),
        )
    ]


@given(st.lists(st.tuples(QUIET, MESSAGES), max_size=20), st.integers(1, 40))
@settings(deadline=None)
def test_messages_are_found_between_anything_however_bytes_are_cut(parts, size):
    data = b"".join(noise + framed(message) for noise, message in parts)
    decoder, found = Decoder(), []
    for start in range(0, len(data), size):
        found += decoder.feed(data[start : start + size], 0.0)
    assert found == [message for _, message in parts]
    assert decoder.bad == 0
    assert decoder.skipped == sum(len(noise) for noise, _ in parts)


@given(st.binary(max_size=200), st.lists(MESSAGES, min_size=1, max_size=4), st.integers(1, 60))
@example(bytes([START, 40]), [Message(9, 1)], 3)
@settings(deadline=None)
def test_behind_any_garbage_the_next_messages_are_found_in_time(garbage, messages, size):
    """Garbage may look like the beginning of a message; what it swallows comes out when it was never finished."""
    data = garbage + b"".join(framed(message) for message in messages)
    decoder, found, now = Decoder(), [], 0.0
    for start in range(0, len(data), size):
        found += decoder.feed(data[start : start + size], now)
        now += 1e-4
    for _ in range(len(garbage) + 1):
        now += 2 * UNFINISHED
        found += decoder.feed(b"", now)
    assert found[len(found) - len(messages) :] == messages


@given(MESSAGES, st.integers(0, LONGEST + AROUND - 1), MESSAGES)
@settings(deadline=None)
def test_a_message_that_was_cut_off_costs_no_other(cut, at, whole):
    data, decoder = framed(cut)[: min(at, len(cut.payload) + AROUND - 1)], Decoder()
    found = decoder.feed(data, 0.0)
    found += decoder.feed(framed(whole), 0.001)
    for turn in range(1, len(data) + 2):
        found += decoder.feed(b"", turn * 2 * UNFINISHED)
    assert found[-1:] == [whole]
    assert (decoder.bad > 0) == bool(data)


def test_no_damage_of_up_to_three_bits_goes_unnoticed():
    whole = framed(Message(Kind.TARGET, 7, Target(-5, 30, 9, 1000).payload()))
    rng = np.random.default_rng(1)
    for _ in range(3000):
        bits = rng.choice(8 * (len(whole) - 1), rng.integers(1, 4), replace=False) + 8
        damaged = bytearray(whole)
        for bit in bits.tolist():
            damaged[bit // 8] ^= 1 << bit % 8
        decoder = Decoder()
        found = decoder.feed(bytes(damaged), 0.0)
        for turn in range(1, 20):
            found += decoder.feed(b"", turn * 2 * UNFINISHED)
        assert found == []
        assert decoder.bad >= 1


def test_a_slow_message_is_not_given_up_with_one_that_was_cut_off_before_it():
    whole, decoder = framed(Message(Kind.ASK, 1)), Decoder()
    assert decoder.feed(bytes([START, 40]), 0.0) == []
    assert decoder.feed(whole[:3], 0.9 * UNFINISHED) == []
    assert decoder.feed(b"", 1.1 * UNFINISHED) == []
    assert decoder.feed(whole[3:], 1.5 * UNFINISHED) == [Message(Kind.ASK, 1)]


INT32 = st.integers(-(2**31), 2**31 - 1)
STATUSES = st.builds(
    Status, st.sampled_from(Result), st.sampled_from(BoardState), st.integers(0, 7).map(Flags), INT32, INT32,
    st.integers(0, 0xFFFF), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF),
)  # fmt: skip
WELCOMES = st.builds(
    Welcome, st.just(1), st.integers(0, 7).map(Ability), st.sampled_from(BoardState), st.integers(0, 7).map(Flags),
    st.integers(0, 2**32 - 1), INT32, st.text(st.characters(min_codepoint=0x21, max_codepoint=0x7E), max_size=32),
)  # fmt: skip


@given(STATUSES, WELCOMES)
def test_what_a_board_says_is_understood(status, welcome):
    assert Status.of(status.payload()) == status
    assert Welcome.of(welcome.payload()) == welcome


@pytest.mark.parametrize("payload", [b"", bytes(16), bytes(18), bytes([9]) + bytes(16), bytes([0, 9]) + bytes(15)])
def test_a_status_that_is_none_is_none(payload):
    assert Status.of(payload) is None


def test_payloads_have_the_lengths_of_the_page():
    assert [len(each) for each in (Configure(100, 5000, -1, 1).payload(), Target(0, 30, 1, 1).payload())] == [14, 14]
    assert Latch(200, 65535).payload() == bytes([200, 0xFF, 0xFF])
    assert Welcome.of(b"") is None
    assert Welcome.of(bytes([1, 2])) is None
    other = Welcome.of(bytes([3, 2]))
    assert other is not None
    assert other.version == 3
