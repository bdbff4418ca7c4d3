"""Marks' plate: the error term of the eccentric rod as parabola, circle and hyperbola, and three other diagrams."""

import math
from dataclasses import replace

import numpy as np
from matplotlib.patches import Circle

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slider_crank import CRANK_END_TRAVEL
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Panel, Plate, polar_points
from governor_mechanism.render.figures.plates.zeuner import CYLINDER_ENDS, END_MARKERS, EventLabelStyle, ValveCircle, ValveDiagram
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, VERMILLION


class EccentricDiagram(ValveDiagram):
    """Slide valve of a scene over a closed turn, lengths in mm.

    `theoretical_displacement` (n,) (mm) is that of Zeuner's law. `piston_travel` (n,) is the travel of the piston from the crank end as a
    fraction of the stroke, `theoretical_piston_travel` (n,) that for an infinite connecting rod.
    """

    heading = "Zeuner’s diagram of the slide valve"
    source = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        lengths = {name: value * MM_PER_M for name, value in scene.part.dimensions.items()}
        self.eccentric = closed.Eccentric.from_dimensions({**lengths, "advance": scene.part.dimensions["advance"]})
        self.circle = ValveCircle(self.eccentric.radius, self.eccentric.advance)
        self.crank_train = CrankTrain.from_dimensions(lengths)
        self.theoretical_displacement = np.asarray(closed.first_order_displacement(self.eccentric, crank_angle=self.angles))
        self.piston_travel = self.turn[CRANK_END_TRAVEL](self.angles) * MM_PER_M / self.stroke
        endless = replace(self.crank_train, rod=math.inf)
        outer_travel = np.asarray(travel_from_outer_dead_centre(endless, crank_angle=self.angles + math.pi))
        self.theoretical_piston_travel = 1 - outer_travel / self.stroke

    @property
    def dimensions(self) -> str:
        """Line about the valve gear below the plate."""
        eccentric, crank_train = self.eccentric, self.crank_train
        rods = {name: "∞" if math.isinf(rod) else f"{rod:.5g} mm" for name, rod in (("l", eccentric.rod), ("L", crank_train.rod))}
        leads = " and ".join(f"{lead * MM_PER_M:.4g}" for lead in self.timing.leads)
        advance = f"{math.degrees(eccentric.advance):.4g}°"
        return (
            f"eccentric $r$ = {eccentric.radius:.4g} mm,  rod $l$ = {rods['l']},  advance $\\delta$ = {advance},  "
            f"laps $e$ = {self.steam_lap:.4g}, $i$ = {self.exhaust_lap:.4g} mm,  "
            f"crank $R$ = {crank_train.crank:.4g} mm,  rod $L$ = {rods['L']};  leads {leads} mm"
        )


_CAPTIONS = {
    (0.03, 0.862): "Fig. 1.  On any crank ray $OP$ the displacement is larger by the ordinate $z$ of the curve",
    (0.545, 0.862): "Fig. 2.  Errors of parabola and circle",
    (0.03, 0.462): "Fig. 3.  The valve’s ellipse: its displacement over the stroke of the piston",
    (0.545, 0.462): "Fig. 4.  Reuleaux’s circle: $\\xi_0$, the distance from a diameter",
}
_CONSTRUCTION_RECT = (0.03, 0.505, 0.47, 0.335)
_ERRORS_RECT = (0.60, 0.545, 0.355, 0.285)
_ELLIPSE_RECT = (0.085, 0.125, 0.385, 0.305)
_REULEAUX_RECT = (0.565, 0.085, 0.40, 0.355)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_APPROXIMATIONS = (("parabola", closed.parabola_error, SERIES_COLOURS[3], DASHED), ("circle", closed.circle_error, GREEN, "-"))
"""Name, function, colour and line style of the approximate error curves."""

_N_CURVE_POINTS = 401
"""Number of points of each curve."""

_UM_PER_MM = 1e3

_SAMPLE_RAY_ANGLE = math.radians(33.0)
"""Angle (rad) between the drawn ray and the line of centres."""

_LABEL_STYLE = EventLabelStyle(size=9.5, offset=(5, 3), centred=(0.0, 0.5), margins=(0.0, 0.0, 12.0, 12.0))


