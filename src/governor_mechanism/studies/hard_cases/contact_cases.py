"""Hard cases of parts that touch: corners hit exactly, gaps of a nanometre, grazing, edges that go over into arcs, two sides at once.

Also a table whose strikes accumulate while it moves, a ledge, at which a contact is lost and found again within a step, and a strut that
locks itself by friction.
"""

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from governor_mechanism.model.results.records import Outcome
from governor_mechanism.studies.hard_cases.case import GRAVITY, Document, HardCase, Solution, bouncing_fall, integrate, run_table
from governor_mechanism.types import FloatArray

RADIUS = 0.02
"""Radius of the ball, m."""

SPEED = 1.0
"""Speed of a ball that passes a disc, m/s."""

DISC = 0.1
"""Radius of the disc, m."""

SLOPE = math.radians(30)
"""Angle of a slope, and half of what a groove lacks to a half turn."""

SLOPE_LENGTH = 0.3
"""Way of the ball on the slope, m."""


def _ball(
    outline: object, *, place: tuple[float, float], rate: float = 0.0, gravity: bool = True, restitution: float, duration: float
) -> Document:
    """Return a ball of 1 kg that moves to the right above a part at rest."""
    return {
        "machine": "custom",
        "size": 0.1,
        "ground": {"O": [0.0, 0.0]},
        "body": [
            {"name": "part", "mass": 1.0, "inertia": 1.0, "outline": outline},
            {"name": "ball", "mass": 1.0, "point": True, "at": list(place)},
        ],
        "joint": [{"type": "weld", "first": "ground.O", "second": "part.origin"}],
        "contact": [{"name": "ball", "first": "ball.origin", "radius": RADIUS, "second": "part", "restitution": restitution}],
        "readings": {"x": {"x": "ball.origin"}, "y": {"y": "ball.origin"}},
        "effects": {"gravity": GRAVITY if gravity else False},
        "start": {"x": place[0], "y": place[1], "x_rate": rate, "y_rate": 0.0},
        "run": run_table(duration),
    }


def _floor(width: float = 0.5) -> list[list[float]]:
    return [[-width, -0.2], [width, -0.2], [width, 0.0], [-width, 0.0]]


CORNER_HEIGHT = 0.05


def _corner(offset: float) -> Document:
    """Return a ball above a corner, beside it by an offset."""
    outline = [[-0.5, -0.2], [0.0, -0.2], [0.0, 0.0], [-0.5, 0.0]]
    height = math.sqrt(RADIUS**2 - offset**2) + CORNER_HEIGHT
    return _ball(outline, place=(offset, height), restitution=1.0, duration=0.18)


def _solve_corner(offset: float, times: FloatArray) -> Solution:
    lift = math.sqrt(RADIUS**2 - offset**2)
    fall = math.sqrt(2 * CORNER_HEIGHT / GRAVITY)
    normal = np.array([offset, lift]) / RADIUS
    velocity = np.array([0.0, -GRAVITY * fall])
    velocity -= 2 * (normal @ velocity) * normal
    since, falls = times - fall, times < fall
    x = np.where(falls, offset, offset + velocity[0] * since)
    y = np.where(falls, lift + CORNER_HEIGHT - GRAVITY * times**2 / 2, lift + velocity[1] * since - GRAVITY * since**2 / 2)
    y_rate = np.where(falls, -GRAVITY * times, velocity[1] - GRAVITY * since)
    return {"x": (x, np.where(falls, 0.0, velocity[0])), "y": (y, y_rate)}


def _gap(gap: float) -> Document:
    return _ball(_floor(), place=(0.0, RADIUS + gap), restitution=0.5, duration=0.5)


def _solve_gap(gap: float, times: FloatArray) -> Solution:
    height, rate = bouncing_fall(times, gap, 0.0, 0.5)
    return {"y": (RADIUS + height, rate)}


TABLE_SPEED, FALL = 2 * math.pi * 10.0, 5e-3
"""Angular frequency of a table that moves up and down, rad/s, and height of the ball above its middle at the start, m."""


def _table(share: float) -> Document:
    """Return a ball above a table that swings up and down, with its largest acceleration as a share of that of gravity."""
    document = _ball(_floor(), place=(0.0, RADIUS + FALL), restitution=0.5, duration=0.5)
    swing = {"amplitude": share * GRAVITY / TABLE_SPEED**2, "frequency": TABLE_SPEED / math.tau}
    return {**document, "ground": {"O": [0.0, {"harmonics": [swing]}]}}


