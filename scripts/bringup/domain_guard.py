"""Keeps two swarms out of one ROS domain: they would take each other's robots for their own."""

from __future__ import annotations

import socket
import struct
from collections.abc import Mapping

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.ros.environment import DOMAIN, LAST_DOMAIN

LAST_SAFE_DOMAIN = 101
"""Above it, the UDP ports of a domain reach into the range from which Linux gives ports to anybody."""

_CREDENTIALS = struct.Struct("3i")  # process, user, group
_BACKLOG = 64  # of those who ask whose the domain is; nobody is ever answered, the kernel knows


def domain_of(environment: Mapping[str, str]) -> int:
    """Return the ROS domain that an environment chooses.

    Raises
    ------
    ConfigError
        If ``ROS_DOMAIN_ID`` is not a domain.
    """
    text = environment.get(DOMAIN, "") or "0"
    if not text.isdecimal() or int(text) > LAST_DOMAIN:
        raise ConfigError(f"{DOMAIN}: must be a whole number from 0 to {LAST_DOMAIN}, got '{text}'")
    return int(text)


class DomainGuard:
    """Holds a domain by a name in the kernel's space of abstract sockets.

    Such a name is no file: nothing is left over. All users of the machine share the names, as they share its domains.
    The kernel drops a name with the last process that holds it, however that ends.

    Parameters
    ----------
    domain : int
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._name = f"\0swarm-ros-domain-{domain}"
        self._socket: socket.socket | None = None

    def acquire(self) -> None:
        """Take the domain.

        Raises
        ------
        ConfigError
            If another swarm is in it; the line names the domain and the way out.
        """
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            claim.bind(self._name)
        except OSError:
            claim.close()
            raise self._taken() from None
        claim.listen(_BACKLOG)  # so that others can learn whose it is
        self._socket = claim

    def release(self) -> None:
        """Give the domain back; may be called again."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _taken(self) -> ConfigError:
        holder = self._holder()
        by = "another swarm" if holder is None else f"the swarm of process {holder}"
        return ConfigError(
            f"{DOMAIN}: domain {self._domain} is in use by {by}; set {DOMAIN} to another number (0 to "
            f"{LAST_SAFE_DOMAIN}), e.g. {DOMAIN}={(self._domain + 1) % (LAST_SAFE_DOMAIN + 1)}"
        )

    def _holder(self) -> int | None:
        """Return the process that holds the domain, if the kernel tells."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as caller:
            caller.setblocking(False)
            try:
                caller.connect(self._name)
                found = caller.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
            except OSError:  # it has just ended, or too many ask
                return None
        process: int = _CREDENTIALS.unpack(found)[0]
        return process or None  # zero for a process outside this container
