"""Validity of certificates: error estimates against true errors, over random scenes of every machine, effect and engine.

The exit status is 1 if an estimate is below a third of the true error.

Usage: python benchmarks/certificates.py --scenes 300 --seed 20261124

The judged runs of the figure are saved in certificates.csv, from which --redraw draws it without a simulation.
"""

from __future__ import annotations

import argparse
import csv
import signal
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from certificate_checks import CertificateCheck, ReferenceSolutions, check_certificate, draw_accuracies
from governor_mechanism.files.plain_values import save_table
from random_machines import MACHINES
from random_scenes import RandomScene, draw_scene

SCENES, SEED = 300, 20261124
TIME_LIMIT = 10.0
"""Largest time of one certificate and its references, s."""
FIGURE_PATH = Path(__file__).with_name("certificates.png")
TABLE_PATH = FIGURE_PATH.with_suffix(".csv")
TABLE_HEADER = ("scene", "engine", "overestimation")
ENGINES = ("reduced", "multibody", "impulse", "auto")
GROUPS = ("plain", "smooth effects", "events")
MAX_ERROR_RATIO = 3.0
"""Largest accepted ratio of the true error of a run to its estimate."""
TOO_LONG = "took too long"


class TooLongError(Exception):
    """A certificate that takes longer than the time limit."""


def main() -> int:
    """Print the tables, draw the picture and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=ENGINES)
    parser.add_argument("--no-figure", action="store_true")
    parser.add_argument("--redraw", action="store_true", help=f"draw the runs in {TABLE_PATH.name} instead of simulating")
    arguments = parser.parse_args()
    if arguments.redraw:
        draw_distribution(load_judged(TABLE_PATH), FIGURE_PATH)
        return 0
    jobs = (delayed(check_random_scene)(number, arguments.seed, arguments.engines) for number in range(arguments.scenes))
    results: list[tuple[int, list[CertificateCheck]]] = []
    for done, result in enumerate(Parallel(n_jobs=arguments.workers, return_as="generator")(jobs), start=1):
        results.append(result)
        print(f"\r{done} of {arguments.scenes} scenes", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    checks = [one for _, scene_checks in results for one in scene_checks]
    refused = sum(refusals for refusals, _ in results)
    print(f"{arguments.scenes} scenes of {len(MACHINES)} machines, seed {arguments.seed}; {refused} more were refused\n")
    print_error_ratios(checks)
    print_unjudged_runs(checks)
    violations = find_violations(checks)
    print_violations(violations, checks)
    if not arguments.no_figure:
        judged = [JudgedRun(scene=one.number, engine=one.engine, overestimation=one.overestimation) for one in checks if one.is_judged]
        save_table(TABLE_HEADER, ((one.scene, one.engine, one.overestimation) for one in judged), TABLE_PATH)
        draw_distribution(judged, FIGURE_PATH)
    return 1 if violations else 0


def check_random_scene(number: int, seed: int, engines: Sequence[str]) -> tuple[int, list[CertificateCheck]]:
    """Return the number of refused scenes before the next accepted one, and the certificates of that scene."""
    drawn = draw_scene(number, seed)
    truth = ReferenceSolutions(drawn.scene)
    accuracies = {engine: accuracy for engine, accuracy in draw_accuracies(drawn).items() if engine in engines}
    checks = [check_within_time_limit(drawn, engine, accuracy, truth) for engine, accuracy in accuracies.items()]
    return len(drawn.refused), checks


def check_within_time_limit(drawn: RandomScene, engine: str, accuracy: float, truth: ReferenceSolutions) -> CertificateCheck:
    """Return one certificate, or a record that it took too long."""
    try:
        with time_limit(TIME_LIMIT):
            return check_certificate(drawn, engine, accuracy, truth)
    except (TooLongError, SystemError):  # interrupted compiled code raises SystemError
        return CertificateCheck(
            seed=drawn.seed,
            number=drawn.number,
            words=drawn.description,
            group=drawn.group,
            engine=engine,
            accuracy=accuracy,
            outcome="",
            set_aside=TOO_LONG,
        )


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TooLongError after a time (s), on systems with alarm signals."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def raise_on_alarm(*_: Any) -> None:
        """Raise the exception on the alarm signal."""
        raise TooLongError

    previous_handler = signal.signal(signal.SIGALRM, raise_on_alarm)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous_handler)


# --- tables -------------------------------------------------------------------------------------------------------


def print_error_ratios(checks: Sequence[CertificateCheck]) -> None:
    """Print how often the error is within the estimate, by engine and by effects of the scene."""
    print("| engine | scenes | runs | error within estimate | within 3 x estimate | median estimate / error | worst |")
    print("|---|---|---|---|---|---|---|")
    for engine in ENGINES:
        for group in (*GROUPS, ""):
            runs = [one for one in checks if one.engine == engine and one.is_judged and group in ("", one.group)]
            if not runs:
                continue
            ratios = np.array([one.overestimation for one in runs])
            within, within_limit = (100 * np.mean(ratios * factor >= 1) for factor in (1.0, MAX_ERROR_RATIO))
            name, worst = (f"**{engine}**", "") if not group else (engine, "")
            worst = f"{1 / np.min(ratios):.2g}" if np.min(ratios) > 0 else "inf"
            cells = (name, group or "**all**", len(runs), f"{within:.1f} %", f"{within_limit:.1f} %", f"{np.median(ratios):.1f}", worst)
            print("| " + " | ".join(map(str, cells)) + " |")
    print("\nworst: the largest true error over its estimate\n")


def print_unjudged_runs(checks: Sequence[CertificateCheck]) -> None:
    """Print the runs that cannot be judged, and the reasons."""
    reasons = Counter((one.engine, one.set_aside.split(":")[0]) for one in checks if not one.is_judged)
    names = sorted({reason for _, reason in reasons})
    print(f"| not judged | {' | '.join(ENGINES)} |\n|---|{'---|' * len(ENGINES)}")
    for name in names:
        print(f"| {name} | {' | '.join(str(reasons[engine, name]) for engine in ENGINES)} |")
    disagreeing = [one for one in checks if one.set_aside == "references disagree" and one.doubt > MAX_ERROR_RATIO * one.estimate]
    counts = Counter(one.engine for one in disagreeing)
    print(f"| of these, by more than 3 estimates | {' | '.join(str(counts[engine]) for engine in ENGINES)} |\n")


def find_violations(checks: Sequence[CertificateCheck]) -> list[CertificateCheck]:
    """Return the runs with a larger error than allowed, the worst first."""
    return sorted((one for one in checks if one.is_judged and MAX_ERROR_RATIO * one.overestimation < 1), key=lambda one: one.overestimation)


def print_violations(violations: Sequence[CertificateCheck], checks: Sequence[CertificateCheck]) -> None:
    """Print every violation with the data to repeat it, and what could not be judged."""
    print(f"{len(violations)} runs have an error of more than {MAX_ERROR_RATIO:g} times their estimate:\n")
    if violations:
        print("| scene | engine | accuracy | outcome | estimate | true error | scene description |\n|---|---|---|---|---|---|---|")
    for one in violations:
        print(f"| {one.number} | {one.engine} | {one.accuracy:.1e} | {one.outcome} | {one.estimate:.1e} | {one.true:.1e} | {one.words} |")
    print()
    for one in checks:
        if one.set_aside == "references disagree" and one.doubt > MAX_ERROR_RATIO * one.estimate:
            print(
                f"references disagree: {one.number} {one.engine} at {one.accuracy:.0e}, estimate {one.estimate:.1e}, "
                f"references {one.doubt:.1e} apart ({one.words})"
            )
    print()
    timed_out = [one for one in checks if one.set_aside == TOO_LONG]
    timeouts = "; ".join(f"{one.number} {one.engine} at {one.accuracy:.0e} ({one.words})" for one in timed_out)
    print(f"took longer than {TIME_LIMIT:g} s: {timeouts or 'none'}")


# --- figure ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class JudgedRun:
    """Number of its scene, engine, and ratio of estimate to true error of a run whose true error is known."""

    scene: int
    engine: str
    overestimation: float


def load_judged(path: Path) -> list[JudgedRun]:
    """Return the judged runs in a file."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return [JudgedRun(scene=int(row["scene"]), engine=row["engine"], overestimation=float(row["overestimation"])) for row in rows]


