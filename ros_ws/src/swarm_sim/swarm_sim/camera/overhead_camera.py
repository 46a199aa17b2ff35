"""The camera over the arena: when it takes images, and what can go wrong with them."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol

from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo, ImageArray
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.camera.exposure import LightArray, digitize, illumination
from swarm_sim.camera.optics import Optics, make_optics, stated_info
from swarm_sim.camera.raster import Raster, Spot
from swarm_sim.config import CameraConfig, Renderer


class Painter(Protocol):
    """Draws the arena as seen through one camera."""

    def draw(self, positions: FloatArray, yaws: FloatArray, spots: Sequence[Spot] = ()) -> LightArray:
        """Return the codes (h, w, 3), not rounded, of robots at positions (n, 2) [m] with headings (n,) [rad]."""
        ...

    def close(self) -> None:
        """Free what the renderer holds; may be called again."""
        ...


class OverheadCamera:
    """Takes images of the robots' covers.

    Each image draws its noise from a stream named after its number, so that no image shifts the noise of another.

    Parameters
    ----------
    config : CameraConfig
    markers : sequence of CoverMarker
        One per robot, in the order of the bodies.
    marks : FloorMarks
    seed : int
        Seed of the run; draws mounting, light and noise.
    renderer : Renderer
        Who draws the images; what the configuration says of it is for who makes the camera to heed.

    Raises
    ------
    PhysicsError
        If the renderer is not installed, or does not start.
    """

    def __init__(
        self,
        config: CameraConfig,
        markers: Sequence[CoverMarker],
        marks: FloorMarks,
        seed: int,
        renderer: Renderer = Renderer.RASTER,
    ) -> None:
        self._config, self._seed = config, seed
        self.optics = mounted_optics(config, seed)
        self._info = stated_info(self.optics.info, config.info_sigma, rng_for(seed, "camera maker"))
        light = illumination(config, rng_for(seed, "camera light"))
        self._painter = self._make_painter(renderer, markers, marks, light)

    def _make_painter(
        self, renderer: Renderer, markers: Sequence[CoverMarker], marks: FloorMarks, light: LightArray
    ) -> Painter:
        config, grain = self._config, rng_for(self._seed, "camera floor")
        if renderer is Renderer.RASTER:
            return Raster(self.optics, markers, marks, light, grain, config.spot_px)
        try:
            # Imported on demand: the other renderer must work where this one is not installed.
            module = import_module("swarm_sim.camera.bullet_painter")
        except ImportError as error:
            raise PhysicsError(
                f"renderer 'bullet' is not installed ({error}); install pybullet or set camera.renderer to raster"
            ) from error
        painter: Painter = module.BulletPainter(self.optics, markers, marks, light, config.spot_px)
        return painter

    @property
    def info(self) -> CameraInfo:
        """Return what the maker of the camera says of its geometry; where it is mounted is for others to find out."""
        return self._info

    def is_due(self, time: float, last: float | None) -> bool:
        """Return whether an image is to be taken at `time`, after one at `last` (None: there was none yet) [s]."""
        return last is None or time - last >= 1.0 / self._config.rate_hz - 1e-9

    def take(
        self, number: int, time: float, positions: FloatArray, yaws: FloatArray, spots: Sequence[Spot] = ()
    ) -> CameraImage | None:
        """Return an image, or None while the camera is off.

        Parameters
        ----------
        number : int
            Of the image, counted from the start of the run; names its noise.
        time : float
            Simulated time [s].
        positions : (n, 2) array
            Of the robots [m].
        yaws : (n,) array
            [rad].
        spots : sequence of Spot
            What else lies on the floor.
        """
        config = self._config
        if config.off_from_s <= time < config.off_from_s + config.off_for_s:
            return None
        codes = self._painter.draw(positions, yaws, spots)
        pixels = digitize(codes, config.noise_codes, rng_for(self._seed, "camera noise", number))
        if config.black_from_s <= time < config.black_from_s + config.black_for_s:
            blacken_half(pixels)
        return CameraImage(time, pixels)

    def close(self) -> None:
        """Free what the renderer holds; may be called again."""
        self._painter.close()


def mounted_optics(config: CameraConfig, seed: int) -> Optics:
    """Return the camera of a run at its place."""
    return make_optics(config, rng_for(seed, "camera mount"))


def blacken_half(pixels: ImageArray) -> None:
    """Turn the left half of an image black, in place, as a broken sensor would."""
    pixels[:, : pixels.shape[1] // 2] = 0
