"""The errata of all papers as one result, which prints as tables, and what the simulation says of some of them."""

import math
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.papers.dubois import list_dubois_errata
from governor_mechanism.papers.erratum import CAUSE_NOUNS, PAPER_REFERENCES, Erratum, Paper, check_cause, check_paper, list_marks_errata
from governor_mechanism.papers.redtenbacher import list_redtenbacher_errata
from governor_mechanism.papers.zehnder import LONGER, PROBE_ANGLE_DEG, SHORTER, list_zehnder_errata
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.design.flywheel import compare_with_paper, design_flywheel
from governor_mechanism.studies.design.hartung import PAPER_INPUTS
from governor_mechanism.studies.design.pendulum import PendulumDesign, design_pendulum
from governor_mechanism.studies.design.simulated import simulate_wheels
from governor_mechanism.studies.design.skeleton import Cause
from governor_mechanism.studies.valve_gears import tabulate_valve_timing
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.text_table import short_repr

PROBE_RESISTANCE = 40.0
"""Resistance at the sleeve, N, from whose band of speed the static sleeve force follows; the result does not depend on it."""

N_STROKE_POINTS = 61
"""Positions of the lever over its stroke, both ends among them, where the static sleeve force is largest or smallest."""


def simulate_flywheels() -> str:
    """Run the engine with the wheel of the printed number, and with the one that its closed cycle needs."""
    wheels = simulate_wheels(design_flywheel(), compare_with_paper())
    light, right = wheels[0], wheels[-1]
    return (
        f"with the wheel of the printed number, {light.inertia:.0f} kg m2, the speed fluctuates by {100 * light.coefficient:.2f} %, "
        f"{light.excess:.2f} times the {100 * light.allowed:.2f} % allowed; with {right.inertia:.0f} kg m2 it fluctuates by "
        f"{100 * right.coefficient:.2f} %"
    )


def simulate_sleeve_forces() -> str:
    """Return how much the sleeve force of both governors changes over the stroke, by the band of speed of a resistance."""
    used, right = (_spread_of_sleeve_force(name) for name in ("hartung_dubois", "hartung_corrected"))
    return (
        f"the static sleeve force changes by {100 * used:.2f} % over the stroke with 132 deg and the spring of the paper, by "
        f"{100 * right:.2f} % with 137.332 deg"
    )


def _spread_of_sleeve_force(name: str) -> float:
    """Return the range of the static sleeve force S over its mean; S = 2 W w^2 / (w'^2 - w''^2) with the resistance W."""
    scene = load_scene(name)
    lever_angles = np.linspace(-PAPER_INPUTS.swing, PAPER_INPUTS.swing, N_STROKE_POINTS)
    band = compute_insensitivity_band(scene, lever_angles, PROBE_RESISTANCE)
    rising, falling = band.rising_speed**2, band.falling_speed**2
    force = PROBE_RESISTANCE * (rising + falling) / (rising - falling)
    return float(np.ptp(force) / np.mean(force))


def simulate_osculating_circle() -> str:
    """Return the speeds of rest beside the point of osculation, with an arm as long as the radius of curvature."""
    return _describe_speeds(1.0)


def simulate_longer_arm() -> str:
    """Return the speeds of rest beside the point of osculation, with a longer arm."""
    return _describe_speeds(LONGER)


def simulate_shorter_arm() -> str:
    """Return the speeds of rest beside the point of osculation, with a shorter arm."""
    return _describe_speeds(SHORTER)


def _describe_speeds(arm_ratio: float) -> str:
    down, start, up = simulated_speeds(design_pendulum(), arm_ratio, np.array([-PROBE_ANGLE_DEG, 0.0, PROBE_ANGLE_DEG])) / RPM
    return (
        f"with l = {arm_ratio:g} rho the speed of rest is {down:.3f} rpm {PROBE_ANGLE_DEG:g} deg below the point of osculation, "
        f"{start:.3f} rpm at it, and {up:.3f} rpm {PROBE_ANGLE_DEG:g} deg above it"
    )


