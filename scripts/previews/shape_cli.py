"""The command line of ``shape.py``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from bringup.formation_kind import METHODS
from bringup.layout import walls
from bringup.option_types import OneLineParser, choice, complain, whole
from bringup.resolution import with_map
from bringup.scenario import Scenario
from bringup.scenario_file import (
    ROBOT_COUNT,
    Override,
    load_scenario,
    map_override,
    method_overrides,
    parse_assignment,
    scenario_names,
    shape_override,
)
from mission_computer.shape import library_names
from previews.preview_figure import FORMATS, is_picture, preview_figure
from previews.shape_preview import ShapePreview, look_at
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.partition import Method

FITS, DOES_NOT_FIT, BAD_INPUT = 0, 1, 2


def main(argv: Sequence[str] | None = None) -> int:
    """Preview the shape that the command line names; return 0 if the robots fit, 1 if not, 2 for bad input."""
    try:
        given, scenario = parse_arguments(sys.argv[1:] if argv is None else argv)
        preview = look_at(scenario)
        print(json.dumps(preview.summary(), indent=1) if given.json else _told(preview))
        if given.out is not None:
            given.out.write_bytes(preview_figure(preview, walls(with_map(scenario)), given.out.suffix.lower()))
    except SwarmError as error:
        complain(error)
        return BAD_INPUT
    except OSError as error:
        print(f"error: {error.filename}: cannot be written ({error.strerror}); choose another --out", file=sys.stderr)
        return BAD_INPUT
    return FITS if preview.fits else DOES_NOT_FIT


def parse_arguments(argv: Sequence[str]) -> tuple[argparse.Namespace, Scenario]:
    """Return what was asked for, and the scenario whose shape is to be previewed.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    """
    given = _parser().parse_args(argv)
    if given.out is not None and not is_picture(given.out):
        raise ConfigError(f"--out {given.out}: unknown kind of picture; end it with one of {', '.join(FORMATS)}")
    overrides = [] if given.shape is None else [shape_override(given.shape)]
    overrides += [] if given.map is None else [map_override(given.map)]
    overrides += [] if given.method is None else method_overrides(given.method)
    overrides += [] if given.agents is None else [Override(f"--agents {given.agents}", ROBOT_COUNT, given.agents)]
    scenario, _ = load_scenario(given.scenario, (*overrides, *(parse_assignment(text) for text in given.set)))
    return given, scenario


def _parser() -> OneLineParser:
    parser = OneLineParser(
        prog="shape.py",
        description="Preview a shape: its contour, its partition into goals, and whether the robots fit.",
        epilog=f"Library shapes: {', '.join(library_names())}. Exit code 0: the robots fit; 1: they do not, with the "
        "reason; 2: bad input.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("shape", nargs="?", metavar="NAME|FILE|text:TEXT",
        help="library name; GeoJSON, points, SVG or a picture; or a text (default: the scenario's shape)")  # fmt: skip
    add("--scenario", metavar="NAME|FILE", default="formation-50",
        help=f"robots, gaps and map to try it with: {', '.join(scenario_names())} (default: %(default)s)")  # fmt: skip
    add("--map", metavar="NAME|FILE", help="in this arena instead of the scenario's")
    add("--agents", metavar="N", type=whole(1, 1000), help="number of robots; keeps the mix of types")
    add("--method", metavar="M", type=choice(Method, *METHODS[len(Method) :]), help=f"{', '.join(METHODS)}")
    add("--set", metavar="KEY=VALUE", action="append", default=[],
        help="any setting, e.g. shape.area_m2=300, shape.rotation_deg=30, shape.center_m=[5,0]")  # fmt: skip
    add("--out", metavar="FILE", type=Path, help="draw it: PNG, SVG or PDF")
    add("--json", action="store_true", help="print the numbers as JSON")
    return parser


def _told(preview: ShapePreview) -> str:
    """Return the preview in words."""
    numbers = preview.summary()
    width, height = preview.contour.max(axis=0) - preview.contour.min(axis=0)
    lines = [
        f"shape      {preview.label}: {numbers['vertices']} vertices, {width:.4g} m x {height:.4g} m",
        f"area       {preview.area:.4g} m2, {preview.area / preview.roster.size:.3g} m2 per robot",
    ]
    if preview.quality is not None:
        pairs = (("topological", preview.quality.topological_interior), ("geometrical", preview.quality.geometrical))
        lines.append("mesh       " + ", ".join(f"{name} {value:.3f}" for name, value in pairs if value is not None))
    lines.append(
        f"robots     {preview.roster.size} fit" if preview.fits else f"robots     do not fit: {preview.problem}"
    )
    return "\n".join(lines)
