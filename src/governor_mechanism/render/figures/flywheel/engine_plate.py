"""Plate of a run of an engine with a flywheel: tangential force and load, indicator diagrams, shaft speed, and stored work."""

import math

import numpy as np

from governor_mechanism.effects.gas_pressure import pressure_in_stroke
from governor_mechanism.machines.flywheel_engine.machine import expansion_gas
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.flywheel.indicator import draw_loop, finish_indicator_panel
from governor_mechanism.render.figures.page import CHAIN_DOTTED, Panel, Plate
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SKY, VERMILLION
from governor_mechanism.types import FloatArray

_CAPTIONS = {
    (0.03, 0.862): "Fig. 1.  Tangential force of the gas at the crank pin in the last turn, and load",
    (0.545, 0.862): "Fig. 2.  Indicator diagrams",
    (0.03, 0.462): "Fig. 3.  Speed of the shaft",
    (0.545, 0.462): "Fig. 4.  Work that the engine has stored since the start",
}
_FORCE_RECT, _SPEED_RECT, _WORK_RECT = (0.085, 0.555, 0.41, 0.275), (0.085, 0.125, 0.41, 0.305), (0.61, 0.125, 0.355, 0.305)
_INDICATOR_RECTS = (0.61, 0.555, 0.155, 0.275), (0.815, 0.555, 0.15, 0.275)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_N_CURVE_POINTS = 361
"""Number of points of an indicator diagram over a stroke."""

MAX_SURPLUS_RATIO = 0.05
"""Difference of force and load at an extreme speed, relative to the range of the force: the curve is drawn through samples."""

_PA_PER_BAR, _N_PER_KN, _J_PER_KJ = 1e5, 1e3, 1e3


def engine_plate_refusal(run: Trajectory) -> str:
    """Return why there is no plate of a run; empty if there is one.

    Parameters
    ----------
    run
        Run of an engine with a flywheel.

    Returns
    -------
    str
        The reason.
    """
    angles = run.readings["crank_angle"]
    return "" if len(angles) > 1 and angles[-1] - angles[0] >= math.tau else "the shaft makes no complete turn"


def draw_engine_plate(run: Trajectory) -> Plate:
    """Draw the plate of a run over a turn at least.

    Parameters
    ----------
    run
        Run of an engine with a flywheel.

    Returns
    -------
    Plate
        The figure; `save` writes it.
    """
    plate = Plate("Engine and flywheel", run.scene.title, f"engine {run.cost.engine}", _CAPTIONS)
    _draw_forces(plate.add_plate_panel(_FORCE_RECT, "Crank angle $\\varphi$ [deg]", "Tangential force [kN]"), run)
    for rect, (name, colour, gases), label in zip(_INDICATOR_RECTS, _cylinders(run), ("Pressure [bar]", " "), strict=False):
        _draw_indicator(plate.add_plate_panel(rect, "Piston travel [% of stroke]", label), run, name, colour, gases)
    _draw_over_turns(
        plate.add_plate_panel(_SPEED_RECT, "Turns of the crank [1]", "Shaft speed [rad/s]"), run, run.readings["shaft_speed"], GREEN
    )
    work = run.readings["stored_work"] / _J_PER_KJ
    _draw_over_turns(plate.add_plate_panel(_WORK_RECT, "Turns of the crank [1]", "Stored work [kJ]"), run, work, BLUE)
    plate.write_dimensions(_describe(run))
    return plate


def _describe(run: Trajectory) -> str:
    """Return the extreme speeds in the last turn, and what the machine notes about its cycle."""
    extremes = run.speed_fluctuations.get("crank_angle")
    dimensions = run.scene.part.dimensions
    text = f"flywheel {dimensions['inertia']:.5g} kg m²"
    if extremes:
        text += f";  last turn {extremes.lowest:.5g} to {extremes.highest:.5g} rad/s, coefficient {extremes.coefficient:.4g}"
    closing = [note.split(";")[0] for note in run.scene.part.mechanism.notes]
    return ";  ".join([text, *closing])


