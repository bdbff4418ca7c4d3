"""Writes the sketches with the symbols of the formulas into the folder sketches: python docs/machines/sketches.py."""

from __future__ import annotations

import math
import re
from pathlib import Path

FOLDER = Path(__file__).parent / "sketches"
INK, GREY, BLUE, ORANGE, GROUND = "#1f2933", "#7b8794", "#1668c8", "#c4540a", "#fbfaf4"
Place = tuple[float, float]


class Sketch:
    """A drawing in SVG with x to the right and y up, in units of which `scale` pixels make one.

    Parameters
    ----------
    left, bottom, right, top
        Ends of the drawing.
    scale
        Pixels of a unit.
    """

    def __init__(self, left: float, bottom: float, right: float, top: float, scale: float) -> None:
        self.left, self.top, self.scale = left, top, scale
        self.width, self.height = (right - left) * scale, (top - bottom) * scale
        self.elements: list[str] = []

    def pixel(self, place: Place) -> Place:
        """Return a place in pixels."""
        return (place[0] - self.left) * self.scale, (self.top - place[1]) * self.scale

    def line(self, *places: Place, colour: str = INK, width: float = 2.0, dashes: str = "", arrows: str = "") -> None:
        """Draw a line through places; `arrows` is "end" or "both"."""
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.pixel, places))
        marks = {"end": ' marker-end="url(#arrow)"', "both": ' marker-start="url(#arrow)" marker-end="url(#arrow)"'}.get(arrows, "")
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.elements.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{width}"{dashed}{marks}/>')

    def circle(self, centre: Place, radius: float, fill: str = GROUND, colour: str = INK) -> None:
        """Draw a circle; the radius is in pixels."""
        x, y = self.pixel(centre)
        self.elements.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{fill}" stroke="{colour}" stroke-width="1.6"/>')

    def box(self, centre: Place, width: float, height: float, fill: str = "#f3c9a5") -> None:
        """Draw a rectangle of a width and a height in units."""
        x, y = self.pixel((centre[0] - width / 2, centre[1] + height / 2))
        size = f'width="{width * self.scale:.1f}" height="{height * self.scale:.1f}"'
        self.elements.append(f'<rect x="{x:.1f}" y="{y:.1f}" {size} fill="{fill}" stroke="{INK}" stroke-width="1.6"/>')

    def label(self, place: Place, text: str, dx: float = 0.0, dy: float = 0.0, colour: str = INK) -> None:
        """Write a symbol, as "x_H" with a subscript, about a place; dx to the right and dy up are in pixels."""
        x, y = self.pixel(place)
        words = re.sub(r"_(\w+)", r'<tspan font-size="13" dy="5">\1</tspan>', text)
        self.elements.append(f'<text x="{x + dx:.1f}" y="{y - dy + 6:.1f}" text-anchor="middle" fill="{colour}">{words}</text>')

    def rod(self, first: Place, second: Place, text: str = "", side: float = 14.0, at: float = 0.5) -> None:
        """Draw a rod with its symbol beside it, `side` pixels to the left of its direction."""
        self.line(first, second, width=3.2)
        if text:
            length = math.dist(first, second)
            across = ((first[1] - second[1]) / length, (second[0] - first[0]) / length)
            middle = (first[0] + at * (second[0] - first[0]), first[1] + at * (second[1] - first[1]))
            self.label(middle, text, dx=side * across[0], dy=side * across[1])

    def dimension(self, first: Place, second: Place, text: str, dx: float = 0.0, dy: float = 11.0) -> None:
        """Draw a dimension line with its symbol."""
        self.line(first, second, colour=GREY, width=1.1, arrows="both")
        self.label(((first[0] + second[0]) / 2, (first[1] + second[1]) / 2), text, dx=dx, dy=dy, colour=BLUE)

    def angle(self, centre: Place, radius: float, start: float, end: float, text: str, reach: float = 15.0) -> None:
        """Draw an angle from start to end (deg, anticlockwise from +x) with an arrow, at a radius in units; the symbol is outside."""
        steps = [math.radians(start + (end - start) * k / 24) for k in range(25)]
        arc = [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in steps]
        self.line(*arc, colour=GREY, width=1.2, arrows="end")
        middle = steps[12]
        self.label(arc[12], text, dx=reach * math.cos(middle), dy=reach * math.sin(middle), colour=BLUE)

    def axis(self, *places: Place) -> None:
        """Draw a centre line."""
        self.line(*places, colour=GREY, width=1.0, dashes="12 3 2 3")

    def thin(self, *places: Place) -> None:
        """Draw an auxiliary line."""
        self.line(*places, colour=GREY, width=1.0, dashes="4 3")

    def pin(self, place: Place) -> None:
        """Draw a joint."""
        self.circle(place, 4.5)

    def fixed(self, place: Place) -> None:
        """Draw a joint on the frame."""
        self.circle(place, 4.5, fill=INK)

    def write(self, name: str, title: str) -> None:
        """Write the file."""
        arrow = (
            '<marker id="arrow" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8" markerHeight="8" orient="auto-start-reverse">'
            f'<path d="M0,1.5 L10,5 L0,8.5 z" fill="{GREY}"/></marker>'
        )
        head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:.0f} {self.height:.0f}" '
        head += f'width="{self.width:.0f}" height="{self.height:.0f}" font-family="Georgia, serif" font-size="18" font-style="italic">'
        lines = [head, f"<title>{title}</title>", f"<defs>{arrow}</defs>", f'<rect width="100%" height="100%" fill="{GROUND}"/>']
        (FOLDER / f"{name}.svg").write_text("\n".join([*lines, *self.elements, "</svg>"]) + "\n", encoding="utf-8")


