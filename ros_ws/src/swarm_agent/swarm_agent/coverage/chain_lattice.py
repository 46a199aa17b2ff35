"""Layouts for many robots: chains of linked robots, side by side so that their balls fill space.

A body-centered cubic lattice covers space with the fewest balls, but its neighbors are 1.55 radii apart, and links are
as short as one radius. So the lattice is compressed along one axis until the robots
of a line are linked, and stretched across it as far as the balls allow: body-centered tetragonal. Per robot it covers
1.97 r^3 of the 2.86 r^3 that are possible without links; one relay then joins each line to the next.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from swarm_agent.coverage.layout_tree import with_relays
from swarm_msgs_py.types import FloatArray, IntArray

SAME = 1e-6  # a site this near the leader, in radii, is the one that the lattice hangs on


def chain_lattice(cloud: FloatArray, leader: FloatArray, radius: float, reach: float) -> FloatArray:
    """Return the layout of chains that needs fewest robots, of one along each axis.

    Parameters
    ----------
    cloud : (m, 3) array
        Points of the shape to be covered, dense enough to leave no ball of the lattice without one [m].
    leader : (3,) array
        First place of the layout [m].
    radius, reach : float
        Range of covering, longest link [m].

    Returns
    -------
    (n, 3) array
        Linked, the leader first [m].
    """
    layouts = []
    for axis in range(3):
        sites = _needed(_lattice(cloud, leader, axis, radius, reach), cloud, radius)
        apart = np.linalg.norm(sites - leader, axis=1) > SAME * radius
        layouts.append(with_relays(np.concatenate([leader[None], sites[apart]]), reach))
    return min(layouts, key=len)


def _lattice(cloud: FloatArray, leader: FloatArray, axis: int, radius: float, reach: float) -> FloatArray:
    """Return the lattice around the leader as far as the cloud goes, (n, 3) [m]."""
    along = reach
    # The point between two sites of a line and two of the next is `x` away from the first line: it must be covered.
    x = np.sqrt(radius**2 - 0.25 * along**2)
    across = x + np.sqrt(x**2 + 0.5 * along**2)
    spacing = np.full(3, across)
    spacing[axis] = along
    lower = np.floor((cloud.min(axis=0) - radius - leader) / spacing).astype(int)
    upper = np.ceil((cloud.max(axis=0) + radius - leader) / spacing).astype(int)
    axes = [np.arange(a, b + 1, dtype=np.float64) for a, b in zip(lower, upper, strict=True)]
    corners = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    sites: FloatArray = leader + np.concatenate([corners, corners + 0.5]) * spacing
    return sites


def _needed(sites: FloatArray, cloud: FloatArray, radius: float) -> FloatArray:
    """Return the sites that the cloud needs, those that cover most of it first asked (greedy set cover)."""
    sites = sites[np.unique(cKDTree(sites).query(cloud)[1])]  # its nearest sites cover each point
    tree = cKDTree(cloud)
    covers = [np.array(points, dtype=np.int64) for points in tree.query_ball_point(sites, radius)]
    times = np.zeros(len(cloud), dtype=np.int64)
    for points in covers:
        times[points] += 1
    keep = np.ones(len(sites), dtype=np.bool_)
    for site in _by_size(covers):
        if (times[covers[site]] > 1).all():
            keep[site] = False
            times[covers[site]] -= 1
    return sites[keep]


def _by_size(covers: list[IntArray]) -> list[int]:
    return sorted(range(len(covers)), key=lambda site: (len(covers[site]), site))
