"""How well certificates hold: estimates against true errors, over random scenes of every machine, effect and engine.

python benchmarks/certificates.py --scenes 300 --seed 20261124
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from certificate_checks import CertificateCheck, ReferenceSolutions, check_certificate, draw_accuracies
from random_machines import MACHINES
from random_scenes import RandomScene, draw_scene

SCENES, SEED = 300, 20261124
LONGEST = 10.0
"""Seconds that one certificate and its references may take."""
PICTURE = Path(__file__).with_name("certificates.png")
ENGINES = ("reduced", "multibody", "impulse", "auto")
GROUPS = ("plain", "smooth effects", "events")
LAW = 3.0
"""So many times its estimate may the true error of a run be."""
TOO_LONG = "took too long"


class TooLongError(Exception):
    """A certificate that takes longer than LONGEST."""


def main() -> None:
    """Print the tables and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    jobs = (delayed(one_scene)(number, asked.seed) for number in range(asked.scenes))
    found: list[tuple[int, list[CertificateCheck]]] = []
    for done, result in enumerate(Parallel(n_jobs=asked.workers, return_as="generator")(jobs), start=1):
        found.append(result)
        print(f"\r{done} of {asked.scenes} scenes", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    every = [one for _, many in found for one in many]
    refused = sum(refusals for refusals, _ in found)
    print(f"{asked.scenes} scenes of {len(MACHINES)} machines, seed {asked.seed}; {refused} more were refused\n")
    tell_law(every)
    tell_set_aside(every)
    tell_short(every)
    draw([one for one in every if one.is_judged], PICTURE)


def one_scene(number: int, seed: int) -> tuple[int, list[CertificateCheck]]:
    """How many refusals came before a scene, and its certificates."""
    drawn = draw_scene(number, seed)
    truth = ReferenceSolutions(drawn.scene)
    return len(drawn.refused), [guarded(drawn, engine, accuracy, truth) for engine, accuracy in draw_accuracies(drawn).items()]


def guarded(drawn: RandomScene, engine: str, accuracy: float, truth: ReferenceSolutions) -> CertificateCheck:
    """One certificate, or word that it took too long."""
    try:
        with at_most(LONGEST):
            return check_certificate(drawn, engine, accuracy, truth)
    except (TooLongError, SystemError):  # compiled code that is interrupted raises the latter
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
def at_most(seconds: float) -> Iterator[None]:
    """Raise TooLongError after so many seconds, where the system has alarms."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def ring(*_: Any) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


# --- the tables -------------------------------------------------------------------------------------------------------


def tell_law(every: Sequence[CertificateCheck]) -> None:
    """The law, by engine and by what is in a scene."""
    print("| engine | scenes | runs | error within estimate | within 3 x estimate | median estimate / error | worst |")
    print("|---|---|---|---|---|---|---|")
    for engine in ENGINES:
        for group in (*GROUPS, ""):
            runs = [one for one in every if one.engine == engine and one.is_judged and group in ("", one.group)]
            if not runs:
                continue
            over = np.array([one.overestimation for one in runs])
            within, lawful = (100 * np.mean(over * factor >= 1) for factor in (1.0, LAW))
            name, worst = (f"**{engine}**", "") if not group else (engine, "")
            worst = f"{1 / np.min(over):.2g}" if np.min(over) > 0 else "no end"
            print(f"| {name} | {group or '**all**'} | {len(runs)} | {within:.1f} % | {lawful:.1f} % | {np.median(over):.1f} | {worst} |")
    print("\nworst: the largest true error over its estimate\n")


def tell_set_aside(every: Sequence[CertificateCheck]) -> None:
    """What could not be judged, and why."""
    reasons = Counter((one.engine, one.set_aside.split(":")[0]) for one in every if not one.is_judged)
    names = sorted({reason for _, reason in reasons})
    print(f"| set aside | {' | '.join(ENGINES)} |\n|---|{'---|' * len(ENGINES)}")
    for name in names:
        print(f"| {name} | {' | '.join(str(reasons[engine, name]) for engine in ENGINES)} |")
    outside = [one for one in every if one.set_aside == "references disagree" and one.doubt > LAW * one.estimate]
    counted = Counter(one.engine for one in outside)
    print(f"| of these, by more than 3 estimates | {' | '.join(str(counted[engine]) for engine in ENGINES)} |\n")


def tell_short(every: Sequence[CertificateCheck]) -> None:
    """Every run that is farther off than the law allows, so that it can be made again."""
    short = sorted((one for one in every if one.is_judged and LAW * one.overestimation < 1), key=lambda one: one.overestimation)
    print(f"{len(short)} runs are farther off than {LAW:g} times their estimate:\n")
    if short:
        print("| scene | engine | asked | ended | estimate | true error | what it is |\n|---|---|---|---|---|---|---|")
    for one in short:
        print(f"| {one.number} | {one.engine} | {one.accuracy:.1e} | {one.outcome} | {one.estimate:.1e} | {one.true:.1e} | {one.words} |")
    print()
    for one in every:
        if one.set_aside == "references disagree" and one.doubt > LAW * one.estimate:
            print(
                f"references disagree: {one.number} {one.engine} at {one.accuracy:.0e}, estimate {one.estimate:.1e}, "
                f"references {one.doubt:.1e} apart ({one.words})"
            )
    print()
    lost = [one for one in every if one.set_aside == TOO_LONG]
    told = "; ".join(f"{one.number} {one.engine} at {one.accuracy:.0e} ({one.words})" for one in lost)
    print(f"took longer than {LONGEST:g} s: {told or 'none'}")


# --- the picture ------------------------------------------------------------------------------------------------------


def draw(judged: Sequence[CertificateCheck], path: Path) -> None:
    """How estimate over true error is distributed, a curve for each engine."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import FuncFormatter, PercentFormatter

    from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT, SERIES_COLOURS, SERIF_FONT, VERMILLION

    figure, axes = pyplot.subplots(figsize=(8.4, 5.0), facecolor=PAPER)
    axes.set_facecolor(PAPER)
    low, high = 0.03, 3e4
    axes.axvspan(low, 1 / LAW, color=VERMILLION, alpha=0.10, linewidth=0)
    for place, words, align in (
        (1 / LAW, "error = 3 estimates", "right"),
        (1.0, "error = estimate", "left"),
        (100.0, "a hundred times too careful", "left"),
    ):
        axes.axvline(place, color=INK if place == 1.0 else MUTED, linewidth=0.9, dashes=(6, 3))
        shift = 0.93 if align == "right" else 1.07
        axes.text(
            place * shift, 1.025, words, ha=align, va="bottom", color=MUTED, fontsize=8.5, fontfamily=SANS_FONT,
            transform=axes.get_xaxis_transform(),
        )  # fmt: skip
    for engine, colour in zip(ENGINES, SERIES_COLOURS, strict=True):
        over = np.sort([min(max(one.overestimation, low), high) for one in judged if one.engine == engine])
        if not len(over):
            continue
        share = np.arange(1, len(over) + 1) / len(over)
        width = 1.3 if engine == "auto" else 2.0
        line = axes.step(
            np.concatenate([[low], over, [high]]), np.concatenate([[0.0], share, [1.0]]), where="post", color=colour,
            linewidth=width, label=f"{engine}: {len(over)} runs, median {np.median(over):.1f}",
        )[0]  # fmt: skip
        if engine == "auto":
            line.set_dashes((4, 2))
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.set_ylim(0.0, 1.0)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else "10 000"))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=" %"))
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("estimate / true error", color=INK, fontfamily=SANS_FONT, fontsize=9.5)
    axes.set_ylabel("share of runs at or below", color=INK, fontfamily=SANS_FONT, fontsize=9.5)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set(color=MUTED, fontfamily=SANS_FONT, fontsize=8.5)
    axes.tick_params(which="both", color=RULE)
    for spine in axes.spines.values():
        spine.set_color(RULE)
    scenes = len({one.number for one in judged})
    figure.text(0.09, 0.945, "What an accuracy estimate is worth", color=INK, fontfamily=SERIF_FONT, fontsize=17)
    figure.text(
        0.09, 0.905, f"{len(judged)} certified runs of {scenes} random scenes; true errors by another engine",
        color=MUTED, fontfamily=SANS_FONT, fontsize=9,
    )  # fmt: skip
    legend = axes.legend(loc="lower right", frameon=True, facecolor=PAPER, edgecolor=RULE, fontsize=9)
    for text in legend.get_texts():
        text.set(color=INK, fontfamily=SANS_FONT)
    figure.subplots_adjust(left=0.09, right=0.97, top=0.84, bottom=0.11)
    figure.savefig(path, dpi=130, facecolor=PAPER)
    pyplot.close(figure)


if __name__ == "__main__":
    main()
