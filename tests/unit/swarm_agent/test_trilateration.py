"""Trilateration on scripted geometries: its three cases, its refusals, hard inputs, and the covariance it claims."""

from __future__ import annotations

import math

import numpy as np
import pytest

from swarm_agent.localization.trilateration import Case, Rejection, Trilateration, trilaterate

ROBOT = np.array([3.0, 4.0])
TRIANGLE = np.array([(-10.0, -5.0), (12.0, -4.0), (1.0, 14.0)])
SCATTER = np.array([(-10.0, -5.0), (12.0, -4.0), (1.0, 14.0), (-7.0, 9.0), (8.0, 8.0)])
LINE = np.array([(-9.0, 0.0), (2.0, 0.0), (5.0, 0.0), (11.0, 0.0)])
CERTAIN = 0.01 * np.eye(2)
NOBODY_KNOWS = np.diag([np.inf, np.inf])


def distances(beacons, point=ROBOT):
    return np.hypot(*(beacons - point).T)


def locate(beacons, ranges=None, propagated=ROBOT, covariance=CERTAIN, sigma=2.0):
    return trilaterate(beacons, distances(beacons) if ranges is None else ranges, propagated, covariance, sigma)


@pytest.mark.parametrize(
    ("beacons", "case"), [(TRIANGLE, Case.EXACT), (SCATTER, Case.OVERDETERMINED), (LINE, Case.COLLINEAR)]
)
@pytest.mark.parametrize("propagated", [ROBOT, np.array([6.0, 9.0]), np.array([-1.0, 2.0])])
def test_ranges_without_noise_give_the_position_in_every_case(beacons, case, propagated):
    fix = locate(beacons, propagated=propagated)
    assert isinstance(fix, Trilateration)
    assert fix.case is case
    assert fix.position == pytest.approx(ROBOT, abs=1e-9)


@pytest.mark.parametrize("propagated", [(500.0, -800.0), (np.inf, 0.0), (np.nan, np.nan)])
@pytest.mark.parametrize("covariance", [NOBODY_KNOWS, 1e6 * np.eye(2), np.full((2, 2), np.nan)])
def test_beacons_that_span_the_plane_need_no_belief(propagated, covariance):
    for beacons in (TRIANGLE, SCATTER):
        fix = locate(beacons, propagated=np.array(propagated), covariance=covariance)
        assert isinstance(fix, Trilateration)
        assert fix.position == pytest.approx(ROBOT, abs=1e-9)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_two_beacons_are_too_few(count):
    assert locate(TRIANGLE[:count]) is Rejection.TOO_FEW


def test_beacons_on_a_line_keep_the_side_of_the_propagated_position():
    below = locate(LINE, propagated=ROBOT * (1.0, -1.0))
    assert isinstance(below, Trilateration)
    assert below.position == pytest.approx(ROBOT * (1.0, -1.0), abs=1e-9)


@pytest.mark.parametrize("height", [0.05, 0.5, 1.0])
def test_a_start_near_the_line_still_ends_on_its_side(height):
    fix = locate(LINE, propagated=np.array([2.5, -height]), covariance=1e-6 * np.eye(2))
    assert isinstance(fix, Trilateration)
    assert fix.position == pytest.approx(ROBOT * (1.0, -1.0), abs=1e-9)


@pytest.mark.parametrize(("sigma", "is_clear"), [(4.0 / 3.0 - 0.01, True), (4.0 / 3.0 + 0.01, False)])
def test_a_belief_whose_3_sigma_ellipse_reaches_the_line_cannot_choose_a_side(sigma, is_clear):
    # Only the spread across the line counts, not the one along it.
    fix = locate(LINE, covariance=np.diag([100.0, sigma**2]))
    assert isinstance(fix, Trilateration) == is_clear
    assert is_clear or fix is Rejection.MIRROR


@pytest.mark.parametrize("covariance", [NOBODY_KNOWS, np.full((2, 2), np.nan)])
def test_who_knows_nothing_cannot_choose_a_side(covariance):
    assert locate(LINE, covariance=covariance) is Rejection.MIRROR


