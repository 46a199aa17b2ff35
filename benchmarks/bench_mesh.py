"""Cost of the mesh network per agent and tick when all radios of a formation hear each other.

python benchmarks/bench_mesh.py [robots] [ticks]
"""

from __future__ import annotations

import sys
from time import thread_time

import numpy as np

from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import MISSION, NodeId

PERIOD_S = 0.5


def main(robots: int, ticks: int) -> None:
    """Run a formation in which everybody hears everybody and print the distribution of the cost of one agent's tick."""
    nodes = [MeshNetwork(node, NetworkConfig(), PERIOD_S) for node in (*map(NodeId, range(robots)), MISSION)]
    outboxes: list[tuple[bytes, ...]] = [() for _ in nodes]
    receive_us, transmit_us, both_us = [], [], []
    for tick in range(ticks):
        said = []
        for index, node in enumerate(nodes):
            inbox = [frame for other, outbox in enumerate(outboxes) if other != index for frame in outbox]
            position = np.array([index, 0.1 * tick])
            presence = Presence(position, np.zeros(2), 4e-4 * np.eye(2), 0.0, tick, 1, True, 3, 1, 77)
            start = thread_time()
            node.receive(tick, inbox)
            middle = thread_time()
            if tick % 4 == index % 4 and index + 1 < len(nodes):
                node.send(MISSION, b"a report of a robot")
            later = thread_time()
            said.append(node.transmit(tick, presence))
            end = thread_time()
            if tick >= ticks // 4:
                receive_us.append(1e6 * (middle - start))
                transmit_us.append(1e6 * (end - later))
                both_us.append(receive_us[-1] + transmit_us[-1])
        outboxes = said
    for name, costs in (("receive", receive_us), ("transmit", transmit_us), ("both", both_us)):
        low, median, high = np.percentile(costs, (10, 50, 99))
        mean = np.mean(costs)
        print(f"{name:8s} p10 {low:5.0f} us   median {median:5.0f} us   p99 {high:5.0f} us   mean {mean:5.0f} us")
    sent = sum(node.counters.bytes_sent for node in nodes)
    print(f"{len(nodes)} radios, {8 * sent / (ticks * PERIOD_S) / 1000:.1f} kbit/s for all of them together")


if __name__ == "__main__":
    main(*(int(word) for word in (sys.argv[1:] + ["50", "60"][len(sys.argv) - 1 :])))