def _draw_forces(panel: Panel, run: Trajectory) -> None:
    """Draw the tangential force in the last turn over its crank angle, the load, and where the shaft gains speed."""
    angles = run.readings["crank_angle"]
    last = angles >= angles[-1] - math.tau
    turn_angles = np.mod(np.degrees(angles[last]), 360.0)
    order = np.argsort(turn_angles)
    crank = 0.5 * run.scene.part.dimensions["stroke"] * _N_PER_KN
    degrees, force, load = (
        values[order] for values in (turn_angles, *(run.readings[f"{name}_torque"][last] / crank for name in ("gas", "load")))
    )
    panel.fill_between(degrees, load, force, where=(force > load).tolist(), color=SKY, alpha=0.45, linewidth=0, zorder=2)
    panel.plot(degrees, force, color=BLUE, linewidth=2.0, zorder=4)
    panel.plot(degrees, load, color=VERMILLION, linewidth=1.5, zorder=3)
    low, high = float(min(force.min(), load.min())), float(force.max())
    panel.set(xlim=(0, 360), ylim=(low - 0.08 * (high - low), high + 0.18 * (high - low)), xticks=range(0, 361, 60))
    panel.annotate_point((356, float(load[-1])), "load", (0, 5), ha="right", color=VERMILLION)
    for extremes in run.speed_fluctuations.values():
        for angle, letter, offset in ((extremes.lowest_angle, "\\alpha", (8, -15)), (extremes.highest_angle, "\\beta", (9, 6))):
            at = math.degrees(angle) % 360
            point, surplus = (at, float(np.interp(at, degrees, load))), float(np.interp(at, degrees, force - load))
            if abs(surplus) > MAX_SURPLUS_RATIO * (high - low):
                continue  # the turn ends there, and the speed has no extreme
            panel.plot(*point, "o", color=INK, markerfacecolor=PAPER, markersize=6, zorder=6)
            panel.annotate_point(point, f"${letter}$ = {at:.4g}°", offset)


def _cylinders(run: Trajectory) -> list[tuple[str, str, tuple[CylinderGas, ...]]]:
    """Return name, colour and gas of each cylinder, with throttle and cut-off of the last stroke."""
    gases = {element.name: element for element in run.scene.part.mechanism.force_elements if isinstance(element, CylinderGas)}
    opening = run.readings["throttle_opening"][-1] if "throttle_opening" in run.readings else 1.0
    expansion = expansion_gas(run.scene.part.mechanism, float(opening), float(run.readings["cut_off"][-1]))
    cylinders = [("expansion cylinder", BLUE, (expansion,))]
    return cylinders + ([("compression pump", VERMILLION, (gases["suction"], gases["delivery"]))] if "suction" in gases else [])


def _draw_indicator(panel: Panel, run: Trajectory, name: str, colour: str, gases: tuple[CylinderGas, ...]) -> None:
    """Draw the pressure on one face of a piston over a turn."""
    travel = np.linspace(0.0, 1.0, _N_CURVE_POINTS)
    outward = pressure_in_stroke(gases[0], travel)
    homeward = np.full_like(travel, gases[0].back_pressure) if len(gases) == 1 else pressure_in_stroke(gases[1], 1 - travel)
    draw_loop(panel, 100 * travel, outward / _PA_PER_BAR, homeward / _PA_PER_BAR, colour)
    dimensions = run.scene.part.dimensions
    finish_indicator_panel(panel, dimensions["supply_pressure"], dimensions["atmospheric_pressure"], name, colour)


def _draw_over_turns(panel: Panel, run: Trajectory, values: FloatArray, colour: str) -> None:
    """Draw a reading over the turns of the crank, with its values at whole turns, which show whether the motion is periodic."""
    turns = run.readings["crank_angle"] / math.tau
    panel.plot(turns, values, color=colour, linewidth=1.8, zorder=4)
    whole = np.arange(math.ceil(turns[0] - 1e-9), math.floor(turns[-1]) + 1)  # rounding at the start
    panel.plot(
        whole, np.interp(whole, turns, values), color=MUTED, linewidth=0.9, linestyle=CHAIN_DOTTED, marker="o", markersize=4, zorder=5
    )
    panel.set(xlim=(float(turns[0]), float(turns[-1])))
