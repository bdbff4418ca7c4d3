"""Long mechanisms: a chain of four-bar loops, and a hanging chain of rods."""

from __future__ import annotations

import math

from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.scene import FIXED_PLANE, Part, RunSettings, Scene, Spindle, Start

LINK_LENGTH = 0.1
"""m: a rod of the hanging chain."""


def four_bar_chain(loops: int, duration: float, output_interval: float) -> Scene:
    """IFToMM A02: cranks and couplers of 1 m and 1 kg, each crank pinned to the ground 1 m from the last.

    All stand upright and begin to turn forwards at 1 rad/s; twice in a turn all bars lie in one line.
    """
    uniform = SecondMoments(xx=1 / 12)
    bodies, sketch = [Body(name="crank 0", mass=1.0, second_moments=uniform)], [(0.0, 0.5, math.pi / 2)]
    joints = [_pin("A0", Point(body=GROUND), Point(body="crank 0", x=-0.5))]
    for k in range(1, loops + 1):
        coupler, crank = f"coupler {k}", f"crank {k}"
        bodies += [Body(name=name, mass=1.0, second_moments=uniform) for name in (coupler, crank)]
        sketch += [(k - 0.5, 1.0, 0.0), (float(k), 0.5, math.pi / 2)]
        joints += [
            _pin(f"A{k}", Point(body=GROUND, x=float(k)), Point(body=crank, x=-0.5)),
            _pin(f"B{k} left", Point(body=f"crank {k - 1}", x=0.5), Point(body=coupler, x=-0.5)),
            _pin(f"B{k} right", Point(body=coupler, x=0.5), Point(body=crank, x=0.5)),
        ]
    reading = BodyAngle(name="crank_angle", quantity="angle", body="crank 0")
    mechanism = Mechanism(
        bodies=tuple(bodies), joints=tuple(joints), readings=(reading,), coordinate=reading.name, length_scale=1.0,
        initial_guess=tuple(sketch),
    )  # fmt: skip
    start = Start(values={"crank_angle": math.pi / 2}, rates={"crank_angle": -1.0})
    return _scene(f"{loops} four-bar loops", mechanism, start, RunSettings(duration=duration, output_interval=output_interval))


def four_bar_acceleration(loops: int, angle: float, gravity: float) -> float:
    """Angular acceleration (rad/s2) of the cranks: couplers are carried round in a circle without turning."""
    inertia = (loops + 1) / 3 + loops
    return -gravity * ((loops + 1) / 2 + loops) * math.cos(angle) / inertia


def hanging_chain(rods: int, duration: float, output_interval: float) -> Scene:
    """Rods of 0.1 m and 0.1 kg, pinned end to end and to the ground, let go straight and at a slant."""
    lean = -1.2
    bodies = [Body(name=f"{k}", mass=0.1, second_moments=SecondMoments(xx=0.1 * LINK_LENGTH**2 / 12)) for k in range(rods)]
    ends = [Point(body=GROUND), *(Point(body=body.name, x=LINK_LENGTH / 2) for body in bodies)]
    joints = [_pin(body.name, end, Point(body=body.name, x=-LINK_LENGTH / 2)) for body, end in zip(bodies, ends, strict=False)]
    sketch = [((k + 0.5) * LINK_LENGTH * math.cos(lean), (k + 0.5) * LINK_LENGTH * math.sin(lean), lean) for k in range(rods)]
    reading = BodyAngle(name="lean", quantity="angle", body="0")
    mechanism = Mechanism(
        bodies=tuple(bodies), joints=tuple(joints), readings=(reading,), coordinate=reading.name, length_scale=LINK_LENGTH,
        initial_guess=tuple(sketch),
    )  # fmt: skip
    return _scene(f"{rods} rods in a chain", mechanism, Start(), RunSettings(duration=duration, output_interval=output_interval))


def _pin(name: str, first: Point, second: Point) -> Pin:
    return Pin(name=name, first=first, second=second)


def _scene(title: str, mechanism: Mechanism, start: Start, run: RunSettings) -> Scene:
    part = Part(name="chain", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE)
    return Scene(title=title, parts=(part,), effects=(Gravity(),), spindle=Spindle(), start=start, run=run)