def polar(centre: Place, length: float, degrees: float) -> Place:
    """Return the place at a distance and a direction (deg, anticlockwise from +x)."""
    return centre[0] + length * math.cos(math.radians(degrees)), centre[1] + length * math.sin(math.radians(degrees))


def draw_pendulum() -> None:
    """Right half of a pendulum governor with extended arms."""
    s = Sketch(-0.09, -0.56, 0.42, 0.09, 900)
    suspension, arm, joint_length, link, lug_x = (0.06, 0.0), 0.4, 0.27, 0.26, 0.045
    ball, joint = polar(suspension, arm, -50), polar(suspension, joint_length, -50)
    beta = math.asin((joint[0] - lug_x) / link)
    lug = (lug_x, joint[1] - link * math.cos(beta))
    s.axis((0, 0.08), (0, -0.55))
    s.thin(suspension, (0.06, -0.2))
    s.thin(joint, (joint[0], joint[1] - 0.17))
    s.box((0.0, lug[1] - 0.02), 0.11, 0.05)
    s.rod(suspension, ball)
    s.rod(joint, lug, "l_2", side=-16)
    for distance, end, symbol in ((0.035, joint, "l_1"), (0.08, ball, "l")):
        ends = [polar(place, distance, 40) for place in (suspension, end)]
        s.dimension(ends[0], ends[1], symbol, dx=12, dy=8)
        s.thin(end, polar(end, distance + 0.01, 40))
    s.thin(suspension, polar(suspension, 0.09, 40))
    s.circle(ball, 22, fill=BLUE)
    s.label(ball, "M", dx=34, dy=-6)
    s.label((0, lug[1] - 0.02), "m_s", dy=-2)
    for place in (joint, lug):
        s.pin(place)
    s.fixed(suspension)
    s.dimension((0, 0.05), (0.06, 0.05), "e")
    s.dimension((0, lug[1] - 0.065), (lug_x, lug[1] - 0.065), "e_s", dy=-16)
    s.dimension((0, -0.51), (ball[0], -0.51), "x", dx=20)
    s.thin(ball, (ball[0], -0.52))
    s.angle(suspension, 0.15, -90, -50, "α")
    s.angle(joint, 0.13, -90, -90 - math.degrees(beta), "β")
    s.write("pendulum_governor", "Symbols of the pendulum governor: the right half")


