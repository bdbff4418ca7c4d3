"""Consistent initial positions and velocities of a scene, and its turning part alone at a given speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from governor_mechanism.effects.holding import CLEARANCE_READING
from governor_mechanism.engines.continuation import motion_at_start
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.curves.outlines import is_inside, outline_points
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, outline_gaps_of
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver, mobility_of, position_solver_of
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path, rotate_vector
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.coupling.coupled_system import SHAFT_NAME, SPINDLE_TORQUE, TurningPlane, rename
from governor_mechanism.model.coupling.couplings import ControlCoupling
from governor_mechanism.model.curves import CornerOutline
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.mechanism import Mechanism, Shaft
from governor_mechanism.model.output_variables import BodyAngle, Limit
from governor_mechanism.model.part import EQUILIBRIUM, Spindle, Start
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import numerical_rank
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.statics.equilibrium_speed import equilibrium_speed_squared, has_spindle_dependent_loads
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.quantities import format_quantity

Motion = tuple[FloatArray, FloatArray]
"""Poses and velocities, m and rad; shapes (bodies, 3)."""


def initial_state(scene: Scene) -> Motion:
    """Return consistent initial poses and velocities.

    Start values and rates are met exactly. Otherwise the poses are nearest to the initial guess, and the velocities are smallest.

    Results: poses, initial poses, m and rad; shape (bodies, 3); velocities, initial velocities, m/s and
    rad/s; shape (bodies, 3). Raises MechanismError if the mechanism cannot be assembled or cannot move, if
    the equilibrium does not exist, or if drivers are redundant.
    """
    poses, velocities = _solve_initial_state(scene)
    return poses.copy(), velocities.copy()


def part_initial_state(scene: Scene) -> Motion:
    """Return initial poses and velocities (bodies, 3), SI, of the bodies of the only part, without the shaft of a free spindle."""
    n_bodies = len(scene.part.mechanism.bodies)
    poses, velocities = initial_state(scene)
    return poses[:n_bodies], velocities[:n_bodies]


@once_per_object
def _solve_initial_state(scene: Scene) -> Motion:
    mechanism = scene.mechanism
    position_solver = position_solver_of(mechanism)
    values = scene.start.values
    if position_solver.equations.is_driven.any() and scene.state is None:
        _require_independent_drivers(mechanism)
    undetermined = None if scene.state else _find_undetermined_plane(scene, position_solver)
    velocities = None
    if scene.state is not None:
        poses, velocities = motion_at_start(scene, scene.state)
    elif undetermined is not None:
        poses, velocities = _find_steady_rotation(scene, position_solver, undetermined)
    elif EQUILIBRIUM in values.values() and len(scene.parts) == 1:
        poses = np.concatenate([_equilibrium_poses(scene), np.zeros((mechanism.count_free_shafts(), 3))])
    else:
        start_values = {name: float(value) for name, value in _resolve_equilibria(scene, position_solver).items()}
        for limit in mechanism.limits:
            if limit.reading in start_values:
                value = start_values[limit.reading]
                _require_in_range(limit, value, f"start.{limit.reading} = {value:.6g}")
        poses = _assemble(position_solver, start_values)
    for limit in mechanism.limits:
        value = float(evaluate_output_value(mechanism, limit.reading, poses))
        _require_in_range(limit, value, f"the start, {limit.reading} = {value:.6g},")
    _require_mobile(position_solver, poses)
    _require_inertia(position_solver, poses)
    _require_within_stops(scene, poses)
    return poses, position_solver.solve_velocities(poses, scene.start.rates) if velocities is None else velocities


def _find_undetermined_plane(scene: Scene, position_solver: PositionSolver) -> TurningPlane | None:
    """Return a plane whose initial speed nothing gives, so that it follows from the equilibrium of the whole scene."""
    for plane in scene.system.planes:
        if plane.given_speed or not plane.is_loaded:
            continue
        rows = position_solver.jacobian(position_solver.initial_guess, [*scene.start.rates, _shaft_reading(scene, plane)])
        if numerical_rank(rows) == numerical_rank(rows[:-1]):
            continue  # its speed follows from the rates of the start
        if EQUILIBRIUM not in scene.start.values.values():
            raise MechanismError(
                f"nothing determines the initial speed of {plane.prefix}{SHAFT_NAME}: give start_speed, or the rate of what it is "
                f"coupled to, or write '{EQUILIBRIUM}' for the position of [start] to begin in the equilibrium of the whole"
            )
        return plane
    return None


def _shaft_reading(scene: Scene, plane: TurningPlane) -> str:
    """Return the name of the angle of the shaft of a plane."""
    return [one.name for one in scene.mechanism.readings if isinstance(one, BodyAngle) and one.body == plane.shaft][-1]


def _find_steady_rotation(scene: Scene, position_solver: PositionSolver, plane: TurningPlane) -> Motion:
    """Return poses and velocities of the equilibrium of the whole scene, near the initial guess."""
    from governor_mechanism.statics.steady_state import settle  # few scenes need it, and it takes time

    part, mechanism = scene.part_of(plane.prefix + SHAFT_NAME)[0], scene.mechanism
    values = {name: float(value) for name, value in scene.start.values.items() if value != EQUILIBRIUM}
    poses = _assemble(position_solver, values)
    own_poses = poses[[mechanism.body_index(plane.prefix + body.name) for body in part.mechanism.bodies]]
    alone = Scene(title=scene.title, parts=(replace(part, spindle=Spindle()),))
    reduction = SingleDofReduction(alone)
    position = evaluate_output_value(part.mechanism, part.mechanism.coordinate, own_poses[np.newaxis])
    coefficients = reduction.evaluate_near(own_poses[np.newaxis], position)
    speed_squared = float(equilibrium_speed_squared(coefficients, reduction.coordinate_scale)[0])
    speed = math.sqrt(speed_squared) if speed_squared > 0 else 1 / time_scale(scene)
    rates = {**scene.start.rates, _shaft_reading(scene, plane): speed / plane.ratio}
    dynamics, state = settle(scene, poses, position_solver.solve_velocities(poses, rates), 0.0)
    return dynamics.mass_centre_motion(state.z, state.rates)


def _resolve_equilibria(scene: Scene, position_solver: PositionSolver) -> dict[str, float | str]:
    """Return the start values of several parts, with the equilibrium of each part at its initial speed as a number."""
    values = dict(scene.start.values)
    for part in scene.parts if EQUILIBRIUM in values.values() else ():
        if EQUILIBRIUM not in part.start.values.values():
            continue
        prefix = f"{part.name}."
        velocities = position_solver.solve_velocities(position_solver.initial_guess, scene.start.rates)
        speed = next((initial_speed(scene, plane, velocities) for plane in scene.system.planes if plane.prefix == prefix), 0.0)
        alone = Scene(title=scene.title, parts=(replace(part, spindle=Spindle(speeds=(speed,))),))
        position = float(evaluate_output_value(part.mechanism, part.mechanism.coordinate, _equilibrium_poses(alone)))
        values[prefix + part.mechanism.coordinate] = position
    return values


def initial_speed(scene: Scene, plane: TurningPlane, velocities: FloatArray) -> float:
    """Return the initial speed (rad/s) of a plane from the initial velocities of the shafts."""
    if plane.given_speed:
        return SpindleSpeedFunction(plane.given_speed, plane.ratio).limits_at(0.0)[1]
    return plane.ratio * float(velocities[scene.mechanism.body_index(plane.shaft), 2])


def _equilibrium_poses(scene: Scene) -> FloatArray:
    mechanism, values = scene.part.mechanism, scene.start.values
    if CLEARANCE_READING in values:
        raise MechanismError(
            f"start = '{EQUILIBRIUM}' is not determined with clearance, which leaves the sleeve free between two ends; give "
            f"start.{mechanism.coordinate} as a number"
        )
    if list(values) != [mechanism.coordinate] or mobility_of(mechanism) != 1:
        raise MechanismError(
            f"start = '{EQUILIBRIUM}' is for the coordinate of a mechanism with one degree of freedom, {mechanism.coordinate!r}; "
            f"found {list(values)}; give numbers"
        )
    return stable_equilibrium_poses(scene)


def _require_independent_drivers(mechanism: Mechanism) -> None:
    """Raise an error for drivers that the joints or other drivers leave nothing to move; tested where only the joints are closed."""
    position_solver = position_solver_of(mechanism)
    is_driver_row = position_solver.equations.is_driven
    driver_names = _driver_names(position_solver)
    undriven_mechanism = replace(mechanism, joints=tuple(joint for joint in mechanism.joints if joint.name not in driver_names))
    poses = PositionSolver(undriven_mechanism).solve({})
    n_drivers = int(np.sum(is_driver_row))
    undriven_mobility = position_solver.count_degrees_of_freedom(poses, include_drives=False)
    n_independent = undriven_mobility - position_solver.count_degrees_of_freedom(poses)
    if n_independent < n_drivers <= undriven_mobility:
        raise MechanismError(
            f"drivers {driver_names} determine only {n_independent} of the {undriven_mobility} "
            "degrees of freedom in the initial configuration: it is singular, or two drivers are the same; draw it in another position"
        )
    if n_independent < n_drivers:
        raise MechanismError(
            f"drivers {driver_names} contradict each other or the joints: the joints leave mobility {undriven_mobility}, "
            f"and of {n_drivers} drivers only {n_independent} are independent; leave one driver out"
        )


def _driver_names(position_solver: PositionSolver) -> list[str]:
    """Return the names of the drivers."""
    equations = position_solver.equations
    return list(dict.fromkeys(equations.joints[k].name for k in equations.joint_indices[equations.is_driven]))


def _require_mobile(position_solver: PositionSolver, poses: FloatArray) -> None:
    if position_solver.equations.is_driven.any() or position_solver.count_degrees_of_freedom(poses) > 0:
        return
    mechanism, freeing_joints = position_solver.mechanism, list[str]()
    for joint in mechanism.joints:
        without_joint = replace(mechanism, joints=tuple(other for other in mechanism.joints if other is not joint))
        if PositionSolver(without_joint).count_degrees_of_freedom(poses) > 0:
            freeing_joints.append(joint.name)
    joints_phrase = f"any one of {freeing_joints}" if freeing_joints else "more than one of them"
    raise MechanismError(f"the mechanism cannot move: its joints leave 0 degrees of freedom; without {joints_phrase} it could")


MIN_INERTIA_RATIO = 1e-13
"""Smallest inertia of a motion, relative to the largest mass at one length scale or one radian, with which it can be integrated."""


def _require_inertia(position_solver: PositionSolver, poses: FloatArray) -> None:
    """Raise an error if joints and drives leave a massless body a motion in which no mass moves."""
    mechanism, masses = position_solver.mechanism, position_solver.free_masses
    is_shaft = np.repeat([isinstance(body, Shaft) for body in mechanism.bodies], 3)[position_solver.free_mask]
    if np.all(is_shaft | (masses > 0)):
        return
    scaled_jacobian = position_solver.scaled_joint_jacobian(poses)
    free_motions = np.linalg.svd(scaled_jacobian)[2][numerical_rank(scaled_jacobian) :]
    inertia = masses * position_solver.free_coordinate_scales**2
    inertia[is_shaft] = np.max(inertia)  # the bodies of its plane give a shaft inertia
    values, vectors = np.linalg.eigh((free_motions * inertia) @ free_motions.T)
    if not values.size or values[0] > MIN_INERTIA_RATIO * np.max(inertia):
        return
    amplitudes = np.abs(position_solver.expand_free(free_motions.T @ vectors[:, 0])).max(axis=-1)
    body = max(zip(amplitudes.tolist(), mechanism.bodies, strict=True), key=lambda pair: pair[0])[1]
    lacking = "mass" if body.mass == 0.0 else "moment of inertia"
    raise MechanismError(
        f"body {body.name!r} has no {lacking} and can move without moving any other mass, so that nothing determines its motion; "
        "give it a mass, point masses or second moments, joints that move another mass with it, or turns = false "
        "(can_rotate=False in Python); a bar between two pins without mass is a [[link]]"
    )


STOP_TOLERANCE = 1e-9
"""Violation of a stop, relative to the scale of the reading, that counts as contact."""


def _require_within_stops(scene: Scene, poses: FloatArray) -> None:
    mechanism = scene.mechanism
    _require_apart(scene, poses)
    for contact in contacts_of(scene):
        is_angle = mechanism.reading(contact.output_name).quantity == "angle"
        unit = "rad" if is_angle else "m"
        coordinate_scale = mechanism.output_scale(contact.output_name)
        value = float(evaluate_output_value(mechanism, contact.output_name, poses))
        if not contact.low - STOP_TOLERANCE * coordinate_scale <= value <= contact.high + STOP_TOLERANCE * coordinate_scale:
            stop_range = " to ".join(format_quantity(end, unit) for end in (contact.low, contact.high))
            raise MechanismError(
                f"the start lies beyond the stops of {contact.output_name!r}, {stop_range}: it is at {format_quantity(value, unit)}; "
                "start between them, or move the stops"
            )


def _require_apart(scene: Scene, poses: FloatArray) -> None:
    """Raise an error for what lies inside an outline at the start."""
    mechanism = scene.mechanism
    problems = dict[str, str]()
    depths = dict[str, float]()
    for gap in outline_gaps_of(scene):
        value = float(evaluate_output_value(mechanism, gap.name, poses))
        tolerance = STOP_TOLERANCE * mechanism.length_scale
        origin, roller = (point_path(mechanism, poses[np.newaxis], point)[0] for point in (gap.origin, gap.roller))
        angle = poses[mechanism.body_index(gap.origin.body), 2] if gap.origin.body != GROUND else 0.0
        is_within = (
            gap.profile is None
            and isinstance(gap.outline, CornerOutline)
            and is_inside(outline_points(gap.outline), *map(float, rotate_vector(-angle, *(roller - origin))))
        )
        if value < -tolerance or is_within:
            # Beyond an outline without an inside a centre is as far as its distance and the radius tell.
            depth = value + 2 * gap.radius if is_within and value > -gap.radius else -value
            if depth >= depths.get(gap.contact, math.inf):
                continue  # it is as near to another part of the outline
            depths[gap.contact] = depth
            kind = "roller" if gap.profile is None else "curve"
            place = ", ".join(format_quantity(float(one), "m") for one in roller)
            problems[gap.contact] = (
                f"the {kind} of contact {gap.contact!r}, with its centre at ({place}), overlaps the outline of {gap.origin.body!r} by "
                f"{format_quantity(depth, 'm')} at the start; move one of them, or write start.{gap.name} = 0 for parts that touch"
            )
    if problems:
        raise MechanismError(*problems.values())


def _assemble(position_solver: PositionSolver, start_values: Mapping[str, float]) -> FloatArray:
    """Assemble at start values; an error names the drivers involved."""
    try:
        return position_solver.solve(start_values)
    except MechanismError as error:
        driver_names = _driver_names(position_solver)
        if not start_values or not driver_names:
            raise
        raise MechanismError(
            f"start values {dict(start_values)} and drivers {driver_names} contradict each other at t = 0: "
            "leave the values out, or let the drivers begin there"
        ) from error


def _require_in_range(limit: Limit, value: float, message_start: str) -> None:
    if not limit.low < value < limit.high:
        event = limit.low_message if value <= limit.low else limit.high_message
        raise MechanismError(f"{message_start} lies outside the travel of {limit.reading!r}, {limit.low:.6g} to {limit.high:.6g}: {event}")


def stable_equilibrium_poses(scene: Scene) -> FloatArray:
    """Return the poses of the only stable equilibrium at the first spindle speed. Raise an error if there is none or more than one."""
    from governor_mechanism.statics.equilibria import find_equilibria  # few scenes need it, and it takes time

    name = scene.part.mechanism.coordinate
    depends_on_speed = has_spindle_dependent_loads(scene)
    try:
        equilibria = find_equilibria(scene)
    except MechanismError as error:
        hint = "change spindle.speed, or give a number" if depends_on_speed else "give a number"
        raise MechanismError(f"start.{name} = 'equilibrium': {error.problems[0]}; {hint}") from error
    stable = [equilibrium for equilibrium in equilibria if equilibrium.stable]
    if len(stable) == 1:
        return stable[0].poses
    speed_clause = f"at {SpindleSpeedFunction(scene.spindle).start_speed / RPM:.6g} rpm " if depends_on_speed else ""
    if stable:
        positions = ", ".join(f"{equilibrium.coordinate:.6g}" for equilibrium in stable)
        raise MechanismError(f"start.{name} = 'equilibrium' is not unique: {speed_clause}there are stable ones at {positions}; give one")
    if equilibria[0].astatic:
        low, high = equilibria[0].extent
        raise MechanismError(
            f"start.{name} = 'equilibrium' is not unique: {speed_clause}the mechanism is astatic, with "
            f"equilibria from {low:.6g} to {high:.6g}; give a number"
        )
    positions = ", ".join(f"{equilibrium.coordinate:.6g}" for equilibrium in equilibria)
    hint = ", or change spindle.speed" if speed_clause else ""
    raise MechanismError(
        f"start.{name} = 'equilibrium': {speed_clause}only an unstable one exists, at {name} = {positions}; start there by number{hint}"
    )


def rotating_part_alone(scene: Scene) -> Scene:
    """Return the part that turns with a spindle as a scene of its own, at the spindle speed and the position of the start."""
    # A single part on a free spindle keeps it; else the speed of the spindle is given. The title says
    # what the scene is.
    if len(scene.parts) == 1:
        return _with_start_speed(scene)
    planes = scene.system.planes
    remedy = "The steady state of all parts together is found by gm.linearise and `equilibria --linearise`"
    if len(planes) != 1:
        names = ", ".join(repr(plane.prefix.removesuffix(".")) for plane in planes) or "none"
        raise MechanismError(
            f"this works on one part that turns with a spindle, and in this scene these parts turn: {names}; "
            f"write the part that is meant in a scene file of its own, with a given spindle.speed. {remedy}"
        )
    plane, prefix = planes[0], planes[0].prefix
    part = scene.part_of(prefix + SPINDLE_TORQUE)[0]
    for control in scene.couplings:
        if isinstance(control, ControlCoupling) and control.target.startswith(prefix) and control.target != prefix + SPINDLE_TORQUE:
            raise MechanismError(
                f"{control.target!r} depends on other parts through coupling {control.name!r}, so that part {part.name!r} has no "
                f"equilibria of its own. {remedy}"
            )
    poses, velocities = initial_state(scene)
    speed = initial_speed(scene, plane, velocities)
    coordinate = part.mechanism.coordinate
    position = float(evaluate_output_value(scene.mechanism, prefix + coordinate, poses))
    own = rename((part.mechanism, part.effects), lambda name: name.removeprefix(prefix))
    start = Start(values={coordinate: position})
    alone = replace(part, mechanism=own[0], effects=own[1], spindle=Spindle(speeds=(speed,)), start=start)
    title = f"{scene.title} (part {part.name!r} alone, started at {speed:.6g} rad/s)"
    try:
        return Scene(title=title, parts=(alone,), run=scene.run, source=scene.source)
    except MechanismError as error:  # it reads other parts
        raise MechanismError(
            *(f"part {part.name!r} has no equilibria of its own: {problem.rstrip('.')}. {remedy}" for problem in error.problems)
        ) from None


def _with_start_speed(scene: Scene) -> Scene:
    """Return a scene of one part in which a free spindle has the start speed that follows from the equilibrium of the whole scene."""
    spindle = scene.part.spindle
    if isinstance(spindle, Spindle) or spindle.start_speed is not None or EQUILIBRIUM not in scene.start.values.values():
        return scene
    speed = initial_speed(scene, scene.system.planes[0], initial_state(scene)[1])
    return scene.with_changes(title=f"{scene.title} (started at {speed:.6g} rad/s)", spindle=replace(spindle, start_speed=speed))
