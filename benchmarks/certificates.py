"""Validity of certificates: error estimates of every engine against true errors, over random scenes of every machine.

True errors come from exact solutions where there are any, else from two references that confirm each other. Each group, a machine and an
engine, must hold by itself; the exit status is 1 if one does not.

Usage: python benchmarks/certificates.py
       python benchmarks/certificates.py --machine "air engine" --engine reduced --runs 50
       python benchmarks/certificates.py --resume
       python benchmarks/certificates.py --print

Every run is a row of certificates.csv.gz, written as it ends: --resume makes only the runs that are missing there,
--print none. Without them the rows of the chosen groups are replaced. Another table (--table) is compressed if its
name ends in .gz; `gzip -9n certificates.csv` packs a plain one, `gzip -dk certificates.csv.gz` unpacks it. --state
writes the last sentence into the README, and it and the table of groups into the page on certificates.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

from certificate_checks import (
    ENGINES,
    MAX_ERROR_RATIO,
    CertificateCheck,
    ReferenceSolutions,
    check_certificate,
    describe_check,
    engines_of,
    references_of,
)
from certificate_groups import Group, append_checks, format_groups, group_checks, load_checks, save_checks, state_study, summarise
from random_scenes import RandomScene, draw_study_scene
from study_machines import STUDY_MACHINES

SEED, N_RUNS, RUNS_PER_SCENE = 20261124, 210, 5
"""Seed, number of runs of a group, of which a few are set aside, and number of runs of a scene by an engine."""

LAST_HALF_DECADE = {"reduced": 22, "multibody": 22, "impulse": 16}
"""Half decades of the finest accuracy of each engine: 1e-11, and 1e-8; the coarsest is 1e-2."""

ACCURACY_STRIDE = 8
"""Half decades from one run to the next, which has no factor in common with the numbers of accuracies: each comes equally often."""

MAX_SCENES_WITHOUT_RUN = 12
"""Number of scenes after which an engine that takes none of them does not model the machine."""

RUN_TIME_LIMIT, REFERENCE_TIME_LIMIT = 20.0, 60.0
"""Largest times of the processor for one certified run and for the references of a scene, s."""

FIGURE_PATH = Path(__file__).with_name("certificates.png")
TABLE_PATH = FIGURE_PATH.with_suffix(".csv.gz")
ROOT = Path(__file__).resolve().parents[1]
README_PATH, PAGE_PATH = ROOT / "README.md", ROOT / "docs" / "theory" / "certificates.md"
TOO_LONG = "took too long"

Plan = dict[str, list[float]]
"""Accuracies of the runs of a scene, by engine."""


class TooLongError(Exception):
    """A run that takes longer than the time limit."""


def main() -> int:
    """Run the study, print its tables and return the exit status."""
    arguments = parse_arguments()
    kept = load_checks(arguments.table) if arguments.table.exists() else []
    if not arguments.print:
        chosen = {(machine, engine) for machine in arguments.machine for engine in arguments.engine}
        if not arguments.resume:
            kept = [one for one in kept if (one.machine, one.engine) not in chosen]
        run_study(arguments, kept)
        kept = load_checks(arguments.table)  # with the digits that are stated, and that --print sees
        save_checks(kept, arguments.table)  # in one stream instead of one for each scene
    checks = sorted(kept, key=lambda one: (list(STUDY_MACHINES).index(one.machine), one.engine, one.number, one.accuracy))
    groups = group_checks(checks)
    print(format_groups(groups), end="\n\n")
    print_failing_runs(groups)
    print_set_aside(checks)
    if not arguments.no_figure:
        draw_distribution(checks, FIGURE_PATH)
    if arguments.state:
        state_study(groups, README_PATH, PAGE_PATH)
    print(summarise(groups))
    return 1 if any(group.failures for group in groups) else 0


def parse_arguments() -> argparse.Namespace:
    """Return the arguments of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machine", nargs="+", choices=list(STUDY_MACHINES), default=list(STUDY_MACHINES))
    parser.add_argument("--engine", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--runs", type=int, default=N_RUNS, help="number of runs of each group")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--table", type=Path, default=TABLE_PATH, help="file with a row for each run")
    parser.add_argument("--resume", action="store_true", help="make only the runs that the file does not have")
    parser.add_argument("--print", action="store_true", help="print the tables of the file without simulating")
    parser.add_argument("--state", action="store_true", help="write the result into README and documentation")
    parser.add_argument("--no-figure", action="store_true")
    return parser.parse_args()


# --- runs -----------------------------------------------------------------------------------------------------------------


