"""Is this point list a shape that robots can fill? Says what is wrong, where, and what to do."""

from __future__ import annotations

import numpy as np
from shapely import LinearRing, Polygon
from shapely.validation import explain_validity

from mission_computer.shape.detail import VERTICES_MAX, simplified
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.types import FloatArray

SAME_POINT = 1e-6  # [m]; vertices nearer than this are one vertex
COORDINATE_MAX = 1e5  # [m]; farther than any robot gets
FLATNESS_MIN = 1e-6  # area over squared perimeter; a 1 m wide strip could be 250 km long


def validate(points: FloatArray, name: str) -> FloatArray:
    """Return a clean contour, or refuse the points.

    Parameters
    ----------
    points : (n, 2) array
        Vertices in order, either direction; the first may be repeated at the end [m].
    name : str
        What to call the shape in errors: its file or library name.

    Returns
    -------
    (k, 2) array
        Counter-clockwise, last vertex not a repetition of the first, k <= `VERTICES_MAX`.

    Raises
    ------
    ShapeError
        If a coordinate is not finite or too large, fewer than three vertices differ, the contour crosses or touches
        itself (with the place), encloses no area, or cannot be told with `VERTICES_MAX` vertices.
    """
    return np.ascontiguousarray(simplify(checked_ring(points, name), name))


def checked_ring(points: FloatArray, name: str, reach: float = COORDINATE_MAX) -> FloatArray:
    """Return the points as a counter-clockwise contour of any number of vertices; as `validate` in all else.

    Parameters
    ----------
    points, name
        As for `validate`.
    reach : float
        No coordinate may be larger [m].
    """
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        x, y = points[bad[0]]
        raise ShapeError(f"{name}: vertex {bad[0] + 1} is ({x:g}, {y:g}); every coordinate must be a finite number")
    if points.size and np.abs(points).max() > reach:
        raise ShapeError(
            f"{name}: a coordinate of {np.abs(points).max():g} m is out of reach; give meters in the arena, or a size"
            " (area_m2, fit_m)"
        )
    contour = _without_repetitions(points)
    if len(contour) < 3:
        raise ShapeError(f"{name}: only {len(contour)} different vertices; a contour needs at least 3")
    _check_simple(contour, name)
    if signed_area(contour) < 0.0:
        contour = contour[::-1]
    return contour


def simplify(contour: FloatArray, name: str) -> FloatArray:
    """Return the contour with at most `VERTICES_MAX` vertices and the same area and center to first order.

    Raises
    ------
    ShapeError
        If so few vertices cannot tell this shape.
    """
    if len(contour) <= VERTICES_MAX:
        return contour
    polygon = Polygon(contour)
    fewer = simplified(polygon, name)
    simple = np.array(fewer.exterior.coords, dtype=np.float64)[:-1]
    # Cutting corners loses area (a circle becomes an inscribed polygon); the robots were promised all of it.
    center = area_centroid(simple)
    scaled: FloatArray = center + (simple - center) * np.sqrt(polygon.area / fewer.area)
    return scaled


def check_inside(contour: FloatArray, bounds: tuple[float, float, float, float], name: str) -> None:
    """Refuse a shape that is not wholly inside the arena.

    Parameters
    ----------
    contour : (k, 2) array
    bounds : tuple of float
        Least x, least y, greatest x, greatest y of the arena [m].
    name : str
        What to call the shape in errors.

    Raises
    ------
    ShapeError
        Naming the vertex that is farthest out.
    """
    excess = np.maximum(bounds[:2] - contour, contour - bounds[2:]).max(axis=1)
    worst = int(np.argmax(excess))
    if excess[worst] > 0.0:
        x, y = contour[worst]
        raise ShapeError(
            f"{name}: vertex ({x:g}, {y:g}) is {excess[worst]:.2g} m outside the arena"
            f" ({bounds[0]:g}, {bounds[1]:g}) to ({bounds[2]:g}, {bounds[3]:g}); move or shrink the shape"
        )


def _without_repetitions(points: FloatArray) -> FloatArray:
    if not len(points):
        return points
    steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    keep = steps > SAME_POINT
    keep[0] = True
    kept: FloatArray = points[keep]
    if len(kept) > 1 and np.linalg.norm(kept[-1] - kept[0]) <= SAME_POINT:
        kept = kept[:-1]
    return kept


def _check_simple(contour: FloatArray, name: str) -> None:
    """Refuse contours without area, and contours that cross or touch themselves."""
    ring = LinearRing(contour)
    if abs(signed_area(contour)) < FLATNESS_MIN * ring.length**2 and _is_flat(contour):
        raise ShapeError(f"{name}: all vertices lie on one line, so it encloses no area; spread them out")
    polygon = Polygon(contour)
    if not polygon.is_valid:
        x, y = _place_of(explain_validity(polygon))
        raise ShapeError(
            f"{name}: the contour crosses or touches itself at ({x:.2f}, {y:.2f}); list the vertices once around"
        )
    if polygon.area < FLATNESS_MIN * ring.length**2:
        raise ShapeError(f"{name}: encloses an area of only {polygon.area:.2g} m2; spread the vertices out")


def _is_flat(contour: FloatArray) -> bool:
    spread = np.linalg.svd(contour - contour.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= SAME_POINT * max(1.0, spread[0]))


def _place_of(explanation: str) -> tuple[float, float]:
    """Return the coordinates in a text such as ``Self-intersection[1.5 2]``."""
    x, y = explanation[explanation.index("[") + 1 : explanation.index("]")].split()[:2]
    return float(x), float(y)