def draw_hartnell() -> None:
    """Right half of a Hartnell governor."""
    s = Sketch(-0.09, -0.10, 0.28, 0.20, 1300)
    pivot, a, b, beta = (0.13, 0.0), 0.13, 0.09, 18.0
    ball, roller = polar(pivot, a, 90 - beta), polar(pivot, b, 180 - beta)
    s.axis((0, 0.19), (0, -0.09))
    s.thin(pivot, (0.13, 0.15))
    s.box((0.0, roller[1] + 0.012), 0.13, 0.014)
    s.box((0.0, roller[1] - 0.03), 0.034, 0.07)
    coil = [((-1) ** k * 0.022, roller[1] + 0.019 + 0.012 * k) for k in range(8)]
    s.line(*coil, colour=INK, width=2)
    s.box((0.0, coil[-1][1] + 0.006), 0.07, 0.01, fill="#cbd2d9")
    s.rod(pivot, ball, "a", side=-15)
    s.rod(pivot, roller, "b", side=-15)
    s.circle(ball, 22, fill=BLUE)
    s.label(ball, "m", dx=36)
    s.circle(roller, 7)
    s.fixed(pivot)
    s.label((0.0, roller[1] - 0.03), "M")
    s.label((-0.05, roller[1] + 0.06), "S")
    s.line((-0.04, roller[1] + 0.075), (-0.04, roller[1] + 0.03), colour=ORANGE, arrows="end")
    s.angle(pivot, 0.1, 90, 90 - beta, "β")
    s.angle(pivot, 0.04, 90 - beta, 180 - beta, "γ")
    s.dimension((0, -0.055), (0.13, -0.055), "p")
    s.thin(pivot, (0.13, -0.065))
    s.dimension((0, 0.165), (ball[0], 0.165), "x", dx=40)
    s.thin(ball, (ball[0], 0.175))
    s.write("hartnell", "Symbols of the Hartnell governor: the right half")


def draw_hartung() -> None:
    """Right half of a Hartung governor, with the weight a little inside."""
    s = Sketch(-0.07, -0.41, 0.28, 0.215, 950)
    fulcrum, a, b, alpha, gamma, lug = (0.122, 0.0), 0.115, 0.16, 12.0, 132.0, (0.03, -0.34)
    weight, top = polar(fulcrum, a, 90 + alpha), polar(fulcrum, b, 90 + alpha + gamma)
    s.axis((0, 0.205), (0, -0.4))
    s.thin((0.122, -0.26), (0.122, 0.14))
    s.box((0.0, -0.355), 0.09, 0.05)
    s.box((weight[0] + 0.035, weight[1]), 0.13, 0.09, fill="#cfe0f3")
    s.rod(fulcrum, weight, "a", side=-15, at=0.35)
    s.rod(fulcrum, top, "b", side=15)
    s.rod(top, lug, "h", side=15)
    s.angle(fulcrum, 0.085, 90, 90 + alpha, "α")
    s.angle(fulcrum, 0.04, 90 + alpha, 90 + alpha + gamma, "γ")
    s.label((weight[0] + 0.06, weight[1]), "M")
    s.line((weight[0], weight[1] + 0.0), (weight[0] - 0.07, weight[1]), colour=ORANGE, arrows="end")
    s.label((weight[0] - 0.075, weight[1]), "P", dy=14)
    for place in (top, lug, weight):
        s.pin(place)
    s.fixed(fulcrum)
    s.label((0.0, -0.36), "m_s", dx=-8)
    s.dimension((0, -0.25), (0.122, -0.25), "x_H", dx=24)
    s.dimension((0, weight[1] + 0.06), (weight[0], weight[1] + 0.06), "x")
    s.thin(weight, (weight[0], weight[1] + 0.065))
    s.dimension((0, -0.31), (lug[0], -0.31), "r_s", dx=34, dy=0)
    s.write("hartung", "Symbols of the Hartung governor: the right half; the lever angle is positive inward")


