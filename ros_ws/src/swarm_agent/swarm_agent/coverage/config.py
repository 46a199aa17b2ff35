"""Settings of the coverage family."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting


class Samples(Enum):
    """Which points of a sense sphere stand for it."""

    FIBONACCI = "fibonacci"  # nearly uniform, any number
    GRID = "grid"  # the rotations of eqs. (2)-(4): 182 distinct points, crowded toward the poles


class Rule(Enum):
    """Which frontier point becomes the target of the next robot."""

    RANDOM = "random"  # paper: any
    FIRST = "first"  # the first in the order of samples
    GAIN = "gain"  # the one whose ball deletes most frontier points
    LAYOUT = "layout"  # the one that the leader's layout asks for


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutConfig(Config):
    """Search for places that cover the shape with few linked robots."""

    covered_fraction: float = setting(
        0.9998, "share of the shape that a layout must cover, by points drawn from it", minimum=0.5, maximum=1.0
    )
    refined_max: int = setting(
        48, "layouts of more robots than this are a lattice, without refinement", minimum=0, maximum=200
    )
    interior_points: int = setting(2000, "points inside the shape that the search looks at", minimum=100)
    surface_points: int = setting(2000, "points on its surface, where gaps are found first", minimum=100)
    judged_points: int = setting(20_000, "fresh points by which a result is accepted", minimum=1000)
    kicks: int = setting(3, "restarts from a shaken layout before a number of robots is given up", minimum=0)
    kick_share: float = setting(0.08, "how far a kick shakes each place, of the covering range", minimum=0.0)
    spare: float = setting(
        0.01, "share of the covering range that is held back, so that small errors of placement open no hole",
        minimum=0.0, maximum=0.2,
    )  # fmt: skip


class Expansion(Enum):
    """How many robots are under way at once."""

    SERIAL = "serial"  # one at a time (Algorithm 1)
    PARALLEL = "parallel"  # one to each place next to a robot that holds its own
    PREDICTED = "predicted"  # one to each place, also next to those whose robots are still on their way


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionConfig(Config):
    """How a robot moves, and when it has come."""

    speed_mps: float = setting(5.0, "S_i, speed limit (Table 1)", unit="m/s", above=0.0)
    approach_mps: float = setting(1.0, "of a leader that looks for the shape", unit="m/s", above=0.0)
    sigma_m: float = setting(
        1.0, "process noise per step and axis that the robot counts on (eq. (10))", unit="m", minimum=0.0
    )
    drifts: bool = setting(False, "whether the robot counts on that noise at rest as well")
    arrival_sigmas: float = setting(2.0, "a robot has come when it is this many sigma from its place", above=0.0)
    arrival_m: float = setting(0.05, "the same, where there is no noise", unit="m", above=0.0)
    station_m: float = setting(
        0.5, "a robot that holds a place drives back to it when it is farther off", unit="m", minimum=0.0
    )
    turning_m: float = setting(4.0, "nearer than this, a place on the way is passed", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolConfig(Config):
    """Timing of the messages, in ticks: one tick takes a frame one hop."""

    absence_ticks: int = setting(3, "a robot not sensed where it must be for so long is gone", minimum=1)
    absence_share: float = setting(
        1.8, "within this many ranges a robot that is there is sensed for certain", above=0.0, maximum=2.0
    )
    heartbeat_ticks: int = setting(10, "between two comparisons of boards between neighbors", minimum=1)
    quiet_ticks: int = setting(5, "a board unchanged for so long is worth comparing", minimum=1)
    offer_ticks: int = setting(
        4, "an offer for a frontier is taken once it is this old: rivals on the air withdraw first", minimum=0
    )
    offers_max: int = setting(3, "open offers of one robot at a time, where several may be under way", minimum=1)
    travel_limit: float = setting(3.0, "a robot gives its place up after this many times the time that it takes")
    flock_notice_ticks: int = setting(20, "from an order to move until all move: news takes a tick per hop", minimum=1)
    gather_limit_s: float = setting(300.0, "the leader waits no longer for a rendezvous", unit="s", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageConfig(Config):
    """Ranges, sense spheres and choice of places."""

    range_m: float = setting(50.0, "r_sc, range of covering and linking (eq. (1))", unit="m", above=0.0)
    samples: Samples = setting(Samples.FIBONACCI, "points of a sense sphere: fibonacci, or grid as in the paper")
    sample_count: int = setting(400, "Q, points of a Fibonacci sense sphere (Table 1)", minimum=12, maximum=10_000)
    rule: Rule = setting(Rule.LAYOUT, "how the next place is chosen: random, first, gain or layout")
    placement: float = setting(
        0.95,
        "s: a robot stops at this share of the way from its frontier's owner to the frontier point, so that the link"
        " is strictly shorter than r_sc; 0.95 without process noise, 0.90 with 1 m per step",
        above=0.0,
        maximum=1.0,
    )
    expansion: Expansion = setting(Expansion.PREDICTED, "robots under way: serial, parallel or predicted")
    motion: MotionConfig = section(MotionConfig, "speed and arrival")
    protocol: ProtocolConfig = section(ProtocolConfig, "timing of messages")
    layout: LayoutConfig = section(LayoutConfig, "search of the layout rule")
