"""What shape, and which shapes after it: the part of a scenario that says so."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from mission_computer.shape import TEXT_PREFIX, CoordinateUnit
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.errors import ConfigError

HOLD_S = 3.0
"""How long robots must have been at rest before the next stage, where a stage says neither when nor how long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeSpec(Config):
    """The contour to form: a library name, a file, a text, or points, and how it is placed."""

    name: str | None = setting(None, "library shape; beside a file, a text or points it is only what to call them")
    file: str | None = setting(
        None,
        "GeoJSON, JSON list of points, SVG drawing, or silhouette as a picture (PNG, JPEG, ...), relative to the"
        " scenario's own folder",
    )
    text: str | None = setting(None, "letters to form")
    font: str | None = setting(
        None, "of the text: family with style, e.g. 'DejaVu Serif:bold', or a font file; null: DejaVu Sans:bold"
    )
    unit: CoordinateUnit | None = setting(
        None,
        "of the coordinates in a GeoJSON file: m, or deg (longitude and latitude, as RFC 7946 has it; the middle of the"
        " map comes to (0, 0)); null: what the file's crs says, or its numbers if they can only be one of both",
    )
    points: tuple[tuple[float, float], ...] | None = setting(None, "contour [x, y], once around", unit="m")
    fit_m: tuple[float, float] | None = setting(
        None, "as large as it can be in a box of this width and height, before it is turned", unit="m", above=0.0
    )
    area_m2: float | None = setting(
        None,
        "instead: of this area; null, and no fit_m: drawings, pictures and texts become large enough for the robots,"
        " and their center comes to (0, 0) unless center_m says where; all else keeps its own size and place",
        unit="m^2",
        above=0.0,
    )
    scale: float = setting(1.0, "size factor about the center of area, after that", above=0.0, maximum=1e4)
    rotation_deg: float = setting(0.0, "turn about the center of area, counter-clockwise", unit="deg")
    center_m: tuple[float, float] | None = setting(None, "where its center of area is put", unit="m")
    translation_m: tuple[float, float] = setting((0.0, 0.0), "shift after that", unit="m")
    heading_deg: float | None = setting(
        None,
        "direction that all robots face in it; null: they hold the one they have (agent.control.heading_deg)",
        unit="deg",
        minimum=-180.0,
        maximum=180.0,
    )

    def __post_init__(self) -> None:
        """Check that there is exactly one source of points, and one size."""
        Config.__post_init__(self)
        sources = {"file": self.file, "text": self.text, "points": self.points}
        given = [name for name, source in sources.items() if source is not None]
        if len(given) > 1:
            raise ConfigError(f"{' and '.join(given)} are both given; remove one of them")
        if not given and self.name is None:
            raise ConfigError("no shape; give one of name, file, text or points")
        if self.font is not None and self.text is None:
            raise ConfigError("font without text; give text, or remove font")
        if self.unit is not None and self.file is None:
            raise ConfigError("unit without file; it is that of GeoJSON files, so give file, or remove unit")
        if self.fit_m is not None and self.area_m2 is not None:
            raise ConfigError("fit_m and area_m2 are both given; remove one of them")

    @property
    def source(self) -> str:
        """What `mission_computer.shape` reads it from."""
        if self.text is not None:
            return f"{TEXT_PREFIX}{self.text}"
        # Points are handed over as JSON, which is read in every form that a file may have.
        source = json.dumps(self.points) if self.points is not None else self.file or self.name
        assert source is not None  # checked above
        return source

    @property
    def label(self) -> str:
        """What to call the shape."""
        return self.name or self.text or (Path(self.file).stem if self.file else "inline shape")


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitSpec(Config):
    """How a shape parts in two halves of equal area."""

    direction_deg: float = setting(0.0, "in which the halves move apart, counter-clockwise from +x", unit="deg")
    gap_m: float = setting(4.0, "free distance between the halves", unit="m", above=0.0, maximum=1e3)


@dataclass(frozen=True, slots=True, kw_only=True)
class StageSpec(Config):
    """One more shape after the first, or what becomes of the shape before it; and when, and for how long it moves."""

    shape: ShapeSpec | None = setting(None, "another shape")
    translate_m: tuple[float, float] | None = setting(
        None, "instead: the shape before it, shifted by so much", unit="m"
    )
    scale: float | None = setting(
        None, "likewise: so many times as large, about the center of area", above=0.0, maximum=1e4
    )
    rotate_deg: float = setting(
        0.0,
        "likewise: turned by so much about the center of area, counter-clockwise; beside `shape`: by how much the shape"
        " before it turns on the way",
        unit="deg",
        minimum=-1080.0,
        maximum=1080.0,
    )
    split: SplitSpec | None = setting(None, "instead: the shape before it in two halves, apart from each other")
    join: bool = setting(False, "instead: the halves of the last split together again")
    over_s: float = setting(
        0.0,
        "how long the shape before it takes to turn into this one, while the robots move along; 0: it is a new shape to"
        " which they drive by themselves",
        unit="s",
        minimum=0.0,
        maximum=1e5,
    )
    at_s: float | None = setting(
        None,
        "when it is ordered, or as soon after as the motion before it is over; motions begin mission.lead_s later. A"
        " stage that is so late that a new shape (over_s 0) is due after it is passed over",
        unit="s",
        minimum=0.0,
    )
    hold_s: float | None = setting(
        None,
        f"instead: for how long all robots must report to be at rest before; null, and no at_s: {HOLD_S:g}",
        unit="s",
        minimum=0.0,
    )

    def __post_init__(self) -> None:
        """Check that there is one shape, and one time for it.

        Raises
        ------
        ConfigError
            Naming what is too much or missing.
        """
        Config.__post_init__(self)
        given = {
            "shape": self.shape is not None,
            "split": self.split is not None,
            "join": self.join,
            "translate_m, scale or rotate_deg": self._is_transformed,
        }
        chosen = [name for name, is_given in given.items() if is_given]
        if not chosen:
            raise ConfigError("a stage without a shape; give shape, split, join, translate_m, scale or rotate_deg")
        if len(chosen) > 1:
            raise ConfigError(f"{' and '.join(chosen)} are both given; make them two stages")
        if self.shape is not None and self.rotate_deg and not self.over_s:
            raise ConfigError("rotate_deg beside shape is the turn on the way; give over_s, or shape.rotation_deg")
        if self.at_s is not None and self.hold_s is not None:
            raise ConfigError("at_s and hold_s are both given; remove one of them")

    @property
    def rest_s(self) -> float:
        """How long robots must have been at rest, if there is no time [s]."""
        return HOLD_S if self.hold_s is None else self.hold_s

    @property
    def _is_transformed(self) -> bool:
        is_turned = self.rotate_deg != 0.0 and self.shape is None
        return self.translate_m is not None or self.scale is not None or is_turned
