"""A swarm that is recorded: nothing is lost, nothing changes, and what was recorded can be played again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from functools import partial
from itertools import islice
from pathlib import Path

import pytest
from leftovers import is_running, wait_until
from rclpy.node import Node
from ros_harness import harness
from rosbags.highlevel import AnyReader
from source_tree import ROOT
from swarms import SmallSwarm

import bringup.recorder
from bringup.compose import ScenarioActors
from bringup.engine import Actors
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.ros_children import OWN
from bringup.ros_engine import RosEngine
from bringup.scenario_file import Override, load_scenario
from recording import FOLDER
from recording.bag import opened
from recording.ros.recorder_node import RecorderNode
from swarm_msgs_py import topics
from swarm_msgs_py.ros.channels import message_type, quality_of
from swarm_msgs_py.ros.spin import is_matched, spin_for, started
from swarm_msgs_py.topics import CAMERA_IMAGE, CAMERA_INFO, CAMERA_VIEW, MARKERS, Party, channels_by_topic
from swarm_msgs_py.types import MISSION, NodeId

REPLAY = ROOT / "scripts" / "replay.py"
PATIENCE_S = 60.0

pytestmark = pytest.mark.usefixtures("domain_id")


def recorded(swarm: Actors, path: Path, ticks: int) -> RosEngine:
    """Run and record some ticks; return the engine, stopped."""
    with RosEngine(swarm, agents_per_process=25, record_to=path) as engine:
        assert len(list(islice(engine.ticks(), ticks))) == ticks
    return engine


def contents(path: Path, before_s: float) -> Counter[tuple[str, int, str]]:
    """Return the messages of a bag up to a time; how far beyond it the world ran is left to chance.

    Not their bytes: between fields, the middleware's serializer leaves what happens to be there. Not the markers: they
    come at a rate that suits the eye.
    """
    with AnyReader([path]) as bag:
        return Counter(
            (connection.topic, stamp, str(bag.deserialize(data, connection.msgtype)))
            for connection, stamp, data in bag.messages(stop=round(before_s * 1e9))
            if connection.topic != MARKERS.topic()
        )


@pytest.mark.usefixtures("nothing_left")
def test_no_message_of_fifty_robots_is_lost(tmp_path_factory: pytest.TempPathFactory) -> None:
    path, ticks = tmp_path_factory.mktemp("fifty") / FOLDER, 6
    physics = Override("the test", "sim.physics.backend", "massdamper")
    swarm = ScenarioActors(resolve(*load_scenario("formation-50", (physics,))))
    engine = recorded(swarm, path, ticks)

    with opened(path) as bag:
        counts = {topic.name: topic.count for topic in bag.topics}
        total = sum(counts.values())
    assert engine.notes == (f"recording: {total} messages on {len(counts)} topics, none lost",)
    always = ("imu", "radio/rx", "radio/tx", "cmd_vel", "odom", "path", "status")
    due = [f"/r{robot:02d}/{name}" for robot in range(50) for name in always]
    due += ["/mission/radio/rx", "/mission/radio/tx", "/clock", "/world/truth"]
    assert {topic: counts.get(topic, 0) for topic in due if counts.get(topic, 0) < ticks} == {}


@pytest.mark.usefixtures("nothing_left")
def test_images_of_the_camera_are_recorded_as_well(tmp_path_factory: pytest.TempPathFactory) -> None:
    path, ticks = tmp_path_factory.mktemp("camera") / FOLDER, 8
    engine = recorded(ScenarioActors(resolve(*load_scenario("arena"))), path, ticks)

    with opened(path) as bag:
        counts = {topic.name: topic.count for topic in bag.topics}
    assert engine.notes[0].endswith("none lost")
    assert counts[CAMERA_IMAGE.topic()] >= ticks
    assert counts[CAMERA_VIEW.topic()] > 0
    assert abs(counts[CAMERA_INFO.topic()] - counts[CAMERA_IMAGE.topic()]) <= 1  # one may be on its way at the end


@pytest.mark.usefixtures("nothing_left")
def test_a_recorded_run_is_the_same_run_and_its_recording_the_same_messages(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    swarm, folder = SmallSwarm(3, deaths=((NodeId(2), 6), (MISSION, 8))), tmp_path_factory.mktemp("twice")
    with RosEngine(swarm, agents_per_process=2, record_to=folder / "first") as engine:
        records = list(islice(engine.ticks(), 12))
    with InProcessEngine(swarm) as reference:
        expected = list(islice(reference.ticks(), 12))
    recorded(swarm, folder / "second", 12)

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert record.reports.keys() == wanted.reports.keys()
    assert engine.notes[0].endswith("none lost")
    first, second = (contents(folder / name, 6.0) for name in ("first", "second"))
    assert first == second
    assert max(stamp for topic, stamp, _ in first if topic == "/r02/imu") == 2_500_000_000  # it died in tick 6


@pytest.mark.usefixtures("nothing_left")
def test_a_recorder_that_dies_is_named_and_the_run_goes_on(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("dies") / FOLDER
    with RosEngine(SmallSwarm(2), agents_per_process=2, record_to=path) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 5))
        os.kill(next(child.pid for child in engine._group.children if child.name == "recorder"), signal.SIGKILL)
        later = list(islice(ticks, 40))

    assert any("recorder" in line and "is not recorded any more" in line for r in later for line in r.alerts)
    assert later[-1].reports.keys() == {0, 1}
    assert later[-1].lost == frozenset()
    assert "SIGKILL" in engine.notes[0]


@pytest.mark.usefixtures("nothing_left")
def test_in_real_time_nobody_waits_for_a_recorder_that_hangs(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bringup.recorder, "PATIENCE_S", 1.0)
    path = tmp_path_factory.mktemp("hangs") / FOLDER
    with RosEngine(SmallSwarm(2), agents_per_process=2, real_time=True, record_to=path) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 2))
        os.kill(next(child.pid for child in engine._group.children if child.name == "recorder"), signal.SIGSTOP)
        later = list(islice(ticks, 6))

    assert any("the recorder hangs" in line for record in later for line in record.alerts)
    assert later[-1].reports.keys() == {0, 1}
    assert "hung" in engine.notes[0]


def test_who_looks_on_does_not_stand_in_for_the_recorder() -> None:
    topic, channel = topics.TRUTH.topic(), topics.TRUTH
    with harness() as ros:
        speaker = ros.add(Node("world", context=ros.context))
        publisher = speaker.create_publisher(message_type(channel.message), topic, quality_of(channel))
        ros.listen(channel)  # as somebody with a viewer does
        ros.wait(lambda: publisher.get_subscription_count() > 0, "a viewer")
        is_heard = partial(is_matched, [speaker], lambda _: False, {topic}.__contains__)

        assert is_heard()
        assert not is_heard(OWN)
        ros.add(RecorderNode({topic: channel}, lambda *_: None, context=ros.context))
        ros.wait(lambda: is_heard(OWN), "the recorder")


def test_the_sudden_death_of_the_launcher_leaves_a_finished_bag(tmp_path: Path) -> None:
    path = tmp_path / FOLDER
    reading, writing = os.pipe()
    launcher = os.fork()
    if launcher == 0:
        with RosEngine(SmallSwarm(2), agents_per_process=2, record_to=path) as engine:
            list(islice(engine.ticks(), 10))
            recorder = next(child.pid for child in engine._group.children if child.name == "recorder")
            os.write(writing, recorder.to_bytes(4))
            signal.pause()
        os._exit(0)
    os.close(writing)
    recorder = int.from_bytes(os.read(reading, 4))
    os.kill(launcher, signal.SIGKILL)
    os.waitpid(launcher, 0)

    assert wait_until(lambda: not is_running(recorder))
    with opened(path) as bag:
        assert min(topic.count for topic in bag.topics if topic.name.endswith(("imu", "cmd_vel"))) >= 10


def test_a_recording_is_played_onto_its_topics_message_by_message(tmp_path: Path) -> None:
    pid = os.fork()
    if pid == 0:  # a process that has forked a swarm cannot use ROS itself
        recorded(SmallSwarm(2), tmp_path / FOLDER, 10)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    with opened(tmp_path) as bag:
        wanted = Counter((topic, data) for _, topic, data in bag.messages())
        kinds = {topic.name: topic.message for topic in bag.topics}
    channels = channels_by_topic((NodeId(0), NodeId(1)))
    heard: Counter[tuple[str, bytes]] = Counter()

    with started() as executor:
        listener = RecorderNode(channels, lambda topic, data: heard.update([(topic, data)]), context=executor.context)
        executor.add_node(listener)
        player = subprocess.Popen([sys.executable, str(REPLAY), str(tmp_path), "--rate", "4"], stdout=subprocess.PIPE)
        assert wait_until(lambda: spin_for(executor, 0.1) or player.poll() is not None, PATIENCE_S)
        spin_for(executor, 0.3)

    assert player.returncode == 0
    assert f"{wanted.total()} messages played" in player.stdout.read().decode()
    assert heard == wanted
    assert kinds == {topic: channels[topic].message for topic in kinds}
    assert all(message_type(kind) for kind in kinds.values())
    assert not any(channels[topic].source is Party.OPERATOR for topic, _ in heard)
