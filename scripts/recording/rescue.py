"""Bags that nobody has finished, because who recorded them was killed: what had reached the disk can be read."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.metadata import parse_qos

from swarm_msgs_py.errors import ConfigError

VERSION: Final = 9  # of the bag's metadata: what ROS 2 Jazzy writes
QUALITIES: Final = "offered_qos_profiles"  # metadata of a channel
_CUT = (McapError, struct.error, zstandard.ZstdError, ValueError, RuntimeError)
"""What reading raises where a file ends in the middle of a record."""
_NO_HASH: Final = "RIHS01_" + 64 * "0"  # of message types; the storage does not hold them, nobody compares them

Record = tuple[Schema | None, Channel, Message]


def rescue(files: list[Path], path: Path) -> int:
    """Write a finished bag with everything that unfinished files hold up to where they were cut off.

    Parameters
    ----------
    files : list of Path
        MCAP files of one recording, in order.
    path : Path
        Folder that is not there yet.

    Returns
    -------
    int
        How many messages there are.

    Raises
    ------
    ConfigError
        If there are none.
    OSError
        If the disk does not take them, or a file cannot be read.
    """
    count, connections = 0, dict[str, Connection]()
    with Writer(path, version=VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
        for file in files:
            for schema, channel, message in _records(file):
                if channel.topic not in connections:
                    connections[channel.topic] = _connection(writer, schema, channel)
                writer.write(connections[channel.topic], message.log_time, message.data)
                count += 1
    if not count:
        named = ", ".join(file.name for file in files)
        raise ConfigError(f"{named}: has no messages; cut off before any reached the disk, or no recording at all")
    return count


def _records(file: Path) -> Iterator[Record]:
    """Yield the messages of a file up to its end, or up to where it was cut off."""
    schemas, channels = dict[int, Schema](), dict[int, Channel]()
    with file.open("rb") as stream:
        records = StreamReader(stream).records
        while True:
            try:
                record = next(records, None)
            except _CUT:
                return
            if record is None:
                return
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                yield schemas.get(channel.schema_id), channel, record


def _connection(writer: Writer, schema: Schema | None, channel: Channel) -> Connection:
    return writer.add_connection(
        channel.topic,
        schema.name if schema is not None else "",
        msgdef=schema.data.decode(errors="replace") if schema is not None else "",
        rihs01=_NO_HASH,
        offered_qos_profiles=parse_qos(channel.metadata.get(QUALITIES, "")),
    )
