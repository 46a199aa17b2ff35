"""The images of a run, one after the other: each is taken once, when it is due."""

from __future__ import annotations

from collections.abc import Sequence

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.camera.raster import Spot
from swarm_sim.config import CameraConfig, Renderer, SpotConfig
from swarm_sim.world.world import BodyState


class CameraFeed:
    """The overhead camera of a run.

    Parameters
    ----------
    config : CameraConfig
    markers : sequence of CoverMarker
        One per robot, in the order of the bodies.
    seed : int
        Seed of the run.
    renderer : Renderer
        Who draws the images.

    Raises
    ------
    ConfigError
        If robots have no covers to be known by.
    PhysicsError
        If the renderer is not installed, or does not start.
    """

    def __init__(
        self,
        config: CameraConfig,
        markers: Sequence[CoverMarker],
        seed: int,
        renderer: Renderer = Renderer.RASTER,
    ) -> None:
        if not markers:
            raise ConfigError("camera.is_on: the robots have no covers for it to see; give each type its colors")
        self._camera = OverheadCamera(config, markers, FloorMarks(), seed, renderer)
        self._spots = tuple(_spot(spot) for spot in config.spots)
        self._number = 0
        self._asked: float | None = None  # time that was asked for last [s]
        self._taken: float | None = None  # time of the last image that was due, taken or not [s]
        self._image: CameraImage | None = None

    @property
    def info(self) -> CameraInfo:
        """Return what the maker of the camera says of its geometry."""
        return self._camera.info

    def image(self, time: float, bodies: BodyState) -> CameraImage | None:
        """Return the image taken at `time` [s], None if none is due or to be had; again if asked again."""
        if time == self._asked:
            return self._image
        self._asked, self._image = time, None
        if self._camera.is_due(time, self._taken):
            self._image = self._camera.take(self._number, time, bodies.positions, bodies.yaws, self._spots)
            self._taken = time
            self._number += 1
        return self._image

    def close(self) -> None:
        """Free what the renderer holds; may be called again."""
        self._camera.close()


def _spot(config: SpotConfig) -> Spot:
    return Spot(config.color, config.center_m, config.radius_m)
