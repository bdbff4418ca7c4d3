"""Long mechanisms: a chain of four-bar loops, and a hanging chain of rods."""

import math

from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.model.scene import Scene
from scene_parts import body_angle, body_point, ground_point, make_mechanism, pin, rod_body, scene_of

LINK_LENGTH = 0.1
"""Length of a rod of the hanging chain, m."""


def four_bar_chain(loops: int, duration: float, output_interval: float) -> Scene:
    """Return IFToMM problem A02: cranks and couplers of 1 m and 1 kg, the cranks pinned to the ground 1 m apart.

    All cranks start upright with 1 rad/s; twice per turn all bars are in one line.
    """
    bodies, initial_guess = [rod_body("crank 0", 1.0, 1.0)], [(0.0, 0.5, math.pi / 2)]
    joints = [pin("A0", ground_point(), body_point("crank 0", -0.5))]
    for k in range(1, loops + 1):
        coupler, crank = f"coupler {k}", f"crank {k}"
        bodies += [rod_body(name, 1.0, 1.0) for name in (coupler, crank)]
        initial_guess += [(k - 0.5, 1.0, 0.0), (float(k), 0.5, math.pi / 2)]
        joints += [
            pin(f"A{k}", ground_point(float(k)), body_point(crank, -0.5)),
            pin(f"B{k} left", body_point(f"crank {k - 1}", 0.5), body_point(coupler, -0.5)),
            pin(f"B{k} right", body_point(coupler, 0.5), body_point(crank, 0.5)),
        ]
    mechanism = make_mechanism(bodies, joints, [body_angle("crank 0", "crank_angle")], initial_guess)
    start = {"values": {"crank_angle": math.pi / 2}, "rates": {"crank_angle": -1.0}}
    return scene_of(mechanism, Gravity(), **start, duration=duration, output_interval=output_interval)


def four_bar_acceleration(loops: int, angle: float, gravity: float) -> float:
    """Return the angular acceleration (rad/s2) of the cranks; the couplers translate on a circle."""
    inertia = (loops + 1) / 3 + loops
    return -gravity * ((loops + 1) / 2 + loops) * math.cos(angle) / inertia


def hanging_chain(rods: int, duration: float, output_interval: float) -> Scene:
    """Return rods of 0.1 m and 0.1 kg, pinned end to end and to the ground, released straight and inclined."""
    inclination = -1.2
    bodies = [rod_body(f"{k}", 0.1, LINK_LENGTH) for k in range(rods)]
    ends = [ground_point(), *(body_point(body.name, LINK_LENGTH / 2) for body in bodies)]
    joints = [pin(body.name, end, body_point(body.name, -LINK_LENGTH / 2)) for body, end in zip(bodies, ends, strict=False)]
    middles = [(k + 0.5) * LINK_LENGTH for k in range(rods)]
    sketch = [(middle * math.cos(inclination), middle * math.sin(inclination), inclination) for middle in middles]
    mechanism = make_mechanism(bodies, joints, [body_angle("0", "lean")], sketch, size=LINK_LENGTH)
    return scene_of(mechanism, Gravity(), duration=duration, output_interval=output_interval)