def _solve_table(share: float, times: FloatArray) -> Solution:
    """Return the parabolas between strikes, which accumulate at the rest on the table; above it the ball always falls toward it."""
    swing = share * GRAVITY / TABLE_SPEED**2
    begin = 0.0
    height = FALL
    rate = 0.0
    heights = swing * np.sin(TABLE_SPEED * times)
    rates = swing * TABLE_SPEED * np.cos(TABLE_SPEED * times)
    while begin < times[-1]:
        approach = rate - swing * TABLE_SPEED * math.cos(TABLE_SPEED * begin)
        gap = height - swing * math.sin(TABLE_SPEED * begin)
        if gap < 1e-15 and approach < 1e-7:  # the height of what is left of the bounces is below rounding
            break
        first, last = (
            (approach + math.sqrt(approach**2 + 2 * pull * gap)) / pull for pull in (GRAVITY * (1 + share), GRAVITY * (1 - share))
        )

        def distance(since: float, start: float = begin, height: float = height, rate: float = rate) -> float:
            return height + rate * since - GRAVITY * since**2 / 2 - swing * math.sin(TABLE_SPEED * (start + since))

        flight = brentq(distance, 0.999 * first, 1.001 * last, xtol=1e-16)
        inside = (times >= begin) & (times <= begin + flight)
        since = times[inside] - begin
        heights[inside] = height + rate * since - GRAVITY * since**2 / 2
        rates[inside] = rate - GRAVITY * since
        begin += flight
        height = swing * math.sin(TABLE_SPEED * begin)
        table_rate = swing * TABLE_SPEED * math.cos(TABLE_SPEED * begin)
        rate = table_rate - 0.5 * (rate - GRAVITY * flight - table_rate)
    return {"y": (RADIUS + heights, rates)}


def _graze(overlap: float) -> Document:
    """Return a ball that flies past a disc without weight, and touches it by an overlap of both paths."""
    outline = [[DISC, 0.0, DISC], [-DISC, 0.0, DISC]]
    return _ball(outline, place=(-0.1, DISC + RADIUS - overlap), rate=SPEED, gravity=False, restitution=1.0, duration=0.2)


def _solve_graze(overlap: float, times: FloatArray) -> Solution:
    reach, height = DISC + RADIUS, DISC + RADIUS - overlap
    along = -math.sqrt(overlap * (2 * reach - overlap))
    normal, impact = np.array([along, height]) / reach, (along + 0.1) / SPEED
    velocity = np.array([SPEED, 0.0]) - 2 * SPEED * normal[0] * normal
    flies, since = times < impact, times - impact
    x = np.where(flies, -0.1 + SPEED * times, along + velocity[0] * since)
    y = np.where(flies, height, height + velocity[1] * since)
    return {"x": (x, np.where(flies, SPEED, velocity[0])), "y": (y, np.where(flies, 0.0, velocity[1]))}


def _fillet(radius: float) -> Document:
    """Return a ball on a slope that goes over into a floor by a hollow arc of a radius, with the centre of the arc at x = 0."""
    lip = radius * math.sin(SLOPE)
    top = [-lip - 0.6 * math.cos(SLOPE), radius * (1 - math.cos(SLOPE)) + 0.6 * math.sin(SLOPE)]
    outline = [[top[0], -0.2], [2.0, -0.2], [2.0, 0.0], [0.0, 0.0, -radius], [-lip, radius * (1 - math.cos(SLOPE))], top]
    path = radius - RADIUS
    place = -path * math.sin(SLOPE) - SLOPE_LENGTH * math.cos(SLOPE), radius - path * math.cos(SLOPE) + SLOPE_LENGTH * math.sin(SLOPE)
    return _ball(outline, place=place, restitution=0.0, duration=0.6)


