"""PyBullet without its greeting; who needs the engine imports it from here."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from swarm_msgs_py.errors import PhysicsError


@contextmanager
def quiet_stderr() -> Iterator[None]:
    """Keep what C code prints out of the terminal."""
    sys.stderr.flush()
    kept, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(sink)


with quiet_stderr():  # PyBullet announces its build time when it is imported
    import pybullet

__all__ = ["open_server", "pybullet", "quiet_stderr"]


def open_server() -> int:
    """Return the number of a new physics server.

    Raises
    ------
    PhysicsError
        If it does not start.
    """
    client: int = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise PhysicsError("PyBullet could not start a physics server; close other simulations and try again")
    return client
