"""Zehnder's plate: isochronous parabolas with the circle of the ball, and the speed deviations near the start point."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator

from governor_mechanism.closed_form import parabolic as isochronous
from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form.parabolic import equilibrium_speed_change, parabola_speed_change
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, DOTTED, MM_PER_M, Panel, Plate, add_legend, polar_points
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, ROLE_STYLES, SERIES_COLOURS, SERIF_FONT, SKY
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

MARKED_ANGLE_CHANGES = np.radians([-4.0, -2.0, -1.0, 1.0, 2.0, 4.0])
"""Changes of the arm angle (rad) with a marker."""

MAX_ANGLE_CHANGE = math.radians(8.0)
"""Largest shown change of the arm angle (rad), up and down."""

_START_ANGLE_RANGE = math.radians(10.0), math.radians(55.0)
"""Arm angles (rad) with a circle of curvature that fits the plate."""

_SPEED_STEP_RATIO = 0.085
"""Target step between the speeds of neighbouring parabolas, as a fraction of the middle speed."""


class SpeedDeviationCurve(NamedTuple):
    """Relative speed changes (n,) against changes of the arm angle (n,) (rad).

    `equilibrium_speed_changes` are those of the equilibrium speed, `parabola_speed_changes` those of the parabola through the ball,
    which Zehnder used.
    """

    angle_changes: FloatArray
    equilibrium_speed_changes: FloatArray
    parabola_speed_changes: FloatArray


class IsochronousPlateData:
    """Data of the plate of a scene, in SI and radians: x from the spindle axis, y up, both zero at the common vertex of all parabolas.

    The start point is the osculation point of crossed arms (`starts_at_osculation`), otherwise an equilibrium. `start_speed` is its
    equilibrium speed. `radius_of_curvature` and `centre_of_curvature` are those of the parabola of this speed there. `suspension` is the
    suspension point of the arm, `travel` the lowest and highest arm angle. `speeds` are seven speeds of the family, with `start_speed` in
    the middle.

    Raises MechanismError unless the governor is a rhombus with the balls at its joints, with gravity and centrifugal force.
    """

    def __init__(self, scene: Scene) -> None:
        if not has_isochronous_parabolas(scene):
            raise MechanismError(
                "isochronous parabolas need machine 'pendulum_governor' with gravity and centrifugal, balls at the joints of arms "
                f"and links, links as long as the arms, and lugs below the suspensions; the scene {scene.title!r} differs"
            )
        self.governor = PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)
        self.travel = next((limit.low, limit.high) for limit in scene.part.mechanism.limits if limit.reading == "arm_angle")
        self.start_angle = angle = _start_angle(self.governor, self.travel, scene)
        self.start_speed = float(pendulum.equilibrium_speed(self.governor, arm_angle=angle))
        self.starts_at_osculation = self.governor.offset < 0
        self.speeds = _speed_family(self.start_speed)
        parameter = self.double_parameter(self.start_speed)
        x = float(pendulum.ball_radius(self.governor, arm_angle=angle))
        y = float(isochronous.parabola_height(abscissa=x, double_parameter=parameter))
        self.radius_of_curvature = radius = float(isochronous.radius_of_curvature(abscissa=x, double_parameter=parameter))
        self.start_point: Vec2 = x, y
        self.suspension: Vec2 = self.governor.offset, y + self.governor.arm * math.cos(angle)
        self.centre_of_curvature: Vec2 = x - radius * math.sin(angle), y + radius * math.cos(angle)

    def double_parameter(self, speed: float) -> float:
        """Return the double parameter (m) of the parabola of one spindle speed (rad/s)."""
        ratio = self.governor.sleeve_mass / self.governor.ball_mass
        return float(isochronous.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=self.governor.gravity))

    def point_at_45_degrees(self, speed: float) -> Vec2:
        """Return the point (m) with x = 2 y, where the parabola of one spindle speed (rad/s) has a slope of 45 degrees."""
        parameter = self.double_parameter(speed)
        return parameter / 2, parameter / 4

    def speed_deviations(self, arm_ratio: float, angle_changes: FloatArray | None = None) -> SpeedDeviationCurve:
        """Return the speed deviations near the start for an arm of `arm_ratio` radii of curvature and changes of angle (n,), rad."""
        # By default these are a grid within MAX_ANGLE_CHANGE. Changes that bring the arm to the
        # vertical or the horizontal, or the ball close to the axis or the vertex, are dropped.
        requested_changes = np.linspace(-MAX_ANGLE_CHANGE, MAX_ANGLE_CHANGE, 321) if angle_changes is None else angle_changes
        arm, angle = arm_ratio * self.radius_of_curvature, self.start_angle
        x, y = self.start_point
        angles = angle + requested_changes
        abscissa_ratio = 1 + arm / x * (np.sin(angles) - math.sin(angle))
        height_ratio = 1 + arm / y * (math.cos(angle) - np.cos(angles))
        min_angle = math.radians(0.5)
        valid = (angles > min_angle) & (angles < math.pi / 2 - min_angle) & (abscissa_ratio > 0.1) & (height_ratio > 0.05)
        valid_changes = requested_changes[valid]
        arguments: dict[str, Any] = {"start_angle": angle, "start_abscissa": x, "arm": arm, "angle_change": valid_changes}
        changes = (np.asarray(change(**arguments)) for change in (equilibrium_speed_change, parabola_speed_change))
        return SpeedDeviationCurve(valid_changes, *changes)


def has_isochronous_parabolas(scene: Scene) -> bool:
    """Return whether the plate can show a scene: a rhombic pendulum governor with gravity and centrifugal force."""
    if len(scene.parts) != 1 or scene.part.machine != "pendulum_governor" or not (scene.gravity and scene.has_centrifugal):
        return False
    governor = PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)
    return governor.is_rhombus and math.isclose(governor.joint_length, governor.arm, rel_tol=1e-12)


def _start_angle(governor: PendulumGovernor, travel: tuple[float, float], scene: Scene) -> float:
    """Return the osculation angle, else an equilibrium angle at the first speed, else the middle of the travel above the vertical."""
    if governor.offset < 0:
        return pendulum.least_stable_angle(governor)
    spindle = scene.spindle
    speed = abs((spindle.start_speed or 0.0) if isinstance(spindle, FreeSpindle) else spindle.speeds[0])
    for angle in pendulum.equilibrium_angles(governor, spindle_speed=speed) if speed else ():
        if _START_ANGLE_RANGE[0] <= angle <= _START_ANGLE_RANGE[1]:
            return float(angle)
    return (max(travel[0], 0.0) + travel[1]) / 2


def _speed_family(start_speed: float) -> tuple[float, ...]:
    """Return seven speeds (rad/s, ascending): round values in rpm on both sides of the start speed."""
    rpm = start_speed / RPM
    decade = 10.0 ** math.floor(math.log10(_SPEED_STEP_RATIO * rpm))
    step = min((m * decade for m in (1.0, 2.0, 2.5, 5.0, 10.0)), key=lambda step: abs(math.log(step / (_SPEED_STEP_RATIO * rpm))))
    nearest_multiple = round(rpm / step)
    return tuple((nearest_multiple + k) * step * RPM if k else start_speed for k in range(-3, 4))


_FAMILY_RECT = (0.078, 0.155, 0.476, 0.69)
_DEVIATION_RECT = (0.672, 0.475, 0.243, 0.37)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_DOWN = -math.pi / 2
"""Direction from which arm angles are measured, rad from the horizontal."""

_SOURCE = "after L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1–14"
_CAPTIONS = {
    (0.03, 0.862): "Fig. 1.  On each parabola $x^2 = c\\,y$, $c = 2g\\,(1+m)/\\omega^2$, a ball is in equilibrium at one speed",
    (0.605, 0.862): "Fig. 2.  Speed deviation on a circle through the start point",
    (0.605, 0.4): "Equilibrium speeds near the start",
}

ARM_STYLES = {1.0: ("$l = \\rho$", BLUE, "o"), 1.3: ("$l = 1.3\\,\\rho$", SERIES_COLOURS[3], "s"), 0.7: ("$l = 0.7\\,\\rho$", GREEN, "^")}
"""Label, colour and marker of an arm, by its ratio to the radius of curvature."""

ZEHNDER_VERDICTS = {
    1.0: ("lower below, higher above:\nusable both ways", "minimum at the start:\nusable upward"),
    1.3: ("lower both ways:\nusable downward only", "lower above, higher below:\nunstable here"),
    0.7: ("higher both ways:\nusable upward only", "higher above, lower below:\nusable both ways"),
}
"""Speed deviations near the start point in Zehnder's text and in fact, by ratio of the arm to the radius of curvature."""

