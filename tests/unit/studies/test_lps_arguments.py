from __future__ import annotations

from pathlib import Path

import pytest

from studies.lps_arguments import parse_arguments
from studies.lps_cells import Design, Experiment, Motion, SweepKind, Trial
from swarm_agent.localization.config import LpsMode
from swarm_msgs_py.errors import ConfigError


def test_no_argument_is_the_whole_study() -> None:
    arguments = parse_arguments([])

    assert (arguments.design, arguments.trial, arguments.seeds) == (Design(), Trial(), range(1, 31))


def test_naming_values_of_a_sweep_asks_for_that_sweep() -> None:
    design = parse_arguments(["--shares", "0.1", "0.3"]).design

    assert (design.sweeps, design.shares) == ((SweepKind.SHARE,), (0.1, 0.3))


def test_options_narrow_the_study() -> None:
    words = "--experiment formation --modes cooperative literal --periods 0 3 --motion wander --seeds 2 --first-seed 5"
    arguments = parse_arguments([*words.split(), "--agents", "6", "--out", "here", "--workers", "1"])

    assert arguments.design.experiments == (Experiment.FORMATION,)
    assert arguments.design.modes == (LpsMode.LITERAL, LpsMode.COOPERATIVE)
    assert arguments.design.motion is Motion.WANDER
    assert arguments.seeds == range(5, 7)
    assert (arguments.trial.robots, arguments.out, arguments.workers) == (6, Path("here"), 1)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--modes cooperativ", "did you mean 'cooperative'"),
        ("--modes", "expected at least one argument"),
        ("--periods -1", "--periods"),
        ("--periods three", "expected a number from 0 to 600, got 'three'"),
        ("--shares 1.5", "expected a number from 0 to 1, got '1.5'"),
        ("--sigmas 0", "expected a number from 0.01"),
        ("--sigmas nan", "got 'nan'"),
        ("--seeds 0", "whole number from 1"),
        ("--experiment flight", "choose from: formation, mission, all"),
        ("--warm-up 180", "lower it or raise --duration"),
        ("--first-seed 4294967295", "seeds end at"),
        ("--seed 3", "did you mean '--seeds'"),
        ("--workers 0", "whole number from 1"),
    ],
)
def test_bad_input_is_one_line_that_names_the_option_and_the_remedy(words: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_arguments(words.split())

    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
