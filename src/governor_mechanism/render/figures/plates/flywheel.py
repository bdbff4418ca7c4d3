"""Plate of a run of an engine with a flywheel: tangential force and load, indicator diagrams, shaft speed, and stored work."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.gas_pressure import pressure_in_stroke
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import CHAIN_DOTTED, Panel, Plate
from governor_mechanism.render.machines.flywheel_engine import expansion_gas
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SKY, VERMILLION
from governor_mechanism.types import BoolArray, FloatArray

_CAPTION_PLACES = ((0.03, 0.862), (0.545, 0.862), (0.03, 0.462), (0.545, 0.462))
"""Left and lower ends of the captions, in fractions of the plate."""

SPEED_RECT, FOURTH_RECT = (0.085, 0.125, 0.41, 0.305), (0.61, 0.125, 0.355, 0.305)
_FORCE_RECT, _INDICATOR_RECTS = (0.085, 0.555, 0.41, 0.275), ((0.61, 0.555, 0.155, 0.275), (0.815, 0.555, 0.15, 0.275))
"""Left and lower edge, width and height of the panels, in fractions of the plate."""

PA_PER_BAR, N_PER_KN = 1e5, 1e3


class EnginePlate(Plate):
    """Plate with four figures: tangential force, indicator diagrams, shaft speed, and one more."""

    def __init__(self, heading: str, title: str, source: str, captions: Sequence[str]) -> None:
        numbered = (f"Fig. {number}.  {caption}" for number, caption in enumerate(captions, start=1))
        super().__init__(heading, title, source, dict(zip(_CAPTION_PLACES, numbered, strict=True)))

    def add_force_panel(
        self, degrees: FloatArray, force: FloatArray, load: FloatArray, is_shaded: BoolArray, limit: int
    ) -> tuple[Panel, float, float]:
        """Draw a tangential force (kN) over the crank angle (deg), shaded to the load; return the panel and the range of the forces."""
        panel = self.add_plate_panel(_FORCE_RECT, "Crank angle $\\varphi$ [deg]", "Tangential force [kN]")
        panel.fill_between(degrees, load, force, where=is_shaded.tolist(), color=SKY, alpha=0.45, linewidth=0, zorder=2)
        panel.plot(degrees, force, color=BLUE, linewidth=2.0, zorder=4)
        low, high = float(min(force.min(), load.min())), float(force.max())
        margins = low - 0.08 * (high - low), high + 0.18 * (high - low)
        panel.set(xlim=(0, limit), ylim=margins, xticks=range(0, limit + 1, limit // 6))
        return panel, low, high

    def add_indicator(
        self, index: int, name: str, colour: str, travel: FloatArray, upper: FloatArray, lower: FloatArray, pressures: tuple[float, float]
    ) -> Panel:
        """Draw a loop of pressures (Pa) over travels (fractions of the stroke), of a cylinder between supply and atmosphere (Pa)."""
        label = "Pressure [bar]" if index == 0 else " "
        panel = self.add_plate_panel(_INDICATOR_RECTS[index], "Piston travel [% of stroke]", label)
        travel, upper, lower = 100 * travel, upper / PA_PER_BAR, lower / PA_PER_BAR
        highest, atmosphere = (pressure / PA_PER_BAR for pressure in pressures)
        panel.fill_between(travel, lower, upper, color=colour, alpha=0.13, linewidth=0, zorder=2)
        loop = np.concatenate([travel, travel[::-1], travel[:1]]), np.concatenate([upper, lower[::-1], upper[:1]])
        panel.plot(*loop, color=colour, linewidth=1.8, zorder=4)
        panel.axhline(atmosphere, color=MUTED, linewidth=0.8, linestyle=CHAIN_DOTTED, zorder=1)
        panel.set(xlim=(-3, 103), ylim=(0, 1.22 * highest), xticks=(0, 25, 50, 75, 100))
        panel.annotate_point((50, 1.12 * highest), name, ha="center", color=colour, fontstyle="italic")
        panel.annotate_point((101, atmosphere), "atmosphere", (0, -12), ha="right", fontsize=9, color=MUTED)
        return panel


def mark_extreme(panel: Panel, point: tuple[float, float], text: str, offset: tuple[float, float], zorder: float | None = None) -> None:
    """Mark a point of extreme speed with its angle."""
    panel.plot(*point, "o", color=INK, markerfacecolor=PAPER, markersize=6, zorder=zorder)
    panel.annotate_point(point, text, offset)


_CAPTIONS = (
    "Tangential force of the gas at the crank pin in the last turn, and load",
    "Indicator diagrams",
    "Speed of the shaft",
    "Work that the engine has stored since the start",
)

_N_CURVE_POINTS = 361
"""Number of points of an indicator diagram over a stroke."""

MAX_SURPLUS_RATIO = 0.05
"""Difference of force and load at an extreme speed, relative to the range of the force: the curve is drawn through samples."""

_J_PER_KJ = 1e3


def engine_plate_refusal(run: Trajectory) -> str:
    """Return why there is no plate of a run; empty if there is one."""
    angles = run.readings["crank_angle"]
    return "" if len(angles) > 1 and angles[-1] - angles[0] >= math.tau else "the shaft makes no complete turn"


def draw_engine_plate(run: Trajectory) -> Plate:
    """Draw the plate of a run over a turn at least; `save` writes it."""
    plate = EnginePlate("Engine and flywheel", run.scene.title, f"engine {run.cost.engine}", _CAPTIONS)
    _draw_forces(plate, run)
    for index, (name, colour, gases) in enumerate(_cylinders(run)):
        _draw_indicator(plate, index, run, name, colour, gases)
    speed_panel = plate.add_plate_panel(SPEED_RECT, "Turns of the crank [1]", "Shaft speed [rad/s]")
    _draw_over_turns(speed_panel, run, run.readings["shaft_speed"], GREEN)
    work_panel = plate.add_plate_panel(FOURTH_RECT, "Turns of the crank [1]", "Stored work [kJ]")
    _draw_over_turns(work_panel, run, run.readings["stored_work"] / _J_PER_KJ, BLUE)
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


def _draw_forces(plate: EnginePlate, run: Trajectory) -> None:
    """Draw the tangential force in the last turn over its crank angle, the load, and where the shaft gains speed."""
    angles = run.readings["crank_angle"]
    last = angles >= angles[-1] - math.tau
    turn_angles = np.mod(np.degrees(angles[last]), 360.0)
    order = np.argsort(turn_angles)
    crank = 0.5 * run.scene.part.dimensions["stroke"] * N_PER_KN
    degrees, force, load = (
        values[order] for values in (turn_angles, *(run.readings[f"{name}_torque"][last] / crank for name in ("gas", "load")))
    )
    panel, low, high = plate.add_force_panel(degrees, force, load, force > load, 360)
    panel.plot(degrees, load, color=VERMILLION, linewidth=1.5, zorder=3)
    panel.annotate_point((356, float(load[-1])), "load", (0, 5), ha="right", color=VERMILLION)
    for extremes in run.speed_fluctuations.values():
        for angle, letter, offset in ((extremes.lowest_angle, "\\alpha", (8, -15)), (extremes.highest_angle, "\\beta", (9, 6))):
            at = math.degrees(angle) % 360
            point, surplus = (at, float(np.interp(at, degrees, load))), float(np.interp(at, degrees, force - load))
            if abs(surplus) > MAX_SURPLUS_RATIO * (high - low):
                continue  # the turn ends there, and the speed has no extreme
            mark_extreme(panel, point, f"${letter}$ = {at:.4g}°", offset, zorder=6)


def _cylinders(run: Trajectory) -> list[tuple[str, str, tuple[CylinderGas, ...]]]:
    """Return name, colour and gas of each cylinder, with throttle and cut-off of the last stroke."""
    gases = {element.name: element for element in run.scene.part.mechanism.force_elements if isinstance(element, CylinderGas)}
    opening = run.readings["throttle_opening"][-1] if "throttle_opening" in run.readings else 1.0
    expansion = expansion_gas(gases, float(opening), float(run.readings["cut_off"][-1]))
    cylinders = [("expansion cylinder", BLUE, (expansion,))]
    return cylinders + ([("compression pump", VERMILLION, (gases["suction"], gases["delivery"]))] if "suction" in gases else [])


def _draw_indicator(plate: EnginePlate, index: int, run: Trajectory, name: str, colour: str, gases: tuple[CylinderGas, ...]) -> None:
    """Draw the pressure on one face of a piston over a turn."""
    travel = np.linspace(0.0, 1.0, _N_CURVE_POINTS)
    outward = pressure_in_stroke(gases[0], travel)
    homeward = np.full_like(travel, gases[0].back_pressure) if len(gases) == 1 else pressure_in_stroke(gases[1], 1 - travel)
    dimensions = run.scene.part.dimensions
    pressures = dimensions["supply_pressure"], dimensions["atmospheric_pressure"]
    plate.add_indicator(index, name, colour, travel, outward, homeward, pressures)


def _draw_over_turns(panel: Panel, run: Trajectory, values: FloatArray, colour: str) -> None:
    """Draw a reading over the turns of the crank, with its values at whole turns, which show whether the motion is periodic."""
    turns = run.readings["crank_angle"] / math.tau
    panel.plot(turns, values, color=colour, linewidth=1.8, zorder=4)
    whole = np.arange(math.ceil(turns[0] - 1e-9), math.floor(turns[-1]) + 1)  # rounding at the start
    panel.plot(
        whole, np.interp(whole, turns, values), color=MUTED, linewidth=0.9, linestyle=CHAIN_DOTTED, marker="o", markersize=4, zorder=5
    )
    panel.set(xlim=(float(turns[0]), float(turns[-1])))
