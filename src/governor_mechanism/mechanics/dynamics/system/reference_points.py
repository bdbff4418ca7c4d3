"""Origins of bodies: their mass centres, or the ground pins of point masses; conversion of motions between the two."""

from governor_mechanism.mechanics.dynamics.system.arrays import System
from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.types import FloatArray


def to_mass_centres(
    system: System,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (..., bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (..., bodies, 3)
) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities of the body origins to those of the mass centres.

    Results: poses, poses of the mass centres; shape (..., bodies, 3); velocities, their time derivatives;
    shape (..., bodies, 3).
    """
    return _shift_reference_points(system, 1.0, poses, velocities)


def from_mass_centres(
    system: System,
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (..., bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (..., bodies, 3)
) -> tuple[FloatArray, FloatArray]:
    """Convert poses and velocities of the mass centres to those of the body origins.

    Results: poses, poses of the body origins; shape (..., bodies, 3); velocities, their time derivatives;
    shape (..., bodies, 3).
    """
    return _shift_reference_points(system, -1.0, poses, velocities)


def _shift_reference_points(system: System, sign: float, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return poses and velocities of points shifted by the vector from body origin to mass centre (sign 1) or back (-1)."""
    poses, velocities = poses.copy(), velocities.copy()
    arm_x, arm_y = rotate_vector(poses[..., 2], sign * system.bodies["x"], sign * system.bodies["y"])
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def body_reference_point(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """Return the origin of a body in body axes (m): the ground pin of a point mass, else the mass centre."""
    pin = ground_pin_of_point_mass(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own_point = pin.first if pin.first.body == body.name else pin.second
    return own_point.x, own_point.y


def ground_pin_of_point_mass(mechanism: Mechanism, body: Body) -> Pin | None:
    """Return the pin about which a point mass rotates.

    About a pin that joins it to the ground, a point mass has a moment of inertia. The pin does not move, so the coupling of
    rotation and translation in its mass matrix never acts on the motion.

    Result: the pin; None if there is none, or if the body cannot rotate, has no mass, or has a moment of
    inertia of its own.
    """
    if not body.can_rotate or body.mass == 0 or body.planar_inertia > 0:
        return None
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            own_point = points[body.name]
            if own_point.x != 0.0 or own_point.y != 0.0:
                return joint
    return None
