"""A mission computer and radios around it, in lockstep, without a world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builders import make_presence

from mission_computer.mission import Mission
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.messages.bodies import Plan, Report, RowRequest
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

PERIOD = 0.5
SQUARE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])


class Radio:
    """A robot that is nothing but a radio within reach of the mission computer."""

    def __init__(self, robot: int, epoch: int = 0) -> None:
        self.id = NodeId(robot)
        self.epoch = epoch
        self.heard: list[Delivery] = []
        self.mesh = MeshNetwork(self.id, NetworkConfig(), PERIOD)

    @property
    def plans(self) -> list[Plan]:
        bodies = [decode_body(delivery.body) for delivery in self.heard]
        return [body for body in bodies if isinstance(body, Plan)]

    def tell(self, body: Report | RowRequest) -> None:
        assert self.mesh.send(MISSION, encode_body(body))

    def report(self, epoch: int, mode: Mode = Mode.TRAVELING) -> None:
        self.tell(Report(self.id, 1, epoch, 0, (1.0, 2.0), int(mode), 0.1))


class Air:
    """Steps a mission computer and radios, all within range of each other, in lockstep."""

    def __init__(self, mission: Mission, *radios: Radio) -> None:
        self.mission, self.radios, self.tick = mission, radios, 0
        self.said: dict[NodeId, Sequence[bytes]] = {}

    def step(self, shape: FloatArray | None = None) -> MissionOutputs:
        heard = {node: tuple(f for other, fs in self.said.items() if other != node for f in fs) for node in self.nodes}
        outputs = self.mission.step(MissionInputs(self.tick, self.tick * PERIOD, heard[MISSION], shape))
        said: dict[NodeId, Sequence[bytes]] = {MISSION: outputs.outbox}
        for radio in self.radios:
            radio.heard += radio.mesh.receive(self.tick, heard[radio.id])
            presence = make_presence(sigma=0.0, epoch=radio.epoch)
            said[radio.id] = radio.mesh.transmit(self.tick, presence)
        self.said = said
        self.tick += 1
        return outputs

    @property
    def nodes(self) -> list[NodeId]:
        return [MISSION, *(radio.id for radio in self.radios)]

    def run(self, ticks: int) -> MissionOutputs:
        return [self.step() for _ in range(ticks)][-1]
