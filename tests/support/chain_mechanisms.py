"""Long mechanisms: a chain of four-bar loops, and a hanging chain of rods."""

import math

from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.part import FIXED_PLANE, Part, Start
from governor_mechanism.model.scene import RunSettings, Scene

LINK_LENGTH = 0.1
"""Length of a rod of the hanging chain, m."""


def four_bar_chain(loops: int, duration: float, output_interval: float) -> Scene:
    """Return IFToMM problem A02: cranks and couplers of 1 m and 1 kg, the cranks pinned to the ground 1 m apart.

    All cranks start upright with 1 rad/s; twice per turn all bars are in one line.
    """
    uniform = SecondMoments(xx=1 / 12)
    bodies, initial_guess = [Body(name="crank 0", mass=1.0, second_moments=uniform)], [(0.0, 0.5, math.pi / 2)]
    joints = [_pin("A0", Point(body=GROUND), Point(body="crank 0", x=-0.5))]
    for k in range(1, loops + 1):
        coupler, crank = f"coupler {k}", f"crank {k}"
        bodies += [Body(name=name, mass=1.0, second_moments=uniform) for name in (coupler, crank)]
        initial_guess += [(k - 0.5, 1.0, 0.0), (float(k), 0.5, math.pi / 2)]
        joints += [
            _pin(f"A{k}", Point(body=GROUND, x=float(k)), Point(body=crank, x=-0.5)),
            _pin(f"B{k} left", Point(body=f"crank {k - 1}", x=0.5), Point(body=coupler, x=-0.5)),
            _pin(f"B{k} right", Point(body=coupler, x=0.5), Point(body=crank, x=0.5)),
        ]
    reading = BodyAngle(name="crank_angle", quantity="angle", body="crank 0")
    mechanism = Mechanism(
        bodies=tuple(bodies), joints=tuple(joints), readings=(reading,), coordinate=reading.name, length_scale=1.0,
        initial_guess=tuple(initial_guess),
    )  # fmt: skip
    start = Start(values={"crank_angle": math.pi / 2}, rates={"crank_angle": -1.0})
    return _scene(f"{loops} four-bar loops", mechanism, start, RunSettings(duration=duration, output_interval=output_interval))


def four_bar_acceleration(loops: int, angle: float, gravity: float) -> float:
    """Return the angular acceleration (rad/s2) of the cranks; the couplers translate on a circle."""
    inertia = (loops + 1) / 3 + loops
    return -gravity * ((loops + 1) / 2 + loops) * math.cos(angle) / inertia


def hanging_chain(rods: int, duration: float, output_interval: float) -> Scene:
    """Return rods of 0.1 m and 0.1 kg, pinned end to end and to the ground, released straight and inclined."""
    inclination = -1.2
    bodies = [Body(name=f"{k}", mass=0.1, second_moments=SecondMoments(xx=0.1 * LINK_LENGTH**2 / 12)) for k in range(rods)]
    ends = [Point(body=GROUND), *(Point(body=body.name, x=LINK_LENGTH / 2) for body in bodies)]
    joints = [_pin(body.name, end, Point(body=body.name, x=-LINK_LENGTH / 2)) for body, end in zip(bodies, ends, strict=False)]
    initial_guess = [
        ((k + 0.5) * LINK_LENGTH * math.cos(inclination), (k + 0.5) * LINK_LENGTH * math.sin(inclination), inclination) for k in range(rods)
    ]
    reading = BodyAngle(name="lean", quantity="angle", body="0")
    mechanism = Mechanism(
        bodies=tuple(bodies), joints=tuple(joints), readings=(reading,), coordinate=reading.name, length_scale=LINK_LENGTH,
        initial_guess=tuple(initial_guess),
    )  # fmt: skip
    return _scene(f"{rods} rods in a chain", mechanism, Start(), RunSettings(duration=duration, output_interval=output_interval))


def _pin(name: str, first: Point, second: Point) -> Pin:
    return Pin(name=name, first=first, second=second)


def _scene(title: str, mechanism: Mechanism, start: Start, run: RunSettings) -> Scene:
    part = Part(name="chain", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE, effects=(Gravity(),), start=start)
    return Scene(title=title, parts=(part,), run=run)
