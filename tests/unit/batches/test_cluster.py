from __future__ import annotations

import sys

import pytest

from batches.cluster import Cluster
from swarm_msgs_py.errors import ConfigError


def test_without_the_library_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)

    with pytest.raises(ConfigError, match=r"--scheduler: .*pip install dask distributed"):
        Cluster("tcp://127.0.0.1:1")


def test_an_address_that_is_none_is_refused() -> None:
    with pytest.raises(ConfigError, match="no Dask scheduler answers there"):
        Cluster("nonsense://127.0.0.1:1")