def draw_marks_plate(data: EccentricDiagram) -> Plate:
    """Return Marks' plate for a slide valve; raise MechanismError for an infinite eccentric rod, which has no error term."""
    eccentric, r = data.eccentric, data.eccentric.radius
    if eccentric.has_infinite_rod:
        raise MechanismError("Marks' construction needs a finite eccentric_rod; an infinite one has no error term")
    plate = Plate("Marks’ construction of the error term", data.timing.title, data.source, _CAPTIONS)
    _draw_error_construction(plate.add_plate_panel(_CONSTRUCTION_RECT), data)
    error_labels = "Theoretical displacement $\\xi_0 = r\\,\\sin(\\omega+\\delta)$ [mm]", "Deviation from the exact error [µm]"
    _draw_approximation_errors(plate.add_plate_panel(_ERRORS_RECT, *error_labels), data)
    ellipse_labels = "Piston travel from the crank end [% of the stroke]", "Valve’s displacement $\\xi$ [mm]"
    _draw_valve_ellipse(plate.add_plate_panel(_ELLIPSE_RECT, *ellipse_labels), data)
    _draw_reuleaux_diagram(plate.add_plate_panel(_REULEAUX_RECT), data)
    plate.write_dimensions(
        f"eccentric $r$ = {r:.4g} mm,  rod $l$ = {eccentric.rod:.5g} mm,  advance $\\delta$ = {math.degrees(eccentric.advance):.4g}°;  "
        f"neglected terms are of order $r^4/8l^3$ = {r**4 / (8 * eccentric.rod**3):.3g} mm"
    )
    return plate


