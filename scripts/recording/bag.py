"""Bags on disk: MCAP in a folder as ``ros2 bag record`` writes it, by way of rosbags."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, ReaderError, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from recording import FOLDER
from recording.rescue import VERSION, rescue
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.ros.cdr import NANO
from swarm_msgs_py.topics import Channel, Delivery

METADATA, SUFFIX = "metadata.yaml", ".mcap"
Timed = tuple[float, str, bytes]
"""Time of a message [s], its topic and its bytes."""
_NEVER = QosTime(0, 0)
_LATCHED = Qos(
    history=QosHistory.KEEP_LAST,
    depth=1,
    reliability=QosReliability.RELIABLE,
    durability=QosDurability.TRANSIENT_LOCAL,
    deadline=_NEVER,
    lifespan=_NEVER,
    liveliness=QosLiveliness.AUTOMATIC,
    liveliness_lease_duration=_NEVER,
    avoid_ros_namespace_conventions=False,
)
"""How latched channels are offered; the others as ROS does by default."""


class BagWriter:
    """Writes serialized messages; makes the bag with the first of them.

    Parameters
    ----------
    path : Path
        Folder that is not there yet.
    channels : mapping of str to Channel
        By topic.
    """

    def __init__(self, path: Path, channels: Mapping[str, Channel]) -> None:
        self._path, self._channels = path, channels
        self._writer: Writer | None = None
        self._connections: dict[str, Connection] = {}

    def write(self, topic: str, time: float, data: bytes) -> None:
        """Append a message of a time [s].

        Raises
        ------
        OSError
            If the disk does not take it.
        """
        if self._writer is None:
            self._writer = self._open()
        self._writer.write(self._connections[topic], round(time * NANO), data)

    def close(self) -> None:
        """Finish the bag, so that others can read it; in vain if nothing was written."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def _open(self) -> Writer:
        writer = Writer(self._path, version=VERSION, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        writer.open()
        types = get_typestore(Stores.ROS2_JAZZY)
        for topic, channel in sorted(self._channels.items()):
            # Only what is not the default: every profile costs a millisecond when the bag is closed.
            profiles = [_LATCHED] if channel.delivery is Delivery.LATCHED else []
            self._connections[topic] = writer.add_connection(
                topic, channel.message, typestore=types, offered_qos_profiles=profiles
            )
        return writer


@dataclass(frozen=True, slots=True)
class BagTopic:
    """A topic of a bag.

    Attributes
    ----------
    name : str
    message : str
        Type of its messages.
    count : int
        How many there are.
    is_latched : bool
        Whether the last message also reaches those who come later.
    """

    name: str
    message: str
    count: int
    is_latched: bool


class BagReader:
    """An open bag; made by `opened`.

    Attributes
    ----------
    is_unfinished : bool
        Whether the recording was cut off, so that what came last is not in it.
    """

    def __init__(self, reader: Reader, *, is_unfinished: bool = False) -> None:
        self._reader = reader
        self.is_unfinished = is_unfinished

    @property
    def duration_s(self) -> float:
        """From the first message to the last [s]."""
        return max(self._reader.duration - 1, 0) / NANO  # rosbags counts up to the nanosecond after the last

    @property
    def topics(self) -> tuple[BagTopic, ...]:
        """All topics with messages, by name."""
        found = [
            BagTopic(connection.topic, connection.msgtype, connection.msgcount, _is_latched(connection))
            for connection in self._reader.connections
            if connection.msgcount
        ]
        return tuple(sorted(found, key=lambda topic: topic.name))

    def messages(self, wanted: frozenset[str] | None = None, start_s: float = 0.0) -> Iterator[Timed]:
        """Yield time after the beginning of the bag [s], topic and bytes of messages, in order of time.

        What is latched reaches also those who come later: its last message from before the start comes first, at the
        time of the start.
        """
        chosen = [c for c in self._reader.connections if wanted is None or c.topic in wanted]
        begin, start = self._reader.start_time, self._reader.start_time + round(start_s * NANO)
        latched = [connection for connection in chosen if _is_latched(connection)]
        if latched and start > begin:
            last = {connection.topic: data for connection, _, data in self._reader.messages(latched, stop=start)}
            yield from ((start_s, topic, bytes(data)) for topic, data in sorted(last.items()))
        if chosen:  # rosbags takes none for all
            for connection, stamp, data in self._reader.messages(chosen, start=start):
                yield (stamp - begin) / NANO, connection.topic, bytes(data)


@contextmanager
def opened(path: Path) -> Iterator[BagReader]:
    """Open a bag: a run folder that has one, a bag folder, or an MCAP file; also an unfinished one.

    Raises
    ------
    ConfigError
        If there is none, or it cannot be read.
    """
    place = path / FOLDER if (path / FOLDER).is_dir() else path
    if not place.exists():
        raise ConfigError(f"{path}: there is no such file or folder; name a run folder, a bag folder or an .mcap file")
    files = sorted(place.glob(f"*{SUFFIX}")) if place.is_dir() else [place]
    if not files and not (place / METADATA).is_file():
        raise ConfigError(f"{path}: holds no recording; launch_swarm.py makes one with --record")
    with ExitStack() as stack:
        try:
            yield _reader(place, files, stack)
        except (ReaderError, OSError) as error:
            raise ConfigError(f"{place}: cannot be read as a bag ({error})") from error


def _reader(place: Path, files: list[Path], stack: ExitStack) -> BagReader:
    """Return the reader of a bag, or of what can be read of one that nobody has finished; the stack closes it.

    Raises
    ------
    ConfigError, OSError, ReaderError
        If there is nothing to read.
    """
    is_finished = place.is_file() or (place / METADATA).is_file()
    if is_finished or len(files) == 1:
        try:
            return BagReader(stack.enter_context(Reader(place if is_finished else files[0])))
        except ReaderError:
            if any(file.suffix != SUFFIX for file in files):
                raise
    copy = Path(stack.enter_context(TemporaryDirectory(prefix="swarm-"))) / FOLDER
    rescue(files, copy)
    return BagReader(stack.enter_context(Reader(copy)), is_unfinished=True)


def _is_latched(connection: Connection) -> bool:
    profiles = getattr(connection.ext, "offered_qos_profiles", [])
    return any(profile.durability is QosDurability.TRANSIENT_LOCAL for profile in profiles)
