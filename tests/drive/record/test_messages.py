"""Messages are what ROS 2 makes of the same values, byte for byte: rosbags, which is not ours, is asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hognose.drive.record import CycleRow, Event, messages
from hognose.drive.record.cdr import Decoder

STORE: Any = get_typestore(Stores.ROS2_HUMBLE)
for name, text in messages.TOPICS.values():
    STORE.register(get_types_from_msg(text, name))  # of ROS's own messages: fails if they were other ones

STAMP = st.integers(0, 2**31 * 10**9 - 1)
NUMBER = st.floats(width=64)
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=30)


def rows(cables):
    def array(kind, elements):
        return arrays(kind, cables, elements=elements)

    whole = st.integers(-(2**63), 2**63 - 1)
    status = st.integers(0, 2**16 - 1)
    return st.builds(
        CycleRow, NUMBER, TEXT, NUMBER, array(np.int64, whole), array(np.int64, whole), array(np.float64, NUMBER),
        array(np.float64, NUMBER), array(np.float64, NUMBER), array(np.uint16, status), NUMBER, NUMBER, NUMBER,
    )  # fmt: skip


def same(value, expected):
    return np.asarray(value).tobytes() == np.asarray(expected).tobytes()


@given(stamp=STAMP, row=st.integers(1, 40).flatmap(rows))
def test_a_cycle(stamp, row):
    data = messages.cycle_message(stamp, row)
    theirs = STORE.deserialize_cdr(data, "hognose_msgs/msg/Cycle")
    assert bytes(STORE.serialize_cdr(theirs, "hognose_msgs/msg/Cycle")) == data
    assert theirs.header.stamp.sec * 10**9 + theirs.header.stamp.nanosec == stamp
    assert theirs.header.frame_id == ""
    for name, value in zip(CycleRow._fields, messages.cycle_row(data), strict=True):
        expected = getattr(row, name)
        if name == "state":
            assert value == expected == theirs.state
        else:
            assert same(value, expected), name
            assert same(getattr(theirs, name), expected), name


@given(
    stamp=STAMP, time=NUMBER, kind=TEXT, text=TEXT,
    node=st.none() | st.integers(0, 127), step=st.none() | st.floats(allow_nan=False),
)  # fmt: skip
def test_an_event(stamp, time, kind, text, node, step):
    data = messages.event_message(stamp, Event(time, kind, text, node, step))
    theirs = STORE.deserialize_cdr(data, "hognose_msgs/msg/Event")
    assert bytes(STORE.serialize_cdr(theirs, "hognose_msgs/msg/Event")) == data
    assert (theirs.kind, theirs.text, theirs.node) == (kind, text, -1 if node is None else node)
    assert same(theirs.time, time)
    read = messages.event(data)
    assert (read.kind, read.text, read.node, read.step) == (kind, text, node, step)
    assert same(read.time, time)


@given(stamp=STAMP, names=st.lists(TEXT, min_size=1, max_size=40), seed=st.integers(0, 99), pulls=st.booleans())
def test_states_of_joints(stamp, names, seed, pulls):
    drawn = np.random.default_rng(seed)
    positions, efforts = drawn.normal(size=(2, len(names)))
    data = messages.joints_message(stamp, messages.names_of(names), positions, efforts if pulls else np.zeros(0))
    theirs = STORE.deserialize_cdr(data, "sensor_msgs/msg/JointState")
    assert bytes(STORE.serialize_cdr(theirs, "sensor_msgs/msg/JointState")) == data
    assert theirs.name == names
    assert same(theirs.position, positions)
    assert same(theirs.effort, efforts if pulls else np.zeros(0))
    assert len(theirs.velocity) == 0


@given(stamp=STAMP, jpeg=st.binary(max_size=200))
def test_a_picture(stamp, jpeg):
    data = messages.image_message(stamp, jpeg)
    theirs = STORE.deserialize_cdr(data, "sensor_msgs/msg/CompressedImage")
    assert bytes(STORE.serialize_cdr(theirs, "sensor_msgs/msg/CompressedImage")) == data
    assert (theirs.format, theirs.data.tobytes(), theirs.header.frame_id) == ("jpeg", jpeg, "tip_camera")
    assert messages.image(data) == (stamp, jpeg)


@given(row=rows(3), cut=st.floats(0, 1, exclude_max=True))
def test_what_is_cut_is_no_message(row, cut):
    data = messages.cycle_message(0, row)
    with pytest.raises(ValueError, match=r"ends too early|plain CDR|without its end"):
        messages.cycle_row(data[: int(cut * len(data))])


def test_other_encodings_are_refused():
    with pytest.raises(ValueError, match="little-endian plain CDR"):
        Decoder(b"\x00\x00\x00\x00\x00\x00\x00\x05")


def test_what_is_no_letter_does_not_end_a_run():
    read = messages.event(messages.event_message(0, Event(1.0, "note", "caf\udce9.toml")))
    assert read.text == "caf?.toml"