_HOLLOW: dict[str, Any] = {"markersize": 6.5, "markeredgewidth": 1.3, "markerfacecolor": PAPER}
"""Markers at the ends of the curves of the parabolas through the ball."""

_VERDICT_COLUMNS = (0.609, 0.7, 0.842)
"""Left edges of the columns of the table, in fractions of the plate."""

_REASON = (
    "Zehnder compared the parabolas through the ball. Equilibrium depends",
    "on the slope of the ball’s path, $\\tan\\,\\alpha = \\omega^2 x\\,/\\,g\\,(1+m)$, not on its height.",
    "His advice is still correct: $l \\leq \\rho$, start at the lowest point, use the arc above it.",
)


def isochronous_figure(
    scene: Scene,  # scene of a rhombic pendulum governor; another scene raises MechanismError
) -> Plate:
    """Draw Zehnder's plate for a scene with isochronous parabolas (`has_isochronous_parabolas`); `save` writes it."""
    data = IsochronousPlateData(scene)
    plate = Plate("The isochronous parabolas and the governor’s circle", scene.title, _SOURCE, _CAPTIONS)
    family_labels = "Distance from the spindle axis [mm]", "Height above the vertex [mm]"
    _draw_parabola_family(plate.add_plate_panel(_FAMILY_RECT, *family_labels), data)
    deviation_labels = "Change of the arm angle [deg]", "Change of the equilibrium speed [%]"
    _draw_speed_deviations(plate.add_plate_panel(_DEVIATION_RECT, *deviation_labels), data)
    _write_dimensions(plate, data)
    _write_verdicts(plate)
    return plate


