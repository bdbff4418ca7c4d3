"""A Porter governor of rigid links, built body by body: slender rods with mass, pinned to balls and sleeve."""

import math

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.model.joints import GROUND, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import LineAngle
from governor_scenes import PORTER, governor_scene
from one_coordinate_reference import integrate_one_coordinate
from scene_parts import make_mechanism, point_mass, rod_body

ARM_MASS, LINK_MASS = 0.6, 0.5


def porter_with_rods(*, speed, angle, rate):
    """The scene, and the one-coordinate motion of the same governor with massive rods."""
    scene = governor_scene(PORTER, speed=speed, angle=angle, rate=rate)
    governor = closed.PendulumGovernor(**PORTER, arm_mass=ARM_MASS, link_mass=LINK_MASS)
    return scene.with_changes(mechanism=_build_mechanism()), lambda scene, times: integrate_one_coordinate(scene, times, governor)


def _build_mechanism():
    length, offset, ball = PORTER["arm"], PORTER["offset"], PORTER["ball_mass"]
    # One body of arm and ball: mass centre at `centre` from the suspension.
    mass = ball + ARM_MASS
    centre = length * (ball + ARM_MASS / 2) / mass
    along = ball * (length - centre) ** 2 + ARM_MASS * (length**2 / 12 + (centre - length / 2) ** 2)
    bodies, joints, sketch = [], [], []
    angle = 0.7
    for side, sign in (("right", 1.0), ("left", -1.0)):
        down = sign * angle - math.pi / 2
        arm, link = f"{side} arm", f"{side} link"
        bodies.append(Body(name=arm, mass=mass, second_moments=SecondMoments(xx=along)))
        bodies.append(rod_body(link, LINK_MASS, length))
        end = Point(body=arm, x=length - centre)
        joints.append(Pin(name=f"{side} suspension", first=Point(body=GROUND, x=sign * offset), second=Point(body=arm, x=-centre)))
        joints.append(Pin(name=f"{side} knee", first=end, second=Point(body=link, x=-length / 2)))
        joints.append(Pin(name=f"{side} lug", first=Point(body=link, x=length / 2), second=Point(body="sleeve", x=sign * offset)))
        sketch.append((sign * (offset + centre * math.sin(angle)), -centre * math.cos(angle), down))
        sketch.append((sign * (offset + length / 2 * math.sin(angle)), -1.5 * length * math.cos(angle), -math.pi - down))
    bodies.append(point_mass("sleeve", PORTER["sleeve_mass"]))
    sketch.append((0.0, -2 * length * math.cos(angle), 0.0))
    joints.append(Slider(name="guide", first=Point(body=GROUND), second=Point(body="sleeve"), angle=math.pi / 2))
    reading = LineAngle(name="arm_angle", quantity="angle", start=Point(body=GROUND, x=offset), end=Point(body="right arm"))
    return make_mechanism(bodies, joints, [reading], sketch, size=length)
