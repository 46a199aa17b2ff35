from __future__ import annotations

import pytest

from swarm_msgs_py.config import dotted_keys, dump_config, load_config
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.networking.config import NetworkConfig


def test_defaults_are_those_of_the_specification() -> None:
    """Section 5.3, rule 2."""
    config = NetworkConfig()

    assert (config.full_dump_period_s, config.missed_adverts, config.stale_time_s) == (3.0, 3, 6.0)


def test_plain_form_loads_back() -> None:
    config = NetworkConfig(hop_limit=12)

    assert load_config(NetworkConfig, dump_config(config)) == config


def test_every_setting_says_what_it_does() -> None:
    assert all(about.help for _, about in dotted_keys(NetworkConfig).values())


@pytest.mark.parametrize("key", ["full_dump_period_s", "hop_limit", "queue_packets", "attempts"])
def test_zero_is_refused_where_it_means_nothing(key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        load_config(NetworkConfig, {key: 0})