def test_a_slanted_ellipse_is_measured_across_the_line():
    # 3 sigma across the diagonal line is 3 * sqrt(0.5); the robot is 4 / sqrt(2) from it.
    diagonal = np.array([(-9.0, -9.0), (0.0, 0.0), (5.0, 5.0)])
    robot, across = np.array([4.0, 0.0]), np.array([[1.0, -1.0], [-1.0, 1.0]])
    ranges = distances(diagonal, robot)
    assert isinstance(locate(diagonal, ranges, robot, 0.25 * across), Trilateration)
    assert locate(diagonal, ranges, robot, 0.5 * across) is Rejection.MIRROR
    assert isinstance(locate(diagonal, ranges, robot, 0.5 * np.abs(across)), Trilateration)


@pytest.mark.parametrize("copies", [3, 5])
def test_beacons_in_one_spot_determine_nothing(copies):
    for spot in ((1.0, 1.0), (1e3 + 0.1, -2e3 / 3.0)):
        beacons = np.tile(spot, (copies, 1))
        assert locate(beacons) is Rejection.SINGULAR


def test_twins_among_the_beacons_leave_two_places_like_a_line():
    beacons = np.array([(-9.0, 0.0), (11.0, 0.0), (11.0, 0.0)])
    fix = locate(beacons)
    assert isinstance(fix, Trilateration)
    assert fix.case is Case.COLLINEAR
    assert fix.position == pytest.approx(ROBOT, abs=1e-9)


@pytest.mark.parametrize("beacons", [TRIANGLE, SCATTER])
def test_a_robot_on_a_beacon_is_found(beacons):
    fix = locate(beacons, distances(beacons, beacons[1]), beacons[1])
    assert isinstance(fix, Trilateration)
    assert fix.position == pytest.approx(beacons[1], abs=1e-6)


def test_a_range_of_zero_is_a_range_like_any_other():
    ranges = distances(SCATTER, SCATTER[2] + (0.5, 0.5))
    ranges[2] = 0.0
    fix = locate(SCATTER, ranges, SCATTER[2])
    assert isinstance(fix, Trilateration)
    assert fix.position == pytest.approx(SCATTER[2], abs=1.0)


def test_all_ranges_zero_give_an_answer_among_the_beacons_or_none():
    fix = locate(SCATTER, np.zeros(5))
    assert fix is Rejection.SINGULAR or np.all(np.abs(fix.position) < 15.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200, 1e308])
@pytest.mark.parametrize("beacons", [TRIANGLE, SCATTER, LINE])
def test_one_absurd_range_is_refused(beacons, value):
    ranges = distances(beacons)
    ranges[1] = value
    assert locate(beacons, ranges) is Rejection.SINGULAR


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e100, 1e120, 1e155, 1e200, -1e308])
def test_an_absurd_beacon_is_refused_or_gives_itself_away(value):
    for beacons in (TRIANGLE, SCATTER, LINE):
        moved = beacons.copy()
        moved[0, 1] = value
        found = trilaterate(moved, distances(beacons), ROBOT, CERTAIN, 2.0)
        # Its squared residual is finite up to 1e154, and tells.
        assert isinstance(found, Rejection) or found.squared_residual > 1e100


def test_far_from_the_origin_it_is_as_exact_as_the_numbers_are():
    offset = np.array([4.5e5, 5.2e6])  # a survey grid
    fix = locate(SCATTER + offset, distances(SCATTER), ROBOT + offset)
    assert isinstance(fix, Trilateration)
    assert fix.position == pytest.approx(ROBOT + offset, abs=1e-8)


@pytest.mark.parametrize("wild", [60.0, 300.0, 5000.0])
def test_one_wild_range_never_makes_the_fit_worse_than_at_the_propagated_position(wild):
    for seed in range(20):
        beacons = np.random.default_rng(seed).uniform(-12.0, 12.0, (6, 2))
        ranges = distances(beacons)
        ranges[seed % 6] = wild
        fix = locate(beacons, ranges)
        if isinstance(fix, Trilateration):
            assert np.sum((distances(beacons, fix.position) - ranges) ** 2) <= np.sum(
                (distances(beacons) - ranges) ** 2
            )
            assert np.hypot(*(fix.position - ROBOT)) <= 50.0  # five steps


def test_contradictory_ranges_to_beacons_on_a_line_have_no_answer():
    # Both circles are far too small to meet; what fits best lies on the line, where the height is undetermined.
    beacons = np.array([(-20.0, 0.0), (20.0, 0.0), (20.0, 0.0)])
    assert locate(beacons, np.array([2.0, 2.0, 2.0])) is Rejection.SINGULAR


