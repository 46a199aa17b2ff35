"""What is recorded: when it was true, that it can be read again by others, and whether something is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from tick_builders import make_plan, make_tick

from bringup.engine import TickRecord
from recording import FOLDER
from recording.audit import Audit
from recording.bag import BagWriter, opened
from recording.stamps import time_of
from recording.taking import CHANNELS_OF_PART, Account, Taking
from recording.tick_ranges import TickRanges
from swarm_msgs_py import topics
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.frames import pack_batch
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.messages.sensing import ImuSample, RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.ros import cdr, convert
from swarm_msgs_py.topics import Parts, channels_by_topic
from swarm_msgs_py.types import MISSION, NodeId

PERIOD = 0.5
ROBOTS = (NodeId(0), NodeId(1))
CHANNELS = channels_by_topic(ROBOTS)


def imu(time: float) -> bytes:
    return convert.encode_imu(cdr.stamp(time), "r00/base_link", ImuSample(np.zeros(2), 0.3, 0.0))


def clock(time: float) -> bytes:
    return cdr.stamp(time)


def batch(tick: int, parts: Parts = Parts.NONE) -> bytes:
    return convert.encode_batch(pack_batch(tick, parts, [b"frame"]))


def ranges(tick: int) -> bytes:
    return convert.encode_ranges(tick, RangeScan(np.array([1]), np.array([2.5])))


class Kept:
    """Keeps what would be written."""

    def __init__(self) -> None:
        self.messages: list[tuple[str, float, bytes]] = []

    def write(self, topic: str, time: float, data: bytes) -> None:
        self.messages.append((topic, time, data))


@pytest.mark.parametrize(
    ("channel", "data"),
    [
        (topics.CLOCK, clock(7.5)),
        (topics.IMU, imu(7.5)),
        (topics.RADIO_RX, batch(15)),
        (topics.RADIO_TX, batch(15)),
        (topics.RANGES, ranges(15)),
        (topics.PROXIMITY, convert.encode_proximity(cdr.stamp(7.5), "r00/base_link", np.zeros((2, 2)))),
        (topics.MARKERS, cdr.ENCAPSULATION + b"\x01\x00\x00\x00" + cdr.stamp(7.5)[4:] + bytes(40)),
    ],
)
def test_a_message_was_true_when_it_says_so_or_in_the_tick_that_it_names(channel: topics.Channel, data: bytes) -> None:
    assert time_of(channel, data, PERIOD) == pytest.approx(7.5)


def test_orders_of_an_operator_have_no_time_of_their_own() -> None:
    assert time_of(topics.SHAPE, clock(1e9), PERIOD) is None


def test_what_says_no_time_counts_as_of_now_and_is_kept_as_it_is() -> None:
    kept = Kept()
    taking = Taking(kept, CHANNELS, PERIOD)
    taking.take("/clock", clock(3.0))
    taking.take("/mission/shape", b"order")
    taking.take("/r00/imu", b"\0")  # no message at all

    assert kept.messages[1:] == [("/mission/shape", 3.0, b"order"), ("/r00/imu", 3.0, b"\0")]
    assert taking.account.taken["/mission/shape"].ranges == ((6, 6),)


@pytest.mark.parametrize("stamp", [1e9, 60.0])
def test_the_time_of_another_clock_does_not_count(stamp: float) -> None:
    kept = Kept()
    taking = Taking(kept, CHANNELS, PERIOD)
    taking.take("/clock", clock(3.0))
    taking.take("/r00/cmd_vel", clock(stamp))

    assert kept.messages[1] == ("/r00/cmd_vel", 3.0, clock(stamp))


@pytest.mark.parametrize("numbers", [[], [float("nan")], [float("inf")], [-4.0]])
def test_numbers_of_a_stranger_do_not_end_the_recording(numbers: list[float]) -> None:
    data = cdr.double_array(np.empty((0, 2)), ("rows", "columns"), tuple(numbers))
    taking = Taking(kept := Kept(), CHANNELS, PERIOD)
    taking.take("/clock", clock(3.0))
    taking.take("/r00/ranges", data)

    assert kept.messages[1] == ("/r00/ranges", 3.0, data)


def test_radio_batches_promise_the_readings_beside_them() -> None:
    taking = Taking(Kept(), CHANNELS, PERIOD)
    taking.take("/r01/radio/rx", batch(4, Parts.IMU | Parts.RANGES))
    taking.take("/r01/radio/tx", batch(4))

    promised = {topic: ticks.ranges for topic, ticks in taking.account.promised.items() if len(ticks)}
    assert promised == {"/r01/imu": ((4, 4),), "/r01/ranges": ((4, 4),)}


def test_every_announced_part_is_counted() -> None:
    assert CHANNELS_OF_PART.keys() == set(Parts)


def test_a_bag_is_read_by_rosbags_and_by_the_readers_of_its_format(tmp_path: Path) -> None:
    path = tmp_path / FOLDER
    writer = BagWriter(path, CHANNELS)
    for tick in (1, 0, 2):  # as they may come
        writer.write("/r00/imu", tick * PERIOD, imu(tick * PERIOD))
    writer.write("/clock", 0.25, clock(0.25))
    writer.close()

    with AnyReader([path]) as bag:
        found = [(c.topic, c.msgtype, stamp, bag.deserialize(data, c.msgtype)) for c, stamp, data in bag.messages()]
    assert [(topic, stamp) for topic, _, stamp, _ in found] == [
        *(("/r00/imu", 0), ("/clock", 250_000_000), ("/r00/imu", 500_000_000), ("/r00/imu", 1_000_000_000)),
    ]
    assert found[2][3].header.frame_id == "r00/base_link"
    assert found[2][3].header.stamp.nanosec == 500_000_000
    with (path / f"{FOLDER}.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        stored = [message.data for _, _, message in reader.iter_messages()]
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 4
    assert {channel.topic for channel in summary.channels.values()} == {*CHANNELS}
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert stored == [imu(0.0), clock(0.25), imu(0.5), imu(1.0)]


def test_a_bag_is_found_in_its_run_folder_and_gives_back_what_was_written(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / FOLDER, CHANNELS)
    for tick in range(4):
        writer.write("/r00/imu", 2.0 + tick, imu(2.0 + tick))
    writer.write("/mission/goals", 3.0, b"\0\1\0\0")
    writer.close()

    for place in (tmp_path, tmp_path / FOLDER, tmp_path / FOLDER / f"{FOLDER}.mcap"):
        with opened(place) as bag:
            assert bag.duration_s == 3.0
            assert [(topic.name, topic.count, topic.is_latched) for topic in bag.topics] == [
                ("/mission/goals", 1, True),
                ("/r00/imu", 4, False),
            ]
            assert [time for time, _, _ in bag.messages(frozenset({"/r00/imu"}), start_s=1.5)] == [2.0, 3.0]


def test_what_is_latched_comes_first_when_the_start_is_later(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / FOLDER, CHANNELS)
    for tick, goals in ((0, b"\0\1\0\0old"), (2, b"\0\1\0\0new"), (6, b"\0\1\0\0end")):
        writer.write("/mission/goals", tick * PERIOD, goals)
    for tick in range(6):
        writer.write("/clock", tick * PERIOD, clock(tick * PERIOD))
    writer.close()

    with opened(tmp_path) as bag:
        later = [(time, topic, data[4:]) for time, topic, data in bag.messages(start_s=2.0) if topic != "/clock"]
        whole = [data[4:] for _, topic, data in bag.messages() if topic != "/clock"]
        none = list(bag.messages(frozenset({"/clock"}), start_s=2.5))
    assert later == [(2.0, "/mission/goals", b"new"), (3.0, "/mission/goals", b"end")]
    assert whole == [b"old", b"new", b"end"]
    assert none == [(2.5, "/clock", clock(2.5))]


@pytest.mark.parametrize("is_renamed", [False, True])
def test_a_recording_that_nobody_finished_is_read_up_to_where_it_was_cut_off(tmp_path: Path, is_renamed: bool) -> None:
    writer, wanted = BagWriter(tmp_path / "whole", CHANNELS), []
    for tick in range(60):
        noise = rng_for(tick, "noise").bytes(40_000)  # chunks of a mebibyte do not shrink
        writer.write("/r00/imu", tick * PERIOD, noise)
        wanted.append((tick * PERIOD, "/r00/imu", noise))
    writer.write("/mission/goals", 0.0, b"\0\1\0\0")
    writer.close()
    written = (tmp_path / "whole" / "whole.mcap").read_bytes()
    folder = tmp_path / FOLDER
    folder.mkdir()
    (folder / f"{FOLDER}.mcap").write_bytes(written[: len(written) * 4 // 5])

    with opened(folder / f"{FOLDER}.mcap" if is_renamed else tmp_path) as bag:
        found = list(bag.messages())
        assert bag.is_unfinished
        assert [topic.message for topic in bag.topics] == ["sensor_msgs/msg/Imu"]
    assert 20 < len(found) < 60
    assert found == wanted[: len(found)]
    with opened(tmp_path / "whole") as bag:
        assert not bag.is_unfinished


def test_a_bag_that_got_no_message_is_not_made(tmp_path: Path) -> None:
    BagWriter(tmp_path / FOLDER, CHANNELS).close()

    assert not (tmp_path / FOLDER).exists()


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (Path.absolute, "there is no such file or folder"),
        (Path.mkdir, "holds no recording; launch_swarm.py makes one with --record"),
        (lambda path: path.write_bytes(b"no bag"), "x.mcap: has no messages; cut off before any reached the disk"),
    ],
)
def test_what_is_no_bag_is_refused_in_a_line(make: object, complaint: str, tmp_path: Path) -> None:
    make(tmp_path / "x.mcap")  # type: ignore[operator]

    with pytest.raises(ConfigError, match=complaint), opened(tmp_path / "x.mcap"):
        pass


def spoken(tick: int) -> TickRecord:
    """Return a tick in which two robots and the mission computer spoke; in the first, there is a plan."""
    record = make_tick(tick, [[0.0, 0.0], [1.0, 0.0]], plan=make_plan([[0.0, 0.0]]) if tick == 0 else None)
    return replace(record, mission=MissionReport(1, (), (), (), "", RadioCounters()))


def account_of(ticks: range, but: Mapping[str, set[int]] | None = None) -> Account:
    """Return the account of a recording that has everything of some ticks, but for some of some topics."""
    lacking = but or {}
    taken = {
        topic: TickRanges(set(ticks) - lacking.get(topic, set()))
        for topic, channel in CHANNELS.items()
        if channel.source is not topics.Party.OPERATOR
    }
    return Account(taken | {"/mission/goals": TickRanges([0]), "/viz/markers": TickRanges([0])}, {})


def test_an_audit_of_a_complete_recording_misses_nothing() -> None:
    audit = Audit()
    for tick in range(10):
        audit.expect(spoken(tick))
    finding = audit.compare(account_of(range(12)))  # the world runs a little ahead

    assert finding.missing == {}
    assert finding.expected == 10 * (3 + 2 * 6 + 2) + 2
    assert finding.line().endswith("none lost")


def test_an_audit_finds_every_message_that_is_missing() -> None:
    audit = Audit()
    for tick in range(10):
        audit.expect(spoken(tick))
    account = account_of(range(10), {"/r01/odom": {7}, "/clock": {3, 4}, "/r00/ranges": {2}})
    account.taken["/r01/odom"].add(10)  # as many as there should be, but not the right ones
    promising = Account(account.taken, {"/r00/ranges": TickRanges([0, 2, 10])})
    finding = audit.compare(promising)

    assert finding.missing == {"/clock": 2, "/r00/ranges": 1, "/r01/odom": 1}
    assert "4 lost, 2 of them on /clock" in finding.line()


def test_silent_and_dead_nodes_owe_nothing() -> None:
    audit = Audit()
    record = make_tick(0, [[0.0, 0.0], [1.0, 0.0]], lost=frozenset({NodeId(1), MISSION}))
    audit.expect(record)
    only = {
        topic: TickRanges([0]) for topic in CHANNELS if topic.startswith(("/r00/", "/clock", "/world/truth", "/viz/"))
    }

    assert audit.compare(Account(only, {})).missing == {}
