"""Records between the orchestrator and its child processes, over a pair of sockets; neither side ever waits to send."""

from __future__ import annotations

import contextlib
import pickle
import select
import socket
import struct
from collections import deque
from typing import Any

_LENGTH = struct.Struct("<I")
CHUNK_BYTES = 1 << 18
BUFFER_BYTES = 1 << 20  # of the socket, as far as the kernel grants it: a few ticks of a whole swarm


class Link:
    """One end of a connection that carries picklable records in order.

    What the socket does not take at once is kept and sent with later calls, so that a slow reader never stops a robot
    from answering in time. Only trusted processes, parent and child, are at the ends.

    Parameters
    ----------
    end : socket
        Connected stream socket; taken over.

    Attributes
    ----------
    is_open : bool
        False once the other end is gone and everything that it sent has been received.
    """

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        self._socket = end
        self._unsent: deque[memoryview] = deque()
        self._received = bytearray()
        self.is_open = True

    @classmethod
    def pair(cls) -> tuple[Link, Link]:
        """Return both ends of a new connection."""
        here, there = socket.socketpair()
        return cls(here), cls(there)

    def fileno(self) -> int:
        """Return the file descriptor, for `select`."""
        return self._socket.fileno()

    def send(self, record: object) -> None:
        """Send a record, now or as soon as the other end has read enough; in vain if it is gone."""
        data = pickle.dumps(record, pickle.HIGHEST_PROTOCOL)
        self._unsent.append(memoryview(_LENGTH.pack(len(data)) + data))
        self.flush()

    def flush(self) -> bool:
        """Send what is left over; return whether nothing is."""
        try:
            while self._unsent:
                data = self._unsent[0]
                sent = self._socket.send(data)
                if sent < len(data):
                    self._unsent[0] = data[sent:]
                else:
                    self._unsent.popleft()
        except BlockingIOError:
            return False
        except OSError:  # the other end is gone; receive() will tell
            self._unsent.clear()
        return True

    def flush_within(self, duration_s: float) -> None:
        """Send what is left over, waiting up to `duration_s` each time that the other end is full."""
        while not self.flush() and select.select([], [self], [], duration_s)[1]:
            pass

    def wait(self, duration_s: float) -> bool:
        """Wait until there is something to receive, `duration_s` at most; return whether there is."""
        return bool(select.select([self], [], [], duration_s)[0])

    def receive(self) -> list[Any]:
        """Return all records that have arrived, without waiting."""
        try:
            while data := self._socket.recv(CHUNK_BYTES):
                self._received += data
            self.is_open = False
        except BlockingIOError:
            pass
        except OSError:
            self.is_open = False
        return self._complete_records()

    def close(self) -> None:
        """Hang up."""
        self.is_open = False
        with contextlib.suppress(OSError):
            self._socket.close()

    def _complete_records(self) -> list[Any]:
        records, at = [], 0
        while len(self._received) - at >= _LENGTH.size:
            start = at + _LENGTH.size
            end = start + _LENGTH.unpack_from(self._received, at)[0]
            if end > len(self._received):
                break
            records.append(pickle.loads(self._received[start:end]))
            at = end
        del self._received[:at]
        return records