def run_study(arguments: argparse.Namespace, kept: list[CertificateCheck]) -> list[CertificateCheck]:
    """Return the checks in the file and those of the runs that are missing, which are written as they end."""
    kept = [one for one in kept if one.seed == arguments.seed]
    has_run = {(one.machine, one.engine, one.number, f"{one.accuracy:.3e}") for one in kept}
    save_checks(kept, arguments.table)
    workers = Parallel(n_jobs=arguments.workers, return_as="generator_unordered")
    plans = workers(delayed(plan_machine)(machine, arguments) for machine in arguments.machine)
    jobs = []
    for machine, plan in plans:
        for number, accuracies in plan.items():
            missing = {
                engine: [one for one in values if (machine, engine, number, f"{one:.3e}") not in has_run]
                for engine, values in accuracies.items()
            }
            if any(missing.values()):
                jobs.append((machine, number, missing))
    jobs.sort(key=lambda job: job[1])  # all machines advance together
    n_runs, done, start = sum(len(values) for job in jobs for values in job[2].values()), 0, time.monotonic()
    found = list(kept)
    for checks in workers(delayed(check_scene)(*job, arguments.seed) for job in jobs):
        found += checks
        append_checks(checks, arguments.table)
        done += len(checks)
        print(f"\r{done} of {n_runs} runs, {time.monotonic() - start:.0f} s", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return found


def plan_machine(machine: str, arguments: argparse.Namespace) -> tuple[str, dict[int, Plan]]:
    """Return the machine, and the accuracies of each of its scenes by engine, so that each engine that models it has all its runs."""
    plan: dict[int, Plan] = {}
    n_planned = Counter[str]()
    for number in count():
        wanted = {
            engine
            for engine in arguments.engine
            if n_planned[engine] < arguments.runs and (number < MAX_SCENES_WITHOUT_RUN or n_planned[engine])
        }
        if not wanted:
            return machine, plan
        takers = wanted & set(engines_of(draw_study_scene(machine, number, arguments.seed).scene))
        plan[number] = {}
        for engine in takers:
            runs = range(n_planned[engine], min(n_planned[engine] + RUNS_PER_SCENE, arguments.runs))
            plan[number][engine] = [accuracy_of(engine, run) for run in runs]
            n_planned[engine] += len(runs)


def accuracy_of(engine: str, run: int) -> float:
    """Return the accuracy of a run of a group."""
    first, n_accuracies = 4, LAST_HALF_DECADE[engine] - 3
    return float(10.0 ** (-0.5 * (first + ACCURACY_STRIDE * run % n_accuracies)))


def check_scene(machine: str, number: int, accuracies: Plan, seed: int) -> list[CertificateCheck]:
    """Return the checks of the runs of a scene, which share their references."""
    drawn = draw_study_scene(machine, number, seed)
    references = references_of(drawn)
    try:
        with time_limit(REFERENCE_TIME_LIMIT):
            if references.exact is None:
                _ = references.reduced, references.multibody
    except Exception as error:  # too long (interrupted compiled code raises SystemError), or whatever it is
        reason = f"references failed: {type(error).__name__}"
        return [replace(describe_check(drawn, engine, one), set_aside=reason) for engine, values in accuracies.items() for one in values]
    return [check_within_limits(drawn, engine, one, references) for engine, values in accuracies.items() for one in values]


def check_within_limits(drawn: RandomScene, engine: str, accuracy: float, references: ReferenceSolutions) -> CertificateCheck:
    """Return one check, or a record that the run took too long or raised an error that is not the package's."""
    try:
        with time_limit(RUN_TIME_LIMIT):
            return check_certificate(drawn, engine, accuracy, references)
    except (TooLongError, SystemError):
        return replace(describe_check(drawn, engine, accuracy), failure=TOO_LONG)
    except Exception as error:  # whatever it is, it is a finding
        text = f"crashed: {type(error).__name__}: {error}".replace("\n", " ")
        return replace(describe_check(drawn, engine, accuracy), failure=text)


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TooLongError after a time (s) of the processor, which other programs do not change, on systems with alarm signals."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def raise_on_alarm(*_: Any) -> None:
        """Raise the exception on the alarm signal."""
        raise TooLongError

    previous_handler = signal.signal(signal.SIGPROF, raise_on_alarm)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous_handler)


# --- tables ------------------------------------------------------------------------------------------------------------


def print_failing_runs(groups: Sequence[Group]) -> None:
    """Print every run with an error above its estimate or above the request, the worst first, and every run that crashed."""
    failing = [one for group in groups for one in group.judged if not one.is_within_estimate or one.claims_too_much]
    failing.sort(key=lambda one: one.estimate / max(one.least, 1e-300))
    print(f"{len(failing)} runs have an error above their estimate or, DONE, above the request:\n")
    if failing:
        print("| machine | number | seed | engine | accuracy | outcome | estimate | true error | doubt | reading | scene |")
        print("|---" * 11 + "|")
    for one in failing:
        cells = (one.machine, one.number, one.seed, one.engine, f"{one.accuracy:.3e}", one.outcome)
        errors = (f"{one.estimate:.2e}", f"{one.true:.2e}", f"{one.doubt:.0e}")
        scene = draw_study_scene(one.machine, one.number, one.seed).description
        print("| " + " | ".join(map(str, (*cells, *errors, one.worst, scene))) + " |")
    crashed = [one for group in groups for one in group.checks if "crashed" in one.failure]
    for one in crashed:
        print(f"{one.machine} {one.number} by {one.engine} at {one.accuracy:.3e} {one.failure}")
    print()


def print_set_aside(checks: Sequence[CertificateCheck]) -> None:
    """Print the runs that are not judged by machine, engine and reason."""
    reasons = Counter((one.machine, one.engine, (one.set_aside or one.failure).split(":")[0]) for one in checks if not one.is_judged)
    print("| not judged: machine | engine | reason | runs |\n|---|---|---|---|")
    for (machine, engine, reason), number in sorted(reasons.items()):
        print(f"| {machine} | {engine} | {reason} | {number} |")
    print()


# --- figure ------------------------------------------------------------------------------------------------------------


def draw_distribution(checks: Sequence[CertificateCheck], path: Path) -> None:
    """Draw the distribution of estimate over true error, one curve per engine."""
    from matplotlib.ticker import FuncFormatter, PercentFormatter

    from governor_mechanism.render.figures.page import DASHED, SERIES_LINE_STYLES, Page, add_legend
    from governor_mechanism.render.style import INK, MUTED, SANS_FONT, SERIES_COLOURS, VERMILLION

    judged = [one for one in checks if one.is_judged]
    scenes = len({(one.machine, one.number) for one in judged})
    subtitle = f"{len(judged):,} certified runs of {scenes} random scenes; true errors by exact solutions, or by another engine"
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
    for engine, colour, style in zip(ENGINES, SERIES_COLOURS, SERIES_LINE_STYLES, strict=False):
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
