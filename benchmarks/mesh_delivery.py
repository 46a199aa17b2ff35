"""Measures how many routed packets arrive among mobile robots, and how much longer their ways are than the shortest.

Robots drive from one random point of the arena to the next (random waypoint) with and without the obstacles of a map.
Every radio runs the real mesh network over the simulated medium; frames are lost, and delayed by up to a tick, for each
receiver on its own. In each tick some robots send a packet to others.

A packet counts if its two ends were connected (by any number of links over other robots) when it was sent and in every
tick after that until it arrived, or for 15 s. It was delivered if it arrived within these 15 s.

The table's columns: "delivered" is the share of the packets that count, "worst run" the least of any run. "No route" is
the share whose sender had no usable route when it sent; they count as any others, and wait for one if the route has
broken lately. "Route stretch" is over the packets with a route: the hops that the sender's table claimed, or the least
number that were needed at that instant if the claim is lower (so short a path does not exist any more, and no stale
claim makes up for a detour), summed, over the sum of the least numbers. "Path stretch" compares the hops that the
delivered packets really took with the least number when they were sent. "Latency" is the mean time to arrive.

Prints a Markdown table; ``--figure FILE`` draws it. Ctrl-C prints what was done, and draws nothing.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from scipy.sparse import csr_array
from scipy.sparse.csgraph import shortest_path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from drawing import BLUE, TARGET, VERMILION, panels, save
from tables import print_head, print_row

from bringup.layout import walls
from bringup.resolution import resolve
from bringup.scenario_file import load_scenario
from swarm_msgs_py.frames import decode_frame
from swarm_msgs_py.messages.radio import Packet, Presence
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import LinkModel
from swarm_sim.radio.medium import Medium
from swarm_sim.world.obstacles import ObstacleField

SCENARIO = "formation-50"  # whose arena it is
PERIOD_S, SPEED_M_S, HALF_SIDE_M = 0.5, 0.5, 45.0
WARM_UP, MEASURED, FLIGHT = 20, 50, 30
"""Ticks to converge, to send packets in, and that a packet may take at most."""
PACKETS_PER_TICK = 10
ARENAS, LOSSES, DELAYS = ("open", "obstacles"), (0.0, 0.1, 0.3), (0, 1)
COLORS = {"open": BLUE, "obstacles": VERMILION}
TARGETS = {0.0: 0.99, 0.1: 0.95}
STRETCH_TARGET = 1.05


@dataclass(frozen=True)
class Case:
    """One run: where, how bad the radio is, and the seed."""

    arena: str
    loss: float
    delay: int
    robots: int
    seed: int


@dataclass(frozen=True)
class Outcome:
    """Sums over the packets of one run that count."""

    counted: int
    delivered: int
    no_route: int
    route_hops: int
    route_needed: int
    path_hops: int
    path_needed: int
    latency_ticks: int


@dataclass
class _Sent:
    """One packet on its way."""

    tick: int
    ends: tuple[int, int]
    needed: int
    route: int | None
    path: int = 0
    arrived: int | None = None
    is_connected: bool = True


def run(case: Case) -> Outcome:
    """Let robots drive about and send packets, and return what became of those whose ends were connected."""
    obstacles = _obstacles() if case.arena == "obstacles" else ()
    field = ObstacleField(obstacles)
    ids = [NodeId(robot) for robot in range(case.robots)]
    nodes = [MeshNetwork(robot, NetworkConfig(), PERIOD_S) for robot in ids]
    medium = Medium(RadioConfig(loss=case.loss, delay_ticks_max=case.delay), ids, PERIOD_S, case.seed)
    links, alive = LinkModel(RadioConfig().range_m, field), np.ones(case.robots, dtype=np.bool_)
    rng = rng_for(case.seed, "packets")
    sent: list[_Sent] = []
    for tick, positions in enumerate(_random_waypoints(case, field)):
        if tick == WARM_UP + MEASURED + FLIGHT:
            break
        table = links.evaluate(positions, alive)
        hops = shortest_path(csr_array(table.connected), unweighted=True)
        for entry in sent:
            if entry.arrived is None:
                entry.is_connected &= bool(np.isfinite(hops[entry.ends])) or tick > entry.tick + FLIGHT
        for node, inbox in zip(nodes, medium.collect(tick, alive), strict=True):
            for delivery in node.receive(tick, inbox):
                number = int(delivery.body)
                sent[number].arrived = tick
        if WARM_UP <= tick < WARM_UP + MEASURED:
            sent += _send(nodes, hops, rng, tick, len(sent))
        outboxes = {
            robot: node.transmit(tick, _presence(tick, positions[robot]))
            for robot, node in zip(ids, nodes, strict=True)
        }
        _follow(outboxes, sent)
        medium.transmit(tick, outboxes, table)
    return _sums([entry for entry in sent if entry.is_connected])


def _send(
    nodes: Sequence[MeshNetwork], hops: FloatArray, rng: np.random.Generator, tick: int, first: int
) -> list[_Sent]:
    """Let random robots send a packet to others that they are connected with."""
    sent: list[_Sent] = []
    for origin, destination in rng.integers(len(nodes), size=(PACKETS_PER_TICK, 2)).tolist():
        if origin == destination or not np.isfinite(hops[origin, destination]):
            continue
        route = nodes[origin].route(NodeId(destination))
        is_usable = route is not None and NodeId(destination) in nodes[origin].reachable
        nodes[origin].send(NodeId(destination), b"%d" % (first + len(sent)))
        length = route.hops if route is not None and is_usable else None
        sent.append(_Sent(tick, (origin, destination), int(hops[origin, destination]), length))
    return sent


def _follow(outboxes: dict[NodeId, tuple[bytes, ...]], sent: Sequence[_Sent]) -> None:
    """Note how many hops the packets have made that are on their last one."""
    limit = NetworkConfig().hop_limit
    for frames in outboxes.values():
        for frame in map(decode_frame, frames):
            if isinstance(frame, Packet) and frame.next_hop == frame.destination:
                entry = sent[int(frame.body)]
                if entry.arrived is None:
                    entry.path = limit - frame.hops_left + 1


def _sums(counted: Sequence[_Sent]) -> Outcome:
    delivered = [entry for entry in counted if entry.arrived is not None and entry.arrived <= entry.tick + FLIGHT]
    routed = [entry for entry in counted if entry.route is not None]
    return Outcome(
        counted=len(counted),
        delivered=len(delivered),
        no_route=len(counted) - len(routed),
        route_hops=sum(max(entry.route or 0, entry.needed) for entry in routed),
        route_needed=sum(entry.needed for entry in routed),
        path_hops=sum(entry.path for entry in delivered),
        path_needed=sum(entry.needed for entry in delivered),
        latency_ticks=sum((entry.arrived or 0) - entry.tick for entry in delivered),
    )


def _random_waypoints(case: Case, field: ObstacleField) -> Iterator[FloatArray]:
    """Yield the positions of each tick, (n, 2) [m]; every robot drives straight to points that it can see."""
    rng = rng_for(case.seed, "waypoints")
    positions = _visible_points(rng, np.full((case.robots, 2), np.inf), field)
    goals = _visible_points(rng, positions, field)
    while True:
        yield positions
        ways = goals - positions
        lengths = np.linalg.norm(ways, axis=1)
        step = SPEED_M_S * PERIOD_S
        positions = positions + ways * np.minimum(1.0, step / np.maximum(lengths, 1e-9))[:, None]
        arrived = lengths <= step
        goals[arrived] = _visible_points(rng, positions[arrived], field)


def _visible_points(rng: np.random.Generator, starts: FloatArray, field: ObstacleField) -> FloatArray:
    """Return one uniformly random free point for each start, with a free straight way to it (any, if inf)."""
    points = rng.uniform(-HALF_SIDE_M, HALF_SIDE_M, starts.shape)
    todo = np.arange(len(starts))
    while len(todo):
        ends = points[todo]
        begins = np.where(np.isfinite(starts[todo]), starts[todo], ends)
        blocked: NDArray[np.bool_] = field.is_blocked(begins, ends) | field.is_blocked(ends, ends + 1e-3)
        todo = todo[blocked]
        points[todo] = rng.uniform(-HALF_SIDE_M, HALF_SIDE_M, (len(todo), 2))
    return points


def _obstacles() -> tuple[FloatArray, ...]:
    return walls(resolve(*load_scenario(SCENARIO)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all cases, print the table, and return the exit code: 1 when a target was missed, 130 after Ctrl-C."""
    options = _parser().parse_args(arguments)
    groups = list(product(ARENAS, LOSSES, DELAYS))
    cases = [Case(*group, options.robots, seed) for seed in range(1, options.seeds + 1) for group in groups]
    outcomes: dict[Case, Outcome] = {}
    context = multiprocessing.get_context("spawn")
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    try:
        # Workers leave Ctrl-C to this process, which ends them.
        with (
            context.Pool(options.processes, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool,
            Progress(*columns, console=Console(stderr=True)) as progress,
        ):
            bar = progress.add_task("runs", total=len(cases))
            for case, outcome in zip(cases, pool.imap(run, cases), strict=True):
                outcomes[case] = outcome
                progress.advance(bar)
    except KeyboardInterrupt:
        print("interrupted; the table has what was done", file=sys.stderr)
        _print_table(outcomes)
        return 130
    reached = _print_table(outcomes)
    if options.figure is not None:
        _draw(outcomes, options.figure)
    return 0 if reached else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=30, help="runs of each case (default: %(default)s)")
    parser.add_argument("--robots", type=int, default=50, help="default: %(default)s")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="at a time (default: all cores)")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="where to draw the result, a PNG")
    return parser


