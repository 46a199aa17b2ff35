"""The replay of a run as a film: MP4 (H.264) or GIF."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from reports import scene
from reports.figures import FONT, LABEL, blank
from reports.palette import LINK
from reports.run_record import RunRecord
from reports.series import links_by_tick
from swarm_msgs_py.types import FloatArray

WATCHED_S = 15.0  # length of a film that nobody asked to be longer
HOLD_S = 1.0  # that the last picture stays
ASPECT = 1.0
MILLISECONDS = 1000

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class FilmSpec:
    """What a film is like.

    Attributes
    ----------
    fps : int
        Pictures per second.
    speed : float or None
        Simulated seconds per second; None for a film of `WATCHED_S`.
    width_in : float
        Width of the picture [in].
    dpi : int
        Pixels per inch.
    """

    fps: int
    speed: float | None
    width_in: float
    dpi: int


def write_film(path: Path, record: RunRecord, spec: FilmSpec) -> int:
    """Write the film of a run; return how many pictures it has.

    Parameters
    ----------
    path : Path
        Its ending says what kind: ``.mp4`` or ``.gif``.
    record : RunRecord
        With at least one tick.
    spec : FilmSpec
    """
    times = film_times(record, spec)
    pictures = _pictures(record, times, spec)
    if path.suffix == ".gif":
        _write_gif(path, pictures, spec.fps)
    else:
        _write_mp4(path, pictures, spec.fps)
    return len(times)


def film_times(record: RunRecord, spec: FilmSpec) -> FloatArray:
    """Return the simulated times of the pictures [s]; the last of them several times."""
    end = float(record.edge_times[-1])
    rate = spec.speed if spec.speed is not None else max(1.0, end / WATCHED_S)
    moving = np.append(np.arange(0.0, end, rate / spec.fps), end)
    return np.append(moving, np.full(round(HOLD_S * spec.fps), end))


class Scene:
    """The arena as it is at one time after the other."""

    def __init__(self, record: RunRecord, width_in: float) -> None:
        self._record = record
        self.figure = blank(width_in, ASPECT)
        axes = self.figure.subplots()
        scene.draw_ground(axes, record)
        self._shape = scene.draw_shape(axes, np.empty((0, 2)))
        self._links = LineCollection([], colors=LINK, linewidths=0.5, alpha=0.25, zorder=2.5)
        axes.add_collection(self._links)
        self._surface = scene.draw_surface(axes, record, 0)
        self._robots, self._goals = scene.RobotMarks(axes, record), scene.GoalMarks(axes, record)
        self._shapes, self._pairs = record.point_sets("shape"), self._link_rows()
        scene.frame_arena(axes, record)
        axes.set_aspect("equal")
        axes.tick_params(labelsize=FONT)
        axes.set_xlabel("x [m]", fontsize=LABEL)
        axes.set_ylabel("y [m]", fontsize=LABEL)
        self._title = axes.set_title("", fontsize=LABEL, loc="left", family="monospace")

    def put(self, time: float) -> None:
        """Show the last edge time up to `time` [s]."""
        record = self._record
        edge = int(np.searchsorted(record.edge_times, time + 1e-9, side="right")) - 1
        contour = self._shapes.at(edge)
        if len(contour):
            self._shape.set_xy(contour)
        places = record.edge_positions[edge][:, :2]
        if "mission_position" in record.arrays:
            places = np.vstack([places, record.arrays["mission_position"][:2]])
        pairs = self._pairs[min(edge, len(self._pairs) - 1)] if self._pairs else np.empty((0, 2), dtype=np.int64)
        self._links.set_segments(places[pairs] if len(pairs) else [])
        self._surface.set_data(*record.surface_at(edge)[:, :2].T)
        self._robots.put(edge)
        self._goals.put(edge)
        self._title.set_text(f"{record.metrics.get('scenario', '')}  {record.edge_times[edge]:7.1f} s")

    def _link_rows(self) -> list[NDArray[np.int64]]:
        """Return the rows of linked nodes by tick, (l, 2), the mission computer after the last robot."""
        if not self._record.has("link_tick"):
            return []
        return [np.argwhere(np.triu(linked)) for linked in links_by_tick(self._record)]


def _pictures(record: RunRecord, times: FloatArray, spec: FilmSpec) -> Iterator[Picture]:
    drawn = Scene(record, spec.width_in)
    drawn.figure.set_dpi(spec.dpi)
    drawn.put(float(times[0]))
    _rendered(drawn.figure)
    drawn.figure.set_layout_engine("none")  # laid out once: doing it for every picture costs more than drawing it
    shown, picture = None, None
    for time in times:
        if picture is None or time != shown:
            drawn.put(float(time))
            shown, picture = time, _rendered(drawn.figure)
        yield picture


def _rendered(figure: Figure) -> Picture:
    """Return the pixels of a figure, (h, w, 3), both sizes even as H.264 wants them."""
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)  # of `blank`
    canvas.draw()  # type: ignore[no-untyped-call]
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]  # type: ignore[no-untyped-call]
    height, width = (size - size % 2 for size in pixels.shape[:2])
    return np.ascontiguousarray(pixels[:height, :width])


def _write_mp4(path: Path, pictures: Iterator[Picture], fps: int) -> None:
    first = next(pictures)
    size = (first.shape[1], first.shape[0])
    writer = imageio_ffmpeg.write_frames(str(path), size, fps=fps, quality=7, macro_block_size=2)
    writer.send(None)
    try:
        writer.send(first)
        for picture in pictures:
            writer.send(picture)
    finally:
        writer.close()


def _write_gif(path: Path, pictures: Iterator[Picture], fps: int) -> None:
    images = [Image.fromarray(picture).convert("P", palette=Image.Palette.ADAPTIVE) for picture in pictures]
    images[0].save(path, save_all=True, append_images=images[1:], duration=MILLISECONDS // fps, loop=0, optimize=True)