def draw_proell() -> None:
    """Right half of a Proell governor."""
    s = Sketch(-0.08, -0.51, 0.36, 0.07, 1000)
    suspension, arm, link, d, theta, bend = (0.03, 0.0), 0.25, 0.26, 0.13, 45.0, -25.0
    joint = polar(suspension, arm, -90 + theta)
    lug_x = 0.04
    phi = math.degrees(math.asin((joint[0] - lug_x) / link))
    lug = (lug_x, joint[1] - link * math.cos(math.radians(phi)))
    ball = polar(joint, d, 90 - phi - bend)
    s.axis((0, 0.06), (0, -0.49))
    s.thin(suspension, (0.03, -0.15))
    s.thin(lug, (lug_x, lug[1] + 0.17))
    s.thin(joint, polar(joint, 0.13, 90 - phi))
    s.box((0.0, lug[1] - 0.025), 0.11, 0.05)
    s.rod(suspension, joint, "l", side=15)
    s.rod(lug, joint, "k", side=-15)
    s.rod(joint, ball, "d", side=15)
    s.circle(ball, 20, fill=BLUE)
    s.label(ball, "m", dx=-34)
    s.label((0.0, lug[1] - 0.025), "M")
    s.pin(joint)
    s.pin(lug)
    s.fixed(suspension)
    s.angle(suspension, 0.11, -90, -90 + theta, "θ")
    s.angle(lug, 0.12, 90, 90 - phi, "φ")
    s.angle(joint, 0.1, 90 - phi, 90 - phi - bend, "-ε", reach=18)
    s.dimension((0, 0.035), (0.03, 0.035), "e")
    s.dimension((0, lug[1] - 0.07), (lug_x, lug[1] - 0.07), "e_s", dy=-15)
    s.dimension((0, ball[1] + 0.055), (ball[0], ball[1] + 0.055), "x", dx=40)
    s.thin(ball, (ball[0], ball[1] + 0.06))
    s.write("proell", "Symbols of the Proell governor: the right half")


def draw_slider_crank() -> None:
    """Crank, connecting rod and crosshead."""
    s = Sketch(-0.42, -0.30, 1.55, 0.42, 380)
    crank, rod, t = 0.3, 1.1, 50.0
    pin = polar((0, 0), crank, t)
    crosshead = (pin[0] + math.sqrt(rod**2 - pin[1] ** 2), 0.0)
    s.axis((-0.38, 0), (1.5, 0))
    s.rod((0, 0), pin, "R", side=15)
    s.rod(pin, crosshead, "L", side=15)
    s.box(crosshead, 0.16, 0.09)
    s.angle((0, 0), 0.14, 0, t, "t")
    s.angle(crosshead, 0.32, 180, 180 - math.degrees(math.asin(pin[1] / rod)), "φ")
    s.dimension((0, -0.2), (crosshead[0], -0.2), "X", dy=-16)
    s.thin((0, 0), (0, -0.22))
    s.thin(crosshead, (crosshead[0], -0.22))
    s.pin(pin)
    s.pin(crosshead)
    s.fixed((0, 0))
    s.write("slider_crank", "Symbols of the slider crank")


