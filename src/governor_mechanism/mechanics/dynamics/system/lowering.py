"""Lowering of a scene to the arrays of the multibody model in one contact mode."""

import numpy as np

from governor_mechanism.mechanics.curves.segments import concatenate_segments
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode, forced_output_names, initial_mode, make_output_forces
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.forces.force_elements import lower_outputs
from governor_mechanism.mechanics.dynamics.forces.inputs import InputLayout, make_input_layout, make_input_terms
from governor_mechanism.mechanics.dynamics.forces.loads import loads_of
from governor_mechanism.mechanics.dynamics.system.arrays import System, lay_out_state
from governor_mechanism.mechanics.dynamics.system.body_records import make_body_records, make_inertia, make_plane_records
from governor_mechanism.mechanics.dynamics.system.event_functions import make_event_functions
from governor_mechanism.mechanics.dynamics.system.holding_rows import disable_rows, find_coupled_rows, make_holding_rows, order_rows
from governor_mechanism.mechanics.dynamics.system.reference_points import body_reference_point
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import NO_INDEX


def make_system(
    scene: Scene,
    # contact mode; the initial mode if left out, in which nothing is held and no friction acts
    mode: ContactMode | None = None,
) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    """Lower a scene to arrays.

    Results: system, the arrays; inputs, inputs as functions of time: given spindle speeds, drives, loads of
    force elements, friction forces, inputs of factors and lags.
    """
    return _make_initial_system(scene) if mode is None else _make_system_in_mode(scene, mode)


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
    return _make_system_in_mode(scene, initial_mode(scene))


def _make_system_in_mode(scene: Scene, mode: ContactMode) -> tuple[System, tuple[CubicTimeFunction, ...]]:
    mechanism = scene.mechanism
    origins = {body.name: body_reference_point(mechanism, body) for body in mechanism.bodies}
    constraint_table = make_constraint_table(mechanism, origins)
    output_names = forced_output_names(scene)
    speeds, layout, loads = given_speeds(scene), multibody_input_layout(scene), loads_of(scene)
    output_rows, force_elements = lower_outputs(mechanism, output_names, mechanism.force_elements, origins, layout.element_loads.start)
    holding_rows = make_holding_rows(scene, mode, output_rows)
    row_order = order_rows(constraint_table.rows, holding_rows)
    held_rows = np.argsort(row_order)[len(constraint_table.joint_indices) :]
    segments = concatenate_segments([constraint_table.rows.curve_segments, output_rows.curve_segments])
    holding_rows["first_segment"] += len(constraint_table.rows.curve_segments)
    joint_rows = disable_rows(constraint_table, [mechanism.joint_index(name) for name in mode.broken])
    ordered_rows = np.concatenate([joint_rows, holding_rows])[row_order]
    rows = ConstraintRows(ordered_rows, bodies_of_rows(ordered_rows), segments)
    rows.table["drive"] += np.where(rows.table["drive"] != NO_INDEX, layout.drives.start, 0)
    row_pairs = find_coupled_rows(rows.row_bodies)
    input_terms, lags = make_input_terms(output_names, mode.segments, layout, loads)
    inputs: list[InputFunction | PrescribedMotion] = [speed.speed_function for speed in speeds]
    inputs += [*constraint_table.motions, *loads]
    inputs += [InputFunction()] * (layout.n_inputs - len(inputs))
    inertia, stand_in_inertia = make_inertia(mechanism, origins)
    total_inertia = inertia + stand_in_inertia
    inverse_mass = np.divide(1.0, total_inertia, out=np.zeros_like(inertia), where=total_inertia > 0)
    bodies = make_body_records(scene, origins)
    system = System(
        state_layout=lay_out_state(len(bodies)),
        constraint_rows=rows,
        force_elements=force_elements,
        row_pairs=row_pairs,
        bandwidth=int(np.max(row_pairs[:, 0] - row_pairs[:, 1], initial=0)),
        bodies=bodies,
        inverse_mass=inverse_mass,
        equal_mass_metric=inverse_mass * np.where(total_inertia[:, :1] > 0, total_inertia[:, :1], 1.0),
        stand_in_inertia=stand_in_inertia,
        has_stand_in_inertia=bool(stand_in_inertia.any()),
        planes=make_plane_records(scene, speeds),
        output_rows=output_rows,
        output_forces=make_output_forces(scene, mode, layout.friction_inputs),
        event_functions=make_event_functions(scene, mode, layout.friction_inputs, held_rows, force_elements),
        input_terms=input_terms,
        lags=lags,
        n_inputs=layout.n_inputs,
    )
    return system, tuple(map(CubicTimeFunction, inputs))
