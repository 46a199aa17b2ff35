"""Text as a region: the glyphs of a font."""

from __future__ import annotations

import difflib
from pathlib import Path

import numpy as np
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.path import Path as Outline
from matplotlib.textpath import text_to_path
from shapely.geometry.base import BaseGeometry

from mission_computer.shape.filling import FillRule, filled, polygonal
from swarm_msgs_py.errors import ShapeError

FONT = "DejaVu Sans:bold"
"""Comes with Matplotlib, so that it is the same everywhere; bold, for robots need room."""

LINE_SPACING = 1.25  # of the height of the font
EM = 100.0  # [font units]; glyphs are drawn this large, so that curves get enough chords
TEXT_MAX = 40  # [characters]; a contour of 128 vertices cannot tell more


def text_region(text: str, font: str | None = None) -> BaseGeometry:
    """Return the letters of a text, lines centered above each other, capital letters about one unit high.

    Parameters
    ----------
    text : str
        At most `TEXT_MAX` characters, lines separated by newlines.
    font : str or None
        Family with style, as in ``DejaVu Serif:bold``, or a font file; None for `FONT`.

    Raises
    ------
    ShapeError
        If there is nothing to see, too much, or the font is not there or lacks a letter.
    """
    name = f"text '{text}'"
    if not text.strip():
        raise ShapeError("the text is empty; give at least one letter")
    if len(text) > TEXT_MAX:
        raise ShapeError(f"{name}: {len(text)} characters are too many for one contour; give at most {TEXT_MAX}")
    properties = _font(font or FONT)
    _check_letters(text, properties, name)
    rings, height = [], 0.0
    for line in text.split("\n"):
        points, codes = text_to_path.get_text_path(properties, line)
        outlines = [np.asarray(ring) for ring in Outline(points, codes).to_polygons()] if len(points) else []
        if outlines:
            corners = np.vstack(outlines)
            middle = 0.5 * (corners[:, 0].min() + corners[:, 0].max())
            rings += [(ring - (middle, -height)) / EM for ring in outlines]
        height -= LINE_SPACING * EM
    region = polygonal(filled(rings, FillRule.NONZERO))
    if region.is_empty:
        raise ShapeError(f"{name}: has no visible letter; give at least one")
    return region


def _font(font: str) -> FontProperties:
    """Return a font that is there.

    Raises
    ------
    ShapeError
        With the nearest family.
    """
    if Path(font).suffix.lower() in {".ttf", ".otf", ".ttc"}:
        if not Path(font).is_file():
            raise ShapeError(f"font {font}: no such file; give a font file or a family such as '{FONT}'")
        return FontProperties(fname=font, size=EM)
    try:
        properties = FontProperties(font)  # alone, it may hold a style
        properties.set_size(EM)
        findfont(properties, fallback_to_default=False)
    except ValueError:
        families = sorted({entry.name for entry in fontManager.ttflist})
        near = difflib.get_close_matches(font.partition(":")[0], families, n=1)
        remedy = f"did you mean '{near[0]}'?" if near else f"give a family that is installed, such as '{FONT}'"
        raise ShapeError(f"font '{font}': not found; {remedy}") from None
    return properties


def _check_letters(text: str, properties: FontProperties, name: str) -> None:
    try:
        glyphs = get_font(findfont(properties)).get_charmap()
    except RuntimeError as error:
        raise ShapeError(f"font {findfont(properties)}: not a readable font ({error}); give another one") from None
    for letter in text:
        if letter not in "\n" and ord(letter) not in glyphs:
            raise ShapeError(f"{name}: the font has no letter '{letter}'; choose another font, or leave it out")
