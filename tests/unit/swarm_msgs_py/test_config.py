"""The strict loader: what is not exactly as declared is refused, in one line that helps."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import pytest

from swarm_msgs_py.config import Config, dotted_keys, dump_config, full_key, load_config, section, setting, with_setting
from swarm_msgs_py.errors import ConfigError


class Color(Enum):
    RED = "red"
    GREEN = "green"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel(Config):
    radius_m: float = setting(0.1, "radius", unit="m", above=0.0)
    spokes: int = setting(5, "number of spokes", minimum=0, maximum=100)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cart(Config):
    name: str = setting(help="what to call it")
    color: Color = setting(Color.RED, "paint")
    front: Wheel = section(Wheel, "front wheel")
    rear: Wheel = section(Wheel, "rear wheel")
    place_m: tuple[float, float] = setting((0.0, 0.0), "where it stands", unit="m")
    loads_kg: tuple[float, ...] = setting((), "what it carries", unit="kg", minimum=0.0)
    spare: Wheel | None = setting(None, "spare wheel")
    is_open: bool = setting(True, "has no roof")


FULL = {
    "name": "c",
    "color": "green",
    "front": {"radius_m": 0.2, "spokes": 3},
    "rear": {"radius_m": 1, "spokes": 0},
    "place_m": [1, 2.5],
    "loads_kg": [3, 4],
    "spare": {"spokes": 1},
    "is_open": False,
}


def test_loads_what_is_declared() -> None:
    cart = load_config(Cart, FULL)

    assert cart.color is Color.GREEN
    assert cart.rear == Wheel(radius_m=1.0, spokes=0)
    assert cart.place_m == (1.0, 2.5)
    assert cart.spare == Wheel(spokes=1)


def test_dumped_data_loads_to_an_equal_configuration() -> None:
    cart = load_config(Cart, FULL)

    assert load_config(Cart, dump_config(cart)) == cart


BAD: dict[str, tuple[object, str]] = {  # what is wrong: the data, the error
    "unknown key": ({"nam": "c"}, r"cart.yaml: nam: unknown key; did you mean 'name'\?"),
    "unknown key, nothing near": ({"qqq": 1, "name": "c"}, "cart.yaml: qqq: unknown key; choose from: .*name"),
    "missing key": ({}, "cart.yaml: name: missing; add it"),
    "unknown nested key": (
        {"name": "c", "rear": {"radius": 1}},
        r"rear.radius: unknown key; .*'radius_m'\?",
    ),
    "text for number": (
        {"name": "c", "rear": {"radius_m": "big"}},
        "rear.radius_m: expected a number, got 'big'",
    ),
    "true for number": ({"name": "c", "rear": {"spokes": True}}, "rear.spokes: expected a whole number, got true"),
    "fraction for whole": ({"name": "c", "rear": {"spokes": 1.5}}, "rear.spokes: expected a whole number, got 1.5"),
    "number for text": ({"name": 3}, "cart.yaml: name: expected text, got 3"),
    "one for true": ({"name": "c", "is_open": 1}, "is_open: expected true or false, got 1"),
    "too small": ({"name": "c", "rear": {"radius_m": 0}}, "rear.radius_m: must be > 0 m, got 0"),
    "too large": ({"name": "c", "rear": {"spokes": 101}}, "rear.spokes: must be >= 0 and <= 100, got 101"),
    "not a number": ({"name": "c", "rear": {"radius_m": float("nan")}}, "rear.radius_m: must be > 0 m, got nan"),
    "infinite": ({"name": "c", "place_m": [0, float("inf")]}, r"place_m\[1\]: must be a finite number, got inf"),
    "list too short": ({"name": "c", "place_m": [1]}, "place_m: expected 2 values, got 1"),
    "number for list": ({"name": "c", "place_m": 1}, "place_m: expected a list, got 1"),
    "item out of range": ({"name": "c", "loads_kg": [1, -2]}, r"loads_kg\[1\]: must be >= 0 kg, got -2"),
    "unknown choice": ({"name": "c", "color": "gren"}, r"color: got 'gren'; did you mean 'green'\?"),
    "number for section": ({"name": "c", "rear": 3}, "cart.yaml: rear: expected keys and values, got 3"),
    "nothing for number": (
        {"name": "c", "rear": {"spokes": None}},
        "rear.spokes: expected a whole number",
    ),
    "list for all": ([1], "cart.yaml: expected keys and values, got a list"),
}


@pytest.mark.parametrize(("data", "text"), BAD.values(), ids=BAD.keys())
def test_refuses_in_one_line_with_file_key_and_remedy(data: object, text: str) -> None:
    with pytest.raises(ConfigError, match=text) as caught:
        load_config(Cart, data, "cart.yaml")

    assert "\n" not in str(caught.value)


def test_python_code_meets_the_same_limits() -> None:
    with pytest.raises(ConfigError, match="radius_m must be > 0 m, got -1"):
        Wheel(radius_m=-1.0)


def test_keys_can_be_shortened_to_an_unambiguous_ending() -> None:
    assert full_key(Cart, "front.spokes", "--set") == "front.spokes"
    assert full_key(Cart, "is_open", "--set") == "is_open"
    with pytest.raises(ConfigError, match=r"could be front\.spokes or rear\.spokes"):
        full_key(Cart, "spokes", "--set")
    with pytest.raises(ConfigError, match="did you mean 'is_open'"):
        full_key(Cart, "is_opn", "--set")


def test_every_leaf_has_a_key_and_a_meaning() -> None:
    leaves = dotted_keys(Cart)

    assert leaves["rear.radius_m"][1].unit == "m"
    assert all(about.help for _, about in leaves.values())


def test_sets_one_key_in_nested_data() -> None:
    data = {"rear": {"spokes": 1}}

    with_setting(data, "rear.radius_m", 0.3, "--set")
    with_setting(data, "front.spokes", 2, "--set")

    assert data == {"rear": {"spokes": 1, "radius_m": 0.3}, "front": {"spokes": 2}}


def test_a_single_value_is_no_section() -> None:
    with pytest.raises(ConfigError, match=r"'name' in 'name\.x' is a single value"):
        with_setting({"name": "c"}, "name.x", 1, "--set")