def test_an_ellipse_of_uncertainty_along_which_the_circles_bend_is_no_fix_but_exact_ranges_are():
    huddle = np.array([(20.0, 0.5), (20.5, 0.0), (20.0, -0.5), (20.2, 0.1)])
    assert locate(huddle, distances(huddle, np.zeros(2)), np.zeros(2), sigma=2.0) is Rejection.SINGULAR
    fix = locate(huddle, distances(huddle, np.zeros(2)), np.zeros(2), sigma=0.001)
    assert isinstance(fix, Trilateration)
    assert fix.position == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(("thickness", "case"), [(0.11, Case.OVERDETERMINED), (0.09, Case.COLLINEAR)])
@pytest.mark.parametrize("first", range(4))
def test_a_cloud_a_tenth_as_thick_as_it_is_long_counts_as_a_line_whichever_beacon_comes_first(thickness, case, first):
    corners = np.array([(-10.0, -1.0), (10.0, -1.0), (10.0, 1.0), (-10.0, 1.0)]) * (1.0, 10.0 * thickness)
    fix = locate(np.roll(corners, first, axis=0), propagated=ROBOT + 0.1)
    assert isinstance(fix, Trilateration)
    assert fix.case is case
    assert fix.position == pytest.approx(ROBOT, abs=1e-9)


@pytest.mark.parametrize(("height", "is_found"), [(0.1, True), (1e-4, False)])
def test_even_exact_ranges_do_not_fix_a_robot_that_is_all_but_on_the_line_of_the_beacons(height, is_found):
    robot = np.array([3.0, height])
    fix = locate(LINE, distances(LINE, robot), robot, 1e-12 * np.eye(2), sigma=0.0)
    assert isinstance(fix, Trilateration) == is_found
    assert is_found or fix is Rejection.SINGULAR


def test_next_to_a_near_line_noise_never_carries_the_answer_across():
    rng = np.random.default_rng(17)
    beacons, robot = np.array([(-12.0, 0.4), (-4.0, -0.9), (3.0, 1.0), (12.0, -0.5)]), np.array([2.0, 2.5])
    heights = []
    for _ in range(2000):
        ranges = distances(beacons, robot) + rng.normal(0.0, 2.0, 4)
        fix = locate(beacons, ranges, robot + rng.normal(0.0, 0.3, 2), 0.09 * np.eye(2))
        if isinstance(fix, Trilateration):
            assert fix.case is Case.COLLINEAR
            heights.append(fix.position[1] + 0.05)  # the line slopes a little
    assert len(heights) > 1000
    assert min(heights) > 0.0


def test_beside_a_line_an_answer_is_a_minimum_of_the_cost_even_if_a_range_is_wild():
    rng, answers = np.random.default_rng(18), 0
    for _ in range(1500):
        ranges = distances(LINE) + rng.normal(0.0, 2.0, 4)
        ranges[rng.integers(4)] = rng.uniform(0.0, 100.0)
        fix = locate(LINE, ranges)
        if isinstance(fix, Trilateration):
            answers += 1
            offsets = fix.position - LINE
            lengths = np.hypot(*offsets.T)
            gradient = (offsets / lengths[:, None]).T @ (lengths - ranges)
            assert np.hypot(*gradient) < 1e-4
    assert answers > 200


def test_the_answer_is_never_worse_than_the_linear_solution_that_it_starts_from():
    rng, answers = np.random.default_rng(19), 0
    for _ in range(1500):
        beacons = rng.uniform(-15.0, 15.0, (4, 2))
        ranges = np.maximum(distances(beacons) + rng.normal(0.0, 3.0, 4), 0.0)
        fix = locate(beacons, ranges, covariance=NOBODY_KNOWS, sigma=0.1)
        if isinstance(fix, Trilateration):
            answers += 1
            spokes = beacons - beacons.mean(axis=0)
            squares = 0.5 * ((spokes**2).sum(axis=1) - ranges**2)
            linear = beacons.mean(axis=0) + np.linalg.lstsq(spokes, squares - squares.mean())[0]
            assert fix.squared_residual <= np.sum((distances(beacons, linear) - ranges) ** 2) + 1e-9
    assert answers > 1000


