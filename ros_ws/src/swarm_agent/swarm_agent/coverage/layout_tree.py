"""Trees over places: which links hold a layout together, and where relays must stand where none do."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, dijkstra, minimum_spanning_tree
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from swarm_agent.coverage.expansion import ROOT, Layout
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.types import FloatArray, IntArray

ROUNDING = 1e-9  # relays and lattices put robots exactly one link apart
FAR = 1.6  # gaps up to this many link lengths are looked at first: between chains of a lattice there are no wider ones


def rooted(positions: FloatArray, reach: float, barriers: Barriers = OPEN_SPACE) -> Layout | None:
    """Return the places as a tree of fewest hops from the first, parents first; None if links do not join them.

    Parameters
    ----------
    positions : (n, 3) array
        The leader first [m].
    reach : float
        Longest link [m].
    barriers : Barriers, optional
        Obstacles that cut links.
    """
    links = _links(positions, reach, barriers)
    order, before = breadth_first_order(links, 0, directed=False, return_predecessors=True)
    if len(order) < len(positions):
        return None
    rank = np.empty(len(positions), dtype=np.int64)
    rank[order] = np.arange(len(order))
    parents = np.full(len(positions), ROOT, dtype=np.int64)
    parents[1:] = rank[before[order[1:]]]
    return Layout(positions[order], parents)


def short_edges(positions: FloatArray, power: float) -> tuple[IntArray, IntArray]:
    """Return the ends, (n - 1,) each, of the edges of a tree that reaches each place from the first over short edges.

    It is the tree of shortest paths by powers of lengths: a long edge costs more than a detour over two short ones, but
    not more than one along a chain of many, which a minimum spanning tree (an infinite power) would take, and robots
    would have to follow.
    """
    count = len(positions)
    costs = cdist(positions, positions, "sqeuclidean") ** (0.5 * power)
    # The sparse form of the full matrix: of a dense one, scipy first looks for what is no edge, which takes longer.
    starts, ends = np.arange(0, count * count + 1, count), np.tile(np.arange(count), count)
    graph = csr_array((costs.ravel(), ends, starts), shape=(count, count))
    before = dijkstra(graph, indices=0, return_predecessors=True)[1].astype(np.int64)
    heads = np.flatnonzero(before >= 0)
    return before[heads], heads


def with_relays(positions: FloatArray, reach: float) -> FloatArray:
    """Return the places and, where links of `reach` [m] do not join them, the fewest relays on straight gaps.

    Parameters
    ----------
    positions : (n, 3) array
        [m].
    reach : float
        Longest link [m].

    Returns
    -------
    (m, 3) array
        The places in their order, then the relays [m].
    """
    far = FAR * reach
    while True:
        pairs = cKDTree(positions).query_pairs(far, output_type="ndarray")
        lengths = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
        # A link costs next to nothing, so that gaps are bridged only where links leave no way.
        costs = np.maximum(np.ceil(lengths / reach * (1.0 - ROUNDING)) - 1.0, 0.0) + 1e-3 * lengths / far + 1e-6
        size = (len(positions), len(positions))
        graph = coo_array((costs, (pairs[:, 0], pairs[:, 1])), shape=size)
        if connected_components(graph, directed=False, return_labels=False) == 1:
            break
        far *= 2.0
    tree = minimum_spanning_tree(graph.tocsr()).tocoo()
    relays = []
    for first, second in zip(tree.row, tree.col, strict=True):
        gap = positions[second] - positions[first]
        count = int(np.ceil(np.linalg.norm(gap) / reach * (1.0 - ROUNDING))) - 1
        relays += [positions[first] + gap * step / (count + 1) for step in range(1, count + 1)]
    return np.concatenate([positions, np.array(relays).reshape(-1, 3)])


def _links(positions: FloatArray, reach: float, barriers: Barriers) -> csr_array:
    """Return the graph of all pairs within `reach` that see each other."""
    pairs = barriers.pairs_in_sight(positions, reach * (1.0 + ROUNDING))
    ones = np.ones(len(pairs))
    return csr_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(positions), len(positions)))
