"""Growth of run time with simulated seconds, with loops in a chain of linkages, and with links in a hanging chain.

Times are those of whole runs at one true error, so they include both the number of steps and the cost of a step.

Usage: python benchmarks/growth.py [--draw growth.png] [--redraw]

The times are saved in growth.csv, from which --redraw draws without a measurement.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.files.writing import save_table
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import Page, add_legend, use_plain_decades
from governor_mechanism.render.figures.work_precision import _VARIANT_STYLES
from governor_mechanism.render.style import INK, MUTED
from governor_mechanism.studies.plain_runs import FittedParameter, fit_slope
from governor_mechanism.studies.work_precision import ErrorBenchmark, build_ladders
from governor_mechanism.studies.work_precision_results import WorkPrecisionPoint
from governor_mechanism.types import FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))
from chain_mechanisms import four_bar_acceleration, four_bar_chain, hanging_chain

MAX_EXPONENT = 1.5
"""Largest accepted exponent of the engine `multibody` on chains."""

ENGINES = ("reduced", "multibody", "impulse extrapolated")
TIME_LIMIT = 6.0
"""Largest time of a setting (s); an engine is not run at sizes that take longer."""

N_REPORTED_INTERVALS = 20
"""Number of intervals between reported times at every size, so that the cost of reporting does not grow."""

MIN_FIT_POINTS = 3
"""Smallest number of points, at the largest sizes, for the fit of the exponent; the fit uses at least half of the points."""


@dataclass(frozen=True)
class Growth:
    """One varied size: its values, the scene of a value, and the true error at which times are compared."""

    title: str
    unit: str
    sizes: tuple[int, ...]
    scene: Callable[[int], Scene]
    error: float


def porter_of_duration(duration: int) -> Scene:
    """Return the shipped Porter governor for a duration (s)."""
    scene = gm.load("porter")
    return replace(scene, run=replace(scene.run, duration=float(duration)))


def half_second_loop_chain(count: int) -> Scene:
    """Return a chain of four-bar linkages for half a second."""
    return four_bar_chain(count, 0.5, 0.025)


def half_second_hanging_chain(count: int) -> Scene:
    """Return a hanging chain for half a second."""
    return hanging_chain(count, 0.5, 0.025)


LOOPS = (1, 2, 5, 10, 20, 40)
GROWTHS = (
    Growth("Porter governor", "simulated seconds", (1, 3, 10, 30, 100, 300), porter_of_duration, 1e-6),
    Growth("four-bar linkages in a chain", "loops", LOOPS, half_second_loop_chain, 1e-6),
    Growth("hanging chain", "links", (1, 2, 5, 10, 20, 50, 100, 200), half_second_hanging_chain, 1e-5),
)

Found = dict[str, list[tuple[int, WorkPrecisionPoint]]]
"""Fastest setting within the error by size, for each engine."""
SizeTime = tuple[int, float]
"""A size and the time of a run, s."""
Times = Mapping[str, Mapping[str, Sequence[SizeTime]]]
"""Sizes and times by the title of what grows and by engine."""

TABLE_PATH = Path(__file__).with_suffix(".csv")
TABLE_HEADER = ("growth", "engine", "size", "time_s")


def main() -> None:
    """Print the tables, save the times and draw them."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--draw", type=Path, default=Path(__file__).with_suffix(".png"))
    options.add_argument("--redraw", action="store_true", help=f"draw the times in {TABLE_PATH.name} instead of measuring")
    arguments = options.parse_args()
    if not arguments.redraw:
        results = {growth.title: measure_growth(growth) for growth in GROWTHS}
        for growth in GROWTHS:
            print_growth(growth, results[growth.title])
        print_change_point_runs()
        save_times({title: {name: list_times(points) for name, points in found.items()} for title, found in results.items()}, TABLE_PATH)
    draw_growth(load_times(TABLE_PATH), arguments.draw)


def list_times(points: Sequence[tuple[int, WorkPrecisionPoint]]) -> list[SizeTime]:
    """Return the sizes with their times."""
    return [(size, point.wall_time) for size, point in points]


def save_times(times: Times, path: Path) -> None:
    """Write a row for each engine and size."""
    rows = [(title, name, *one) for title, engines in times.items() for name, points in engines.items() for one in points]
    save_table(TABLE_HEADER, rows, path)


def load_times(path: Path) -> Times:
    """Return the times of a file that `save_times` wrote."""
    times: dict[str, dict[str, list[SizeTime]]] = {growth.title: {name: [] for name in ENGINES} for growth in GROWTHS}
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            times[row["growth"]][row["engine"]].append((int(row["size"]), float(row["time_s"])))
    return times


def measure_growth(growth: Growth) -> Found:
    """Return the fastest setting of every engine within the error, size by size, up to the time limit."""
    found: Found = {name: [] for name in ENGINES}
    active_engines = set(ENGINES)
    for size in growth.sizes:
        scene = growth.scene(size)
        times = np.linspace(0.0, scene.run.duration, N_REPORTED_INTERVALS + 1)
        bench = ErrorBenchmark(scene, times, TIME_LIMIT, growth.error)
        for ladder in build_ladders(scene):
            if ladder.name not in active_engines:
                continue
            point = bench.run_ladder(ladder, lambda _: None).cheapest_for(growth.error)
            print(f"{growth.title}, {size}: {ladder.name} {point and point.setting}", file=sys.stderr)
            if point is None:
                active_engines.discard(ladder.name)
            else:
                found[ladder.name].append((size, point))
    return found


