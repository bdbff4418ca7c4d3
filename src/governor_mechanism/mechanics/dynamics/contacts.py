"""Contacts of a scene (dry friction, stops, one-sided springs) and their discrete mode."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.effects.gas_pressure import travel_in_stroke
from governor_mechanism.mechanics.dynamics.inputs import NOT_HELD, evaluate_reading_function, output_of_reading
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction, StrokeHold, TableFunction
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray, RecordArray, record_dtype

FRICTION_LAW_NAME = "dry friction"
"""Name of sliding friction in the counts of evaluations."""


@dataclass(frozen=True)
class Contact:
    """One output variable that dry friction or stops may hold.

    Attributes
    ----------
    output_name
        Name of the reading.
    friction
        Friction force against time, N or N m, or None.
    low
        Lower stop, m or rad.
    high
        Upper stop, m or rad.
    restitution
        Coefficient of restitution of the stops, 0 to 1.
    """

    output_name: str
    friction: InputFunction | None = None
    low: float = -math.inf
    high: float = math.inf
    restitution: float = 0.0


CONTACT_DTYPE = record_dtype("i8 output_index friction_input", "f8 low high restitution scale")
"""One contact: index of its output, input of the friction force or -1, both stops, coefficient of restitution, scale of the output."""


@dataclass(frozen=True)
class ContactMode:
    """Discrete state of all contacts and one-sided springs of a scene.

    Attributes
    ----------
    held_values
        Value at which each contact holds its output, m or rad; None where it holds nothing.
    sliding_signs
        Sign of the rate that friction opposes at each contact; 0 without friction.
    taut
        Whether each one-sided spring pulls.
    is_locked
        Whether the held outputs leave no degree of freedom.
    segments
        Segment of each table of a reading: 0 below its first point, 1 behind it, and so on.
    broken
        Gears that have broken.
    """

    held_values: tuple[float | None, ...] = ()
    sliding_signs: tuple[int, ...] = ()
    taut: tuple[bool, ...] = ()
    is_locked: bool = False
    segments: tuple[int, ...] = ()
    broken: tuple[str, ...] = ()


@once_per_object
def contacts_of(scene: Scene) -> tuple[Contact, ...]:
    """Return the contacts of a scene.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[Contact, ...]
        One contact for each reading with dry friction or stops.
    """
    properties: defaultdict[str, dict[str, Any]] = defaultdict(dict)
    for effect in sorted(scene.output_effects, key=lambda effect: "friction" not in effect.contact):
        if effect.contact:
            properties[effect.reading] |= effect.contact
    return tuple(Contact(name, **given) for name, given in properties.items())


def make_contact_table(scene: Scene, output_names: Sequence[str], first_friction_input: int) -> RecordArray:
    """Return the contacts of a scene for compiled functions.

    Parameters
    ----------
    scene
        Scene with its output effects.
    output_names
        Names of the outputs in the order of their indices.
    first_friction_input
        Index of the first friction force among the inputs.

    Returns
    -------
    RecordArray
        Records of `CONTACT_DTYPE`; shape (contacts,).
    """
    rows, friction_input = [], first_friction_input
    for contact in contacts_of(scene):
        has_friction, scale = contact.friction is not None, scene.mechanism.output_scale(contact.output_name)
        output = output_names.index(contact.output_name)
        rows.append((output, friction_input if has_friction else -1, contact.low, contact.high, contact.restitution, scale))
        friction_input += has_friction
    return np.array(rows, dtype=CONTACT_DTYPE)


@once_per_object
def output_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects of a scene that act along readings with a force law.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[OutputForce, ...]
        The effects; those with a potential come first, so that sums do not depend on the order in the scene.
    """
    forces = [effect for effect in scene.output_effects if isinstance(effect, OutputForce)]
    return tuple(sorted(forces, key=lambda effect: effect.dissipates))


