"""A solid bounded by triangles, as CAD programs and scanners give it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

FORMATS = (".stl", ".obj")
CELLS = 48  # of the lookup grid along the longest edge: fine enough that few points are near the surface
PAIRS_MAX = 400_000  # points times triangles looked at in one go, to bound the memory
FULL_ANGLE = 4.0 * np.pi  # solid angle of everything around a point


class TriangleMesh:
    """A closed triangle mesh.

    The generalized winding number tells inside from outside: the signed solid angle under which all triangles are
    seen [1]_. It knows no special cases (rays through edges), but costs points times triangles. So a grid remembers
    for each cell that no triangle comes near whether it is inside; only points in the other cells are calculated.

    Parameters
    ----------
    vertices : (v, 3) array
        [m].
    faces : (f, 3) int array
        Corners of each triangle, rows of `vertices`.

    Raises
    ------
    ShapeError
        If a face has a corner that there is not, or the mesh is not closed or encloses nothing.

    References
    ----------
    .. [1] A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding
       numbers", ACM Transactions on Graphics 32(4), 2013.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        if not len(faces) or faces.min() < 0 or faces.max() >= len(vertices):
            raise ShapeError(f"{len(faces)} faces do not fit {len(vertices)} vertices")
        surface = trimesh.Trimesh(vertices, faces, process=True)
        if not surface.is_watertight:
            raise ShapeError("the mesh is not closed; repair it, for example with Blender's 3D print toolbox")
        surface.fix_normals()
        if not surface.volume > 0.0:
            raise ShapeError("the mesh encloses no volume")
        self.vertices: FloatArray = np.array(surface.vertices, dtype=np.float64)
        self.faces: IntArray = np.array(surface.faces, dtype=np.int64)
        self._triangles = self.vertices[self.faces]
        self._lower = self.vertices.min(axis=0)
        extent = self.vertices.max(axis=0) - self._lower
        self._cell = float(extent.max()) / CELLS
        self._cells = self._classified(np.ceil(extent / self._cell).astype(int) + 1)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        places = np.floor((points - self._lower) / self._cell).astype(int)
        on_grid = ((places >= 0) & (places < self._cells.shape)).all(axis=1)
        known = np.zeros(len(points), dtype=np.int8)
        known[on_grid] = self._cells[tuple(places[on_grid].T)]
        inside = known > 0
        near = known < 0
        inside[near] = self._winding(points[near]) > 0.5
        return inside

    def _classified(self, shape: IntArray) -> np.ndarray:
        """Return for each cell of the grid 1 inside, 0 outside, -1 near the surface, as int8."""
        near = np.zeros(shape, dtype=np.bool_)
        for triangle in self._triangles:
            first = np.floor((triangle.min(axis=0) - self._lower) / self._cell).astype(int)
            last = np.floor((triangle.max(axis=0) - self._lower) / self._cell).astype(int)
            near[tuple(slice(max(a - 1, 0), b + 2) for a, b in zip(first, last, strict=True))] = True
        cells = np.where(near, -1, 0).astype(np.int8)
        regions, count = ndimage.label(~near)
        if count:  # no triangle parts the cells of a region, so that one of them speaks for all
            index = np.arange(1, count + 1)
            spots = np.array(ndimage.maximum_position(~near, regions, index)).reshape(-1, 3)
            inside = self._winding(self._lower + (spots + 0.5) * self._cell) > 0.5
            cells[np.isin(regions, index[inside])] = 1
        return cells

    def _winding(self, points: FloatArray) -> FloatArray:
        """Return the winding number of the surface around each point: 1 inside, 0 outside, (n,)."""
        numbers = np.empty(len(points))
        step = max(1, PAIRS_MAX // len(self._triangles))
        for start in range(0, len(points), step):
            rays = self._triangles[None] - points[start : start + step, None, None]
            a, b, c = rays[:, :, 0], rays[:, :, 1], rays[:, :, 2]
            la, lb, lc = (np.sqrt(np.einsum("ijk,ijk->ij", side, side)) for side in (a, b, c))
            volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
            cosines = (
                la * lb * lc
                + np.einsum("ijk,ijk->ij", a, b) * lc
                + np.einsum("ijk,ijk->ij", b, c) * la
                + np.einsum("ijk,ijk->ij", c, a) * lb
            )
            numbers[start : start + step] = 2.0 * np.arctan2(volume, cosines).sum(axis=1) / FULL_ANGLE
        return numbers


def load_mesh(path: Path, scale: float) -> tuple[FloatArray, IntArray]:
    """Return vertices (v, 3) [m] and faces (f, 3) of an STL or OBJ file.

    Parameters
    ----------
    path : Path
    scale : float
        Meters per unit of the file.

    Raises
    ------
    ShapeError
        If the file is not there, of another format, or cannot be read; one line.
    """
    if path.suffix.lower() not in FORMATS:
        raise ShapeError(f"{path.name}: a mesh must be one of {', '.join(FORMATS)}")
    try:
        surface = trimesh.load_mesh(str(path))
    except (OSError, ValueError, KeyError, IndexError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ShapeError(f"{path.name}: cannot be read as a mesh ({reason})") from None
    if not isinstance(surface, trimesh.Trimesh) or not len(surface.faces):
        raise ShapeError(f"{path.name}: holds no triangles")
    return scale * np.array(surface.vertices, dtype=np.float64), np.array(surface.faces, dtype=np.int64)