def fit_exponent(points: Sequence[SizeTime]) -> FittedParameter:
    """Return the exponent of time over size, from the upper half of the sizes."""
    sizes, times = np.log(points[-max(MIN_FIT_POINTS, len(points) // 2) :]).T
    return fit_slope(sizes, times)


def print_growth(growth: Growth, found: Found) -> None:
    """Print a row for each size."""
    shown = [name for name in ENGINES if found[name]]
    columns = [f"{name}, ms | {'steps' if 'impulse' in name else 'evaluations'}" for name in shown]
    print(f"| {growth.title}: {growth.unit}, true error {growth.error:g} | {' | '.join(columns)} |")
    print("|---" * (1 + 2 * len(shown)) + "|")
    for size in growth.sizes:
        cells = []
        for name in shown:
            point = dict(found[name]).get(size)
            iterations = "" if point is None else point.setting.partition(", ")[2]
            cells += ["", ""] if point is None else [format_milliseconds(1e3 * point.wall_time), f"{point.evaluations:,}"]
            if iterations:
                cells[-1] += f" of {iterations}"
        print(f"| {size} | {' | '.join(cells)} |")
    fitted = {name: fit_exponent(list_times(found[name])) for name in shown if len(found[name]) >= MIN_FIT_POINTS}
    powers = "; ".join(f"{name} {one.value:.2f} ± {max(one.standard_error, 0.005):.2f}" for name, one in fitted.items())
    print(f"\nTime grows as the power: {powers}.\n")


def format_milliseconds(milliseconds: float) -> str:
    """Return a number with three significant digits, or all digits before the decimal point."""
    return f"{milliseconds:,.0f}" if milliseconds >= 100 else f"{milliseconds:.3g}"


def print_change_point_runs() -> None:
    """Run the chain of loops for ten seconds, with ten passages through a straight position, with a certified multibody run."""
    print("| loops, 10 s, ten change points, accuracy 1e-6 | multibody, ms | true error, rad |\n|---|---|---|")
    for count in (*LOOPS, 100):
        scene = four_bar_chain(count, 10.0, 0.5)
        runs = [gm.run(scene, "multibody", accuracy=1e-6) for _ in range(3)]
        best = min(run.cost.wall_time for run in runs)
        error = float(np.max(np.abs(runs[0].readings["crank_angle"] - solve_one_coordinate(count, runs[0].times))))
        print(f"| {count} | {best * 1e3:.0f} | {error:.1e} |")
    print()


def solve_one_coordinate(count: int, times: FloatArray) -> FloatArray:
    """Return the crank angle from the one-coordinate equation of the chain."""
    found = solve_ivp(
        lambda _, y: (y[1], four_bar_acceleration(count, y[0], 9.81)), (0.0, times[-1]), (math.pi / 2, -1.0),
        method="DOP853", t_eval=times, rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    return np.asarray(found.y[0])


def draw_growth(times: Times, target: Path) -> None:
    """Draw a panel for each varied size, with logarithmic axes."""
    page = Page(12.0, 4.8, "Growth of run time at equal true error")
    for at, growth in enumerate(GROWTHS):
        curves = times[growth.title]
        panel = page.add_panel(
            (0.065 + 0.318 * at, 0.135, 0.275, 0.68), label_sizes(growth), "" if at else "Time of a run [ms]", which="both"
        )
        panel.set(xscale="log", yscale="log")
        panel.write_heading(f"{growth.title[:1].upper()}{growth.title[1:]}, error {growth.error:g}", y=1.03)
        use_plain_decades(panel.xaxis, panel.yaxis)
        letter = "T" if growth.unit == "simulated seconds" else "N"
        for name in reversed(ENGINES):
            points = curves[name]
            if len(points) < MIN_FIT_POINTS:
                continue
            colour, marker, style = _VARIANT_STYLES[name]
            sizes, milliseconds = [size for size, _ in points], [1e3 * seconds for _, seconds in points]
            label = rf"{name} $\propto {letter}^{{{fit_exponent(points).value:.2f}}}$"
            panel.plot(sizes, milliseconds, color=colour, marker=marker, markersize=4.5, linewidth=1.5, linestyle=style, label=label)
        if letter == "N":
            draw_target_slope(panel, curves["multibody"])
        low, high = panel.get_ylim()
        panel.set_ylim(low, high * (high / low) ** 0.35)  # space for the legend
        add_legend(panel, {"color": INK, "math_fontfamily": "stix"}, loc="upper left", fontsize=9, handlelength=3.0)
    page.save(target)


def label_sizes(growth: Growth) -> str:
    """Return the label of the axis of sizes."""
    return "Simulated time [s]" if growth.unit == "simulated seconds" else f"{growth.unit.capitalize()} [1]"


def draw_target_slope(axes: Axes, points: Sequence[SizeTime]) -> None:
    """Draw the largest accepted slope of `multibody` below its line."""
    first, last = points[len(points) // 2][0], points[-1][0]
    lower_end = 0.5 * 1e3 * points[len(points) // 2][1]
    label = rf"target of multibody, $N^{{{MAX_EXPONENT}}}$"
    ends = [lower_end, lower_end * (last / first) ** MAX_EXPONENT]
    axes.plot([first, last], ends, color=MUTED, linewidth=1.0, linestyle=(0, (5, 3)), label=label)


if __name__ == "__main__":
    main()
