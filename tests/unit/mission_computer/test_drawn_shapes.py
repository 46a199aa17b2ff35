"""Shapes from drawings, pictures, texts, and GeoJSON with holes and parts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image, ImageDraw
from shapely import Point, Polygon

from mission_computer.shape import Placement, is_drawing, load_shape, placed_shape, with_room
from mission_computer.shape.detail import VERTICES_MAX
from mission_computer.shape.filling import FillRule, filled
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.partition import PartitionConfig, needed_scale
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster

SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {frame}>{body}</svg>'


def drawn(folder: Path, body: str, frame: str = 'width="100" height="100"') -> Path:
    """Write an SVG file."""
    file = folder / "drawing.svg"
    file.write_text(SVG.format(frame=frame, body=body))
    return file


def pictured(folder: Path, mode: str, paper: object, ink: object) -> Path:
    """Write a PNG of a ring, outer radius 60 and inner radius 20 pixels, center right and above the middle."""
    image = Image.new(mode, (300, 200), paper)
    pen = ImageDraw.Draw(image)
    pen.ellipse((140, 20, 260, 140), fill=ink)
    pen.ellipse((180, 60, 220, 100), fill=paper)
    file = folder / "ring.png"
    image.save(file)
    return file


def test_transforms_of_groups_uses_and_view_boxes_apply(tmp_path: Path) -> None:
    body = """
      <defs><rect id="bar" width="4" height="2"/></defs>
      <g transform="translate(10,20) rotate(90) scale(2)"><use xlink:href="#bar" x="1"/></g>"""

    contour = load_shape(drawn(tmp_path, body, 'viewBox="0 0 50 50" width="500" height="500"'))

    # The bar is 8 x 4 after the scale, turned by 90 degrees; the view box makes it ten times as large, y downward.
    low, high = contour.min(axis=0), contour.max(axis=0)
    assert_allclose(high - low, [40.0, 80.0], atol=1e-6)
    assert_allclose(0.5 * (low + high), [80.0, -260.0], atol=1e-6)


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<path d="M0 0H10V10H0Z M2 2H6V6H2Z" fill-rule="evenodd"/>', 100 - 16),
        ('<path d="M0 0H10V10H0Z M2 2H6V6H2Z"/>', 100),
        ('<path d="M0 0H10V10H0Z M2 2V6H6V2Z"/>', 100 - 16),
        ('<rect width="10" height="10"/><rect x="2" y="2" width="4" height="4" fill="#ffffff"/>', 100 - 16),
        ('<circle r="10" cx="20" cy="20"/>', 100 * math.pi),
        ('<path d="M0 0 C 0 10 10 10 10 0 Z"/>', 60),
        ('<path d="M0 0H10V10H0Z" fill="none" stroke="black"/>', 100),
        ('<polygon points="0,0 10,0 10,10 0,10"/><rect width="90" height="90" fill="none"/>', 100),
    ],
    ids=["even-odd", "nonzero", "turned hole", "white over black", "circle", "curve", "outline only", "unfilled aside"],
)
def test_a_drawing_is_what_it_fills(tmp_path: Path, body: str, area: float) -> None:
    assert signed_area(load_shape(drawn(tmp_path, body))) == pytest.approx(area, rel=6e-3)


BAR = '<rect width="10" height="4"/>'
"""Four by ten: area 40, its middle at (5, -2), as pictures have y downward."""


@pytest.mark.parametrize(
    "unseen",
    [
        '<symbol id="s"><rect width="90" height="90"/></symbol>',
        '<mask id="m"><rect width="90" height="90"/></mask>',
        '<clipPath id="c"><rect width="90" height="90"/></clipPath>',
        '<marker id="k"><rect width="90" height="90"/></marker>',
        '<pattern id="p" width="9" height="9"><rect width="90" height="90"/></pattern>',
        '<linearGradient id="l"/><filter id="f"/>',
        '<rect width="90" height="90" visibility="hidden"/>',
        '<g visibility="hidden"><rect width="90" height="90"/></g>',
        '<rect width="90" height="90" style="display:none"/>',
        '<g display="none"><rect width="90" height="90" display="inline"/></g>',
        '<g opacity="0"><rect width="90" height="90" opacity="1"/></g>',
        '<a style="opacity: 0%"><rect width="90" height="90"/></a>',
        '<rect width="90" height="90" fill-opacity="0"/>',
        '<rect width="90" height="90" style="fill-opacity:0%"/>',
        '<style>.ghost { visibility: hidden }</style><rect class="ghost" width="90" height="90"/>',
        '<x:rect xmlns:x="urn:editor" width="90" height="90"/><metadata><rect width="90" height="90"/></metadata>',
        '<use xlink:href="#nowhere"/>',
    ],
)
def test_what_cannot_be_seen_is_no_part_of_the_shape(tmp_path: Path, unseen: str) -> None:
    contour = load_shape(drawn(tmp_path, unseen + BAR))

    assert signed_area(contour) == pytest.approx(40.0)
    assert_allclose(area_centroid(contour), [5.0, -2.0], atol=1e-9)


@pytest.mark.parametrize(
    ("body", "low", "high"),
    [
        (f'<g visibility="hidden"><g visibility="visible">{BAR}</g></g>', (0, -4), (10, 0)),
        # 20 units of the view box over 40 of the page: twice as large, put at (5, 6); the bar becomes 20 x 8.
        (
            f'<symbol id="s" viewBox="0 0 20 20">{BAR}</symbol><use href="#s" x="5" y="6" width="40" height="40"/>',
            (5, -14),
            (25, -6),
        ),
        # The viewport is wider than the box: the height decides (factor 2), and (100 - 40) / 2 are free on the left.
        (
            f'<symbol id="s" viewBox="0 0 20 20">{BAR}</symbol><use href="#s" width="100%" height="40%"/>',
            (30, -8),
            (50, 0),
        ),
        (f'<svg x="10" y="20" width="30" height="30" viewBox="0 0 10 10">{BAR}</svg>', (10, -32), (40, -20)),
        (f'<g transform="scale(2)"><svg x="10" y="20">{BAR}</svg></g>', (20, -48), (40, -40)),
        # A box inside of a box: 3 times, then (1, 2) of the middle box further and 2 times in it.
        (
            '<svg x="10" y="20" width="30" height="30" viewBox="0 0 10 10">'
            '<svg x="1" y="2" width="8" height="8" viewBox="0 0 4 4"><rect width="1" height="2"/></svg></svg>',
            (13, -38),
            (19, -26),
        ),
        ('<svg width="50%" height="40"><rect width="50%" height="10%"/></svg>', (0, -4), (25, 0)),
        (f'<g id="a">{BAR}</g><use href="#a" y="4"/><use href="#a" y="8"/>', (0, -12), (10, 0)),
    ],
    ids=["shown again", "symbol", "symbol in the middle", "box", "offset", "box in box", "percent", "used group"],
)
def test_viewports_and_uses_put_what_they_hold(
    tmp_path: Path, body: str, low: tuple[float, float], high: tuple[float, float]
) -> None:
    contour = load_shape(drawn(tmp_path, body))

    assert_allclose([contour.min(axis=0), contour.max(axis=0)], [low, high], atol=1e-9)
    assert signed_area(contour) == pytest.approx((high[0] - low[0]) * (high[1] - low[1]))


def test_a_drawing_all_in_white_is_its_white_figure(tmp_path: Path) -> None:
    body = '<g fill="white"><rect width="10" height="4"/><rect x="10" width="5" height="4"/></g>'

    assert signed_area(load_shape(drawn(tmp_path, body))) == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("mode", "paper", "ink"),
    [("L", 255, 0), ("L", 0, 255), ("RGB", "white", "navy"), ("RGBA", (0, 0, 0, 0), (255, 255, 255, 255)), ("1", 1, 0)],
    ids=["dark on light", "light on dark", "color", "transparent", "bitmap"],
)
def test_a_picture_is_its_silhouette(tmp_path: Path, mode: str, paper: object, ink: object) -> None:
    contour = load_shape(pictured(tmp_path, mode, paper, ink))

    # From the middle of one edge pixel to that of the opposite one a disc is one pixel wider than twice its radius.
    assert signed_area(contour) == pytest.approx(math.pi * (60.5**2 - 20.5**2), rel=0.02)
    assert_allclose(area_centroid(contour), [201.0, 200.0 - 80.0], atol=1.0)
    assert len(contour) <= VERTICES_MAX


@pytest.mark.parametrize(("kind", "paper", "ink"), [(np.uint16, 65535, 20000), (np.float32, 1.0, 0.1)])
def test_pictures_of_more_than_eight_bits_are_read_in_their_own_range(
    tmp_path: Path, kind: type, paper: float, ink: float
) -> None:
    values = np.full((100, 100), paper, dtype=kind)
    values[20:60, 30:80] = ink
    file = tmp_path / "deep.tiff"
    Image.fromarray(values).save(file)

    assert signed_area(load_shape(file)) == pytest.approx(2000.0, rel=0.03)


def test_a_speck_of_transparency_does_not_make_the_picture_its_rectangle(tmp_path: Path) -> None:
    file = pictured(tmp_path, "RGBA", (255, 255, 255, 255), (0, 0, 0, 255))
    with Image.open(file) as image:
        image.putpixel((0, 0), (255, 255, 255, 0))
        image.save(file)

    assert signed_area(load_shape(file)) == pytest.approx(math.pi * (60.5**2 - 19.5**2), rel=0.02)


def test_numbers_beyond_all_bounds_are_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match=r"drawing\.svg"):
        load_shape(drawn(tmp_path, '<rect width="1e400" height="10"/>'))


@pytest.mark.parametrize("source", ["text:SWARM", "hw_2_square"])
def test_shapes_without_a_unit_of_length_get_room_for_all(source: str) -> None:
    roster = Roster.of((THESIS_TYPES[0],) * 6)

    placement = with_room(source, Placement(), roster, PartitionConfig())

    if is_drawing(source):
        assert placement.center == (0.0, 0.0)
        factor = needed_scale(placed_shape(source, placement), roster, PartitionConfig())
        assert factor is not None
        assert factor <= 1.0
    else:
        assert placement == Placement()


def test_letters_have_holes_and_parts() -> None:
    shape = Polygon(placed_shape("text:Bio", Placement(area=300.0)))

    assert shape.area == pytest.approx(300.0, rel=2e-3)
    assert shape.is_valid
    holes = shape.buffer(0.1).buffer(-0.1).interiors  # closes the slits
    assert len(holes) == 3


def test_lines_of_a_text_are_centered_below_each_other() -> None:
    high, two = load_shape("text:I"), load_shape("text:I\nI")

    assert two[:, 1].min() < high[:, 1].min() - 1.0
    assert np.ptp(two[:, 0]) == pytest.approx(np.ptp(high[:, 0]), abs=1e-6)


def test_a_font_may_be_named_by_its_family_or_file() -> None:
    sans, serif = (placed_shape("text:I", Placement(), font) for font in ("DejaVu Sans", "DejaVu Serif"))

    assert len(serif) > len(sans) == 4


def test_a_placement_sizes_turns_and_puts_a_shape() -> None:
    box = [[0, 0], [4, 0], [4, 2], [0, 2]]

    fitted = placed_shape(box, Placement(fit=(10.0, 3.0), rotation=math.pi / 2, center=(5.0, 5.0)))
    sized = placed_shape(box, Placement(area=50.0, scale=2.0))

    assert_allclose([fitted.min(axis=0), fitted.max(axis=0)], [[3.5, 2.0], [6.5, 8.0]])
    assert signed_area(sized) == pytest.approx(200.0)
    assert_allclose(area_centroid(sized), [2.0, 1.0])


@pytest.mark.parametrize(
    "placement", [Placement(fit=(0.0, 1.0)), Placement(area=-1.0), Placement(center=(math.inf, 0))]
)
def test_a_placement_without_sense_is_refused(placement: Placement) -> None:
    with pytest.raises(ShapeError, match=r"inline shape: .* must be"):
        placed_shape([[0, 0], [1, 0], [0, 1]], placement)


@pytest.mark.parametrize(
    ("body", "complaint"),
    [
        ("<g", "not a sound SVG drawing"),
        ("<text>words</text>", "nothing in the drawing can be seen; .* convert texts"),
        ('<line x1="0" y1="0" x2="9" y2="9" stroke="black"/>', "nothing in the drawing has area"),
        ('<rect width="9" height="9"/><rect width="9" height="9" fill="#fff"/>', "white covers all"),
        ('<rect width="9" height="9" fill-opacity="0"/>', "nothing in the drawing has area; close its outlines"),
        ('<rect width="9" height="9" opacity="0"/>', "nothing in the drawing can be seen; show hidden layers"),
        ('<g id="a"><use href="#a"/></g>', r"not a sound SVG drawing \(ValueError\)"),
        ('<path d="M 0 0 L nonsense"/>', "not a sound SVG drawing|has area"),
    ],
)
def test_drawings_without_a_shape_are_refused(tmp_path: Path, body: str, complaint: str) -> None:
    with pytest.raises(ShapeError, match=complaint) as caught:
        load_shape(drawn(tmp_path, body))

    assert str(caught.value).startswith(str(tmp_path))
    assert "\n" not in str(caught.value)


def test_pictures_without_a_shape_are_refused(tmp_path: Path) -> None:
    blank, broken = tmp_path / "blank.png", tmp_path / "broken.jpg"
    Image.new("L", (20, 20), 255).save(blank)
    broken.write_bytes(b"\xff\xd8 no picture")

    with pytest.raises(ShapeError, match=r"blank\.png: the picture shows no figure"):
        load_shape(blank)
    with pytest.raises(ShapeError, match=r"broken\.jpg: not a readable picture"):
        load_shape(broken)


@pytest.mark.parametrize(
    ("text", "font", "complaint"),
    [
        ("", None, "the text is empty"),
        ("   ", None, "the text is empty"),
        ("x" * 50, None, "50 characters are too many"),
        ("A\u4e2d", None, "the font has no letter"),
        ("A", "Dejavu Sons", "did you mean 'DejaVu Sans'"),
        ("A", "nowhere.ttf", "no such file"),
    ],
)
def test_texts_that_cannot_be_drawn_are_refused(text: str, font: str | None, complaint: str) -> None:
    with pytest.raises(ShapeError, match=complaint):
        placed_shape(f"text:{text}", Placement(), font)


def test_only_drawings_have_no_unit_of_length() -> None:
    assert [is_drawing(source) for source in ("text:A", "a.svg", Path("b.PNG"))] == [True] * 3
    assert not any(is_drawing(source) for source in ("formation_1", "c.geojson", [[0.0, 0.0]], "[[0, 0]]"))


def test_outlines_that_cross_themselves_are_filled_by_the_rule() -> None:
    star = np.array([[np.sin(k * 0.8 * np.pi), np.cos(k * 0.8 * np.pi)] for k in range(5)])

    whole, hollow = filled([star], FillRule.NONZERO), filled([star], FillRule.EVENODD)

    assert whole.contains(Point(0.0, 0.0))
    assert not hollow.contains(Point(0.0, 0.0))
    assert filled([], FillRule.NONZERO).is_empty