def _draw_error_construction(panel: Panel, data: EccentricDiagram) -> None:
    """Draw the construction to scale (mm): valve circles on their line of centres, Marks' curves over it, one ray."""
    eccentric, r = data.eccentric, data.eccentric.radius
    panel.set(xlim=(-1.62 * r, 1.84 * r), ylim=(-0.72 * r, 0.76 * r), aspect="equal")
    for ends in (([-1.18 * r, 1.18 * r], [0, 0]), ([0, 0], [-0.6 * r, 0.6 * r])):
        panel.plot(*ends, color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    for side in (1, -1):
        panel.add_patch(Circle((side * r / 2, 0), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=3))
    data.draw_displacement_curves(panel, eccentric.advance - math.pi / 2, linewidth=2.2, zorder=4)
    x = np.linspace(-r, r, _N_CURVE_POINTS)
    for _, error, colour, style in _APPROXIMATIONS:
        panel.plot(x, np.asarray(error(eccentric, theoretical=x)), color=colour, linewidth=1.5, linestyle=style, zorder=5)
    _draw_sample_ray(panel, data)
    for side, text in ((1, "$m$"), (-1, "$m'$")):
        position = side * r * math.sin(eccentric.advance)
        panel.plot(position, 0, "o", color=INK, markerfacecolor=PAPER, markersize=5, zorder=6)
        panel.annotate_point((position, 0), text, (0, -14), ha="center", fontsize=11)
    panel.annotate_point((0, 0), "$O$", (-9, -13), fontsize=11)
    text = "Marks’ circle\nof radius $l$ and\nhis parabola\n(dashed), both\nthrough $m$, $m'$"
    panel.annotate_point((-1.62 * r, 0.6 * r), text, va="top", color=GREEN, fontsize=9.5, linespacing=1.4)
    panel.annotate_point((-1.62 * r, -0.58 * r), "thin: theory\nbold: mechanism", va="bottom", fontsize=9.5, linespacing=1.4)


def _draw_sample_ray(panel: Panel, data: EccentricDiagram) -> None:
    """Draw one ray: its chord in the valve circle, transferred to the line of centres; there the error, transferred to the ray."""
    angle, r = _SAMPLE_RAY_ANGLE, data.eccentric.radius
    x = r * math.cos(angle)
    z = float(closed.hyperbola_error(data.eccentric, theoretical=x))
    panel.plot(*polar_points(angle, [0, 1.16 * r]), color=INK, linewidth=0.9, zorder=3)
    panel.plot(*polar_points(np.linspace(0.0, angle, 40), x), color=MUTED, linewidth=0.8, linestyle=DASHED, zorder=3)
    for line in (([x, x], [0.0, z]), polar_points(angle, [x, x + z])):
        panel.plot(*line, color=VERMILLION, linewidth=3.0, zorder=7, solid_capstyle="butt")
    panel.plot(*polar_points(angle, x), "o", color=INK, markerfacecolor=PAPER, markersize=4, zorder=8)
    panel.annotate_point(polar_points(angle, x), "$P$", (-8, 5), fontsize=11)
    _draw_lens(panel, data, angle, (x, z))


def _draw_lens(panel: Panel, data: EccentricDiagram, angle: float, distances: tuple[float, float]) -> None:
    """Draw the surroundings of P enlarged: the theoretical circle, the curve of the mechanism, and the patch of the ray between them."""
    r, (x, z) = data.eccentric.radius, distances
    point = np.array(polar_points(angle, x))
    lens = np.array((1.54 * r, -0.36 * r))
    lens_radius = 0.27 * r
    factor = _round_down(0.8 * lens_radius / abs(z))
    edge = Circle(tuple(lens), lens_radius, facecolor=PAPER, edgecolor=MUTED, linewidth=0.9, zorder=9)
    panel.add_patch(edge)
    panel.add_patch(Circle(tuple(point), lens_radius / factor, fill=False, edgecolor=MUTED, linewidth=0.9, zorder=9))
    circle = polar_points(np.linspace(0.0, math.tau, 2001), r / 2, (r / 2, 0.0))
    curve = polar_points(data.angles + data.eccentric.advance - math.pi / 2, np.where(data.displacement > 0, data.displacement, np.nan))
    for line, colour, width in (
        (circle, INK, 0.9),
        (curve, BLUE, 2.2),
        (polar_points(angle, np.array([0.0, 1.2 * r])), INK, 0.9),
        (polar_points(angle, np.array([x, x + z])), VERMILLION, 4.0),
    ):
        enlarged = lens[:, np.newaxis] + factor * (np.array(line) - point[:, np.newaxis])
        (drawn,) = panel.plot(*enlarged, color=colour, linewidth=width, zorder=10, solid_capstyle="butt")
        drawn.set_clip_path(edge)
    panel.plot(*lens, "o", color=INK, markerfacecolor=PAPER, markersize=4, zorder=11)
    text = f"$z$ = {z:.2f} mm\nat $P$, enlarged {factor:g} times"
    panel.annotate_point((lens[0], lens[1] + lens_radius), text, (0, 5), ha="center", color=VERMILLION, fontsize=9.5, linespacing=1.3)


def _round_down(value: float) -> float:
    """Return the next of 1, 2 and 5 times a power of ten, or less."""
    decade = 10.0 ** math.floor(math.log10(value))
    return max(factor * decade for factor in (1.0, 2.0, 5.0) if factor * decade <= value)


def _draw_approximation_errors(panel: Panel, data: EccentricDiagram) -> None:
    """Draw the errors of parabola and circle relative to the exact curve (um), with points of the mechanism on the exact curve."""
    eccentric, r = data.eccentric, data.eccentric.radius
    centre_shift = data.timing.centre * MM_PER_M - closed.equal_lead_centre(eccentric)
    simulated_errors = data.displacement - data.theoretical_displacement + centre_shift
    deviations = simulated_errors - np.asarray(closed.hyperbola_error(eccentric, theoretical=data.theoretical_displacement))
    panel.plot(data.theoretical_displacement[::10], deviations[::10] * _UM_PER_MM, "o", color=BLUE, markersize=4.5, zorder=3)
    panel.axhline(0, color=BLUE, linewidth=0.9, zorder=2)
    x = np.linspace(-r, r, _N_CURVE_POINTS)
    exact_errors = np.asarray(closed.hyperbola_error(eccentric, theoretical=x))
    curves = [(np.asarray(error(eccentric, theoretical=x)) - exact_errors) * _UM_PER_MM for _, error, _, _ in _APPROXIMATIONS]
    low, high = np.min(curves), np.max(curves)
    panel.set(xlim=(-1.06 * r, 1.06 * r), ylim=(low - 0.2 * (high - low), high + 0.25 * (high - low)))
    label_positions = ((-0.35 * r, high), "center"), ((r, float(curves[1][-1])), "right")
    for z, (name, _, colour, style), (position, alignment) in zip(curves, _APPROXIMATIONS, label_positions, strict=True):
        panel.plot(x, z, color=colour, linewidth=2.0, linestyle=style, zorder=4)
        panel.annotate_point(position, f"{name}: at most {np.abs(z).max():.3g} µm", (0, 8), ha=alignment, va="bottom", color=colour)
    text = "on the hyperbola $(z+d)^2-\\xi_0^2=l^2-r^2$:\npoints of the mechanism"
    # Both curves turn away from the middle of the lower edge.
    panel.annotate_point((0, panel.get_ylim()[0]), text, (0, 6), ha="center", va="bottom", color=BLUE, linespacing=1.4, fontsize=9.5)


def _draw_valve_ellipse(panel: Panel, data: EccentricDiagram) -> None:
    """Draw the valve displacement over the piston travel: the theoretical ellipse, and the curve with two finite rods."""
    panel.plot(100 * data.theoretical_piston_travel, data.theoretical_displacement, color=INK, linewidth=0.9, zorder=3)
    panel.plot(100 * data.piston_travel, data.displacement, color=BLUE, linewidth=2.4, zorder=4)
    for lap, text in ((data.steam_lap, "$e$"), (-data.steam_lap, "$−e$"), (data.exhaust_lap, "$i$"), (-data.exhaust_lap, "$−i$")):
        panel.axhline(lap, color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=2)
        panel.annotate_point((104, lap), text, (5, 0), va="center", color=MUTED, fontsize=10)
    for event, _, colour in data.events:
        piston_travel = event.simulated_stroke if event.name.startswith("crank end") else 1 - event.simulated_stroke
        lap = float(np.interp(event.simulated, data.angles, data.displacement))
        panel.plot(100 * piston_travel, lap, END_MARKERS[colour], color=colour, markeredgecolor=PAPER, markersize=7, zorder=6)
    panel.set_xlim(-4, 104)
    for end, side, colour in CYLINDER_ENDS:
        position = 50 - 23 * side, 0.68 * side * float(np.max(side * data.displacement))
        panel.annotate_point(position, f"steam to the {end}", ha="center", va="center", color=colour, fontstyle="italic")
    panel.annotate_point((0, 0.86 * float(data.theoretical_displacement.min())), "thin: both rods infinite", fontsize=9.5)


def _draw_reuleaux_diagram(panel: Panel, data: EccentricDiagram) -> None:
    """Draw Reuleaux's circle: the distance of the crank pin from a diameter inclined by the advance, with lines at the laps."""
    r, advance = data.eccentric.radius, data.eccentric.advance
    panel.set(xlim=(-1.75 * r, 1.75 * r), ylim=(-1.1 * r, 1.1 * r), aspect="equal")
    panel.add_patch(Circle((0, 0), r, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    panel.plot([-1.06 * r, 1.06 * r], [0, 0], color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    diameter_direction = np.array([math.cos(advance), -math.sin(advance)])
    normal_direction = np.array([math.sin(advance), math.cos(advance)])
    panel.plot(*np.outer(diameter_direction, [-1.12 * r, 1.12 * r]), color=INK, linewidth=0.9, linestyle=CHAIN_DOTTED, zorder=2)
    for event, kind, colour in data.events:
        if kind in ("admission", "release"):
            lap_distance = closed.event_threshold(event.name, outside_lap=data.steam_lap, inside_lap=data.exhaust_lap)
            half_chord = math.sqrt(max(r**2 - lap_distance**2, 0.0))
            line = lap_distance * normal_direction[:, None] + np.outer(diameter_direction, [-half_chord, half_chord])
            panel.plot(*line, color=colour, linewidth=1.2, linestyle="-" if kind == "admission" else DASHED, zorder=3)
        panel.plot(*polar_points(event.theory, r), END_MARKERS[colour], color=colour, markeredgecolor=PAPER, markersize=6, zorder=6)
    data.label_events(panel, [event.theory for event in data.timing.rows], r, _LABEL_STYLE)
    start, arrow = 0.1 * r * diameter_direction, 0.62 * r * normal_direction
    panel.annotate("", tuple(start + arrow), tuple(start), arrowprops={"arrowstyle": "<->", "color": MUTED, "linewidth": 0.7})
    panel.plot(*polar_points(np.linspace(-advance, 0.0, 30), 0.78 * r), color=MUTED, linewidth=0.8, zorder=3)
    panel.annotate_point(polar_points(-advance / 2, 0.78 * r), "$\\delta$", (5, 0), va="center", color=MUTED)
    panel.annotate_point(tuple(start + 0.5 * arrow), "$\\xi_0$", (8, 0), color=MUTED)