def one_sided_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that go slack.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[OutputForce, ...]
        One-sided springs and the like.
    """
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below > -math.inf)


@once_per_object
def loads_of(scene: Scene) -> tuple[InputFunction, ...]:
    """Return the loads of a scene: those of force elements with their factors, then the friction forces.

    Parameters
    ----------
    scene
        Scene with its effects.

    Returns
    -------
    tuple[InputFunction, ...]
        Loads in the order of the inputs of a system.
    """
    element_loads = [load for element in scene.mechanism.force_elements for load in element.inputs]
    return (*element_loads, *(contact.friction for contact in contacts_of(scene) if contact.friction is not None))


@once_per_object
def reading_functions_of(scene: Scene) -> tuple[ReadingFunction, ...]:
    """Return the functions of readings in the loads of a scene.

    Parameters
    ----------
    scene
        Scene with its effects.

    Returns
    -------
    tuple[ReadingFunction, ...]
        Functions in the order of the loads.
    """
    return tuple(function for load in loads_of(scene) for function in (*load.functions, *load.factors))


@once_per_object
def lagged_functions_of(scene: Scene) -> tuple[ReadingFunction | InputFunction, ...]:
    """Return the functions of readings with a lag and the loads that are held.

    Parameters
    ----------
    scene
        Scene with its effects.

    Returns
    -------
    tuple[ReadingFunction | InputFunction, ...]
        They in the order of their states.
    """
    found = list[ReadingFunction | InputFunction]()
    for load in loads_of(scene):
        found += [function for function in (*load.functions, *load.factors) if function.lag]
        found += [load] if load.hold else []
    return tuple(found)


def reading_tables_of(scene: Scene) -> tuple[TableFunction, ...]:
    """Return the tables of readings in the loads of a scene; their kinks are events.

    Parameters
    ----------
    scene
        Scene with its effects.

    Returns
    -------
    tuple[TableFunction, ...]
        Tables in the order of the loads.
    """
    return tuple(function for function in reading_functions_of(scene) if isinstance(function, TableFunction))


def active_forces_of(scene: Scene, mode: ContactMode) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that are not slack in a mode.

    Parameters
    ----------
    scene
        Scene with its output effects.
    mode
        Contact mode.

    Returns
    -------
    tuple[OutputForce, ...]
        Effects in the order of `output_forces_of`.
    """
    is_taut = iter(mode.taut)
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below == -math.inf or next(is_taut))


@once_per_object
def initial_mode(scene: Scene) -> ContactMode:
    """Return the mode in which nothing is held, nothing slides and every one-sided spring is slack.

    The search for the consistent mode at the start begins with it.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    ContactMode
        The mode.
    """
    n_contacts, n_one_sided, n_tables = len(contacts_of(scene)), len(one_sided_forces_of(scene)), len(reading_tables_of(scene))
    return ContactMode((None,) * n_contacts, (0,) * n_contacts, (False,) * n_one_sided, False, (0,) * n_tables)


def has_contacts(scene: Scene) -> bool:
    """Return whether a scene has contacts or one-sided springs.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    bool
        True if its mode can change during a run.
    """
    return initial_mode(scene) != ContactMode() or bool(scene.system.breaking_gears)


def has_kinks(scene: Scene) -> bool:
    """Return whether forces have kinks at which steps end though no mode changes: those of gas in cylinders."""
    return any(isinstance(element, CylinderGas) for element in scene.mechanism.force_elements)


def initial_lags(scene: Scene, poses: FloatArray, velocities: FloatArray) -> FloatArray:
    """Return the states of the lags and holds at the start: each begins at the value that it follows, unless its cut-off is still ahead.

    Parameters
    ----------
    scene
        Scene with its loads.
    poses
        Poses of the mass centres at the start, m and rad; shape (bodies, 3).
    velocities
        Their time derivatives; shape (bodies, 3).

    Returns
    -------
    FloatArray
        Values in the order of the lags; shape (lags,).
    """

    def evaluate(function: ReadingFunction) -> float:
        name, is_rate = output_of_reading(function.reading)
        output = evaluate_output(scene.mechanism, name, poses)
        value = np.sum(output.gradient * velocities) if is_rate else output.value
        return evaluate_reading_function(function, float(value))

    def evaluate_held(load: InputFunction) -> float:
        total = float(CubicTimeFunction(load)(np.zeros(1))[0]) + sum(evaluate(function) for function in load.functions)
        value = total * math.prod(evaluate(function) for function in load.factors)
        is_ahead = load.hold is StrokeHold.FROM_CUT_OFF and _travel_in_stroke(scene, load, poses) < value
        return NOT_HELD if is_ahead else value

    return np.array(
        [evaluate(owner) if isinstance(owner, ReadingFunction) else evaluate_held(owner) for owner in lagged_functions_of(scene)]
    )


def _travel_in_stroke(scene: Scene, switch: InputFunction, poses: FloatArray) -> float:
    """Return the travel since the last dead centre, relative to the stroke, of the piston whose gas has a switch."""
    gases = (element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas))
    gas = next(one for one in gases if one.switch is switch)
    rows = (rows_of_readings(scene.mechanism, [reading], {}) for reading in (gas.travel, gas.crank_angle))
    travel, crank_angle = (float(OutputDerivatives(row, poses).value) for row in rows)
    return float(travel_in_stroke(1.0 / gas.stroke, travel, crank_angle))