def _of(outcomes: dict[Case, Outcome], arena: str, loss: float, delay: int) -> list[Outcome]:
    return [o for case, o in outcomes.items() if (case.arena, case.loss, case.delay) == (arena, loss, delay)]


def _print_table(outcomes: dict[Case, Outcome]) -> bool:
    """Print one row per case, and return whether all targets were met."""
    names = ("arena", "loss", "delay [ticks]", "runs", "packets", "delivered", "worst run", "no route")
    print_head([*names, "route stretch", "path stretch", "latency [ticks]"])
    reached = True
    for arena, loss, delay in product(ARENAS, LOSSES, DELAYS):
        some = _of(outcomes, arena, loss, delay)
        if not some:
            continue
        delivery, route, path = _delivery(some), _route_stretch(some), _path_stretch(some)
        reached &= loss not in TARGETS or (delivery >= TARGETS[loss] and route <= STRETCH_TARGET)
        latency = sum(o.latency_ticks for o in some) / sum(o.delivered for o in some)
        worst = min(_delivery([o]) for o in some)
        counts = str(len(some)), str(sum(o.counted for o in some))
        no_route = sum(o.no_route for o in some) / sum(o.counted for o in some)
        ratios = (
            *(f"{delivery:.2%}", f"{worst:.1%}", f"{no_route:.2%}"),
            *(f"{route:.3f}", f"{path:.3f}", f"{latency:.1f}"),
        )
        print_row([arena, f"{loss:.0%}", f"0 to {delay}" if delay else "0", *counts, *ratios])
    return reached