def draw_slide_valve() -> None:
    """Crank and eccentric on one shaft: the crank angle from the dead centre nearest to the shaft."""
    s = Sketch(-0.42, -0.33, 1.35, 0.42, 420)
    crank, rod, r, eccentric_rod, w, delta = 0.3, 0.85, 0.27, 0.95, 35.0, 25.0
    # the crank turns clockwise here, from the dead centre away from the cylinder
    pin, eccentric = polar((0, 0), crank, 180 - w), polar((0, 0), r, 90 - w - delta)
    crosshead = (pin[0] + math.sqrt(rod**2 - pin[1] ** 2), 0.0)
    valve = (eccentric[0] + math.sqrt(eccentric_rod**2 - eccentric[1] ** 2), 0.0)
    s.axis((-0.38, 0), (1.4, 0))
    s.rod((0, 0), pin, "R", side=-13, at=0.45)
    s.rod(pin, crosshead, "L", side=-14, at=0.66)
    s.rod((0, 0), eccentric, "r", side=-14, at=0.62)
    s.rod(eccentric, valve, "l", side=15, at=0.35)
    s.thin((0, 0), polar((0, 0), 0.36, 90 - w))
    s.angle((0, 0), 0.2, 180, 180 - w, "w")
    s.angle((0, 0), 0.33, 90 - w, 90 - w - delta, "δ")
    s.box(crosshead, 0.13, 0.1, fill="#cfe0f3")
    s.box(valve, 0.13, 0.1)
    s.dimension((0, -0.2), (valve[0], -0.2), "s", dy=-16)
    s.thin((0, 0), (0, -0.22))
    s.thin(valve, (valve[0], -0.22))
    for place in (pin, eccentric, crosshead, valve):
        s.pin(place)
    s.fixed((0, 0))
    s.label(crosshead, "piston", dx=0, dy=-36, colour=GREY)
    s.label(valve, "valve", dx=40, dy=-36, colour=GREY)
    s.write("slide_valve", "Symbols of the slide valve: piston and valve move on one line, drawn on the same side")


def draw_stephenson() -> None:
    """Eccentrics, rods, link and hanger of the link motion, with open rods."""
    s = Sketch(-0.45, -0.46, 1.75, 0.93, 380)
    r, c, rho, delta = 0.26, 0.36, 1.3, 25.0
    forward, back = polar((0, 0), r, 90 - delta), polar((0, 0), r, delta - 90)
    middle = (1.25, 0.12)
    depth = rho - math.sqrt(rho**2 - c**2)
    upper, lower = (middle[0] - depth, middle[1] + c), (middle[0] - depth, middle[1] - c)
    centre = (middle[0] - rho, middle[1])
    span = math.degrees(math.asin(1.2 * c / rho))
    link = [polar(centre, rho, -span + 2 * span * k / 30) for k in range(31)]
    die = polar(centre, rho, math.degrees(math.asin(-middle[1] / rho)))
    hanger_top = (middle[0] + 0.03, 0.82)
    s.axis((-0.42, 0), (1.72, 0))
    s.line(*link, width=9, colour="#cfe0f3")
    s.line(*link, width=1.4)
    s.rod((0, 0), forward, "r", side=-14)
    s.rod((0, 0), back, "r", side=14)
    s.rod(forward, upper, "l", side=15)
    s.rod(back, lower, "l", side=-15)
    s.rod((0, 0), (-0.3, 0), "R", side=14)
    s.rod(middle, hanger_top, "h", side=-15, at=0.6)
    s.angle((0, 0), 0.33, 90, 90 - delta, "δ")
    s.thin((0, 0), (0, 0.42))
    s.dimension((1.0, middle[1]), (1.0, upper[1]), "c", dx=-13, dy=0)
    s.thin(upper, (0.98, upper[1]))
    s.thin(middle, (0.98, middle[1]))
    s.dimension((1.42, die[1]), (1.42, middle[1]), "u", dx=16, dy=0)
    s.thin(middle, (1.44, middle[1]))
    s.thin(centre, polar(centre, rho, span * 0.45))
    s.label(polar(centre, rho * 0.55, span * 0.45), "ρ", dy=-14, colour=BLUE)
    s.box(die, 0.09, 0.1)
    s.rod((die[0] + 0.045, 0), (1.66, 0))
    for place in (forward, back, upper, lower, middle):
        s.pin(place)
    s.fixed((0, 0))
    s.fixed(hanger_top)
    s.label((1.6, 0), "valve", dy=20, colour=GREY)
    s.write("stephenson", "Symbols of the link motion with open rods, crank at the dead centre away from the cylinder")


def draw_all() -> None:
    """Write all sketches."""
    FOLDER.mkdir(exist_ok=True)
    for draw in (draw_pendulum, draw_hartnell, draw_hartung, draw_proell, draw_slider_crank, draw_slide_valve, draw_stephenson):
        draw()


if __name__ == "__main__":
    draw_all()