def _solve_fillet(radius: float, times: FloatArray) -> Solution:
    """Return a steady acceleration on the slope, the swing of a pendulum in the arc, and a steady speed on the floor."""
    path, pull = radius - RADIUS, GRAVITY * math.sin(SLOPE)
    leaves = math.sqrt(2 * SLOPE_LENGTH / pull)
    speed = math.sqrt(2 * SLOPE_LENGTH * pull)
    last_speed = math.sqrt(speed**2 + 2 * GRAVITY * path * (1 - math.cos(SLOPE)))
    passage = quad(
        lambda angle: path / math.sqrt(speed**2 + 2 * GRAVITY * path * (math.cos(angle) - math.cos(SLOPE))), 0.0, SLOPE, epsabs=1e-14
    )

    def slope(time: float, state: FloatArray) -> list[float]:
        return [float(state[1]), GRAVITY * math.sin(SLOPE - float(state[0]) / path)]

    reaches = leaves + passage[0]
    in_arc = (times > leaves) & (times < reaches)
    ways = np.where(times <= leaves, pull * times**2 / 2 - SLOPE_LENGTH, path * SLOPE + last_speed * (times - reaches))
    rates = np.where(times <= leaves, pull * times, last_speed)
    ways[in_arc], rates[in_arc] = integrate(slope, [0.0, speed], np.append(times[in_arc] - leaves, passage[0]))[:, :-1]
    angles = np.clip(SLOPE - ways / path, 0.0, SLOPE)
    beyond = np.where(ways < 0.0, ways, np.maximum(ways - path * SLOPE, 0.0))
    x = -path * np.sin(angles) + beyond * np.cos(angles)
    y = radius - path * np.cos(angles) - beyond * np.sin(angles)
    return {"x": (x, rates * np.cos(angles)), "y": (y, -rates * np.sin(angles))}


GROOVE_DEPTH = 0.05


def _groove(restitution: float) -> Document:
    """Return a ball that falls into the middle of a groove, on both of its sides at once."""
    side = 0.3
    outline = [[0.3, -0.2], [0.3, side * math.tan(SLOPE)], [0.0, 0.0], [-0.3, side * math.tan(SLOPE)], [-0.3, -0.2], [0.0, -0.15]]
    return _ball(outline, place=(0.0, RADIUS / math.cos(SLOPE) + GROOVE_DEPTH), restitution=restitution, duration=0.8)


def _solve_groove(restitution: float, times: FloatArray) -> Solution:
    height, rate = bouncing_fall(times, GROOVE_DEPTH, 0.0, restitution)
    return {"y": (RADIUS / math.cos(SLOPE) + height, rate)}


LEDGE_PLACE = 0.1
"""Way of the ball to the ledge, m."""


def _ledge(depth: float) -> Document:
    """Return a ball that slides over a ledge onto a floor which is lower by a depth, toward a wall that it does not reach."""
    wall = [[0.6, -0.2], [0.6, 0.2], [0.5, 0.2], [0.5, -depth]]
    outline = [[-0.5, -0.2], *wall, [0.0, -depth], [0.0, 0.0], [-0.5, 0.0]]
    return _ball(outline, place=(-LEDGE_PLACE, RADIUS), rate=SPEED, restitution=0.0, duration=0.3)


def _solve_ledge(depth: float, times: FloatArray) -> Solution:
    """Return a fall from the ledge: so fast a ball does not turn round its edge."""
    since = np.maximum(times - LEDGE_PLACE / SPEED, 0.0)
    falls = since < math.sqrt(2 * depth / GRAVITY)
    height = RADIUS - np.where(falls, GRAVITY * since**2 / 2, depth)
    return {"x": (SPEED * times - LEDGE_PLACE, np.full_like(times, SPEED)), "y": (height, np.where(falls, -GRAVITY * since, 0.0))}


STRUT = 0.4
STRUT_ANGLE = math.radians(30)
STRUT_TIP = 0.01
PLATE_SPEED = 0.5
"""Length of the strut and radius of its tip, m, its angle against the vertical, and the speed of the plate, m/s."""

LOCKING_FRICTION = STRUT * math.sin(STRUT_ANGLE) / (STRUT * math.cos(STRUT_ANGLE) + STRUT_TIP)
"""Coefficient of friction at which friction presses the strut as much as the plate lifts it."""