def simulated_speeds(
    design: PendulumDesign,
    arm_ratio: float,  # arm over the radius of curvature; point and slope stay
    degrees: FloatArray,  # angles through which the arm has turned up, deg; shape (n,)
) -> FloatArray:
    """Return the speeds of rest (n,) by the statics of the simulated governor beside the point of osculation."""
    start = design.start
    arm = arm_ratio * start.radius_of_curvature
    governor = design.governor
    document = {
        "title": "Governor beside the point of osculation",
        "machine": "pendulum_governor",
        "dimensions": {
            "arm": arm,
            "offset": start.abscissa - arm * math.sin(start.arm_angle),
            "ball_mass": governor.ball_mass,
            "sleeve_mass": governor.sleeve_mass,
        },
        "effects": {"gravity": f"{governor.gravity:.15g} m/s^2", "centrifugal": True},
        "spindle": {"speed": design.requirement.lowest_speed},
        "start": {"arm_angle": start.arm_angle},
        "run": {"duration": 1.0, "output_interval": 0.1, "accuracy": 1e-6},
    }
    angles = start.arm_angle + np.radians(degrees)
    return np.asarray(compute_controlling_force(parse_scene_document(document), angles).speed)


def simulate_valve() -> str:
    """Return the delays of release and compression at both ends of the cylinder, by the simulated valve gear."""
    shifts = {row.name: math.degrees(row.shift) for row in tabulate_valve_timing(load_scene("slide_valve_marks")).rows}
    return "; ".join(
        f"{end}: release {shifts[f'{end} release']:+.2f} deg, compression {shifts[f'{end} compression']:+.2f} deg"
        for end in ("crank end", "head end")
    )


SIMULATIONS: Mapping[tuple[Paper, str], Callable[[], str]] = {
    (Paper.REDTENBACHER, "flywheel"): simulate_flywheels,
    (Paper.DUBOIS, "bell-crank-angle"): simulate_sleeve_forces,
    (Paper.ZEHNDER, "osculating-circle"): simulate_osculating_circle,
    (Paper.ZEHNDER, "longer-arm"): simulate_longer_arm,
    (Paper.ZEHNDER, "shorter-arm"): simulate_shorter_arm,
    (Paper.MARKS, "cylinder-ends"): simulate_valve,
}
"""Functions that return a sentence, by paper and name of the erratum."""


TEXT_WIDTH = 130
"""Letters of a line of text."""


