"""Lowering of a scene to the arrays of the multibody model in one contact mode, and of its bodies to records of the kernels."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from governor_mechanism.mechanics.curves.segments import concatenate_segments
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode, forced_output_names, initial_mode, make_output_forces
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.forces.inputs import InputLayout, make_input_layout, make_input_terms
from governor_mechanism.mechanics.dynamics.forces.loads import loads_of
from governor_mechanism.mechanics.dynamics.forces.output_forces import lower_outputs
from governor_mechanism.mechanics.dynamics.system.arrays import System, body_reference_point, lay_out_state
from governor_mechanism.mechanics.dynamics.system.event_functions import KINKS, are_gaps, make_event_functions, rows_of_event_functions
from governor_mechanism.mechanics.dynamics.system.holding_rows import (
    disable_rows,
    find_coupled_rows,
    make_holding_rows,
    make_rubbing,
    order_rows,
    uses_of_rows,
)
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintTable, bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.points import Origins
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.mechanism import Body, Mechanism, Shaft
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.numerics.jit import record_dtype
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray

BODY_DTYPE = record_dtype(
    ("mass", "f8"),  # kg
    ("x", "f8"),  # mass centre from the origin, in body axes, m
    ("y", "f8"),
    ("xx", "f8"),  # second moments about the mass centre, kg m2
    ("yy", "f8"),
    ("xy", "f8"),
    ("zz", "f8"),
    ("gravity", "f8"),  # gravitational acceleration, m/s2
    ("plane", "i8"),  # plane whose centrifugal forces the body carries, or NO_INDEX
)
"""One body."""

PLANE_DTYPE = record_dtype(
    ("shaft", "i8"),  # body that the plane turns with, or NO_INDEX
    ("input_index", "i8"),  # input of its given speed, or NO_INDEX
    ("has_reaction", "i8"),  # whether its bodies act on the shaft
    ("ratio", "f8"),  # its speed relative to the shaft or the input
    ("amplitude", "f8"),  # relative amplitude of a fluctuation of the given speed
    ("cycles_per_turn", "f8"),
)
"""One plane with centrifugal forces."""

# `constrained_solution` removes it again by an iteration that converges by about this ratio; a smaller ratio
# conditions the joint equations worse.
STAND_IN_INERTIA_RATIO = 1e-3
"""Stand-in inertia of massless coordinates, relative to the smallest mass and moment of inertia of the mechanism."""


def make_body_record(
    body: Body,
    gravity: float,  # gravitational acceleration, m/s2
    plane: int,  # index of the plane whose centrifugal forces it carries, or NO_INDEX
    origin: tuple[float, float] = (0.0, 0.0),  # its origin in body axes from the mass centre, m
) -> tuple[float, ...]:
    """Return a body as a record of `BODY_DTYPE`."""
    moments = body.second_moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz, gravity, plane)


def make_body_records(scene: Scene, origins: Origins) -> RecordArray:
    """Return the bodies as records of `BODY_DTYPE`."""
    loaded_planes = [plane for plane in scene.system.planes if plane.is_loaded]
    plane_of_body = {body: index for index, plane in enumerate(loaded_planes) for body in plane.bodies}
    records = [
        make_body_record(body, gravity, plane_of_body.get(index, NO_INDEX), origins[body.name])
        for index, (body, gravity) in enumerate(zip(scene.mechanism.bodies, scene.system.gravity, strict=True))
    ]
    return np.array(records, dtype=BODY_DTYPE)


def make_plane_records(scene: Scene, speeds: Sequence[Spindle]) -> RecordArray:
    """Return the planes with centrifugal forces as records of `PLANE_DTYPE`; `speeds` are the inputs of given speeds."""
    records = []
    for plane in scene.system.planes:
        if plane.is_loaded and plane.given_speed:
            given = plane.given_speed
            records.append((NO_INDEX, speeds.index(given), 0, plane.ratio, 0.5 * given.speed_fluctuation, given.cycles_per_turn))
        elif plane.is_loaded:
            records.append((scene.mechanism.body_index(plane.shaft), NO_INDEX, plane.has_reaction, plane.ratio, 0.0, 1.0))
    return np.array(records, dtype=PLANE_DTYPE)


def make_inertia(mechanism: Mechanism, origins: Origins) -> tuple[FloatArray, FloatArray]:
    """Return mass (twice) and moment of inertia about the origin of each body, (bodies, 3), and the stand-ins for those that are 0."""
    # Coordinates that cannot change have neither. The moment of inertia of a shaft follows with the
    # poses.
    rows = []
    for body in mechanism.bodies:
        moment = 1.0 if isinstance(body, Shaft) else body.planar_inertia + body.mass * math.hypot(*origins[body.name]) ** 2
        rows.append([body.mass, body.mass, moment])
    moves = np.array([body.moves for body in mechanism.bodies]).reshape(-1, 3)
    inertia = np.where(moves, np.array(rows).reshape(-1, 3), 0.0)
    masses, moments = inertia[:, 0][inertia[:, 0] > 0], inertia[:, 2][inertia[:, 2] > 0]
    mass = float(np.min(masses)) if masses.size else 1.0
    moment = float(np.min(moments, initial=mass * mechanism.length_scale**2))
    return inertia, np.where(moves & (inertia == 0), STAND_IN_INERTIA_RATIO * np.array([mass, mass, moment]), 0.0)


def make_system(
    scene: Scene,
    # contact mode; the initial mode if left out, in which nothing is held and no friction acts
    mode: ContactMode | None = None,
) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """Lower a scene to arrays and inputs: spindle speeds, drives, loads of elements, friction forces, inputs of factors and lags."""
    system, inputs = _make_initial_system(scene)
    return (system if mode is None else system._replace(**_arrays_of_mode(scene, mode, system.output_rows, system.force_elements))), inputs


def given_speeds(scene: Scene) -> list[Spindle]:
    """Return the given spindles of a scene, each once."""
    return list(dict.fromkeys(plane.given_speed for plane in scene.system.planes if plane.given_speed))


@once_per_object
def multibody_input_layout(scene: Scene) -> InputLayout:
    """Return the layout of the inputs of a scene, of which the drives move joints and points of the ground."""
    n_drives = len(make_constraint_table(scene.mechanism).motions)
    return make_input_layout(loads_of(scene), contacts_of(scene), len(given_speeds(scene)), n_drives)


@once_per_object
def _make_initial_system(scene: Scene) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    mechanism = scene.mechanism
    origins, constraint_table = _make_joint_rows(scene)
    speeds, layout, loads = given_speeds(scene), multibody_input_layout(scene), loads_of(scene)
    output_rows, force_elements = lower_outputs(
        mechanism, forced_output_names(scene), mechanism.force_elements, origins, layout.element_loads.start
    )
    inputs: list[InputFunction | PrescribedMotion] = [speed.speed_function for speed in speeds]
    inputs += [*constraint_table.motions, *loads]
    inputs += [InputFunction()] * (layout.n_inputs - len(inputs))
    inertia, stand_in_inertia = make_inertia(mechanism, origins)
    total_inertia = inertia + stand_in_inertia
    inverse_mass = np.divide(1.0, total_inertia, out=np.zeros_like(inertia), where=total_inertia > 0)
    bodies = make_body_records(scene, origins)
    system = System(
        state_layout=lay_out_state(len(bodies)),
        force_elements=force_elements,
        bodies=bodies,
        inverse_mass=inverse_mass,
        equal_mass_metric=inverse_mass * np.where(total_inertia[:, :1] > 0, total_inertia[:, :1], 1.0),
        stand_in_inertia=stand_in_inertia,
        has_stand_in_inertia=bool(stand_in_inertia.any()),
        planes=make_plane_records(scene, speeds),
        n_inputs=layout.n_inputs,
        **_arrays_of_mode(scene, initial_mode(scene), output_rows, force_elements),
    )
    return system, tuple(map(CubicTimeFunction, inputs))


@once_per_object
def _make_joint_rows(scene: Scene) -> tuple[Origins, ConstraintTable]:
    """Return the origins of the bodies and the rows of the joints, which are the same in all modes."""
    origins = {body.name: body_reference_point(scene.mechanism, body) for body in scene.mechanism.bodies}
    return origins, make_constraint_table(scene.mechanism, origins)


def _arrays_of_mode(scene: Scene, mode: ContactMode, output_rows: ConstraintRows, force_elements: RecordArray) -> dict[str, Any]:
    """Return the fields of a system that depend on the contact mode."""
    constraint_table, layout = _make_joint_rows(scene)[1], multibody_input_layout(scene)
    holding_rows = make_holding_rows(scene, mode, output_rows)
    row_order = order_rows(constraint_table.rows, holding_rows)
    held_rows = np.argsort(row_order)[len(constraint_table.joint_indices) :]
    segments = concatenate_segments([constraint_table.rows.curve_segments, output_rows.curve_segments])
    holding_rows["first_segment"] += len(constraint_table.rows.curve_segments)
    joint_rows = disable_rows(constraint_table, [scene.mechanism.joint_index(name) for name in mode.broken])
    ordered_rows = np.concatenate([joint_rows, holding_rows])[row_order]
    rows = ConstraintRows(ordered_rows, bodies_of_rows(ordered_rows), segments)
    rows.table["drive"] += np.where(rows.table["drive"] != NO_INDEX, layout.drives.start, 0)
    row_pairs = find_coupled_rows(rows.row_bodies)
    event_functions = make_event_functions(scene, mode, layout.friction_inputs, held_rows, force_elements)
    rubbing, output_table = make_rubbing(scene, mode, held_rows), output_rows.table.copy()
    output_table["use"] = uses_of_rows(scene, rubbing, rows_of_event_functions(event_functions), len(output_table))
    input_terms, lags = make_input_terms(forced_output_names(scene), mode.segments, layout, loads_of(scene))
    return {
        "constraint_rows": rows,
        "row_pairs": row_pairs,
        "bandwidth": int(np.max(row_pairs[:, 0] - row_pairs[:, 1], initial=0)),
        "output_forces": make_output_forces(scene, mode, layout.friction_inputs),
        "output_rows": output_rows._replace(table=output_table),
        "rubbing": rubbing,
        "event_functions": event_functions,
        "n_kinks": sum(kind in KINKS for kind in event_functions["kind"].tolist()),
        "watches_gaps_alone": are_gaps(scene, event_functions),
        "input_terms": input_terms,
        "lags": lags,
    }
