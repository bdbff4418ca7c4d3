"""Writes the drawing of each question into the folder drawings, from what the package computes: python docs/questions/drawings.py."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from question_scenes import SCENES, engine_with_flywheel, valve_with_lead

import governor_mechanism as gm

FOLDER = Path(__file__).parent / "drawings"
INK, GREY, FADED, BLUE, ORANGE, PALE, GROUND = "#1f2933", "#7b8794", "#c9cfd5", "#1668c8", "#c4540a", "#cfe2f6", "#fbfaf4"
WIDTH, HEIGHT = 720, 420
SHOWN_WIDTH, TEXT_HEIGHT = 560, 22
"""Width of the drawing on a page with room for it, and height of its words, which a telephone shows at half their size, pixels."""
LEFT, RIGHT, TOP, BOTTOM = 84, 684, 44, 360
"""Ends of the field with curves, pixels."""

RPM = 30.0 / math.pi


class Plot:
    """Curves in SVG: what is meant has a colour, and the rest is pale.

    Parameters
    ----------
    x, y
        Ends of both axes.
    """

    def __init__(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        self.x, self.y = x, y
        self.elements: list[str] = []

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return a point in pixels."""
        across = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return LEFT + across * (RIGHT - LEFT), BOTTOM - up * (BOTTOM - TOP)

    def path(self, xs: Iterable[float], ys: Iterable[float]) -> str:
        """Return the corners of a line."""
        return " ".join("{:.1f},{:.1f}".format(*self.place(x, y)) for x, y in zip(xs, ys, strict=True))

    def curve(self, xs: Iterable[float], ys: Iterable[float], colour: str, width: float = 2.5, dashes: str = "") -> None:
        """Draw a line."""
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        look = f'fill="none" stroke="{colour}" stroke-width="{width}"{dashed} clip-path="url(#field)"'
        self.elements.append(f'<polyline points="{self.path(xs, ys)}" {look}/>')

    def area(self, xs: Iterable[float], ys: Iterable[float], colour: str) -> None:
        """Fill what a line goes round."""
        self.elements.append(f'<polygon points="{self.path(xs, ys)}" fill="{colour}" clip-path="url(#field)"/>')

    def dot(self, x: float, y: float, colour: str) -> None:
        """Draw a point."""
        across, down = self.place(x, y)
        self.elements.append(f'<circle cx="{across:.1f}" cy="{down:.1f}" r="5" fill="{colour}"/>')

    def words(self, x: float, y: float, text: str, colour: str = INK, anchor: str = "start") -> None:
        """Write beside a point."""
        across, down = self.place(x, y)
        self.elements.append(f'<text x="{across:.1f}" y="{down:.1f}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def axes(self, x_name: str, y_name: str, x_ticks: Sequence[float], y_ticks: Sequence[float]) -> None:
        """Draw axes with ticks."""
        self.elements.append(f'<path d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}" fill="none" stroke="{GREY}" stroke-width="1.2"/>')
        for value in x_ticks:
            across, _ = self.place(value, self.y[0])
            self.elements.append(f'<text x="{across:.1f}" y="{BOTTOM + 25}" text-anchor="middle" fill="{GREY}">{_number(value)}</text>')
        for value in y_ticks:
            _, down = self.place(self.x[0], value)
            self.elements.append(f'<text x="{LEFT - 8}" y="{down + 8:.1f}" text-anchor="end" fill="{GREY}">{_number(value)}</text>')
        self.elements.append(f'<text x="{RIGHT}" y="{BOTTOM + 51}" text-anchor="end" fill="{INK}">{x_name}</text>')
        self.elements.append(f'<text x="{LEFT}" y="{TOP - 18}" fill="{INK}">{y_name}</text>')

    def save(self, name: str) -> Path:
        """Write the file."""
        path = FOLDER / f"{name}.svg"
        head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}"'
        head += f' width="{SHOWN_WIDTH}" height="{SHOWN_WIDTH * HEIGHT / WIDTH:.0f}"'
        ground = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="{GROUND}"/>'
        style = f'font-family="DejaVu Sans, Verdana, sans-serif" font-size="{TEXT_HEIGHT}">{ground}'
        clip = f'<clipPath id="field"><rect x="{LEFT}" y="{TOP}" width="{RIGHT - LEFT}" height="{BOTTOM - TOP}"/></clipPath>'
        path.write_text("\n".join([f"{head} {style}", clip, *self.elements, "</svg>", ""]), encoding="utf-8")
        return path


