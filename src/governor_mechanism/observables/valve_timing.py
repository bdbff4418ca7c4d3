"""Valve timing: opening and closing of a slide valve's ports, from the kinematics of the mechanism."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BPoly

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slide_valve import EQUAL_LEADS, SlideValve
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.joints import RotationalDriver
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import find_root, find_roots
from governor_mechanism.types import FloatArray

CYLINDER_ENDS = ("crank end", "head end")

PORT_EVENTS = {"steam": ("admission", "cut-off"), "exhaust": ("release", "compression")}
"""Names of the opening and the closing event of each port."""

VALVE_DISPLACEMENT = "valve_displacement"

N_NODES = 72
"""Number of intervals of a turn between which readings are interpolated; the error is about 1e-11 of the valve travel."""

EVENT_ANGLE_TOLERANCE = 1e-13
"""Tolerance of the crank angle of an event, rad; rounding is about 1e-15."""


def valve_setting(scene: Scene) -> str:
    """Return the rule for the centre of the valve's motion in the scene file.

    Parameters
    ----------
    scene
        Scene of a slide valve.

    Returns
    -------
    str
        The rule, or an empty string for a scene without a file.
    """
    dimensions = scene.document.get("dimensions", {})
    return str(dimensions.get("setting", SlideValve.setting)) if dimensions else ""


def prescribed_centre(scene: Scene) -> float | None:
    """Return the centre of the valve's motion, m; None for equal leads, for which the closed form has its own.

    Parameters
    ----------
    scene
        Scene of a slide valve.

    Returns
    -------
    float or None
        The centre.
    """
    return None if valve_setting(scene) == EQUAL_LEADS else scene.part.dimensions["centre"]


def port_reading_name(end: str, port: str) -> str:
    """Return the name of the reading of a port's opening.

    Parameters
    ----------
    end
        One of CYLINDER_ENDS.
    port
        One of PORT_EVENTS.

    Returns
    -------
    str
        Name of the reading.
    """
    return f"{end.replace(' ', '_')}_{port}"


class ValveKinematics(NamedTuple):
    """Readings and their first two derivatives (n,) with respect to the crank angle, by name, SI and rad."""

    readings: Mapping[str, FloatArray]
    derivatives: Mapping[str, FloatArray]
    second_derivatives: Mapping[str, FloatArray]


def evaluate_at_crank_angles(scene: Scene, angles: FloatArray) -> ValveKinematics:
    """Return the readings and their derivatives at crank angles, with the mechanism assembled at all of them at once.

    Parameters
    ----------
    scene
        Scene of a crank machine.
    angles
        Crank angles, rad; shape (n,).

    Returns
    -------
    ValveKinematics
        Readings and derivatives in the order of the angles.
    """
    driven = scene.part.mechanism
    mechanism = replace(driven, joints=tuple(joint for joint in driven.joints if not isinstance(joint, RotationalDriver)))
    path = SingleDofReduction(scene.with_changes(mechanism=mechanism)).evaluate(angles)
    outputs = {reading.name: evaluate_output(mechanism, reading.name, path.poses, path.tangents) for reading in mechanism.readings}
    motions = [(one.value, one.rate(path.tangents), one.acceleration(path.curvatures)) for one in outputs.values()]
    return ValveKinematics(*(dict(zip(outputs, values, strict=True)) for values in zip(*motions, strict=True)))


def interpolate_turn(scene: Scene) -> dict[str, BPoly]:
    """Return the readings as functions of the crank angle, exact with two derivatives at `N_NODES` equal angles, and periodic.

    Parameters
    ----------
    scene
        Scene of a crank machine.

    Returns
    -------
    dict
        Piecewise polynomials of the fifth degree of the crank angle, rad, by name.
    """
    nodes = np.linspace(0.0, math.tau, N_NODES + 1)
    motions = evaluate_at_crank_angles(scene, nodes)
    tables = {name: np.stack([motion[name] for motion in motions], axis=1) for name in motions.readings}
    return {name: BPoly.from_derivatives(nodes, table, extrapolate="periodic") for name, table in tables.items()}


def find_event_angles(scene: Scene) -> dict[str, float]:
    """Return the crank angles of all eight valve events, to about 1e-13 rad.

    Parameters
    ----------
    scene
        Scene of a slide valve.

    Returns
    -------
    dict
        Crank angles, rad, from 0 to 2 pi, by names such as "crank end cut-off".

    Raises
    ------
    MechanismError
        If the machine is not a slide valve.
    """
    if scene.part.machine != SlideValve.name:
        raise MechanismError(f"valve timing needs machine {SlideValve.name!r}; this scene has {scene.part.machine!r}")
    turn = interpolate_turn(scene)
    dead_centres = _find_valve_dead_centres(turn[VALVE_DISPLACEMENT])
    events: list[tuple[str, str, float, float]] = []
    for end in CYLINDER_ENDS:
        for port, (opens, closes) in PORT_EVENTS.items():
            reading = port_reading_name(end, port)
            closed_angle, open_angle = sorted(dead_centres, key=turn[reading])
            events.append((f"{end} {opens}", reading, closed_angle, _next_angle(closed_angle, open_angle)))
            events.append((f"{end} {closes}", reading, open_angle, _next_angle(open_angle, closed_angle)))
    names, readings, *brackets = zip(*events, strict=True)
    low, high = np.array(brackets)

    def openings(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        motion = evaluate_at_crank_angles(scene, angles % math.tau)
        values, derivatives = (np.array([arrays[name][k] for k, name in enumerate(readings)]) for arrays in motion[:2])
        return values, derivatives

    angles, steps = np.array([find_root(turn[name], *ends) for name, *ends in zip(readings, low, high, strict=True)]), np.zeros(len(low))
    for _ in range(2):  # Newton's method, from angles that are almost right
        values, derivatives = openings(angles)
        steps = -values / derivatives
        angles = angles + steps
    if not np.all((np.abs(steps) < EVENT_ANGLE_TOLERANCE) & (low < angles) & (angles < high)):
        angles = find_roots(openings, low, high, EVENT_ANGLE_TOLERANCE)
    return dict(zip(names, (angles % math.tau).tolist(), strict=True))


def _next_angle(start: float, angle: float) -> float:
    """Return an angle shifted by full turns to the turn that follows `start`, rad."""
    return start + (angle - start) % math.tau


def _find_valve_dead_centres(displacement: BPoly) -> tuple[float, float]:
    """Return the crank angles (rad) of the lowest and the highest position of the valve."""
    nodes, slope = displacement.x, displacement.derivative()
    values, step = displacement(nodes), nodes[1]
    lowest, highest = (find_root(slope, nodes[k] - step, nodes[k] + step) for k in (np.argmin(values), np.argmax(values)))
    return lowest, highest