def _show_family(panel: Panel, data: IsochronousPlateData) -> None:
    """Set limits (mm), to one scale, that contain both centres, the horizontal arm and the 45-degree point."""
    x45, y45 = data.point_at_45_degrees(data.start_speed)
    centre = data.centre_of_curvature
    suspension = data.suspension
    xs = (0.0, centre[0], suspension[0], suspension[0] + data.governor.arm, 1.5 * x45)
    ys = (0.0, centre[1], suspension[1], 1.5 * y45)
    left, right, bottom, top = (MM_PER_M * value for value in (min(xs), max(xs), min(ys), max(ys)))
    margin = 0.06 * max(right - left, top - bottom)
    left = left - 3.6 * margin
    right = right + margin / 2
    bottom = bottom - margin
    top = top + margin
    missing_width = panel.aspect_ratio * (top - bottom) - (right - left)
    if missing_width > 0:
        left, right = left - 0.35 * missing_width, right + 0.65 * missing_width
    else:
        top -= missing_width / panel.aspect_ratio
    panel.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def _larger_side(panel: Panel) -> float:
    return float(max(np.ptp(panel.get_xlim()), np.ptp(panel.get_ylim())))


def _draw_parabola_family(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw the left panel: parabolas, the ball path and the circle of curvature, in mm and to one scale on both axes."""
    _show_family(panel, data)
    bottom, top = panel.get_ylim()
    panel.plot([0, 0], [bottom, top], color=MUTED, linewidth=1.0, linestyle=CHAIN_DOTTED, zorder=1)
    panel.annotate_point((0, top), "spindle axis", (5, 0), color=MUTED, rotation=90, va="top")
    for speed in data.speeds:
        _draw_parabola(panel, data, speed)
    _draw_45_degree_line(panel, data)
    _draw_governor(panel, data)
    _draw_start_point(panel, data)
    _draw_circle_of_curvature(panel, data)


def _draw_parabola(panel: Panel, data: IsochronousPlateData, speed: float) -> None:
    """Draw one parabola of the family on both sides, with its speed at the edge of the panel."""
    is_start_speed = speed == data.start_speed
    colour, width = (INK, 2.0) if is_start_speed else (MUTED, 0.8)
    (left, right), (_, top) = panel.get_xlim(), panel.get_ylim()
    c = data.double_parameter(speed) * MM_PER_M
    end = min(right, math.sqrt(c * top))
    for limit, width_ratio in ((end, 1.0), (max(left, -end), 0.5)):
        x = np.linspace(0, limit, 200)
        panel.plot(x, x**2 / c, color=colour, linewidth=width * width_ratio, zorder=2)
    text = f"{speed / RPM:.4g}" + (" rpm" if is_start_speed else "")
    offset, ha, va = ((5, 0), "left", "center") if end == right else ((0, 4), "center", "bottom")
    panel.annotate_point((end, end**2 / c), text, offset, ha=ha, va=va, color=colour, weight="bold" if is_start_speed else "normal")


def _draw_45_degree_line(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw the line x = 2 y, and the 45-degree tangents of the parabolas on it."""
    right, top = panel.get_xlim()[1], panel.get_ylim()[1]
    end = min(right, 2 * top)
    panel.plot([0, end], [0, end / 2], color=GREEN, linewidth=1.0, zorder=3)
    half_length = 0.018 * _larger_side(panel)
    for x, y in (_to_mm(data.point_at_45_degrees(speed)) for speed in data.speeds):
        if x + half_length < right and y + half_length < top:
            panel.plot([x - half_length, x + half_length], [y - half_length, y + half_length], color=GREEN, linewidth=1.4, zorder=4)
            panel.plot(x, y, "o", color=GREEN, markersize=3.5, zorder=4)
    text = "on $x = 2y$ all slopes\nare 45°, the spacing\nis largest: Zehnder's\nstart point"
    panel.annotate_point((right, panel.get_ylim()[0]), text, (-2, 3), color=GREEN, ha="right", va="bottom", linespacing=1.2, fontsize=9)


def _draw_circle_of_curvature(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw the osculating circle of the parabola at the start point, its centre and radius."""
    centre = _to_mm(data.centre_of_curvature)
    start = _to_mm(data.start_point)
    radius = data.radius_of_curvature * MM_PER_M
    circle = polar_points(_DOWN + np.linspace(-math.pi / 6, math.pi / 2 + 0.1, 400), radius, centre)
    panel.plot(*circle, color=BLUE, linewidth=1.3, linestyle=DASHED, zorder=5)
    panel.plot(*centre, "+", color=BLUE, markersize=12, markeredgewidth=1.5, zorder=8)
    if data.starts_at_osculation:
        text = "suspension,\ncentre of\ncurvature"
    else:
        text = "centre of\ncurvature"
        panel.plot(*zip(centre, start, strict=True), color=BLUE, linewidth=0.8, linestyle=DASHED, zorder=3)
        _label_along_arm(panel, data, centre, _to_mm(data.suspension), f"$\\rho$ = {radius:.4g} mm", BLUE)
    panel.annotate_point(centre, text, (-9, -9), color=BLUE, ha="right", va="top")


def _draw_governor(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw suspension, arm, arm angle and ball at the start point, and the path of the ball, wide over the travel."""
    suspension = _to_mm(data.suspension)
    start = _to_mm(data.start_point)
    arm = data.governor.arm * MM_PER_M
    low, high = data.travel
    panel.plot(*polar_points(_DOWN + np.linspace(low, high, 300), arm, suspension), color=SKY, linewidth=6, alpha=0.75, zorder=3)
    panel.plot(*polar_points(_DOWN + np.linspace(low - 0.3, low, 60), arm, suspension), color=SKY, linewidth=1.2, zorder=3)
    panel.annotate_point(polar_points(_DOWN + high, arm, suspension), "path of the ball", (-22, 0), ha="right", va="center", color=BLUE)
    panel.plot(*zip(suspension, start, strict=True), color=INK, linewidth=1.8, zorder=6)
    ball = ROLE_STYLES["ball"]
    panel.add_patch(Circle(start, 0.02 * _larger_side(panel), facecolor=ball.fill, edgecolor=ball.stroke, linewidth=1.2, zorder=7))
    panel.plot(*start, "o", color=PAPER, markersize=2.5, zorder=8)
    panel.plot(*suspension, "o", color=INK, markerfacecolor=PAPER, markersize=8, zorder=7)
    arm_ratio_text = "= \\rho$" if data.starts_at_osculation else f"= {data.governor.arm / data.radius_of_curvature:.2f}\\,\\rho$"
    _label_along_arm(panel, data, suspension, start, f"$l {arm_ratio_text} = {arm:.4g} mm", INK)
    if not data.starts_at_osculation:
        panel.annotate_point(suspension, "suspension", (9, 2), va="center")
    arc_radius, angle = 0.24 * arm, data.start_angle
    panel.plot([suspension[0]] * 2, [suspension[1], suspension[1] - 1.15 * arc_radius], color=MUTED, linewidth=0.7, zorder=3)
    panel.plot(*polar_points(_DOWN + np.linspace(0, angle, 60), arc_radius, suspension), color=MUTED, linewidth=0.7, zorder=3)
    middle = polar_points(_DOWN + angle / 2, arc_radius, suspension)
    panel.annotate_point(middle, "$\\alpha_1$", (2, -8), ha="center", va="center", color=MUTED)


def _draw_start_point(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw a leader from the start point to its name below the parabolas."""
    (x, y), (left, right) = _to_mm(data.start_point), panel.get_xlim()
    label_ordinate = 0.5 * x**2 / (data.double_parameter(data.speeds[0]) * MM_PER_M)
    panel.plot([x, x], [y, label_ordinate], color=INK, linewidth=0.7, zorder=6)
    is_crowded = x - left > 0.65 * (right - left)
    panel.annotate_point((x, label_ordinate), _start_point_name(data), (0, -3), ha="right" if is_crowded else "center", va="top")


def _start_point_name(data: IsochronousPlateData) -> str:
    return f"{'osculation' if data.starts_at_osculation else 'start'} point"


def _label_along_arm(panel: Panel, data: IsochronousPlateData, first: Vec2, second: Vec2, text: str, colour: str) -> None:
    """Write a label along the arm, above it, between two points."""
    middle = (first[0] + second[0]) / 2, (first[1] + second[1]) / 2
    offset = polar_points(data.start_angle, 10)
    rotation = math.degrees(data.start_angle) - 90
    panel.annotate_point(middle, text, offset, color=colour, ha="center", va="center", rotation=rotation)


def _to_mm(point: Vec2) -> Vec2:
    return MM_PER_M * point[0], MM_PER_M * point[1]


def _draw_speed_deviations(panel: Panel, data: IsochronousPlateData) -> None:
    """Draw the right panel: changes of the equilibrium speed (percent) against changes of the arm angle (deg) for three arms."""
    limit = 1.5 * 100 * float(np.abs(data.speed_deviations(0.7).equilibrium_speed_changes).max())
    axis_limit = 1.05 * math.degrees(MAX_ANGLE_CHANGE)
    panel.set(xlim=(-axis_limit, axis_limit), ylim=(-limit, limit))
    panel.xaxis.set_major_locator(MultipleLocator(4))
    panel.axhline(0, color=MUTED, linewidth=0.8, zorder=1)
    panel.axvline(0, color=MUTED, linewidth=0.8, zorder=1)
    for arm_ratio, (name, colour, marker) in ARM_STYLES.items():
        curve = data.speed_deviations(arm_ratio)
        degrees = np.degrees(curve.angle_changes)
        percent = 100 * curve.equilibrium_speed_changes
        parabola_percent = 100 * curve.parabola_speed_changes
        is_rising = np.gradient(percent, degrees) > 0
        for is_stable, style in ((True, "-"), (False, DASHED)):
            panel.plot(degrees, np.where(is_rising == is_stable, percent, np.nan), color=colour, linewidth=2.2, linestyle=style, zorder=4)
        panel.plot(degrees, parabola_percent, color=colour, linewidth=1.1, linestyle=DOTTED, zorder=3)
        panel.plot(degrees[[0, -1]], parabola_percent[[0, -1]], marker, color=colour, **_HOLLOW, zorder=6)
        marked = data.speed_deviations(arm_ratio, MARKED_ANGLE_CHANGES)
        panel.plot(np.degrees(marked.angle_changes), 100 * marked.equilibrium_speed_changes, marker, color=colour, markersize=5, zorder=5)
        panel.annotate_point((degrees[-1], percent[-1]), name, (9, 0), color=colour, va="center", fontsize=12)
    _add_line_style_legend(panel)


def _add_line_style_legend(panel: Panel) -> None:
    entries: dict[str, dict[str, Any]] = {
        "stable": {"linewidth": 2.2},
        "unstable": {"linewidth": 2.2, "linestyle": DASHED},
        "parabola through the ball": {"linewidth": 1.1, "linestyle": DOTTED, "marker": "o", **_HOLLOW},
    }
    handles = [Line2D([], [], color=INK, label=label, **style) for label, style in entries.items()]
    position: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.08, 0), "handlelength": 2.5}
    frame: dict[str, Any] = {"frameon": True, "framealpha": 1, "facecolor": PAPER, "edgecolor": "none"}
    add_legend(panel, handles=handles, prop={"family": SERIF_FONT, "size": 10}, **position, **frame)


def _write_dimensions(plate: Plate, data: IsochronousPlateData) -> None:
    """Write the dimensions of the governor and its start point below the left panel."""
    x, y = _to_mm(data.start_point)
    governor = data.governor
    lines = (
        f"arm $l$ = {governor.arm * MM_PER_M:.4g} mm,  suspension $e$ = {governor.offset * MM_PER_M:.4g} mm from the axis,  "
        f"$m = Q/P$ = {governor.sleeve_mass / governor.ball_mass:.3g},  $g$ = {governor.gravity:.4g} m/s²",
        f"{_start_point_name(data)} $x_1$ = {x:.1f} mm,  $y_1$ = {y:.1f} mm,  "
        f"$\\alpha_1$ = {math.degrees(data.start_angle):.2f}°,  {data.start_speed / RPM:.4g} rpm;  "
        f"circle of curvature (dashed): $\\rho$ = {data.radius_of_curvature * MM_PER_M:.4g} mm",
    )
    for line, text in enumerate(lines):
        plate.write_dimensions(text, 0.309, 0.065 - 0.025 * line, 9.5)


def _write_verdicts(plate: Plate) -> None:
    """Write what Zehnder says and what is correct side by side below the right panel."""
    left, text_left, right_left = _VERDICT_COLUMNS
    top = 0.35
    row = 0.062
    for x, heading in ((text_left, "as Zehnder has it"), (right_left, "correct")):
        plate.write_text(x, 0.373, heading, 10.5, fontstyle="italic", color=MUTED)
    for k, (arm_ratio, (name, colour, marker)) in enumerate(ARM_STYLES.items()):
        (zehnder_text, correct_text), y = ZEHNDER_VERDICTS[arm_ratio], top - k * row
        plate.add_artist(Line2D([left, left + 0.022], [y - 0.008] * 2, color=colour, linewidth=2, marker=marker, markevery=[0]))
        plate.write_text(left + 0.029, y - 0.015, name, 12, color=colour)
        plate.write_text(text_left, y + 0.012, zehnder_text, 10, color=MUTED, va="top", linespacing=1.3)
        plate.write_text(right_left, y + 0.012, correct_text, 10, va="top", linespacing=1.3)
    for line, reason in enumerate(_REASON):
        plate.write_text(left, 0.137 - 0.029 * line, reason, 10)
