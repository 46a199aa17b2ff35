from __future__ import annotations

import asyncio
import io
import json
import socket
from itertools import islice
from typing import Any

import pytest
from rich.console import Console
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

from bringup.compose import ScenarioActors
from bringup.formation_scenes import FormationScenes
from bringup.inprocess import InProcessEngine
from bringup.live_view import HOST, LiveView
from bringup.progress import Progress
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_msgs_py.errors import ConfigError

PROTOCOL = "foxglove.sdk.v1"
DEADLINE_S = 20.0
MESSAGE_DATA = 1  # first byte of a binary frame that carries a message


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return resolve(*load_scenario("smoke-4", (parse_assignment("backend=massdamper"),)))


async def watch(scenario: Scenario) -> tuple[dict[str, Any], bytes]:
    """Run a swarm, connect as Foxglove does, and return what is said of all robots, and a picture of the scene."""
    with (
        LiveView(scenario.name, FormationScenes(scenario), 0) as view,
        InProcessEngine(ScenarioActors(scenario)) as engine,
    ):
        ticks = engine.ticks()
        view.take(next(ticks))
        connection = await websocket_connect(HTTPRequest(view.address), subprotocols=[PROTOCOL])
        channels: dict[str, int] = {}
        while {"/swarm", "/robots"} - channels.keys():
            told = await connection.read_message()
            record = json.loads(told) if isinstance(told, str) else {}
            channels |= {channel["topic"]: channel["id"] for channel in record.get("channels", ())}
        numbers = {"/swarm": 1, "/robots": 2}
        subscriptions = [{"id": number, "channelId": channels[topic]} for topic, number in numbers.items()]
        await connection.write_message(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
        heard: dict[int, bytes] = {}
        while set(heard) < set(numbers.values()):
            view.take(next(ticks))
            try:
                message = await asyncio.wait_for(connection.read_message(), 0.2)
            except TimeoutError:
                continue
            if isinstance(message, bytes) and message[0] == MESSAGE_DATA:
                heard[int.from_bytes(message[1:5], "little")] = message[13:]
        connection.close()
    return json.loads(heard[2]), heard[1]


def test_who_connects_sees_all_robots_and_the_scene(scenario: Scenario) -> None:
    told, scene = asyncio.run(asyncio.wait_for(watch(scenario), DEADLINE_S))

    assert [robot["robot"] for robot in told["robots"]] == ["r00", "r01", "r02", "r03"]
    assert told["time_s"] > 0.0
    for entity in (b"robots", b"walls", b"links"):
        assert entity in scene


def test_a_port_that_is_taken_is_refused(scenario: Scenario) -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]

        with (
            pytest.raises(ConfigError, match=f"--live {port}: cannot be served"),
            LiveView(scenario.name, FormationScenes(scenario), port),
        ):
            pass


def test_a_port_that_is_taken_after_the_start_costs_the_view_and_not_the_run(scenario: Scenario) -> None:
    text = io.StringIO()
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        port = taken.getsockname()[1]
        taken.close()
        with LiveView(scenario.name, FormationScenes(scenario), port) as view, socket.socket() as thief:
            thief.bind((HOST, port))
            thief.listen()
            with (
                InProcessEngine(ScenarioActors(scenario)) as engine,
                Progress(Console(file=text, width=200), None, view) as progress,
            ):
                for record in islice(engine.ticks(), 3):
                    progress.show(record, record.truth.time, "")

    assert text.getvalue().count(f"--live {port}: cannot be served any more") == 1
    assert text.getvalue().count("the run goes on without") == 1
