from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.planning.configuration_space import ConfigurationSpace, disc_polygon
from swarm_agent.planning.visibility_graph import VisibilityGraph

SQUARE = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
DISC = disc_polygon(0.6, 16)


def graph_of(*obstacles: np.ndarray) -> VisibilityGraph:
    return VisibilityGraph(ConfigurationSpace(obstacles, DISC))


def test_around_one_convex_obstacle_each_corner_sees_its_two_neighbors():
    graph = graph_of(SQUARE)
    degrees = np.diff(graph.edges().tocsr().indptr)
    assert len(graph.nodes) == 16
    assert degrees.tolist() == [2] * 16


def test_two_convex_obstacles_share_four_tangents():
    graph = graph_of(SQUARE, SQUARE + np.array((10.0, 3.0)))
    edges = graph.edges().tocoo()
    between = (graph.nodes[edges.row, 0] < 7.0) & (graph.nodes[edges.col, 0] > 7.0)
    assert np.count_nonzero(between) == 4


def test_an_obstacle_between_two_others_hides_the_inner_tangents():
    tall = np.array([(6.9, -30.0), (7.1, -30.0), (7.1, 30.0), (6.9, 30.0)])
    graph = graph_of(SQUARE, SQUARE + np.array((10.0, 3.0)), tall)
    edges = graph.edges().tocoo()
    between = (graph.nodes[edges.row, 0] < 5.0) & (graph.nodes[edges.col, 0] > 9.0)
    assert np.count_nonzero(between) == 0


def test_edges_are_symmetric_and_as_long_as_their_ends_are_apart():
    graph = graph_of(SQUARE, SQUARE + np.array((10.0, 3.0)))
    edges = graph.edges().toarray()
    assert np.array_equal(edges, edges.T)
    one, two = np.nonzero(edges)
    assert edges[one, two] == pytest.approx(np.linalg.norm(graph.nodes[one] - graph.nodes[two], axis=1))


def test_a_notch_is_no_node():
    ell = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (2.0, 2.0), (2.0, 9.0), (0.0, 9.0)])
    assert not (np.linalg.norm(graph_of(ell).nodes - (2.6, 2.6), axis=1) < 0.01).any()


def test_a_point_sees_one_corner_on_each_side_of_a_lone_obstacle():
    graph = graph_of(SQUARE)
    seen = graph.nodes[graph.visible_nodes(np.array([-5.0, 2.0]))]
    assert len(seen) == 2
    assert sorted(np.sign(seen[:, 1] - 2.0)) == [-1.0, 1.0]


def test_the_corners_of_a_hole_are_no_nodes_but_those_outside_are():
    walls = [np.array([(-5.0, y), (5.0, y), (5.0, y + 1.0), (-5.0, y + 1.0)]) for y in (-5.0, 4.0)]
    walls += [wall[:, ::-1] for wall in walls]
    graph = graph_of(*walls)
    assert np.abs(graph.nodes).max(axis=1).min() > 5.0


def test_without_obstacles_the_graph_is_empty():
    graph = graph_of()
    assert graph.nodes.shape == (0, 2)
    assert graph.edges().shape == (0, 0)
    assert len(graph.visible_nodes(np.zeros(2))) == 0