def _number(value: float) -> str:
    """Return a number at an axis."""
    return f"{value:g}".replace("-", "−")


def draw_hunting() -> Path:
    """Draw the speed after half the load has gone, with too weak a dashpot and with a good one."""
    plot = Plot((0.0, 30.0), (119.0, 125.0))
    plot.axes("time, s", "speed of the shaft, rpm", range(0, 31, 5), range(120, 126))
    for name, colour in (("question_hunting", ORANGE), ("question_settling", BLUE)):
        run = gm.run(SCENES[name]())
        plot.curve(run.times, run.readings["engine.shaft_speed"] * RPM, colour, width=2.0)
    plot.words(6.2, 119.6, "half the load goes", GREY)
    plot.words(30.0, 124.4, "dashpot of 10 N s/m: hunts", ORANGE, "end")
    plot.words(30.0, 121.6, "dashpot of 60 N s/m: settles", BLUE, "end")
    return plot.save("hunting")


def draw_friction() -> Path:
    """Draw the sleeve over the speed, which goes up and comes back, in the band in which friction holds it."""
    scene = gm.load("porter_dry_friction")
    angles = [f"{angle / 10} deg" for angle in range(220, 401, 5)]
    band = gm.insensitivity_band(scene, over=angles, resistance="40 N")
    lifts = 1000.0 * 0.6 * (1.0 - np.cos(np.radians(np.arange(22.0, 40.25, 0.5))))  # of two rods of 300 mm
    plot = Plot((90.0, 135.0), (40.0, 125.0))
    plot.axes("speed, rpm", "lift of the sleeve, mm", range(90, 136, 10), range(60, 121, 20))
    plot.area([*(band.falling_speed * RPM), *(band.rising_speed[::-1] * RPM)], [*lifts, *lifts[::-1]], PALE)
    run = gm.run(scene)
    plot.curve(run.readings["spindle_speed"] * RPM, 1000.0 * run.readings["sleeve_lift"], BLUE)
    plot.words(117.0, 90.0, "friction holds it", INK, "middle")
    plot.words(130.0, 92.0, "rises", BLUE)
    plot.words(105.5, 86.0, "sinks", BLUE, "end")
    return plot.save("friction")


def draw_jump() -> Path:
    """Draw the speed curve of a governor whose lower part is unstable, and the way of a run that goes up and down."""
    curve = gm.speed_curve("watt_improved")
    angles, speeds = np.degrees(curve.coordinate), curve.speed * RPM
    (fold,) = curve.folds
    shown = (angles > 22.0) & (angles < 43.0)
    unstable = shown & (angles < math.degrees(fold[0]))
    stable = shown & (angles >= math.degrees(fold[0]))
    plot = Plot((60.0, 62.5), (22.0, 43.0))
    plot.axes("speed, rpm", "arm angle, degrees", (60, 60.5, 61, 61.5, 62, 62.5), range(25, 41, 5))
    plot.curve(speeds[unstable], angles[unstable], FADED, dashes="7 5")
    plot.curve(speeds[stable], angles[stable], FADED, width=5.0)
    run = gm.run("watt_improved")
    plot.curve(run.readings["spindle_speed"] * RPM, np.degrees(run.readings["arm_angle"]), BLUE, width=2.0)
    plot.dot(fold[1] * RPM, math.degrees(fold[0]), ORANGE)
    plot.words(61.72, 33.0, "jumps up", BLUE)
    plot.words(60.26, 27.0, "falls", BLUE)
    plot.words(61.1, 27.6, "unstable", GREY)
    plot.words(60.9, 37.9, "stable", GREY, "end")
    return plot.save("jump")


