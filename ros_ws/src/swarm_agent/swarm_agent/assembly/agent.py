"""One boat's agent, from frames heard to frames sent: the step contract of the assembly family."""

from __future__ import annotations

import numpy as np

from swarm_agent.assembly.boat_computer import BoatComputer
from swarm_agent.assembly.steering import SkipperConfig, SkipperInputs, SkipperOutputs
from swarm_msgs_py.assembly.boat_frames import BoatFrame, decode_boat_frame, encode_boat_frame, is_boat_frame
from swarm_msgs_py.assembly.boat_io import AssemblyInputs, AssemblyOutputs, AssemblyReport, BoatMode
from swarm_msgs_py.assembly.orders import Order, decode_order, is_order
from swarm_msgs_py.assembly.progress_frames import (
    ProgressFrame,
    decode_progress_frame,
    encode_progress_frame,
    is_progress_frame,
)
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.types import NodeId


class AssemblyAgent:
    """A boat.

    Parameters
    ----------
    robot : NodeId
    config : SkipperConfig
    period_s : float
        Control period [s].
    """

    def __init__(self, robot: NodeId, config: SkipperConfig, period_s: float) -> None:
        self._computer = BoatComputer(int(robot), config, period_s)

    def step(self, inputs: AssemblyInputs) -> AssemblyOutputs:
        """Advance by one tick; frames that are damaged or foreign are ignored."""
        words: list[ProgressFrame] = []
        ways: list[BoatFrame] = []
        order: Order | None = None
        for data in inputs.inbox:
            try:
                if is_progress_frame(data):
                    words.append(decode_progress_frame(data))
                elif is_boat_frame(data):
                    ways.append(decode_boat_frame(data))
                elif is_order(data):
                    order = decode_order(data)
            except FrameError:
                continue
        places = [(x, y) for x, y in inputs.seen.tolist()]
        known = SkipperInputs(inputs.tick, inputs.pose, inputs.reference, inputs.contacts, words, ways, places)
        said = self._computer.step(known, order)
        outbox = [encode_progress_frame(said.frame)]
        if said.word is not None:
            outbox.append(encode_boat_frame(said.word))
        report = AssemblyReport(
            mode=_mode(said, self._computer.steps),
            epoch=said.frame.epoch,
            steps_done=said.frame.steps_done,
            steps=self._computer.steps,
            pose=inputs.pose,
            contacts=inputs.contacts,
            goal=said.goal,
        )
        return AssemblyOutputs(inputs.tick, said.velocity, tuple(outbox), report)


def _mode(said: SkipperOutputs, steps: int) -> BoatMode:
    if steps == 0:
        return BoatMode.IDLE
    if said.is_done:
        return BoatMode.DOCKED
    return BoatMode.MOVING if np.any(said.velocity) else BoatMode.WAITING
