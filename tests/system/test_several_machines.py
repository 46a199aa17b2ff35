"""A swarm on two machines, as docs/real-robots.md has it: two network namespaces, joined by a virtual cable.

One has the world and the mission computer, the other the robots; nothing but the network connects them.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

GROUND, FIELD = "swarm-ground", "swarm-field"
DEADLINE_S = 100.0
ROBOTS = 3

NODE = "import sys; from {module} import main; main(['{name}', *sys.argv[1:]])"
WORLD = ("swarm_sim.ros.world_node", "counts:=[3]", "physics.backend:=massdamper", "first_deadline_s:=1.0")
MISSION = ("mission_computer.ros.mission_node", "counts:=[3]", "shape:=hw_2_square")

ONLOOKER = f"""
import json, sys, time, rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
node, modes = rclpy.create_node("onlooker"), {{}}
def take(message):
    for status in message.status:
        modes[status.name] = status.message
for robot in range({ROBOTS}):
    node.create_subscription(DiagnosticArray, f"/r{{robot:02d}}/status", take, 10)
deadline = time.monotonic() + {DEADLINE_S}
while time.monotonic() < deadline and sorted(modes.values()) != ["parked"] * {ROBOTS}:
    rclpy.spin_once(node, timeout_sec=0.2)
print(json.dumps(modes))
"""


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, timeout=10, capture_output=True)


def can_make_namespaces() -> bool:
    """Return whether this user may make network namespaces, and has the tool for it."""
    if shutil.which("ip") is None or os.geteuid() != 0:
        return False
    tried = subprocess.run(["ip", "netns", "add", "swarm-trial"], capture_output=True, timeout=10, check=False)
    if tried.returncode:
        return False
    ip("netns", "del", "swarm-trial")
    return True


@pytest.fixture
def machines() -> Iterator[None]:
    """Two network namespaces with a cable between them."""
    if not can_make_namespaces():
        pytest.skip("network namespaces cannot be made here (needs root and iproute2)")
    with ExitStack() as stack:
        for name in (GROUND, FIELD):
            ip("netns", "add", name)
            stack.callback(ip, "netns", "del", name)
        ip("link", "add", "cable0", "netns", GROUND, "type", "veth", "peer", "name", "cable1", "netns", FIELD)
        for name, cable, address in ((GROUND, "cable0", "10.77.0.1/24"), (FIELD, "cable1", "10.77.0.2/24")):
            ip("-n", name, "addr", "add", address, "dev", cable)
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "link", "set", cable, "up")
            ip("-n", name, "route", "add", "224.0.0.0/4", "dev", cable)  # for discovery by multicast
        yield


def started(stack: ExitStack, machine: str, program: str, *parameters: str) -> subprocess.Popen[str]:
    """Start a node, or a program, on a machine; it ends with the stack."""
    ros = [word for parameter in parameters for word in ("-p", parameter)]
    process = subprocess.Popen(
        ["ip", "netns", "exec", machine, sys.executable, "-c", program, *(["--ros-args", *ros] if ros else [])],
        env=os.environ
        | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", "ROS_DOMAIN_ID": "7"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    stack.callback(process.wait)
    stack.callback(process.send_signal, signal.SIGKILL)
    return process


@pytest.mark.needs_ros
@pytest.mark.usefixtures("machines")
def test_robots_on_another_machine_form_the_shape() -> None:
    with ExitStack() as stack:
        for module, *parameters in (WORLD, MISSION):
            started(stack, GROUND, NODE.format(module=module, name="node"), *parameters)
        for robot in range(ROBOTS):
            agent = NODE.format(module="swarm_agent.ros.agent_node", name="node")
            started(stack, FIELD, agent, f"robot:={robot}", "type:=1")
        onlooker = started(stack, GROUND, ONLOOKER)
        output, _ = onlooker.communicate(timeout=DEADLINE_S + 30.0)

    assert json.loads(output.splitlines()[-1]) == {f"r{robot:02d}": "parked" for robot in range(ROBOTS)}