def draw_lead() -> Path:
    """Draw the way of the valve beyond its lap about the dead centre of the piston, for three leads."""
    plot = Plot((-30.0, 30.0), (-8.0, 24.0))
    plot.axes(
        "crank angle from the dead centre, degrees",
        "opening of the port, mm, for leads of 0, 6, 12 mm",
        range(-30, 31, 10),
        range(-5, 21, 5),
    )
    plot.curve((-30.0, 30.0), (0.0, 0.0), GREY, width=1.2)
    plot.curve((0.0, 0.0), (-8.0, 24.0), GREY, width=1.2, dashes="4 4")
    degrees = np.linspace(-30.0, 30.0, 121)
    for lead, colour in ((0.0, FADED), (12.0, FADED), (6.0, BLUE)):
        displacement = 1000.0 * gm.kinematics(valve_with_lead(lead), values=np.radians(degrees + 360.0)).readings["valve_displacement"]
        opening = displacement - displacement[60] + lead  # at the dead centre the port is open by the lead
        plot.curve(degrees, opening, colour, width=3.0 if lead == 6.0 else 2.0)
        plot.words(float(np.interp(19.0, opening, degrees)) + 0.9, 18.0, f"{lead:g}", BLUE if lead == 6.0 else GREY)
    plot.dot(0.0, 6.0, BLUE)
    return plot.save("lead")


def draw_line() -> Path:
    """Draw Watt's linkage, pale, and the path of its pen with the deviations magnified."""
    plot = Plot((-0.4, 2.9), (-0.36, 1.369))  # one scale for both
    magnified = 50.0
    for angle in (-20.0, 0.0, 20.0):
        a = math.radians(angle)
        start = gm.kinematics("watt_linkage", values=[f"{angle} deg"])
        middle = start.paths["coupler.end"][0]
        way = [(0.0, 0.0), (math.cos(a), math.sin(a)), (float(middle[0]), float(middle[1])), (2.0, 1.0)]
        plot.curve(*zip(*way, strict=True), GREY if angle == 0.0 else FADED, width=5.0 if angle == 0.0 else 2.5)
        for x, y in way:
            plot.dot(x, y, GREY if angle == 0.0 else FADED)
    pen = gm.kinematics("watt_linkage", values=[f"{angle} deg" for angle in range(-32, 33)]).paths["pen"]
    plot.curve(1.0 + magnified * (pen[:, 0] - 1.0), pen[:, 1], FADED, width=2.5)
    used = slice(12, 53)
    plot.curve(1.0 + magnified * (pen[used, 0] - 1.0), pen[used, 1], BLUE, width=3.5)
    plot.dot(1.0, 0.5, BLUE)
    plot.words(1.16, 0.47, "path of the pen over ±20°,", BLUE)
    plot.words(1.16, 0.32, "deviations drawn 50 times", BLUE)
    return plot.save("line")


def draw_flywheel() -> Path:
    """Draw the torque of an engine over half a turn, and the work that it does beyond its load."""
    run = gm.run(engine_with_flywheel())
    angles = np.degrees(run.readings["crank_angle"])
    half = (angles >= 0.0) & (angles <= 182.0)
    angles, torque, load = angles[half], run.readings["gas_torque"][half], run.readings["load_torque"][half]
    plot = Plot((0.0, 180.0), (-4500.0, 4500.0))
    plot.axes("crank angle, degrees", "torque, N m", range(0, 181, 30), (-4000, -2000, 0, 2000, 4000))
    surplus = torque >= load
    plot.area([*angles[surplus], *angles[surplus][::-1]], [*torque[surplus], *load[surplus][::-1]], PALE)
    plot.curve(angles, torque, BLUE)
    plot.curve(angles, load, ORANGE)
    plot.words(46.0, 1300.0, "3155 J too much", INK, "middle")
    plot.words(178.0, 700.0, "load", ORANGE, "end")
    plot.words(86.0, 2600.0, "gas", BLUE)
    return plot.save("flywheel")


DRAWINGS = (draw_hunting, draw_friction, draw_jump, draw_lead, draw_line, draw_flywheel)

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for draw in DRAWINGS:
        print(draw())
