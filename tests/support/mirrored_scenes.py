"""Scenes mirrored in the y axis: x becomes -x, angles change their sign, lengths and distances stay."""

import math
from dataclasses import replace
from functools import partial
from typing import TypeVar

from governor_mechanism.effects.holding import Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.model import joints
from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import Force, ForceElement, Torque, TorsionSpring
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import FollowerHeight, Limit, LineAngle, PointCoordinate, Reading
from governor_mechanism.model.part import Start
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion

Element = TypeVar("Element", bound=joints.Joint | ForceElement | Reading)


def reading_sign(scene: Scene, name: str) -> float:
    """Return the factor of a reading under reflection: -1 for angles in the plane, 1 for lengths, forces and the spindle."""
    readings = {reading.name: reading for reading in scene.part.mechanism.readings}
    return -1.0 if name in readings and readings[name].quantity == "angle" else 1.0


def mirror_scene(scene: Scene) -> Scene:
    """Return the mirrored scene of one part. Its readings have the same names."""
    sign = partial(reading_sign, scene)
    start = scene.part.start
    values = {name: value if isinstance(value, str) else sign(name) * value for name, value in start.values.items()}
    return scene.with_changes(
        mechanism=_mirror_mechanism(scene.part.mechanism),
        effects=tuple(_mirror_effect(effect, sign(getattr(effect, "reading", ""))) for effect in scene.part.effects),
        start=Start(values=values, rates={name: sign(name) * rate for name, rate in start.rates.items()}),
    )


def _mirror_mechanism(mechanism: Mechanism) -> Mechanism:
    return replace(
        mechanism,
        bodies=tuple(_mirror_body(body) for body in mechanism.bodies),
        joints=tuple(_mirror_joint(joint) for joint in mechanism.joints),
        readings=tuple(_mirror_reading(reading) for reading in mechanism.readings),
        initial_guess=tuple((-x, y, -angle) for x, y, angle in mechanism.initial_guess),
        limits=tuple(_mirror_limit(limit, mechanism.reading(limit.reading)) for limit in mechanism.limits),
        internal_outputs=tuple(_mirror_reading(reading) for reading in mechanism.internal_outputs),
        force_elements=tuple(_mirror_force_element(element) for element in mechanism.force_elements),
    )


def _mirror_body(body: Body) -> Body:
    return replace(body, second_moments=replace(body.second_moments, xy=-body.second_moments.xy))


def _mirror_points(item: Element) -> Element:
    """Return a copy with its points mirrored in the axes of their bodies."""
    return replace(item, **{name: replace(value, x=-value.x) for name, value in vars(item).items() if isinstance(value, joints.Point)})


def _mirror_joint(joint: joints.Joint) -> joints.Joint:
    found = _mirror_points(joint)
    if isinstance(
        found, joints.Slider | joints.TranslationalDriver | joints.ProportionalDisplacement | joints.RackAndPinion | joints.CurveSlot
    ):
        found = replace(found, angle=math.pi - found.angle)  # displacements along the mirrored line stay
    if isinstance(found, joints.Weld | joints.Prismatic):
        found = replace(found, relative_angle=-found.relative_angle)
    if isinstance(found, joints.Gear):
        found = replace(found, offset=-found.offset)
    if isinstance(found, joints.RackAndPinion):
        found = replace(found, radius=-found.radius)
    if isinstance(found, joints.CurveSlot):
        found = replace(found, curve=_negate_curve(found.curve))
    if isinstance(found, joints.RotationalDriver):
        found = replace(found, motion=_negate_motion(found.motion))
    return found


def _negate_curve(curve: Curve) -> Curve:
    if isinstance(curve, PolynomialCurve):
        return replace(curve, coefficients=tuple(-value for value in curve.coefficients))
    assert isinstance(curve, SplineCurve)
    return replace(curve, y=tuple(-value for value in curve.y))


def _negate_motion(motion: PrescribedMotion) -> PrescribedMotion:
    harmonics = tuple(replace(one, amplitude=-one.amplitude) for one in motion.harmonics)
    return replace(motion, values=tuple(-value for value in motion.values), harmonics=harmonics)


def _negate_input(function: InputFunction) -> InputFunction:
    assert not function.depends_on_readings
    return replace(function, values=tuple(-value for value in function.values))


def _mirror_reading(reading: Reading) -> Reading:
    found = _mirror_points(reading)
    if isinstance(found, LineAngle):
        return replace(found, zero=-found.zero)
    if isinstance(found, PointCoordinate):
        return replace(found, direction_x=-found.direction_x)
    if isinstance(found, FollowerHeight):
        return replace(found, guide_x=-found.guide_x)
    return found


def _mirror_limit(limit: Limit, reading: Reading) -> Limit:
    if reading.quantity != "angle":
        return limit
    return replace(limit, low=-limit.high, high=-limit.low, low_message=limit.high_message, high_message=limit.low_message)


def _mirror_force_element(element: ForceElement) -> ForceElement:
    found = _mirror_points(element)
    if isinstance(found, TorsionSpring):
        return replace(found, free_angle=-found.free_angle)
    if isinstance(found, Torque):
        return replace(found, moment=_negate_input(found.moment))
    if isinstance(found, Force):
        return replace(found, x=_negate_input(found.x))
    return found


def has_mirror_image(scene: Scene) -> bool:
    """Return whether every effect has one: a spring that only pulls has none along an angle, because it would only push."""
    return not any(
        isinstance(effect, OutputSpring) and effect.one_sided and reading_sign(scene, effect.reading) < 0 for effect in scene.effects
    )


def _mirror_effect(effect: Effect, sign: float) -> Effect:
    if sign > 0:
        return effect
    if isinstance(effect, OutputSpring):
        return replace(effect, preload=-effect.preload, zero=-effect.zero)
    if isinstance(effect, Stops):
        return replace(effect, low=-effect.high, high=-effect.low)
    return effect
