"""Lowering of a scene with one degree of freedom to the arrays of its motion table and its forces."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of, make_contact_table, one_sided_forces_of, output_forces_of
from governor_mechanism.mechanics.dynamics.forces.force_elements import element_law
from governor_mechanism.mechanics.dynamics.forces.forced_outputs import forced_output_names
from governor_mechanism.mechanics.dynamics.forces.input_layout import InputLayout, make_input_layout
from governor_mechanism.mechanics.dynamics.forces.inputs import make_input_terms, make_table_segments
from governor_mechanism.mechanics.dynamics.forces.loads import loads_of, reading_tables_of
from governor_mechanism.mechanics.dynamics.forces.output_forces import (
    OUTPUT_FORCE_DTYPE,
    OutputForceRecord,
    make_output_force,
    output_force_record,
)
from governor_mechanism.mechanics.dynamics.system.event_functions import EVENT_FUNCTION_DTYPE, make_gas_event_functions
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lagrangian_lowering import acts_elsewhere, lower_lagrangian
from governor_mechanism.mechanics.reduction.node_evaluation import ReductionArrays
from governor_mechanism.mechanics.reduction.reduced_forces import (
    COORDINATE,
    N_OUTPUT_FORCE_COLUMNS,
    ForceParameter,
    ModeLayout,
    ReducedForces,
    lay_out_events,
    lay_out_mode,
)
from governor_mechanism.mechanics.reduction.shaft import ShaftTrain, find_shaft_train, parts_with_coordinate, shaft_readings
from governor_mechanism.mechanics.reduction.shaft_outputs import lower_shaft_outputs
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import NO_INDEX, FloatArray

UNBOUNDED_RANGE = 1e9
"""Bound of the coordinate where the scene sets none, in coordinate scales."""


@once_per_object
def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedForces, tuple[CubicTimeFunction, ...]]:
    """Lower a scene to the arrays of its motion table and its forces.

    Parameters
    ----------
    scene
        The scene: one part with one degree of freedom and no drives, and at most one shaft.

    Returns
    -------
    arrays : ReductionArrays
        What is tabulated along the coordinate.
    forces : ReducedForces
        The forces that act along it and on the shaft.
    input_functions : tuple[CubicTimeFunction, ...]
        Given spindle speed, loads of force elements, friction forces, factors of these.
    """
    (prefix, part), train = parts_with_coordinate(scene)[0], find_shaft_train(scene)
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    spindle = plane.given_speed if plane and plane.given_speed else Spindle()
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    all_gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    gases = [gas for gas in all_gases if not acts_elsewhere(gas, prefix, part)]
    shaft_gases = [gas for gas in all_gases if acts_elsewhere(gas, prefix, part)]
    names, shaft_names = _output_names(scene, train, [prefix + limit.reading for limit in limits], gases, shaft_gases)
    all_names = [*names, *shaft_names]
    tabulated = [effect for effect in output_forces_of(scene) if _is_tabulated(effect)]
    lagrangian = lower_lagrangian(scene, prefix, part, names, tabulated)
    low, high = _coordinate_bounds(mechanism)
    is_steady = not (plane and plane.shaft) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    arrays = ReductionArrays(
        lagrangian=lagrangian,
        output_scales=np.array([scene.mechanism.output_scale(name) for name in names]),
        limits=np.array([(names.index(prefix + limit.reading), limit.low, limit.high) for limit in limits]).reshape(-1, 3),
        steady_speed=abs(spindle.speeds[0]) if is_steady else -1.0,
        time_scale=time_scale(scene),
        low=low,
        high=high,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=is_steady and not scene.mechanism.force_elements and not scene.output_effects and not train.motion,
    )
    loads, contacts = loads_of(scene), contacts_of(scene)
    layout = make_input_layout(loads, contacts, n_spindle_speeds=1, n_drives=0)
    input_terms, _ = make_input_terms(all_names, [0] * len(reading_tables_of(scene)), layout, loads)
    inputs = [spindle.speed_function, *loads]
    inputs += [InputFunction()] * (layout.n_inputs - len(inputs))
    one_sided_springs = [
        (names.index(one.reading), one.slack_below, scene.mechanism.output_scale(one.reading)) for one in one_sided_forces_of(scene)
    ]
    shaft_elements, first_load_input = _shaft_elements(scene, prefix, part, train, layout.element_loads.start)
    gas_records = [_gas_record(scene, all_names, gas, prefix + mechanism.coordinate, layout) for gas in (*gases, *shaft_gases)]
    kinks = make_gas_event_functions(np.array(gas_records, dtype=OUTPUT_FORCE_DTYPE), NO_INDEX)
    n_tables, scales = len(reading_tables_of(scene)), [scene.mechanism.output_scale(name) for name in all_names]
    mode_layout = lay_out_mode(len(contacts), len(one_sided_springs), n_tables, len(kinks))
    output_rows = [*_effect_rows(scene, names, mode_layout), *_gas_rows(gas_records[: len(gases)], mode_layout.phases)]
    forces = ReducedForces(
        parameters=_make_parameters(scene, part, arrays, train, shaft_elements, first_load_input),
        one_sided_springs=np.array(one_sided_springs).reshape(-1, 3),
        output_forces=np.array(output_rows, dtype=float).reshape(-1, N_OUTPUT_FORCE_COLUMNS),
        contacts=make_contact_table(scene, names, layout.friction_inputs),
        shaft_torques=np.array([(index, ratio) for index, ratio, _ in shaft_elements if index != NO_INDEX]).reshape(-1, 2),
        shaft_forces=np.array(_gas_rows(gas_records[len(gases) :], mode_layout.phases + len(gases))).reshape(-1, N_OUTPUT_FORCE_COLUMNS),
        shaft_outputs=lower_shaft_outputs(scene, train, shaft_names),
        kinks=np.array(kinks, dtype=EVENT_FUNCTION_DTYPE),
        table_segments=make_table_segments(all_names, scales, arrays.time_scale, loads),
        input_terms=input_terms,
        inputs=np.zeros(layout.n_inputs),
        mode_layout=mode_layout,
        event_layout=lay_out_events(len(contacts), len(one_sided_springs), n_tables),
    )
    return arrays, forces, tuple(map(CubicTimeFunction, inputs))


def _shaft_elements(
    scene: Scene, prefix: str, part: Part, train: ShaftTrain, first_input: int
) -> tuple[list[tuple[int, float, float]], int]:
    """Return input, NO_INDEX for a damper, relative ratio and damping of the elements on the shaft, and the first input of the others.

    `first_input` is that of the loads of force elements.
    """
    shaft_elements = list[tuple[int, float, float]]()
    next_input = first_own_input = first_input
    for element in scene.mechanism.force_elements:
        ratio = train.ratio(element.bodies[1]) - train.ratio(element.bodies[0])
        if acts_elsewhere(element, prefix, part):
            if not isinstance(element, CylinderGas):
                shaft_elements.append((next_input, ratio, 0.0) if element.loads else (NO_INDEX, ratio, element_law(element)[1][0]))
            first_own_input += len(element.inputs) if first_own_input == next_input else 0
        next_input += len(element.inputs)
    return shaft_elements, first_own_input


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _is_tabulated(effect: OutputForce) -> bool:
    """Return whether the table contains a force along an output: it depends on the coordinate alone, and smoothly."""
    return not effect.dissipates and effect.slack_below == -math.inf


def _output_names(
    scene: Scene, train: ShaftTrain, limited: Sequence[str], gases: Sequence[CylinderGas], shaft_gases: Sequence[CylinderGas]
) -> tuple[list[str], list[str]]:
    """Return the readings that the table contains, among them those with limits, and those that the shaft gives."""
    forced, given_by_shaft = forced_output_names(scene), shaft_readings(scene, train)
    own = [*(name for name in forced if name not in given_by_shaft), *limited, *(gas.travel.name for gas in gases)]
    of_gas = [name for gas in shaft_gases for name in (gas.travel.name, gas.crank_angle.name)]
    return list(dict.fromkeys(own)), list(dict.fromkeys([*(name for name in forced if name in given_by_shaft), *of_gas]))


def _effect_rows(scene: Scene, names: Sequence[str], mode_layout: ModeLayout) -> list[tuple[float, ...]]:
    """Return the laws of effects that the table does not contain, as in `ReducedForces.output_forces`."""
    one_sided, rows = one_sided_forces_of(scene), list[tuple[float, ...]]()
    for effect in (effect for effect in output_forces_of(scene) if not _is_tabulated(effect)):
        law, output_index, _, dissipates, *_, coefficients = output_force_record(effect, names.index(effect.reading))
        mode_index = mode_layout.springs + one_sided.index(effect) if effect in one_sided else NO_INDEX
        rows.append((output_index, law, dissipates, mode_index, NO_INDEX, NO_INDEX, NO_INDEX, *coefficients))
    return rows


def _gas_record(scene: Scene, names: Sequence[str], gas: CylinderGas, coordinate: str, layout: InputLayout) -> OutputForceRecord:
    """Return the gas in a cylinder as a record of `OUTPUT_FORCE_DTYPE`."""
    law, coefficients = element_law(gas)
    inputs = [load for element in scene.mechanism.force_elements for load in element.inputs]
    first_input = layout.element_loads.start
    return make_output_force(
        FORCE_LAWS.index(law),
        names.index(gas.travel.name),
        coefficients,
        argument_index=COORDINATE if gas.crank_angle.name == coordinate else names.index(gas.crank_angle.name),
        input_index=NO_INDEX if gas.factor is None else first_input + next(k for k, load in enumerate(inputs) if load is gas.factor),
    )


def _gas_rows(records: Sequence[OutputForceRecord], first_phase: int) -> list[tuple[float, ...]]:
    """Return records of gas, whose phases begin at an index of the contact mode, as in `ReducedForces.output_forces`."""
    rows = list[tuple[float, ...]]()
    for phase, (law, output_index, crank_angle, _, factor, *_, coefficients) in enumerate(records, start=first_phase):
        rows.append((output_index, law, False, NO_INDEX, crank_angle, phase, factor, *coefficients))
    return rows


def _make_parameters(
    scene: Scene,
    part: Part,
    arrays: ReductionArrays,
    train: ShaftTrain,
    shaft_elements: list[tuple[int, float, float]],
    first_load_input: int,
) -> FloatArray:
    """Return the scalars of a scene, indexed by `ForceParameter`."""
    spindle = next((plane.given_speed for plane in scene.system.planes if plane.given_speed), None) or Spindle()
    energy_scale = sum(body.mass for body in scene.mechanism.bodies) * (scene.mechanism.length_scale / arrays.time_scale) ** 2
    assembly, mechanism = arrays.lagrangian.assembly, part.mechanism
    own_mass = sum(body.mass for body in mechanism.bodies)
    own_energy_scale = own_mass * (mechanism.length_scale / arrays.time_scale) ** 2
    rotors = [body for body in scene.mechanism.bodies if body.name in train.motion]
    stalling_ratio = next((train.ratio(limit.body) for limit in scene.mechanism.stall_limits if limit.body in train.motion), 0.0)
    values = {
        ForceParameter.IS_SPINDLE_LOADED: arrays.lagrangian.has_centrifugal_forces,
        ForceParameter.SPINDLE_RATIO: train.spindle_ratio,
        ForceParameter.SHAFT_INERTIA: sum(train.ratio(body.name) ** 2 * body.planar_inertia for body in rotors),
        ForceParameter.FLUCTUATION_AMPLITUDE: 0.5 * spindle.speed_fluctuation,
        ForceParameter.CYCLES_PER_TURN: spindle.cycles_per_turn,
        ForceParameter.FORCE_SCALE: own_energy_scale / assembly.coordinate_scale,
        ForceParameter.IS_CONSERVATIVE: arrays.is_conservative,
        ForceParameter.LOAD_COUNT: arrays.lagrangian.n_loads,
        ForceParameter.COORDINATE_SCALE: assembly.coordinate_scale,
        ForceParameter.TIME_SCALE: arrays.time_scale,
        ForceParameter.ENERGY_SCALE: energy_scale,
        ForceParameter.HAS_SHAFT: bool(train.motion),
        ForceParameter.HAS_REACTION: train.has_reaction,
        ForceParameter.SHAFT_DAMPING: sum(damping * ratio**2 for _, ratio, damping in shaft_elements),
        ForceParameter.FIRST_LOAD_INPUT: first_load_input,
        ForceParameter.OUTPUT_COUNT: len(arrays.output_scales),
        ForceParameter.MIN_RATE: -math.inf if stalling_ratio or not scene.mechanism.stall_limits else 0.0,
        ForceParameter.STALL_RATIO: stalling_ratio,
        ForceParameter.TABLE_COUNT: len(reading_tables_of(scene)),
    }
    return np.array([float(values[parameter]) for parameter in ForceParameter])
