"""A run that is followed: exactly what is recorded, to who has the token; whoever is slow delays nobody."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import stat
import subprocess
import sys
import threading

import pytest
from live_makers import OPENING, START, Collector, Watched, address, put_cycle, put_event, until

from hognose.drive.live.address import Address, address_of, newest_addresses
from hognose.drive.live.following import Following
from hognose.drive.live.foxglove_server import shown_in_foxglove
from hognose.drive.live.frames import LONGEST_TOLD, PROTOCOL, Message, NotUnderstoodError, Reader, message_frame, word
from hognose.drive.live.outbox import Numbered, Outbox
from hognose.drive.live.server import Limits, Live
from hognose.drive.record import messages, record_file
from hognose.drive.record.container import read_container
from hognose.drive.wishes import Want, Wish, Wishes
from hognose.errors import InputError


@pytest.fixture
def live():
    made = Live(OPENING, Wishes(), Limits(farewell_s=0.2))
    yield made
    made.close()


def knocked(port, data):
    """What who sends some bytes at first gets until the connection is closed."""
    with socket.create_connection(("127.0.0.1", port), timeout=60.0) as knocker:
        knocker.sendall(data)
        found = b""
        while more := knocker.recv(1 << 16):
            found += more
    return found


def test_a_follower_gets_exactly_what_is_recorded(tmp_path):
    rig, file = Watched(), tmp_path / "run.mcap"
    with rig.recorded(file, Wishes()) as (writer, live):
        assert stat.S_IMODE(os.stat(f"{file}.live.json").st_mode) == 0o600 or os.name != "posix"
        collector = Collector(Following(address_of(file)))
        assert live.is_followed
        rig.ready().executor.run(2.0)
        writer.image(1e-3, b"\xff\xd8 a picture, older than what was recorded before \xff\xd9")
        writer.close("GOOD: at step 2")
    *came, end = collector.all()
    assert end == {"kind": "end"}
    held = read_container(file)
    recorded = [Message(held.channels[each.channel_id].topic, each.log_time, each.data) for each in held.messages]
    assert len(recorded) > 30
    assert {each.topic for each in recorded} == set(messages.TOPICS)
    assert came == recorded
    assert collector.following.run["motion_sha256"] == held.metadata[0].metadata["motion_sha256"]
    assert collector.following.run["before"] == 0
    assert not list(tmp_path.glob("*.live.json"))


def test_a_run_that_fails_ends_for_its_followers_too(tmp_path):
    rig, file = Watched(), tmp_path / "run.mcap"
    collectors = []

    def fail():
        with rig.recorded(file, Wishes()):
            collectors.append(Collector(Following(address_of(file))))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    (collector,) = collectors
    assert collector.all() == [{"kind": "end"}]
    assert not list(tmp_path.glob("*.live.json"))


def test_followers_see_what_a_full_disk_keeps_from_the_record(tmp_path, monkeypatch):
    rig, file = Watched(), tmp_path / "run.mcap"
    with rig.recorded(file, Wishes()) as (writer, _):
        collector = Collector(Following(address_of(file)))
        rig.ready()

        def full(number, data):
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as broken:
            broken.setattr(record_file.os, "write", full)
            outcome = rig.executor.run(9.0)
        assert outcome.place < 9.0
        writer.close("NOT GOOD")
    came = [each for each in collector.all() if isinstance(each, Message) and each.topic == "/events"]
    told = [messages.event(each.data).text for each in came]
    assert any("the record cannot be written any more" in text for text in told)
    assert told[-1] == "NOT GOOD"


def test_who_has_not_the_token_is_told_nothing_else(live):
    put_event(live, 1.0, "fault", "secret")
    put_cycle(live, 1)
    for token in ("wrong", live.token[:-1], live.token + "a", "ä", None, 5):
        reader = Reader(LONGEST_TOLD)
        (said,) = reader.take(knocked(live.port, word({"token": token, "protocol": PROTOCOL})))
        assert isinstance(said, dict)
        assert said.pop("kind") == "refused"
        assert list(said) == ["words"]
        assert "this is not the token of the run" in said["words"]
    assert not live.is_followed


@pytest.mark.parametrize(
    "data",
    [
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 4\r\n\r\nabcd",
        b"\x00\x00\x00\x00\x00",
        b"\xff\xff\xff\xff",
        b"\x02\x00\x00\x00J{",
        b"\x06\x00\x00\x00J[1,2]"[:10],
        message_frame("/state", 0, b"abc"),
        word({"token": "a" * 5000}),
    ],
)
def test_what_is_no_word_is_not_answered(live, data):
    put_event(live, 1.0, "fault", "secret")
    with contextlib.suppress(ConnectionResetError):  # closed with something unread
        assert knocked(live.port, data) == b""
    assert not live.is_followed


def test_who_says_nothing_does_not_stay():
    live = Live(OPENING, Wishes(), Limits(token_s=0.05, newcomers=2))
    assert knocked(live.port, b"") == b""
    silent = [socket.create_connection(("127.0.0.1", live.port), timeout=60.0) for _ in range(6)]
    assert [each.recv(1) for each in silent] == [b""] * 6
    for each in silent:
        each.close()
    live.close()


def test_another_version_is_refused(live, tmp_path, monkeypatch):
    monkeypatch.setattr("hognose.drive.live.following.PROTOCOL", PROTOCOL + 1)
    with pytest.raises(InputError, match="speaks version 1 of the protocol"):
        Following(address(live, tmp_path))


def test_so_many_follow_and_no_more(tmp_path):
    live = Live(OPENING, Wishes(), Limits(followers=2, farewell_s=0.2))
    two = [Following(address(live, tmp_path)) for _ in range(2)]
    with pytest.raises(InputError, match="2 programs follow this run already"):
        Following(address(live, tmp_path))
    two[0].close()
    until(lambda: len(live._outboxes) == 1)
    with Following(address(live, tmp_path)) as third:
        assert third.run["task"] == "bench"
    two[1].close()
    live.close()


def test_it_listens_on_this_machine_only(live):
    assert live._listener.getsockname()[0] == "127.0.0.1"
    assert len(live.token) >= 40


def test_of_who_is_slow_the_oldest_cycles_are_left_out_and_told(tmp_path):
    live = Live(OPENING, Wishes(), Limits(waiting_bytes=100_000))
    following, count = Following(address(live, tmp_path)), 1500
    for number in range(count):  # without anybody who reads, none of these waits
        put_cycle(live, number, cables=200)
        if number % 100 == 0:
            put_event(live, 0.03 * number, "note", str(number))
    collector = Collector(following)
    live.close()
    found, seen, left_out = collector.all(), [], 0
    for each in found:
        if isinstance(each, Message) and each.topic == "/state":
            seen.append(round((each.stamp - START) / 30_000_000))
        elif isinstance(each, dict) and each["kind"] == "left out":
            left_out += each["cycles"]
            assert each["pictures"] == 0
    assert left_out > 0
    assert seen == sorted(set(seen))
    assert seen[-1] == count - 1
    assert left_out + len(seen) == count
    told = [messages.event(each.data).text for each in found if isinstance(each, Message) and each.topic == "/events"]
    assert told == [str(number) for number in range(0, count, 100)]


def test_who_never_reads_events_is_not_a_follower_any_more(tmp_path):
    live = Live(OPENING, Wishes(), Limits(waiting_events=50))
    deaf, other = Following(address(live, tmp_path)), Following(address(live, tmp_path))
    text, k = "x" * 20_000, 0
    collector = Collector(other)
    while len(live._outboxes) == 2:  # the system keeps some
        put_event(live, float(k), "note", text)
        k += 1
        until(lambda: not live._outboxes[-1:] or not len(live._outboxes[-1]))  # the other one reads
        assert k < 20_000
    put_event(live, float(k), "note", "the last")
    live.close()
    told = [messages.event(each.data) for each in collector.all() if isinstance(each, Message)]
    assert [each.time for each in told] == [float(number) for number in range(k + 1)]
    while not deaf.lost:
        deaf.take(1.0)
    assert not deaf.ended
    deaf.close()


def test_an_outbox_leaves_out_whole_cycles_and_counts_them():
    def one(number, topic):
        return Numbered(number, Message(topic, number, bytes(10)))

    order = ["/state", "/commanded", "/measured"]
    outbox = Outbox(70, 3, [one(0, "/events"), one(1, "/state")])
    topics = ["/commanded", "/measured", "/tip_camera", *order, "/events", *order]
    for number, topic in enumerate(topics, 2):
        outbox.put(one(number, topic))
    assert outbox.told() == {"cycles": 1, "pictures": 0}
    assert outbox.told() == {"cycles": 0, "pictures": 0}
    outbox.put(one(12, "/state"))
    assert outbox.told() == {"cycles": 0, "pictures": 1}
    assert [each.number for each in outbox.take(3)] == [0, 5, 6]
    assert [each.number for each in outbox.take(99)] == [7, 8, 9, 10, 11, 12]
    assert len(outbox) == 0
    for number in range(4):
        assert not outbox.overflows
        outbox.put(one(number, "/events"))
    assert outbox.overflows


def test_who_comes_late_gets_the_last_events_and_the_last_cycle(tmp_path):
    live = Live(OPENING, Wishes(), Limits(history=5))
    for number in range(8):
        put_event(live, float(number), "note", str(number))
        put_cycle(live, number)
    collector = Collector(Following(address(live, tmp_path)))
    assert collector.following.run["before"] == 8
    put_event(live, 9.0, "verdict", "GOOD")
    live.close()
    *came, end = collector.all()
    assert end == {"kind": "end"}
    came = [each for each in came if isinstance(each, Message)]
    shown = [messages.event(each.data).text if each.topic == "/events" else each.topic for each in came]
    assert shown == ["3", "4", "5", "6", "7", "/state", "/commanded", "/measured", "GOOD"]


def test_what_followers_want_arrives_and_never_as_from_the_terminal(tmp_path):
    wishes = Wishes()
    live = Live(OPENING, wishes, Limits(farewell_s=0.2))
    for number, name in enumerate(("terminal", "", "a\x1b[2J", "x" * 41, "page"), 1):
        with Following(address(live, tmp_path), name) as following:
            following.ask(Want.STOP)
            answers = []
            until(lambda following=following, answers=answers: answers.extend(following.take(0.1)) or answers)
            assert answers == [{"kind": "accepted", "want": "stop", "confirmed_at_terminal": False}]
            shown = {"terminal": " (terminal)", "page": " (page)"}.get(name, "")
            assert wishes.take() == Wish(Want.STOP, f"follower {number}{shown}")
    with Following(address(live, tmp_path)) as following:
        for want in Want:
            following.ask(want)
        following._socket.setblocking(True)
        following._socket.sendall(word({"want": "fly"}) + word({}))
        answers = []
        until(lambda: answers.extend(following.take(0.1)) or len(answers) == len(Want) + 2)
    assert [each["kind"] for each in answers] == ["accepted"] * len(Want) + ["not accepted"] * 2
    assert [each["confirmed_at_terminal"] for each in answers[: len(Want)]] == [want.starts_motion for want in Want]
    assert "expected one of pause, stop, go on" in answers[-1]["words"]
    stop_first = [Want.STOP, *(want for want in Want if want is not Want.STOP)]
    assert [wish.want for wish in iter(wishes.take, None)] == stop_first
    live.close()


def test_frames_come_whole_however_they_are_cut():
    frames = word({"a": 1}) + message_frame("/events", 7, b"xyz") + message_frame("/state", 2**63, b"") + word({})
    whole = [{"a": 1}, Message("/events", 7, b"xyz"), Message("/state", 2**63, b""), {}]
    for size in (1, 2, 7, len(frames)):
        reader = Reader(1000)
        pieces = [frames[k : k + size] for k in range(0, len(frames), size)]
        assert [each for piece in pieces for each in reader.take(piece)] == whole
    with pytest.raises(NotUnderstoodError, match="a message of the topic 9"):
        Reader(1000).take(b"\x0a\x00\x00\x00M\x09" + bytes(8))
    with pytest.raises(NotUnderstoodError, match=r"a frame of 1,001 bytes"):
        Reader(1000).take((1001).to_bytes(4, "little"))


def test_a_run_that_is_gone_is_said(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    record = tmp_path / "run.mcap"
    left = Address(port, "secret", ended.pid, record)
    left.write()
    assert "secret" not in repr(left)
    with pytest.raises(InputError) as told:
        Following(address_of(record))
    gone = f"its program (process {ended.pid}) is gone" if os.name == "posix" else "nobody listens there"
    assert gone in str(told.value)
    assert "Remove run.mcap.live.json" in str(told.value)
    fresh = Address(port, "other", os.getpid(), record)
    fresh.write()
    left.remove()
    assert address_of(record) == address_of(fresh.file) == fresh, "the file of another run is left alone"
    assert not fresh.is_gone
    fresh.remove()
    assert list(tmp_path.iterdir()) == []


def test_the_newest_run_of_a_folder_comes_first(tmp_path):
    with pytest.raises(InputError, match="nothing runs in this folder"):
        newest_addresses(tmp_path)
    for number, name in enumerate(("old", "new", "middle")):
        each = Address(1 + number, "t", 1, tmp_path / f"{name}.mcap")
        each.write()
        os.utime(each.file, (number if name != "new" else 9, number if name != "new" else 9))
    (tmp_path / "torn.mcap.live.json").write_text("{")
    assert [each.record.stem for each in newest_addresses(tmp_path)] == ["new", "middle", "old"]
    for text in ("{", "[]", '{"port": true, "token": "a", "pid": 1}', '{"port": 70000, "token": "a", "pid": 1}'):
        (tmp_path / "torn.mcap.live.json").write_text(text)
        with pytest.raises(InputError, match="does not say where a run is followed"):
            address_of(tmp_path / "torn.mcap")
    (tmp_path / "over.mcap").write_bytes(b"")
    with pytest.raises(InputError, match="its run is over"):
        address_of(tmp_path / "over.mcap")
    with pytest.raises(InputError, match="no run can be followed there: No such file"):
        address_of(tmp_path / "none.mcap")


def test_what_answers_and_is_no_run_is_said(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:

        def answer():
            with other.accept()[0] as one:
                one.recv(4096)
                one.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

        threading.Thread(target=answer, daemon=True).start()
        with pytest.raises(InputError, match="what answers there is no run of Hognose"):
            Following(Address(other.getsockname()[1], "t", 1, tmp_path / "run.mcap"))


def test_a_run_killed_before_its_first_word_is_said_to_be_gone(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    with socket.create_server(("127.0.0.1", 0)) as other:
        threading.Thread(target=lambda: other.accept()[0].close(), daemon=True).start()
        # Elsewhere than on POSIX it cannot be asked whether a program goes on.
        said = rf"its program \(process {ended.pid}\) is gone" if os.name == "posix" else "it closed the connection"
        with pytest.raises(InputError, match=said):
            Following(Address(other.getsockname()[1], "t", ended.pid, tmp_path / "run.mcap"))


def test_foxglove_reads_along_and_can_do_nothing(tmp_path):
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    rig, file = Watched(), tmp_path / "run.mcap"
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with rig.recorded(file, Wishes()) as (writer, _):
        with shown_in_foxglove(writer, port) as words:
            assert f"ws://127.0.0.1:{port}, read-only. That has no token" in words
            with connect(f"ws://127.0.0.1:{port}", subprotocols=[Subprotocol("foxglove.sdk.v1")]) as page:
                assert json.loads(page.recv())["capabilities"] == []
                offered = []
                while len(offered) < len(messages.TOPICS):
                    offered += json.loads(page.recv())["channels"]
                assert {each["topic"] for each in offered} == set(messages.TOPICS)
                state = next(each["id"] for each in offered if each["topic"] == "/events")
                page.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": state}]}))
                page.send(json.dumps({"op": "advertise", "channels": [{"id": 1, "topic": "/x", "encoding": "json"}]}))
                assert json.loads(page.recv())["op"] == "status"
            with pytest.raises(InputError, match=f"port {port} cannot be listened on"), shown_in_foxglove(writer, port):
                pass
        with pytest.raises(InputError, match="expected a number from 1 to 65535"), shown_in_foxglove(writer, 0):
            pass
