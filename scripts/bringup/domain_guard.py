"""Keeps two swarms out of one ROS domain: they would take each other's robots for their own."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.ros.environment import DOMAIN, LAST_DOMAIN


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
    """A lock file per domain. The kernel drops the lock with the last process that holds it, however that ends.

    Parameters
    ----------
    domain : int
    folder : Path or None
        Where the lock files are; None for the system's folder of temporary files, which all users share.
    """

    def __init__(self, domain: int, folder: Path | None = None) -> None:
        self._domain = domain
        self._path = (folder or Path(tempfile.gettempdir())) / f"swarm-ros-domain-{domain}.lock"
        self._file = -1

    def acquire(self) -> None:
        """Take the domain.

        Raises
        ------
        ConfigError
            If another swarm is in it; the line names the domain and the way out.
        """
        while True:
            try:
                file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            except OSError as error:
                raise self._taken("by another user's swarm") from error
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                holder = os.pread(file, 20, 0).decode(errors="replace").strip()
                os.close(file)
                raise self._taken(f"by the swarm of process {holder}" if holder else "by another swarm") from None
            if self._is_current(file):
                break
            os.close(file)  # its owner removed the file between our opening and locking it
        os.truncate(file, 0)
        os.pwrite(file, f"{os.getpid()}\n".encode(), 0)
        self._file = file

    def release(self) -> None:
        """Give the domain back; may be called again."""
        if self._file >= 0:
            self._path.unlink(missing_ok=True)
            os.close(self._file)
            self._file = -1

    def _is_current(self, file: int) -> bool:
        try:
            return os.fstat(file).st_ino == self._path.stat().st_ino
        except FileNotFoundError:
            return False

    def _taken(self, by: str) -> ConfigError:
        return ConfigError(
            f"{DOMAIN}: domain {self._domain} is in use {by}; set {DOMAIN} to another number (0 to 101), e.g. "
            f"{DOMAIN}={(self._domain + 1) % 102}"
        )