def _strut(ratio: float) -> Document:
    """Return a strut of 1 kg that leans on a plate of 1 kg, which moves toward its pivot; friction relative to that which locks it."""
    pivot = STRUT * math.cos(STRUT_ANGLE) + STRUT_TIP
    return {
        "machine": "custom",
        "size": STRUT,
        "ground": {"O": [0.0, 0.0], "pivot": [0.0, pivot]},
        "body": [
            {"name": "plate", "mass": 1.0, "turns": False, "outline": [[-1.0, -0.1], [1.0, -0.1], [1.0, 0.0], [-1.0, 0.0]]},
            {"name": "strut", "mass": 1.0, "rod": {"length": STRUT}, "at": [0.0, pivot], "angle": STRUT_ANGLE - math.pi / 2},
        ],
        "joint": [
            {"type": "slider", "first": "ground.O", "second": "plate.origin", "angle": 0.0},
            {"type": "pin", "first": "ground.pivot", "second": "strut.start"},
        ],
        "contact": [{"name": "tip", "first": "strut.end", "radius": STRUT_TIP, "second": "plate", "friction": ratio * LOCKING_FRICTION}],
        "readings": {"x": {"x": "plate.origin"}, "turn": {"angle": "strut"}},
        "effects": {"gravity": GRAVITY},
        "start": {"tip_gap": 0.0, "tip_rate": 0.0, "x": 0.0, "x_rate": -PLATE_SPEED},
        "run": run_table(0.5),
    }


def _solve_strut(ratio: float, times: FloatArray) -> Solution:
    """Return the plate slowed by friction: the moments of weight, normal force and friction about the pivot balance."""
    slowing = ratio * LOCKING_FRICTION * GRAVITY / (2 * (1 - ratio))
    moving = np.minimum(times, PLATE_SPEED / slowing if slowing else math.inf)
    still = np.zeros_like(times)
    return {
        "x": (slowing * moving**2 / 2 - PLATE_SPEED * moving, slowing * moving - PLATE_SPEED),
        "turn": (still + STRUT_ANGLE - math.pi / 2, still),
    }


CASES = (
    HardCase(
        name="corner",
        title="Ball that falls on a corner, beside its middle or exactly on it",
        parameter="distance beside the corner, m",
        values=(0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.0199),
        short_values=(0.0, 1e-3),
        make_document=_corner,
        solve=_solve_corner,
    ),
    HardCase(
        name="contact-gap",
        title="Ball above a floor, which bounces until it rests",
        parameter="gap at the start, m",
        values=(0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1),
        short_values=(1e-9,),
        make_document=_gap,
        solve=_solve_gap,
    ),
    HardCase(
        name="driven-table",
        title="Ball that bounces on a table that swings up and down until it rests on it",
        parameter="acceleration of the table relative to gravity",
        values=(0.1, 0.5, 0.9, 0.99),
        short_values=(0.5,),
        make_document=_table,
        solve=_solve_table,
    ),
    HardCase(
        name="grazing",
        title="Ball that flies past a disc and touches it within a step",
        parameter="overlap of both paths, m",
        values=(1e-12, 1e-9, 1e-6, 1e-3, 1e-2),
        short_values=(1e-9,),
        make_document=_graze,
        solve=_solve_graze,
    ),
    HardCase(
        name="fillet",
        title="Ball that slides from a slope through an arc onto a floor",
        parameter="radius of the arc, m",
        values=(0.0201, 0.021, 0.03, 0.1),
        short_values=(0.03,),
        make_document=_fillet,
        solve=_solve_fillet,
    ),
    HardCase(
        name="groove",
        title="Ball that falls into a groove, on both sides at once",
        parameter="restitution",
        values=(0.0, 0.3, 0.7, 0.9),
        short_values=(0.3,),
        make_document=_groove,
        solve=_solve_groove,
    ),
    HardCase(
        name="ledge",
        title="Ball that slides over a ledge: contact lost and found within a step",
        parameter="depth of the ledge, m",
        values=(1e-10, 1e-8, 1e-6, 1e-4, 1e-2),
        short_values=(1e-6,),
        make_document=_ledge,
        solve=_solve_ledge,
    ),
    HardCase(
        name="self-locking",
        title="Strut that rubs on a plate, up to self-locking and beyond",
        parameter="friction relative to that which locks",
        values=(0.0, 0.5, 0.9, 0.999, 1.001, 2.0),
        short_values=(0.9, 1.001),
        make_document=_strut,
        solve=_solve_strut,
        named_ends={Outcome.STALLED: "friction jams the strut"},
    ),
)