def _delivery(some: Sequence[Outcome]) -> float:
    return sum(o.delivered for o in some) / sum(o.counted for o in some)


def _route_stretch(some: Sequence[Outcome]) -> float:
    return sum(o.route_hops for o in some) / sum(o.route_needed for o in some)


def _path_stretch(some: Sequence[Outcome]) -> float:
    return sum(o.path_hops for o in some) / sum(o.path_needed for o in some)


def _draw(outcomes: dict[Case, Outcome], file: Path) -> None:
    """Draw delivery and stretch over the loss: the mean, its 95 % confidence interval, and the targets."""
    figure, (left, right) = panels(2)
    for index, (arena, delay) in enumerate(product(ARENAS, DELAYS)):
        places = np.arange(len(LOSSES)) + 0.09 * (index - 1.5)
        groups = [_of(outcomes, arena, loss, delay) for loss in LOSSES]
        label = f"{arena}, delay {'0 to 1 tick' if delay else '0'}"
        style = {"color": COLORS[arena], "markerfacecolor": "white" if delay else COLORS[arena], "fmt": "o", "ms": 5}
        for axes, measure, scale in ((left, _delivery, 100.0), (right, _route_stretch, 1.0)):
            values = [np.array([measure([outcome]) for outcome in some]) * scale for some in groups]
            errors = [1.96 * v.std(ddof=1) / np.sqrt(len(v)) if len(v) > 1 else 0.0 for v in values]
            means = [float(v.mean()) for v in values]
            if axes is left:  # nothing is delivered more often than always
                bounds = [errors, [min(error, 100.0 - mean) for error, mean in zip(errors, means, strict=True)]]
            else:
                bounds = [errors, errors]
            axes.errorbar(places, means, bounds, capsize=3, lw=1.2, label=label, **style)
    for place, loss in enumerate(LOSSES):
        if loss in TARGETS:
            left.hlines(100.0 * TARGETS[loss], place - 0.35, place + 0.35, **TARGET)
    right.axhline(STRETCH_TARGET, **TARGET)
    left.set_ylabel("packets delivered [%]")
    right.set_ylabel("hops of the route / least number of hops")
    left.set_title("delivery between connected robots", fontsize=10)
    right.set_title("route stretch", fontsize=10)
    for axes in (left, right):
        axes.set_xticks(range(len(LOSSES)), [f"{loss:.0%}" for loss in LOSSES])
        axes.set_xlabel("frames lost per receiver")
    left.plot([], [], **TARGET, label="target")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8, frameon=False)
    save(figure, file)


def _presence(tick: int, position: FloatArray) -> Presence:
    zeros = np.zeros((2, 2))
    return Presence(position, zeros[0], zeros, 0.0, tick, 1, is_beacon=False, mode=0, epoch=0, digest=0)


if __name__ == "__main__":
    sys.exit(main())
