"""What the runs of the robustness benchmark come to: Markdown tables, the targets that were missed, and a figure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from drawing import draw_groups, explain, panels, save
from tables import number, print_head, print_row

from bringup.labels import first_few

Result = Mapping[str, Any]
NumberColumns = Mapping[str, Callable[[Sequence[Result]], str]]


@dataclass(frozen=True)
class Variant:
    """One way to make it hard, and the settings for it.

    Attributes
    ----------
    experiment, name, scenario : str
    settings : tuple of str
        As after ``--set``.
    ratio_max : float or None
        Target of the mean settling time over that of the same seeds in `REFERENCE`.
    agreed_max_s : float or None
        Target of the time from the merge of two networks to one agreed assignment, for each seed [s].
    """

    experiment: str
    name: str
    scenario: str
    settings: tuple[str, ...] = ()
    ratio_max: float | None = None
    agreed_max_s: float | None = None


IDEAL = "no loss, no delay"
REFERENCE = "loss 0 %, delay"
"""What the targets of the loss experiment refer to: the same radio, but no frame gets lost."""
CHANNEL_MAX_BPS = 250_000.0  # what a radio hears must stay below it, in each run
VARIANTS = (
    Variant("loss", IDEAL, "formation-50"),
    Variant("loss", REFERENCE, "formation-50", ("delay_ticks_max=1",), ratio_max=1.0),
    Variant("loss", "loss 10 %, delay", "formation-50", ("radio.loss=0.1", "delay_ticks_max=1"), ratio_max=1.1),
    Variant("loss", "loss 30 %, delay", "formation-50", ("radio.loss=0.3", "delay_ticks_max=1"), ratio_max=1.3),
    Variant("kills", "20 % killed", "formation-50"),
    Variant("split", "split and merge", "split-24", agreed_max_s=10.0),
)
COLUMNS: NumberColumns = {
    "runs": lambda runs: str(len(runs)),
    "achieved": lambda runs: str(sum(run["achieved"] for run in runs)),
    "collisions": lambda runs: str(sum(run["collisions"] for run in runs)),
    "least gap [m]": lambda runs: number(min(run["min_clearance_m"] for run in runs), 3),
    "settling, mean / worst [s]": lambda runs: _mean_and_worst(runs, "settling_time_s"),
    "displacement / bound": lambda runs: _mean_and_worst(runs, "displacement_ratio", 3),
    "localization rms, mean / worst [m]": lambda runs: _mean_and_worst(runs, "localization_rmse_m", 2),
    "neighborhood peak [kbit/s]": lambda runs: number(max(run["radio_neighborhood_peak_bps"] for run in runs) / 1000.0),
}
SPLIT_COLUMNS: NumberColumns = {
    "longest split, mean / worst [s]": lambda runs: _mean_and_worst(runs, "longest_split_s"),
    "busy apart, with / without computer": lambda runs: (
        f"{_worst_low(runs, 'busy_with_computer')} / {_worst_low(runs, 'busy_without_computer')}"
    ),
    "agreed after the merge, mean / worst [s]": lambda runs: _mean_and_worst(runs, "agreed_after_s"),
}


class Report:
    """Finished runs, grouped by variant.

    Parameters
    ----------
    results : sequence of mapping
        One per run.
    """

    def __init__(self, results: Sequence[Result]) -> None:
        self._runs = {
            variant: [
                run for run in results if (run["experiment"], run["variant"]) == (variant.experiment, variant.name)
            ]
            for variant in VARIANTS
        }

    def print(self) -> bool:
        """Print a table per experiment, then each target that was missed; return whether there is none."""
        for experiment in dict.fromkeys(variant.experiment for variant in VARIANTS):
            shown = {v: runs for v, runs in self._runs.items() if v.experiment == experiment and runs}
            if shown:
                self._print_table(experiment, shown)
        missed = list(self.missed())
        print()
        for line in missed:
            print(f"- missed: {line}")
        return not missed

    def missed(self) -> Iterator[str]:
        """Yield a line for each target that was missed: of single runs, then of their mean."""
        for variant, runs in self._runs.items():
            for run in runs:
                for text in _missed_by_run(variant, run):
                    yield f"{variant.name}, seed {run['seed']}: {text}"
            if runs and variant.ratio_max is not None:
                ratio = self._ratio(variant, REFERENCE)
                if ratio is None or ratio[0] > variant.ratio_max:
                    measured = "unknown" if ratio is None else f"{ratio[0]:.3f}"
                    target = f"at most {variant.ratio_max:g}"
                    yield f"{variant.name}: settling is {measured} x that of '{REFERENCE}', {target}"

    def draw(self, file: Path) -> None:
        """Draw a panel for each experiment that there are results of."""
        loss = {v.name: self._slowness(v, REFERENCE) for v in self._runs if v.experiment == "loss"}
        kills = {
            v.name: _known(runs, "settling_time_s")
            for v, runs in self._runs.items()
            if v.name == IDEAL or v.experiment == "kills"
        }
        agreed = {v.name: _known(runs, "agreed_after_s") for v, runs in self._runs.items() if v.experiment == "split"}
        shown: list[tuple[str, dict[str, list[float]], dict[str, float | None]]] = [
            (f"settling / that of the same seed at {REFERENCE}", loss, {v.name: v.ratio_max for v in self._runs}),
            ("settling [s], robots dying", kills, {}),
            ("from merge to one agreed assignment [s]", agreed, {v.name: v.agreed_max_s for v in self._runs}),
        ]
        shown = [panel for panel in shown if any(panel[1].values())]
        if not shown:
            return
        figure, axes = panels(len(shown))
        for one, (title, groups, limits) in zip(axes, shown, strict=True):
            draw_groups(
                one,
                title,
                {name.replace(", ", "\n"): values for name, values in groups.items()},
                {name.replace(", ", "\n"): limit for name, limit in limits.items()},
            )
        explain(figure, axes[0])
        save(figure, file)

    def _print_table(self, experiment: str, shown: Mapping[Variant, Sequence[Result]]) -> None:
        columns = {**COLUMNS, **(SPLIT_COLUMNS if experiment == "split" else {})}
        ratios = [f"settling / {IDEAL}", f"settling / {REFERENCE}", "target"] if experiment == "loss" else []
        first = next(iter(shown.values()))[0]
        print(f"\n### {experiment}: {first['scenario']}, {first['engine']}, {first['physics']}\n")
        print_head(["variant", *columns, *ratios])
        for variant, runs in shown.items():
            cells = [variant.name, *(column(runs) for column in columns.values())]
            if ratios:
                both = [self._ratio(variant, base) for base in (IDEAL, REFERENCE)]
                cells += [f"{ratio[0]:.3f}, worst {ratio[1]:.3f}" if ratio else "-" for ratio in both]
                cells.append(number(variant.ratio_max))
            print_row(cells)

    def _ratio(self, variant: Variant, base: str) -> tuple[float, float] | None:
        """Return by how much longer settling took than in the base runs of the same seeds: of the means, and worst."""
        pairs = self._pairs(variant, base)
        if not pairs:
            return None
        own, other = zip(*pairs, strict=True)
        return fmean(own) / fmean(other), max(self._slowness(variant, base))

    def _slowness(self, variant: Variant, base: str) -> list[float]:
        return [own / other for own, other in self._pairs(variant, base)]

    def _pairs(self, variant: Variant, base: str) -> list[tuple[float, float]]:
        """Return settling times of runs with those of the same seeds in the variant `base`, where both are known."""
        others = {
            run["seed"]: run["settling_time_s"]
            for other, runs in self._runs.items()
            if (other.experiment, other.name) == ("loss", base)
            for run in runs
        }
        pairs = [(run["settling_time_s"], others.get(run["seed"])) for run in self._runs[variant]]
        return [(own, other) for own, other in pairs if own is not None and other is not None]


def _missed_by_run(variant: Variant, run: Result) -> Iterator[str]:
    """Yield what one run should have reached by itself and did not."""
    if not run["achieved"]:
        yield f"not achieved ({run['reason']})"
    if run["collisions"]:
        yield f"{run['collisions']} collisions"
    peak = run["radio_neighborhood_peak_bps"]
    if peak >= CHANNEL_MAX_BPS:
        limit = f"less than {CHANNEL_MAX_BPS / 1000.0:g} kbit/s"
        yield f"the channel around a radio is taken by {peak / 1000.0:.1f} kbit/s, {limit}"
    agreed = run["agreed_after_s"]
    if variant.agreed_max_s is not None and (agreed is None or agreed > variant.agreed_max_s):
        measured = "never agreed after a merge" if agreed is None else f"agreed {agreed:.1f} s after the merge"
        yield f"{measured}, at most {variant.agreed_max_s:g} s"


def _known(runs: Sequence[Result], name: str) -> list[float]:
    return [run[name] for run in runs if run[name] is not None]


def _mean_and_worst(runs: Sequence[Result], name: str, digits: int = 1) -> str:
    values = _known(runs, name)
    missing = [str(run["seed"]) for run in runs if run[name] is None]
    text = f"{fmean(values):.{digits}f} / {max(values):.{digits}f}" if values else "-"
    return f"{text} (none: seed {first_few(missing)})" if missing else text


def _worst_low(runs: Sequence[Result], name: str) -> str:
    values = _known(runs, name)
    return f"{min(values):.2f}" if values else "-"