def test_a_thin_cloud_of_beacons_does_not_draw_the_robot_to_its_mirror_image():
    # Just thick enough for the linear solution, which noise sends to either side of the cloud.
    rng = np.random.default_rng(3)
    beacons = np.array([(-12.0, 0.8), (-4.0, -1.5), (3.0, 1.6), (12.0, -0.9)])
    robot = np.array([1.0, 9.0])
    fixes = [
        locate(beacons, distances(beacons, robot) + rng.normal(0.0, 2.0, 4), robot + rng.normal(0.0, 0.5, 2), np.eye(2))
        for _ in range(300)
    ]
    found = [fix for fix in fixes if isinstance(fix, Trilateration)]
    assert {fix.case for fix in found} == {Case.OVERDETERMINED}
    assert len(found) > 280
    assert sum(fix.position[1] < 0.0 for fix in found) == 0


def test_the_belief_chooses_but_does_not_pull():
    rng = np.random.default_rng(5)
    ranges = distances(SCATTER) + rng.normal(0.0, 1.0, 5)
    one, other = locate(SCATTER, ranges, np.array([4.0, 4.0]), CERTAIN), locate(SCATTER, ranges, ROBOT, NOBODY_KNOWS)
    assert isinstance(one, Trilateration)
    assert isinstance(other, Trilateration)
    assert one.position == pytest.approx(other.position, abs=1e-3)


@pytest.mark.parametrize("beacons", [TRIANGLE, SCATTER, LINE])
def test_the_covariance_is_that_of_monte_carlo(beacons):
    rng, sigma, runs = np.random.default_rng(11), 0.2, 3000
    clean = locate(beacons, sigma=sigma)
    assert isinstance(clean, Trilateration)
    fixes = [
        locate(beacons, distances(beacons) + rng.normal(0.0, sigma, len(beacons)), sigma=sigma) for _ in range(runs)
    ]
    found = np.array([fix.position for fix in fixes if isinstance(fix, Trilateration)])
    assert len(found) == runs
    # In units of the claimed standard deviations, the sample covariance is the identity.
    whitened = np.linalg.solve(np.linalg.cholesky(clean.covariance), (found - ROBOT).T)
    assert np.cov(whitened) == pytest.approx(np.eye(2), abs=6.0 / math.sqrt(runs))


def test_the_errors_are_consistent_with_the_claimed_covariances_at_the_noise_of_the_thesis():
    rng, sigma, squares = np.random.default_rng(12), 2.0, []
    for _ in range(1500):
        robot, beacons = rng.uniform(-10.0, 10.0, 2), rng.uniform(-15.0, 15.0, (8, 2))
        ranges = np.maximum(distances(beacons, robot) + rng.normal(0.0, sigma, 8), 0.0)
        fix = locate(beacons, ranges, robot + rng.normal(0.0, 1.0, 2), np.eye(2), sigma)
        if isinstance(fix, Trilateration):
            error = fix.position - robot
            squares.append(error @ np.linalg.solve(fix.covariance, error))
    assert len(squares) > 1480
    assert np.mean(squares) == pytest.approx(2.0, rel=0.1)
    assert np.mean(np.array(squares) > 13.8) < 0.01


def test_the_squared_residual_is_chi_square_and_gives_a_lying_beacon_away():
    rng, sigma = np.random.default_rng(13), 0.5
    ranges = [distances(SCATTER) + rng.normal(0.0, sigma, 5) for _ in range(1000)]
    honest = [
        fix.squared_residual / sigma**2
        for r in ranges
        if isinstance(fix := locate(SCATTER, r, sigma=sigma), Trilateration)
    ]
    lied = locate(SCATTER, ranges[0] + np.array([0.0, 15.0, 0.0, 0.0, 0.0]), sigma=sigma)
    assert len(honest) == 1000
    assert np.mean(honest) == pytest.approx(3.0, rel=0.1)
    assert np.var(honest) == pytest.approx(6.0, rel=0.25)
    assert isinstance(lied, Trilateration)
    assert lied.squared_residual / sigma**2 > 100.0


def test_it_changes_none_of_its_inputs():
    beacons, ranges, propagated, covariance = SCATTER.copy(), distances(SCATTER), ROBOT.copy(), CERTAIN.copy()
    for array in (beacons, ranges, propagated, covariance):
        array.flags.writeable = False
    assert isinstance(trilaterate(beacons, ranges, propagated, covariance, 2.0), Trilateration)
