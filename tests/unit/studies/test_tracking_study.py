"""The tracking study: its curves, its trials, the rule of Ziegler and Nichols, and the command."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from studies.boat_tuning import ziegler_nichols
from studies.tracking_cli import main
from studies.tracking_curves import SPEED_MPS, Curve, CurveKind
from studies.tracking_trial import drive, scaled_hull, scores_of
from swarm_sim.boats.config import BoatsConfig, ControllerKind
from swarm_sim.boats.firmware import make_controller


def test_curves_have_the_extents_of_the_paper_and_constant_speed() -> None:
    circle, eight = Curve(CurveKind.CIRCLE), Curve(CurveKind.EIGHT)
    points = eight.points(np.linspace(0.0, eight.length_m, 4000))

    assert circle.length_m == pytest.approx(2.0 * np.pi * 1.2, rel=1e-4)
    assert np.abs(points).max(axis=0) == pytest.approx([2.0, np.sqrt(2.0)], rel=1e-3)
    for curve in (circle, eight):
        rows = curve.references(np.linspace(0.0, 60.0, 300))
        assert np.hypot(*rows[:, 2:4].T) == pytest.approx(SPEED_MPS, rel=2e-3)
    assert np.hypot(*circle.references(np.array([3.0]))[0, 4:]) == pytest.approx(SPEED_MPS**2 / 1.2, rel=0.02)


def test_ziegler_and_nichols_gain_is_six_tenths_of_what_makes_the_loop_oscillate() -> None:
    mass, drag, lag, step = 3.1, 2.0, 0.1, 0.01
    p, *_ = ziegler_nichols(mass, drag, lag, step)
    flow = np.zeros((4, 4))
    flow[0, 1], flow[1, 1], flow[1, 2], flow[2, 2], flow[2, 3] = 1.0, -drag / mass, 1.0, -1.0 / lag, 1.0 / lag
    sampled = expm(flow * step)

    def radius(gain: float) -> float:
        loop = sampled[:3, :3] - np.outer(sampled[:3, 3], [gain, 0.0, 0.0])
        return float(np.abs(np.linalg.eigvals(loop)).max())

    assert radius(p / 0.6 * 0.99) < 1.0 < radius(p / 0.6 * 1.01)


def test_ladrc_stays_closer_to_the_circle_and_gets_there_sooner_than_the_papers_baseline() -> None:
    config, scores = BoatsConfig(), {}
    for kind in (ControllerKind.LADRC, ControllerKind.PID_ZN):
        track = drive(config, CurveKind.CIRCLE, [1, 2], lambda p, s, kind=kind: make_controller(kind, p, s))
        assert np.abs(track.thrusts).max() <= config.thrusters.force_max_n + 1e-12
        scores[kind] = scores_of(track)

    own, baseline = scores[ControllerKind.LADRC], scores[ControllerKind.PID_ZN]
    assert own.position_m.mean() < 0.62 * baseline.position_m.mean()
    assert own.heading_rad.mean() < 0.75 * baseline.heading_rad.mean()
    assert own.convergence_s.mean() < 0.82 * baseline.convergence_s.mean()
    assert own.position_m.max() < 0.03


def test_a_boat_that_is_heavier_than_its_gains_expect_is_still_held_on_the_curve() -> None:
    config = BoatsConfig()
    errors = [
        scores_of(
            drive(config, CurveKind.CIRCLE, [1], lambda p, s: make_controller(ControllerKind.LADRC, p, s), hull)
        ).position_all_m[0]
        for hull in (config.hull, scaled_hull(config.hull, 1.5))
    ]

    assert errors[0] < errors[1] < 0.05


def test_the_command_leaves_tables_and_a_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--seeds", "1", "--controllers", "ladrc", "--curves", "circle", "--body", "1.2", "--weather", "2"]
    code = main([*words, "--out", str(tmp_path / "t")])

    assert code == 0
    assert "Body times 1.2, weather times 2." in (tmp_path / "t" / "table.md").read_text()
    assert "circle" in capsys.readouterr().out
    assert (tmp_path / "t" / "tracking-study.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "t" / "table.csv").read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--controllers", "lqr"], "'lqr'"),
        (["--seeds", "0"], "from 1 to 1000"),
        (["--body", "0"], "from 0.1 to 10"),
        (["--x"], "--x"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    printed = capsys.readouterr().err.strip()
    assert expected in printed
    assert "\n" not in printed
