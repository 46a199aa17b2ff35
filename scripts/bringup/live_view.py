"""A run as a scene in a browser: a WebSocket that Foxglove connects to, in the application or on its web page.

The server starts with the first tick, after all processes have parted: its threads would not survive a fork.
"""

from __future__ import annotations

import json
import math
import socket
import time
from types import TracebackType
from typing import Any

import foxglove
import numpy as np
from foxglove.channels import SceneUpdateChannel
from foxglove.messages import (
    Color,
    CylinderPrimitive,
    LinePrimitive,
    LinePrimitiveLineType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    Vector3,
)

from bringup.engine import TickRecord
from bringup.scene import Rgb, RobotView, Scene, Scenes
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.types import FloatArray, robot_name

HOST = "127.0.0.1"
PERIOD_S = 0.1  # wall time between two pictures
FRAME = "map"
HEIGHT, LINE, LINK, PLACE = 0.4, 0.16, 0.06, 0.5  # in radii of the smallest robot
SHAPE, WALL, WANTED, LINKED = (0.1, 0.6, 0.2), (0.4, 0.4, 0.4), (0.9, 0.6, 0.1), (0.3, 0.5, 0.65)


class LiveView:
    """Shows a run to whoever connects.

    Parameters
    ----------
    name : str
        Of the scenario.
    scenes : Scenes
        Of the run that is to be shown.
    port : int
        On this machine; 0: any free one.
    """

    def __init__(self, name: str, scenes: Scenes, port: int) -> None:
        self._port = port
        self._name = name
        self._scenes = scenes
        self._unit = float(scenes.radii.min(initial=1.0))
        self._context = foxglove.Context()
        self._scene = SceneUpdateChannel("/swarm", context=self._context)
        self._robots = foxglove.Channel("/robots", message_encoding="json", context=self._context)
        self._server: foxglove.websocket.WebSocketServer | None = None
        self._due = -math.inf

    def __enter__(self) -> LiveView:
        """Check that the port is free; serving begins with the first tick.

        Raises
        ------
        ConfigError
            If it is not.
        """
        with socket.socket() as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server: after a run it may linger
            try:
                trial.bind((HOST, self._port))
            except OSError as error:
                raise ConfigError(
                    f"--live {self._port}: cannot be served ({error.strerror}); name another port"
                ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop serving."""
        if self._server is not None:
            self._server.stop()
            self._server = None

    @property
    def address(self) -> str:
        """Where it serves, once it does; "" before."""
        return f"ws://{HOST}:{self._server.port}" if self._server is not None else ""

    def take(self, record: TickRecord[Any, Any]) -> None:
        """Take in one tick, and show it if there has not just been a picture.

        Raises
        ------
        SwarmError
            If it cannot be served after all: somebody was faster to take the port.
        """
        if self._server is None:
            self._server = self._serve()
        scene = self._scenes.take(record)
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + PERIOD_S
        stamp = round(record.truth.time * 1e9)
        self._scene.log(SceneUpdate(entities=self._entities(scene)), log_time=stamp)
        told = {"time_s": record.truth.time, "robots": [self._told(view) for view in scene.robots]}
        self._robots.log(json.dumps(told), log_time=stamp)

    def _serve(self) -> foxglove.websocket.WebSocketServer:
        try:
            return foxglove.start_server(name=self._name, host=HOST, port=self._port, context=self._context)
        except (RuntimeError, OSError) as error:
            raise SwarmError(f"--live {self._port}: cannot be served any more ({error})") from None

    def _entities(self, scene: Scene) -> list[SceneEntity]:
        robots = [self._robot(*each) for each in zip(scene.positions, self._scenes.radii, scene.robots, strict=True)]
        size = PLACE * self._unit
        places = [
            SpherePrimitive(pose=_pose(place), size=Vector3(x=size, y=size, z=size), color=_color(WANTED))
            for place in scene.places
        ]
        ends = [_point(scene.positions[end]) for pair in scene.links for end in pair]
        links = self._line(ends, LINKED, LINK, LinePrimitiveLineType.LineList)
        return [
            SceneEntity(frame_id=FRAME, id="robots", **_of_kind(robots)),
            SceneEntity(frame_id=FRAME, id="walls", lines=[self._loop(wall, WALL) for wall in self._scenes.walls]),
            SceneEntity(frame_id=FRAME, id="links", lines=[links]),
            SceneEntity(
                frame_id=FRAME,
                id="plan",
                lines=[self._loop(outline, SHAPE) for outline in scene.outlines],
                spheres=places,
            ),
        ]

    def _robot(self, place: FloatArray, radius: float, view: RobotView) -> CylinderPrimitive | SpherePrimitive:
        """Return a robot: a disc on the ground, a ball in space."""
        color, width = _color(view.color), 2.0 * float(radius)
        if len(place) > 2:
            return SpherePrimitive(pose=_pose(place), size=Vector3(x=width, y=width, z=width), color=color)
        height = HEIGHT * self._unit
        size = Vector3(x=width, y=width, z=height)
        pose = _pose(np.append(place, height / 2.0))
        return CylinderPrimitive(pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=color)

    def _told(self, view: RobotView) -> dict[str, object]:
        """Return what a robot does, as plain data."""
        facts = dict(zip(self._scenes.columns, view.facts, strict=True))
        return {"robot": robot_name(view.robot), "mode": view.state, **facts}

    def _loop(self, outline: FloatArray, rgb: Rgb) -> LinePrimitive:
        return self._line([*map(_point, outline)], rgb, LINE, LinePrimitiveLineType.LineLoop)

    def _line(self, points: list[Point3], rgb: Rgb, width: float, kind: LinePrimitiveLineType) -> LinePrimitive:
        thickness = width * self._unit
        pose = _pose(np.zeros(3))
        return LinePrimitive(type=kind, pose=pose, thickness=thickness, points=points, color=_color(rgb))


def _of_kind(robots: list[CylinderPrimitive | SpherePrimitive]) -> dict[str, Any]:
    """Return primitives by the name of the field of an entity that takes them."""
    return {
        "cylinders": [robot for robot in robots if isinstance(robot, CylinderPrimitive)],
        "spheres": [robot for robot in robots if isinstance(robot, SpherePrimitive)],
    }


def _color(rgb: Rgb) -> Color:
    return Color(r=rgb[0], g=rgb[1], b=rgb[2], a=1.0)


def _point(place: FloatArray) -> Point3:
    x, y, z = [*map(float, place), 0.0][:3]
    return Point3(x=x, y=y, z=z)


def _pose(place: FloatArray) -> Pose:
    x, y, z = [*map(float, place), 0.0][:3]
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