def draw_distribution(judged: Sequence[JudgedRun], path: Path) -> None:
    """Draw the distribution of estimate over true error, one curve per engine."""
    from matplotlib.ticker import FuncFormatter, PercentFormatter

    from governor_mechanism.render.figures.page import DASHED, SERIES_LINE_STYLES, Page, add_legend
    from governor_mechanism.render.style import INK, MUTED, SANS_FONT, SERIES_COLOURS, VERMILLION

    scenes = len({one.scene for one in judged})
    subtitle = f"{len(judged)} certified runs of {scenes} random scenes; true errors by another engine"
    page = Page(8.4, 5.2, "Error estimates of certified runs", subtitle, subtitle_y=0.893)
    panel = page.add_panel((0.095, 0.115, 0.875, 0.685), "Estimate / true error [1]", "Fraction of runs [%]", which="both")
    low, high = 0.03, 3e4
    panel.axvspan(low, 1 / MAX_ERROR_RATIO, color=VERMILLION, alpha=0.10, linewidth=0)
    for position, caption, alignment in (
        (1 / MAX_ERROR_RATIO, "error = 3 estimates", "right"),
        (1.0, "error = estimate", "left"),
        (100.0, "estimate 100 times the error", "left"),
    ):
        panel.axvline(position, color=INK if position == 1.0 else MUTED, linewidth=0.9, linestyle=DASHED)
        transform, shift = panel.get_xaxis_transform(), -3 if alignment == "right" else 3
        panel.write_note(caption, (position, 1.02), (shift, 0), xycoords=transform, ha=alignment, color=MUTED)
    for engine, colour, style in zip(ENGINES, SERIES_COLOURS, SERIES_LINE_STYLES, strict=True):
        ratios = np.sort([min(max(one.overestimation, low), high) for one in judged if one.engine == engine])
        if not len(ratios):
            continue
        cumulative_fraction = np.arange(1, len(ratios) + 1) / len(ratios)
        ends = np.concatenate([[low], ratios, [high]]), np.concatenate([[0.0], cumulative_fraction, [1.0]])
        label = f"{engine}: {len(ratios)} runs, median {np.median(ratios):.1f}"
        panel.step(*ends, where="post", color=colour, linestyle=style, linewidth=1.6, label=label)
    panel.set(xscale="log", xlim=(low, high), ylim=(0.0, 1.0))
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else "10 000"))
    panel.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=""))
    add_legend(panel, {"color": INK, "fontfamily": SANS_FONT}, loc="lower right", fontsize=9, handlelength=3.0)
    page.save(path)


if __name__ == "__main__":
    sys.exit(main())
