"""Given angles of bodies and values of readings as drivers that stand still."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints import GROUND, Distance, Joint, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.observables.assemblies.blocks import count_undetermined


def angle_driver(body: str, angle: float, reference: str = GROUND) -> Joint:
    """Return the driver that holds a body at an angle (rad) to another one."""
    motion = PrescribedMotion.constant_rate(angle, 0.0)
    return RotationalDriver(name=f"angle of {body}", first=Point(body=reference), second=Point(body=body), motion=motion)


def hold_values(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """Return a mechanism whose readings are held at values, SI; raise MechanismError for a reading that no driver can hold."""
    drivers = [_reading_driver(mechanism.reading(name), value) for name, value in values.items()]
    return replace(mechanism, joints=(*mechanism.joints, *drivers))


def _reading_driver(reading: Reading, value: float) -> Joint:
    """Return the driver that holds a reading."""
    name = f"value of {reading.name}"
    if isinstance(reading, BodyAngle):
        return replace(angle_driver(reading.body, value, reading.reference_body), name=name)
    if isinstance(reading, PointDistance):
        return Distance(name=name, first=reading.first, second=reading.second, length=value)
    if isinstance(reading, PointCoordinate):
        motion = PrescribedMotion.constant_rate(value + reading.zero, 0.0)
        angle = math.atan2(reading.direction_y, reading.direction_x)
        return TranslationalDriver(name=name, first=reading.origin, second=reading.point, motion=motion, angle=angle)
    raise MechanismError(
        f"the assemblies at a value of reading {reading.name!r} are not listed; give the angle of a body, a coordinate of a point or a "
        "distance instead"
    )


def hold_needed_angles(mechanism: Mechanism, angles: Iterable[tuple[str, float]]) -> tuple[Mechanism, list[str]]:
    """Return a mechanism that holds the first of some angles (body, rad) that leave fewer values undetermined, and these bodies."""
    held: list[str] = []
    n_undetermined = count_undetermined(PositionSolver(mechanism))
    for body, angle in angles:
        if not n_undetermined:
            break
        trial = replace(mechanism, joints=(*mechanism.joints, angle_driver(body, angle)))
        if (remaining := count_undetermined(PositionSolver(trial))) < n_undetermined:
            mechanism, n_undetermined = trial, remaining
            held.append(body)
    return mechanism, held
