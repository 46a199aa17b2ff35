"""What the middleware is told through the environment before a node starts: stay on this machine, leave no files.

`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` is what ROS offers for a swarm that is closed to the network. In
``rmw_fastrtps_cpp`` it also means at most 32 processes and shared-memory files that outlive a killed process. The Fast
DDS profile below is as closed (its sockets are bound to the loopback interface only), reaches 100 processes, and needs
no shared memory; over UDP on loopback a tick takes as long as over shared memory. ROS tools with the usual settings
find such a swarm.
"""

from __future__ import annotations

from collections.abc import MutableMapping
from pathlib import Path

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
DOMAIN = "ROS_DOMAIN_ID"
PROFILE_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
FAST_DDS = "rmw_fastrtps_cpp"

PROCESSES_MAX = 100
"""How many processes of one domain look for each other; the port numbers of a domain allow for 120."""

LOCALHOST_PROCESSES_MAX = 32
"""The same, with ROS's own ``LOCALHOST``."""

LAST_DOMAIN = 232
"""Highest domain whose port numbers exist."""

_BUFFER_BYTES = 4_194_304  # room for a tick of 100 robots in one process, where the kernel grants it
_SMALLEST_BUFFER_BYTES = 212_992  # Linux's default limit
_LIMIT = Path("/proc/sys/net/core/rmem_max")

# A datagram that a full buffer drops is repeated at the next heartbeat; the default of 3 s would stall the lockstep.
# Each heartbeat also costs a datagram and its answer, a tenth of the whole run at 0.1 s, so it is rarer where buffers
# are large enough to drop nothing.
_HEARTBEAT_NS, _SHORT_HEARTBEAT_NS = 300_000_000, 100_000_000

_PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <profiles>
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>loopback</transport_id>
        <type>UDPv4</type>
        <receiveBufferSize>{buffer}</receiveBufferSize>
        <maxInitialPeersRange>{processes}</maxInitialPeersRange>
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="swarm_participant" is_default_profile="true">
      <rtps>
        <builtin>
          <metatrafficUnicastLocatorList><locator/></metatrafficUnicastLocatorList>
          <initialPeersList><locator><udpv4><address>127.0.0.1</address></udpv4></locator></initialPeersList>
        </builtin>
        <userTransports><transport_id>loopback</transport_id></userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
      </rtps>
    </participant>
    <data_writer profile_name="swarm_writer" is_default_profile="true">
      <times><heartbeatPeriod><sec>0</sec><nanosec>{heartbeat}</nanosec></heartbeatPeriod></times>
    </data_writer>
  </profiles>
</dds>
"""


def stay_local(environment: MutableMapping[str, str]) -> None:
    """Make ``LOCALHOST`` the default range of discovery; what the user has set stays."""
    environment.setdefault(RANGE, "LOCALHOST")


def use_loopback(environment: MutableMapping[str, str], folder: Path) -> bool:
    """Choose the loopback profile, unless the user has chosen a range, a profile or a middleware of their own.

    Parameters
    ----------
    environment : mapping
        Usually ``os.environ``; must be changed before ROS is initialized.
    folder : Path
        Where the profile is written; it must stay until all nodes have started.

    Returns
    -------
    bool
        Whether the profile is in use. If not, the range is ``LOCALHOST`` unless the user has set another.
    """
    middleware = environment.get("RMW_IMPLEMENTATION", FAST_DDS) or FAST_DDS
    has_own = any(environment.get(name) for name in (*PROFILE_VARIABLES, "ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS"))
    if has_own or middleware != FAST_DDS or environment.get(RANGE, "LOCALHOST") not in {"", "LOCALHOST"}:
        stay_local(environment)
        return False
    profile = folder / "fastdds_loopback.xml"
    profile.write_text(_profile(), encoding="utf-8")
    for name in PROFILE_VARIABLES:
        environment[name] = str(profile)
    # The profile says it all; with LOCALHOST the middleware would replace the profile's transport by its own.
    environment[RANGE] = "SYSTEM_DEFAULT"
    return True


def _profile() -> str:
    buffer = _granted_buffer()
    heartbeat = _HEARTBEAT_NS if buffer == _BUFFER_BYTES else _SHORT_HEARTBEAT_NS
    return _PROFILE.format(buffer=buffer, heartbeat=heartbeat, processes=PROCESSES_MAX)


def _granted_buffer() -> int:
    """Return the largest receive buffer [bytes] that the kernel grants, so that Fast DDS need not complain."""
    try:
        return min(_BUFFER_BYTES, int(_LIMIT.read_text(encoding="ascii")))
    except (OSError, ValueError):
        return _SMALLEST_BUFFER_BYTES