@dataclass(frozen=True, kw_only=True)
class Errata(Result):
    """Errata of one paper or of all.

    Attributes
    ----------
    errata
        The errata, by paper; in a paper by cause, in the order of the causes.
    """

    errata: tuple[Erratum, ...]

    __repr__ = short_repr

    figure_set = "papers.errata_drawings.errata_figures"
    record = ("counts", "errata=rows")
    columns = (
        Column("paper"),
        Column("name", "erratum"),
        *(Column(name) for name in ("place", "subject")),
        *(Column(name, name) for name in ("cause", "printed", "right")),
        *(Column(name) for name in ("proof", "command", "consequence", "quotation", "translation", "unit")),
        *(Column(name) for name in ("printed_value", "printed_digits", "right_value", "simulated")),
    )

    @property
    def rows(self) -> tuple[Erratum, ...]:
        """The errata, which are the rows of tables."""
        return self.errata

    @property
    def counts(self) -> dict[str, int]:
        """Number of errata by the name of the cause."""
        return {cause.value: number for cause, number in self.count_causes().items()}

    def __iter__(self) -> Iterator[Erratum]:
        """Return the errata in their order."""
        return iter(self.errata)

    def __len__(self) -> int:
        """Return the number of errata."""
        return len(self.errata)

    @property
    def papers(self) -> tuple[Paper, ...]:
        """The papers that have errata here, in their order."""
        return tuple(dict.fromkeys(erratum.paper for erratum in self))

    def select(self, paper: str, cause: str | None = None) -> tuple[Erratum, ...]:
        """Return the errata of a paper, of one cause or of all.

        Parameters
        ----------
        paper
            The paper, or its name.
        cause
            The cause, or its name; None for all.

        Returns
        -------
        tuple of Erratum
            The errata in their order.

        Raises
        ------
        MechanismError
            If there is no such paper or cause.
        """
        wanted = set(Cause) if cause is None else {check_cause(cause)}
        source = check_paper(paper)
        return tuple(one for one in self if one.paper is source and one.cause in wanted)

    def count(self, cause: str) -> int:
        """Return the number of errata of a cause.

        Parameters
        ----------
        cause
            The cause, or its name.

        Returns
        -------
        int
            The number.

        Raises
        ------
        MechanismError
            If there is no such cause.
        """
        wanted = check_cause(cause)
        return sum(erratum.cause is wanted for erratum in self)

    def count_causes(self) -> dict[Cause, int]:
        """Return the number of errata of every cause.

        Returns
        -------
        dict of Cause to int
            The numbers, in the order of the causes.
        """
        return {cause: self.count(cause) for cause in Cause}

    def describe_counts(self) -> str:
        """Return the counts of the causes that there are, in words.

        Returns
        -------
        str
            The counts, as "1 error, 8 misprints and 1 small slip".
        """
        counts = [(number, CAUSE_NOUNS[cause]) for cause, number in self.count_causes().items() if number]
        words = [f"{number} {noun}{'s' * (number > 1)}" for number, noun in counts]
        return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))

    def __str__(self) -> str:
        """Return for each paper a table of its errata, and below it the proof of each and the command that shows it."""
        last = f"{len(self)} errata: {self.describe_counts()}"
        return "\n\n".join([*(self._format_paper(paper) for paper in self.papers), last])

    def _format_paper(self, paper: Paper) -> str:
        errata = self.select(paper)
        table = format_columns(self.columns, errata)
        return "\n".join([PAPER_REFERENCES[paper], "", table, "", *map(_format_reasons, errata)])


def _format_reasons(erratum: Erratum) -> str:
    """Return proof, consequence and simulation of an erratum, and the command that shows it."""
    text = f"{erratum.reasons()} [{erratum.command}]"
    wrapping: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return textwrap.fill(f"{erratum.name} ({erratum.place}; {erratum.subject}): {text}", TEXT_WIDTH, subsequent_indent="    ", **wrapping)


LISTS: Mapping[Paper, Callable[[], Iterator[Erratum]]] = {
    Paper.REDTENBACHER: list_redtenbacher_errata,
    Paper.ZEHNDER: list_zehnder_errata,
    Paper.MARKS: list_marks_errata,
    Paper.DUBOIS: list_dubois_errata,
}
"""Function that recomputes the errata of a paper, by paper in the order of the years."""


def collect_errata(
    paper: str | None = None,  # name of a paper; None for all
    *,
    simulate: bool = False,  # whether to simulate the machines that show the main errors
) -> Errata:
    """Recompute the errata of a paper or of all, of each paper by cause, then in the order of its list."""
    papers = LISTS if paper is None else (check_paper(paper),)
    ranks = {cause: rank for rank, cause in enumerate(Cause)}
    errata = (erratum for one in papers for erratum in sorted(LISTS[one](), key=lambda erratum: ranks[erratum.cause]))
    return Errata(errata=tuple(_simulated(erratum) if simulate else erratum for erratum in errata))


def _simulated(erratum: Erratum) -> Erratum:
    """Return an erratum with what the simulation finds."""
    simulation = SIMULATIONS.get((erratum.paper, erratum.name))
    return erratum if simulation is None else replace(erratum, simulated=simulation())
