"""Plates of runs of engines: force and load, indicator diagrams, speed and stored work with a flywheel; forces at bearings."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from governor_mechanism.closed_form.slider_crank import BearingLoads, CrankTrain, bearing_loads, crosshead_distance
from governor_mechanism.effects.gas_pressure import pressure_in_stroke
from governor_mechanism.effects.masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import (
    CHAIN_DOTTED,
    DASHED,
    LABEL_DIRECTIONS,
    PLATE_HEIGHT,
    PLATE_WIDTH,
    SERIES_LINE_STYLES,
    SERIES_MARKERS,
    LabelPlacer,
    Panel,
    Plate,
    add_legend,
    polar_points,
)
from governor_mechanism.render.machines.flywheel_engine import expansion_gas
from governor_mechanism.render.shown_readings import choose_multiple
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SERIF_FONT, SKY, STEEL, VERMILLION
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.verification.machines.slider_crank import build_crank_train

_CAPTION_PLACES = ((0.03, 0.862), (0.545, 0.862), (0.03, 0.462), (0.545, 0.462))
"""Left and lower ends of the captions, in fractions of the plate."""

SPEED_RECT = (0.085, 0.125, 0.41, 0.305)
FOURTH_RECT = (0.61, 0.125, 0.355, 0.305)
_FORCE_RECT = (0.085, 0.555, 0.41, 0.275)
_INDICATOR_RECTS = ((0.61, 0.555, 0.155, 0.275), (0.815, 0.555, 0.15, 0.275))
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
        travel = 100 * travel
        upper = upper / PA_PER_BAR
        lower = lower / PA_PER_BAR
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


_FLYWHEEL_CAPTIONS = (
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
    plate = EnginePlate("Engine and flywheel", run.scene.title, f"engine {run.cost.engine}", _FLYWHEEL_CAPTIONS)
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
            point = (at, float(np.interp(at, degrees, load)))
            surplus = float(np.interp(at, degrees, force - load))
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


_LABEL_INTERVAL_DEG, _SHOWN_ANGLE_DEG = 30, 300
"""Crank angle between labelled markers, and crank angle of the drawn engine (deg)."""

_CAPTIONS = {
    (0.03, 0.862): "Fig. 1.  Forces of frame on crank, crank on rod, rod on crosshead, and crank angles",
    (0.605, 0.862): "Fig. 3.  Drive torque",
    (0.605, 0.452): "Fig. 4.  Guide force on the crosshead",
}
_ENGINE_CAPTION = f"Fig. 2.  The same at {_SHOWN_ANGLE_DEG} degrees, as arrows at the loaded parts"
_FORCES_RECT, _ENGINE_RECT = (0.072, 0.37, 0.49, 0.43), (0.03, 0.085, 0.54, 0.2)
_MIN_FORCES_HEIGHT = 0.2
"""Place of the loci and of the engine, in fractions of the figure: flat loci leave height to the engine, down to a minimum."""
_TORQUE_RECT = (0.655, 0.545, 0.30, 0.285)
_GUIDE_RECT = (0.655, 0.135, 0.30, 0.285)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_DIGIT_WIDTH, _N_DIGITS_WITHOUT_SHIFT = 0.008, 2
"""Width of a digit of the ordinate labels, as a fraction of the figure; number of digits that fit without moving the axes."""

_KILO_PER_UNIT = 1e-3

_MIN_FULL_TURN = math.tau * (1 - 1e-9)
"""Smallest crank rotation (rad) that counts as a whole turn; the margin allows for rounding."""

_MIN_FORCE_SCALE_KN = 1e-3
"""Smallest force scale (kN); a balanced crank without moving masses has zero force."""

_MAX_ARROW_LENGTH = 1.3
"""Length of the longest arrow, in crank radii."""


def bearing_loads_figure(run: Trajectory) -> Plate:
    """Return the plate of the bearing loads of a slider crank; raise MechanismError for a run without masses or a whole turn."""
    if refusal := bearing_loads_refusal(run):
        raise MechanismError(refusal)
    crank_train = build_crank_train(run.scene)
    speed = run.scene.part.dimensions["crank_speed"]
    crank_angles = np.linspace(0.0, math.tau, 721)
    exact = bearing_loads(crank_train, crank_angle=crank_angles, crank_rate=speed, gravity=run.scene.gravity)
    first_turn = run.readings["crank_angle"] <= run.scene.part.dimensions["crank_start"] + math.tau
    gain = _FORCES_RECT[3] - _choose_height(exact)
    captions = {**_CAPTIONS, (0.03, 0.292 + gain): _ENGINE_CAPTION}
    plate = Plate("Bearing loads of a slider crank", run.scene.title, "from inertia and weight, at constant crank speed", captions)
    force_labels = "Force along the line of the crosshead [kN]", "Force across it [kN]"
    left, bottom, width, height = _FORCES_RECT
    forces_rect = (left, bottom + gain, width, height - gain)
    engine_rect = (*_ENGINE_RECT[:3], _ENGINE_RECT[3] + gain)
    _draw_force_loci(plate.add_plate_panel(forces_rect, *force_labels), run, exact, first_turn)
    _draw_engine(plate.add_plate_panel(engine_rect), crank_train, exact)
    angles = np.degrees(run.readings["crank_angle"][first_turn] % math.tau)
    drive = run.reactions["drive"].moment[first_turn]
    guide = run.reactions["crosshead guide"].force[first_turn, 1]
    degrees = np.degrees(crank_angles)
    angle_label = "Crank angle from the outer dead centre [deg]"
    unit, factor = choose_multiple("N m", exact.torque)
    torque_panel = plate.add_plate_panel(_TORQUE_RECT, angle_label, f"Torque [{unit}]")
    _draw_load_curve(torque_panel, (angles, drive * factor), (degrees, exact.torque * factor))
    guide_panel = plate.add_plate_panel(_GUIDE_RECT, angle_label, "Force upward [kN]")
    _draw_load_curve(guide_panel, (angles, guide * _KILO_PER_UNIT), (degrees, exact.guide * _KILO_PER_UNIT))
    plate.write_dimensions(
        f"crank $R$ = {crank_train.crank * 1e3:.4g} mm, {crank_train.crank_mass:.4g} kg at {crank_train.crank_centre * 1e3:.4g} mm;  rod "
        f"$L$ = {crank_train.rod * 1e3:.5g} mm, {crank_train.rod_mass:.4g} kg at {crank_train.rod_centre * 1e3:.4g} mm;  crosshead "
        f"{crank_train.crosshead_mass:.4g} kg;  {speed / RPM:.4g} rpm.  Curves: closed form, points: engine {run.cost.engine}; "
        "dashed: the mean",
        size=9.5,
    )
    return plate


def bearing_loads_refusal(run: Trajectory) -> str:
    """Return why the plate cannot show a run, or an empty string."""
    part = run.scene.part
    has_masses = any(isinstance(effect, CrankMasses) for effect in run.scene.effects)
    if part.machine != "slider_crank" or not has_masses or part.mechanism.force_elements or run.scene.output_effects:
        return (
            "bearing loads need machine 'slider_crank' with effects.masses, and no output effects or force elements; "
            f"this scene has machine {part.machine!r}; the closed form knows no other loads"
        )
    if not len(run.times) or np.ptp(run.readings["crank_angle"]) < _MIN_FULL_TURN:
        return "bearing loads need a run of a whole turn of the crank, and this run is shorter; increase run.duration"
    return ""


def _choose_height(exact: BearingLoads) -> float:
    """Return the height of the panel of the loci, in fractions of the figure: as flat as they are, to one scale on both axes."""
    ranges = np.ptp(np.concatenate([force for _, force, _ in _bearing_forces(exact)]), axis=0)
    flatness = (ranges[1] + 0.24 * max(ranges)) / max(1.24 * ranges[0], _MIN_FORCE_SCALE_KN)
    _, _, width, height = _FORCES_RECT
    return float(np.clip(width * PLATE_WIDTH / PLATE_HEIGHT * flatness, _MIN_FORCES_HEIGHT, height))


def _bearing_forces(exact: BearingLoads) -> tuple[tuple[str, FloatArray, str], ...]:
    """Return the name of each bearing, the force on its loaded part over a turn, and its colour."""
    return ("shaft", exact.main, BLUE), ("crank pin", exact.crank_pin, VERMILLION), ("gudgeon", exact.gudgeon, GREEN)


def _draw_force_loci(panel: Panel, run: Trajectory, exact: BearingLoads, first_turn: NDArray[np.bool_]) -> None:
    """Draw each force over a turn as a locus in the plane (kN): points of the run on the curve of the closed form."""
    panel.axhline(0, color=MUTED, linewidth=0.7, zorder=1)
    panel.axvline(0, color=MUTED, linewidth=0.7, zorder=1)
    curves = {name: (force * _KILO_PER_UNIT, colour) for name, force, colour in _bearing_forces(exact) if name in run.reactions}
    _show_forces(panel, np.concatenate([force for force, _ in curves.values()]))
    placer = LabelPlacer(panel, [force for force, _ in curves.values()])
    handles = []
    for (name, (force, colour)), line_style, marker in zip(curves.items(), SERIES_LINE_STYLES, SERIES_MARKERS, strict=False):
        panel.plot(*force.T, color=colour, linewidth=1.8, linestyle=line_style, zorder=3)
        simulated = run.reactions[name].force[first_turn] * _KILO_PER_UNIT
        panel.plot(simulated[::4, 0], simulated[::4, 1], "o", color=colour, markersize=2.6, zorder=4)
        for degree in range(0, 360, _LABEL_INTERVAL_DEG):
            point = force[2 * degree]
            panel.plot(*point, marker, color=colour, markeredgecolor=PAPER, markersize=6, zorder=5)
            if name == "shaft" or degree == 0:
                x, y = point
                placer.place_label(f"{degree}°", x, y, MUTED if name == "shaft" else colour, 8.5, LABEL_DIRECTIONS)
        handles.append(Line2D([], [], color=colour, linewidth=1.8, linestyle=line_style, marker=marker, markersize=5, label=name))
    position: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.99), "ncols": len(handles), "borderaxespad": 0.0}
    add_legend(panel, {"fontfamily": SERIF_FONT, "fontsize": 10.5, "color": INK}, handles=handles, handlelength=3.4, **position)


def _show_forces(panel: Panel, forces: FloatArray) -> None:
    """Set limits around forces (n, 2) (kN), to one scale on both axes."""
    margin = 0.12 * max(*np.ptp(forces, axis=0), _MIN_FORCE_SCALE_KN)
    low, high = forces.min(axis=0) - margin, forces.max(axis=0) + margin
    # Leave room for numbers of many digits between the label and the frame.
    label_space = _DIGIT_WIDTH * max(len(f"{1.25 * float(np.abs(forces[:, 1]).max()):.0f}") - _N_DIGITS_WITHOUT_SHIFT, 0)
    left, bottom, width, height = panel.get_position().bounds
    panel.set_position((left + label_space, bottom, width - label_space, height))
    panel.show_region(tuple((low + high) / 2), max((high[0] - low[0]) / 2, panel.aspect_ratio * (high[1] - low[1]) / 2))


def _draw_engine(panel: Panel, crank_train: CrankTrain, exact: BearingLoads) -> None:
    """Draw the slider crank at one angle, with each force as an arrow at its bearing."""
    angle_index = 2 * _SHOWN_ANGLE_DEG
    angle = math.radians(_SHOWN_ANGLE_DEG)
    r = crank_train.crank
    shaft, pin = (0.0, 0.0), polar_points(angle, r)
    crosshead = float(np.asarray(crosshead_distance(crank_train, crank_angle=angle))), 0.0
    panel.show_region((crosshead[0] / 2, 0.0), max((crosshead[0] + 3.2 * r) / 2, panel.aspect_ratio * 1.25 * r))
    panel.set_aspect("equal")
    panel.plot([-1.3 * r, crosshead[0] + r], [0, 0], color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    panel.add_patch(Circle((0, 0), r, fill=False, edgecolor=MUTED, linewidth=0.7, linestyle=DASHED, zorder=1))
    guide, block = 0.26 * r, 0.22 * r
    for side in (guide, -guide):
        panel.plot([crosshead[0] - 0.9 * r, crosshead[0] + 0.9 * r], [side, side], color=MUTED, linewidth=1.0, zorder=2)
    for start, stop, width in ((shaft, pin, 7.0), (pin, crosshead, 5.0)):
        for colour, line_width in ((INK, width + 1.6), (STEEL, width)):
            panel.plot(*zip(start, stop, strict=True), color=colour, linewidth=line_width, solid_capstyle="round", zorder=3)
    box = Rectangle((crosshead[0] - 0.3 * r, -block), 0.6 * r, 2 * block, facecolor=STEEL, edgecolor=INK, linewidth=0.9, zorder=4)
    panel.add_patch(box)
    for point in (shaft, pin, crosshead):
        panel.plot(*point, "o", color=INK, markerfacecolor=PAPER, markersize=7, zorder=5)
    bearings = zip((shaft, pin, crosshead), _bearing_forces(exact), strict=True)
    forces = [(point, force[angle_index], colour) for point, (_, force, colour) in bearings]
    forces.append((crosshead, np.array([0.0, exact.guide[angle_index]]), SERIES_COLOURS[3]))
    largest = max(*(float(np.hypot(*force)) for _, force, _ in forces), _MIN_FORCE_SCALE_KN / _KILO_PER_UNIT)
    for point, force, colour in forces:
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
        panel.annotate("", tuple(np.add(point, _MAX_ARROW_LENGTH * r * force / largest)), point, arrowprops=arrow, zorder=8)
    _draw_force_scale(panel, _MAX_ARROW_LENGTH * r / (largest * _KILO_PER_UNIT), largest * _KILO_PER_UNIT)


def _draw_force_scale(panel: Panel, length_per_kilonewton: float, largest: float) -> None:
    """Draw the length of a round force below the engine; the largest arrow is `largest` kN."""
    decade = 10.0 ** math.floor(math.log10(largest))
    force = max(factor * decade for factor in (1.0, 2.0, 5.0) if factor * decade <= largest)
    (_, right), (low, high) = panel.get_xlim(), panel.get_ylim()
    y, tick = low + 0.1 * (high - low), 0.02 * (high - low)
    ends = np.array([right - 0.05 * (high - low) - force * length_per_kilonewton, right - 0.05 * (high - low)])
    panel.plot(ends, [y, y], color=INK, linewidth=1.2)
    for end in ends:
        panel.plot([end, end], [y - tick, y + tick], color=INK, linewidth=1.2)
    panel.annotate_point((float(ends.mean()), y), f"{force:g} kN", (0, 5), ha="center", fontsize=10)


def _draw_load_curve(panel: Panel, simulated: tuple[FloatArray, FloatArray], exact: tuple[FloatArray, FloatArray]) -> None:
    """Draw a load over the crank angle (deg): points of the run, the curve of the closed form, and its mean."""
    panel.axhline(0, color=MUTED, linewidth=0.7, zorder=1)
    panel.plot(*exact, color=SERIES_COLOURS[3], linewidth=1.8, zorder=3)
    panel.plot(simulated[0][::4], simulated[1][::4], "o", color=SERIES_COLOURS[3], markersize=2.6, zorder=4)
    panel.axhline(float(np.mean(exact[1][:-1])), color=INK, linewidth=0.7, linestyle=DASHED, zorder=2)
    panel.set(xlim=(0, 360), xticks=range(0, 361, 60))
