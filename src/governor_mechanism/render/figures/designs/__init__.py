"""The figures of designs by the machine."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from governor_mechanism.render.figures.designs.engines import draw_flywheel_plate, governed_engine_figure
from governor_mechanism.render.figures.designs.governors import hartnell_figure, pendulum_figure, sleeve_force_figure, spring_lines_figure
from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.figures.plates.isochronous import has_isochronous_parabolas, isochronous_figure
from governor_mechanism.studies.design.hartung import HartungDesign, design_hartung
from governor_mechanism.studies.design.pendulum import PendulumDesign
from governor_mechanism.studies.design.simulated import DesignReport, SimulatedPendulum, report_design
from governor_mechanism.studies.design.skeleton import Design


def _hartung_figures(design: HartungDesign, _: object, paper: object) -> dict[str, Page]:
    """Draw the spring lines and the spread of the sleeve force; of the paper's design, its spring lines at 132 deg."""
    is_paper = paper is not None
    drawn = design_hartung(replace(design.inputs, angle=math.radians(132), sleeve_arm=0.170)) if is_paper else design
    lines = spring_lines_figure(drawn, with_printed_points=is_paper)
    return {"hartung_spring_lines": lines, "hartung_sleeve_force": sleeve_force_figure(design)}


def _pendulum_figures(design: PendulumDesign, simulated: SimulatedPendulum, _: object) -> dict[str, Page]:
    """Draw the design, and if its path osculates a parabola Zehnder's plate of them, which then starts in the lowest position."""
    figures: dict[str, Page] = {"pendulum_design": pendulum_figure(design, simulated)}
    if design.is_osculating and has_isochronous_parabolas(design.scene):
        figures["pendulum_design_parabolas"] = isochronous_figure(design.scene)
    return figures


_FIGURES: Mapping[str, Callable[[Any, Any, Any], Mapping[str, Page]]] = {
    "flywheel": lambda design, simulated, paper: {"flywheel_design": draw_flywheel_plate(design, simulated, paper)},
    "governed_engine": lambda design, simulated, _: {"governed_engine_design": governed_engine_figure(design, simulated)},
    "hartnell": lambda design, *_: {"hartnell_design": hartnell_figure(design)},
    "hartung": _hartung_figures,
    "pendulum": _pendulum_figures,
}


def simulated_figures(design: Design) -> Mapping[str, Page]:
    """Simulate a design, and draw its figures, by the names of their files without ending."""
    return design_figures(report_design(design))


def design_figures(report: DesignReport) -> Mapping[str, Page]:
    """Draw the figures of a design, by the names of their files without ending."""
    return _FIGURES[report.design.machine](report.design, report.simulated, report.paper)
