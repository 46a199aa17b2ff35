from __future__ import annotations

from pathlib import Path

import pytest

from batches.arguments import parse_arguments
from swarm_msgs_py.errors import ConfigError


def test_a_count_of_seeds_begins_at_one() -> None:
    assert parse_arguments(["--seeds", "3"]).design.seeds == range(1, 4)


def test_a_range_of_seeds_has_both_ends() -> None:
    assert list(parse_arguments(["--seeds", "201:203"]).design.seeds) == [201, 202, 203]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--seeds", "0"], "--seeds: expected 1 to"),
        (["--seeds", "5:4"], "--seeds: expected 1 to"),
        (["--seeds", "1:2:3"], "expected a count N or a range A:B"),
        (["--seeds", "4294967296:4294967297"], "of at most 4294967295"),
        (["--objective", "totl"], "did you mean 'total'"),
        (["--physics", "bulet"], "did you mean 'bullet'"),
        (["--workers", "0"], "--workers: expected a whole number"),
        (["--method", "bubbles"], "bubble-packing"),
        (["--shape", ""], "--shape: expected a name"),
        (["--set", "radio.loss"], "expected key=value"),
        (["--set", "no_such_key=1"], "no_such_key"),
        (["--seed", "1"], "did you mean '--seeds'"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(words: list[str], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_arguments(words)

    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_physics_is_the_fast_model_unless_it_is_named() -> None:
    by_default, named = parse_arguments([]), parse_arguments(["--physics", "bullet"])

    assert [override.value for override in by_default.design.overrides] == ["massdamper"]
    assert [override.value for override in named.design.overrides] == ["bullet"]


def test_settings_come_last_being_the_most_particular() -> None:
    given = parse_arguments(["--set", "sim.physics.backend=bullet", "--agents", "7", "--out", "there"])

    assert [override.value for override in given.design.overrides] == ["massdamper", 7, "bullet"]
    assert given.out == Path("there")
