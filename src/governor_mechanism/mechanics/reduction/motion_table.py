"""Motion table of one scene with one degree of freedom: its arrays; it grows with the motion, and says why it ends."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.contact_modes import forced_output_names
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, make_contact_table, one_sided_forces_of, output_forces_of
from governor_mechanism.mechanics.dynamics.event_functions import EVENT_FUNCTION_DTYPE, make_gas_event_functions
from governor_mechanism.mechanics.dynamics.inputs import (
    InputLayout,
    loads_of,
    make_input_layout,
    make_input_terms,
    make_table_segments,
    reading_tables_of,
)
from governor_mechanism.mechanics.dynamics.output_forces import (
    OUTPUT_FORCE_DTYPE,
    OutputForceRecord,
    element_law,
    make_output_force,
    output_force_record,
)
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lagrangian import (
    OUTPUT_LIMIT_DTYPE,
    ReductionArrays,
    acts_elsewhere,
    lower_lagrangian,
    make_reduction_workspace,
)
from governor_mechanism.mechanics.reduction.reduced_model import (
    COORDINATE,
    MODEL_PARAMETERS_DTYPE,
    ONE_SIDED_SPRING_DTYPE,
    SHAFT_TORQUE_DTYPE,
    ReducedModel,
    ShaftTrain,
    find_shaft_train,
    lay_out_events,
    lay_out_mode,
    lower_shaft_outputs,
    parts_with_coordinate,
    shaft_readings,
)
from governor_mechanism.mechanics.reduction.table import (
    BOUND_TOLERANCE,
    EndReason,
    ExtensionStatus,
    PeriodIndex,
    allocate_table,
    evaluate_poses,
    grow_table,
)
from governor_mechanism.mechanics.reduction.table_refinement import extend_table
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.results.records import FLIGHT_DETAIL
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.interpolation import N_CHEBYSHEV_NODES
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray

UNBOUNDED_RANGE = 1e9
"""Bound of the coordinate where the scene sets none, in coordinate scales."""


@once_per_object
def lower_reduced_scene(scene: Scene) -> tuple[ReductionArrays, ReducedModel, tuple[CubicTimeFunction, ...]]:
    """Lower a scene, one part with one degree of freedom, no drives and at most one shaft: what is tabulated, the model, its inputs."""
    # The model is on no table yet. Inputs: given spindle speed, loads of force elements, friction
    # forces, factors of these. Nothing is held in the contact mode, springs are slack, tables are on
    # their lowest segments, and all kinks are monitored.
    (prefix, part), train = parts_with_coordinate(scene)[0], find_shaft_train(scene)
    gases = _find_gases(scene, prefix, part)
    outputs = _find_outputs(scene, prefix, part, train, gases)
    arrays = _lower_table(scene, prefix, part, train, outputs.of_table)
    loads, contacts = loads_of(scene), contacts_of(scene)
    layout = make_input_layout(loads, contacts, n_spindle_speeds=1, n_drives=0)
    input_terms, _ = make_input_terms(outputs.names, [0] * len(reading_tables_of(scene)), layout, loads)
    inputs = [_given_spindle(scene).speed_function, *loads]
    inputs += [InputFunction()] * (layout.n_inputs - len(inputs))
    own_gases, shaft_gases = (
        [_gas_record(scene, outputs.names, gas, prefix + part.mechanism.coordinate, layout) for gas in some] for some in gases
    )
    kinks = np.array(
        make_gas_event_functions(np.array([*own_gases, *shaft_gases], dtype=OUTPUT_FORCE_DTYPE), NO_INDEX), dtype=EVENT_FUNCTION_DTYPE
    )
    springs, n_tables = one_sided_forces_of(scene), len(reading_tables_of(scene))
    scales = [scene.mechanism.output_scale(name) for name in outputs.names]
    shaft_torques, shaft_damping, first_load_input = _shaft_elements(scene, prefix, part, train, layout.element_loads.start)
    table_segments = make_table_segments(outputs.names, scales, arrays.time_scale, loads)
    mode_layout = lay_out_mode(len(contacts), len(springs), n_tables)
    first_mode = [0] * mode_layout.tables + np.flatnonzero(np.isneginf(table_segments["low"])).tolist() + [1] * len(kinks)
    model = ReducedModel(
        coefficients=np.zeros((0, 0, N_CHEBYSHEV_NODES)),
        intervals=np.zeros((0, 4)),
        neighbours=np.zeros((0, 2), dtype=np.int64),
        periodicity=np.zeros(5),
        parameters=np.zeros(1, dtype=MODEL_PARAMETERS_DTYPE),
        one_sided_springs=_lower_springs(scene, outputs.of_table),
        output_forces=np.array([*_effect_records(scene, outputs.of_table), *own_gases], dtype=OUTPUT_FORCE_DTYPE),
        contacts=make_contact_table(scene, outputs.of_table, layout.friction_inputs),
        shaft_torques=shaft_torques,
        shaft_forces=np.array(shaft_gases, dtype=OUTPUT_FORCE_DTYPE),
        shaft_outputs=lower_shaft_outputs(scene, train, outputs.of_shaft),
        kinks=kinks,
        table_segments=table_segments,
        input_terms=input_terms,
        inputs=np.zeros(layout.n_inputs),
        mode_layout=mode_layout,
        event_layout=lay_out_events(len(contacts), len(springs), n_tables),
        input_cubics=np.zeros((layout.n_inputs, 5)),
        mode=np.array(first_mode, dtype=np.int64),
    )
    parameters = _make_parameters(scene, part, arrays, train)
    parameters |= {"shaft_damping": shaft_damping, "first_load_input": first_load_input, "n_tables": n_tables}
    for name, value in parameters.items():
        model.parameters[name] = value
    return arrays, model, tuple(map(CubicTimeFunction, inputs))


@dataclass(frozen=True)
class _Outputs:
    """Readings that the table contains, among them those with limits, and those that the shaft gives."""

    of_table: list[str]
    of_shaft: list[str]

    @property
    def names(self) -> list[str]:
        """All readings in the order of their indices."""
        return self.of_table + self.of_shaft


def _find_gases(scene: Scene, prefix: str, part: Part) -> tuple[list[CylinderGas], list[CylinderGas]]:
    """Return the gases in cylinders of the part, and those on the shaft."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    return [gas for gas in gases if not acts_elsewhere(gas, prefix, part)], [gas for gas in gases if acts_elsewhere(gas, prefix, part)]


def _find_outputs(scene: Scene, prefix: str, part: Part, train: ShaftTrain, gases: tuple[list[CylinderGas], list[CylinderGas]]) -> _Outputs:
    forced = forced_output_names(scene)
    given_by_shaft = shaft_readings(scene, train)
    own_gases, shaft_gases = gases
    limited = [prefix + limit.reading for limit in _other_limits(part.mechanism)]
    own = [*(name for name in forced if name not in given_by_shaft), *limited, *(gas.travel.name for gas in own_gases)]
    of_gas = [name for gas in shaft_gases for name in (gas.travel.name, gas.crank_angle.name)]
    return _Outputs(list(dict.fromkeys(own)), list(dict.fromkeys([*(name for name in forced if name in given_by_shaft), *of_gas])))


def _other_limits(mechanism: Mechanism) -> list[Limit]:
    """Return the limits of readings that are not the coordinate."""
    return [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]


def _given_spindle(scene: Scene) -> Spindle:
    plane = next(iter(scene.system.planes), None)
    return plane.given_speed if plane and plane.given_speed else Spindle()


def _lower_table(scene: Scene, prefix: str, part: Part, train: ShaftTrain, names: list[str]) -> ReductionArrays:
    """Return what is tabulated along the coordinate, with readings as its outputs."""
    mechanism = part.mechanism
    plane = next(iter(scene.system.planes), None)
    spindle = _given_spindle(scene)
    low, high = _coordinate_bounds(mechanism)
    is_steady = not (plane and plane.shaft) and spindle.speed_function.is_constant and not spindle.speed_fluctuation
    limits = [(names.index(prefix + limit.reading), limit.low, limit.high) for limit in _other_limits(mechanism)]
    tabulated = [effect for effect in output_forces_of(scene) if _is_tabulated(effect)]
    return lower_lagrangian(scene, prefix, part, names, tabulated)._replace(
        limits=np.array(limits, dtype=OUTPUT_LIMIT_DTYPE),
        steady_speed=abs(spindle.speeds[0]) if is_steady else -1.0,
        low=low,
        high=high,
        is_conservative=is_steady and not (scene.mechanism.force_elements or contacts_of(scene) or scene.output_effects or train.motion),
    )


def _lower_springs(scene: Scene, names: Sequence[str]) -> RecordArray:
    """Return the springs that go slack, records of `ONE_SIDED_SPRING_DTYPE`."""
    springs = [(names.index(one.reading), one.slack_below, scene.mechanism.output_scale(one.reading)) for one in one_sided_forces_of(scene)]
    return np.array(springs, dtype=ONE_SIDED_SPRING_DTYPE)


def _shaft_elements(scene: Scene, prefix: str, part: Part, train: ShaftTrain, first_input: int) -> tuple[RecordArray, float, int]:
    """Return the torques on the shaft (`SHAFT_TORQUE_DTYPE`), its damping (N m s/rad) and the first input of other elements."""
    torques, damping = list[tuple[int, float]](), 0.0
    next_input = first_own_input = first_input
    for element in scene.mechanism.force_elements:
        if acts_elsewhere(element, prefix, part):
            ratio = train.ratio(element.bodies[1]) - train.ratio(element.bodies[0])
            if element.loads:
                torques.append((next_input, ratio))
            elif not isinstance(element, CylinderGas):
                damping += element_law(element)[1][0] * ratio**2
            first_own_input += len(element.inputs) if first_own_input == next_input else 0
        next_input += len(element.inputs)
    return np.array(torques, dtype=SHAFT_TORQUE_DTYPE), damping, first_own_input


def _coordinate_bounds(mechanism: Mechanism) -> tuple[float, float]:
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    coordinate_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in coordinate_limits), default=-UNBOUNDED_RANGE * coordinate_scale)
    return low, min((limit.high for limit in coordinate_limits), default=UNBOUNDED_RANGE * coordinate_scale)


def _is_tabulated(effect: OutputForce) -> bool:
    """Return whether the table contains a force along an output: it depends on the coordinate alone, and smoothly."""
    return not effect.dissipates and effect.slack_below == -math.inf


def _effect_records(scene: Scene, names: Sequence[str]) -> list[OutputForceRecord]:
    """Return the laws of effects that the table does not contain, as records of `OUTPUT_FORCE_DTYPE`."""
    springs = one_sided_forces_of(scene)
    return [
        output_force_record(effect, names.index(effect.reading), springs.index(effect) if effect in springs else NO_INDEX)
        for effect in output_forces_of(scene)
        if not _is_tabulated(effect)
    ]


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


def _make_parameters(scene: Scene, part: Part, arrays: ReductionArrays, train: ShaftTrain) -> dict[str, float]:
    """Return the fields of `MODEL_PARAMETERS_DTYPE`, without those of the elements on the shaft and the number of tables."""
    spindle = _given_spindle(scene)
    assembly = arrays.assembly
    mechanism = part.mechanism
    energy_scale = sum(body.mass for body in scene.mechanism.bodies) * (scene.mechanism.length_scale / arrays.time_scale) ** 2
    own_energy_scale = sum(body.mass for body in mechanism.bodies) * (mechanism.length_scale / arrays.time_scale) ** 2
    rotors = [body for body in scene.mechanism.bodies if body.name in train.motion]
    stall_ratio = next((train.ratio(limit.body) for limit in scene.mechanism.stall_limits if limit.body in train.motion), 0.0)
    return {
        "is_conservative": arrays.is_conservative,
        "is_spindle_loaded": arrays.has_centrifugal_forces,
        "has_shaft": bool(train.motion),
        "has_reaction": train.has_reaction,
        "n_loads": arrays.n_loads,
        "n_outputs": len(arrays.output_scales),
        "spindle_ratio": train.spindle_ratio,
        "shaft_inertia": sum(train.ratio(body.name) ** 2 * body.planar_inertia for body in rotors),
        "fluctuation_amplitude": 0.5 * spindle.speed_fluctuation,
        "cycles_per_turn": spindle.cycles_per_turn,
        "min_rate": -math.inf if stall_ratio or not scene.mechanism.stall_limits else 0.0,
        "stall_ratio": stall_ratio,
        "coordinate_scale": assembly.coordinate_scale,
        "time_scale": arrays.time_scale,
        "energy_scale": energy_scale,
        "force_scale": own_energy_scale / assembly.coordinate_scale,
    }


INITIAL_TABLE_CAPACITY = 32
"""Number of pieces allocated at first."""


class MotionTable:
    """The motion table of one scene, from its initial configuration on.

    Parameters
    ----------
    scene
        The scene; its mechanism has one degree of freedom.
    q
        Leading coordinate at the start, SI.
    poses
        Poses at the start; shape (bodies, 3).
    width_ratio
        Factor on the width of the first pieces.

    Attributes
    ----------
    scene
        The scene.
    arrays
        The lowered mechanism.
    model
        The forces along the coordinate, not yet on the table.
    time_functions
        Given spindle speed, loads of force elements, friction forces, factors of these.
    table
        The pieces.
    setup_time
        Wall time spent on the table, s.
    is_started
        Whether the first piece could be computed.
    """

    def __init__(self, scene: Scene, q: float, poses: FloatArray, width_ratio: float = 1.0) -> None:
        start_time = time.perf_counter()
        self.scene = scene
        self.arrays, model, self.time_functions = lower_reduced_scene(scene)
        self.model = model.with_own_results()
        self._workspace = make_reduction_workspace(self.arrays)
        self.table = allocate_table(self.arrays, INITIAL_TABLE_CAPACITY, q, poses.copy())
        self.table.next_widths[:] *= width_ratio
        self.setup_time = 0.0
        """Wall time spent on the table, s."""
        self.is_started = self.extend(1)
        self.setup_time = time.perf_counter() - start_time

    @property
    def n_pieces(self) -> int:
        """Number of pieces."""
        return int(self.table.n_pieces[0])

    def extend(self, side: int) -> bool:
        """Add a piece below (0) or above (1); return whether that was possible."""
        start_time = time.perf_counter()
        status = extend_table(self.arrays, self._workspace, self.table, side)
        if status == ExtensionStatus.TABLE_FULL:
            self.table = grow_table(self.table)
            status = extend_table(self.arrays, self._workspace, self.table, side)
        self.setup_time += time.perf_counter() - start_time
        return status != ExtensionStatus.TABLE_ENDED

    def end_coordinate(self, side: int) -> float:
        """Return the coordinate at which the table ends below (0) or above (1): its bound, or the end of the last piece."""
        edge = self.edge(side)
        bound = self._bound(side)
        return bound if abs(edge - bound) < BOUND_TOLERANCE * self.arrays.assembly.coordinate_scale else edge

    def edge(self, side: int) -> float:
        """Return the coordinate up to which the table has values, below (0) or above (1)."""
        return float(self.table.intervals[self.table.end_pieces[side], side])

    def end_message(self, side: int, *, stops_short: bool = False) -> tuple[bool, str]:
        """Return whether the table, or a motion that turns back before its bound, ends at a limit of the scene, and what happens."""
        prefix, part = parts_with_coordinate(self.scene)[0]
        mechanism = part.mechanism
        own_limits = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
        other_limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
        reason = EndReason.AT_SINGULARITY if stops_short else int(self.table.end_reasons[side])
        coordinate = self.edge(side) if stops_short else self.end_coordinate(side)
        is_at_bound = not stops_short and coordinate == self._bound(side)
        if reason == EndReason.TOO_FAR:
            return True, FLIGHT_DETAIL
        if own_limits and (reason == EndReason.AT_BOUND or is_at_bound):
            limit, at_high = own_limits[0], side == 1
        elif reason >= EndReason.AT_LIMIT:
            limit = other_limits[(reason - EndReason.AT_LIMIT) // 2]
            at_high = bool((reason - EndReason.AT_LIMIT) % 2)
        else:
            return False, (
                f"{prefix + mechanism.coordinate!r} is at a turning point, or the joints at a change point, and does not determine "
                f"the poses at {coordinate:.6g}"
            )
        return True, f"{prefix}{limit.reading}: {limit.high_message if at_high else limit.low_message}"

    def _bound(self, side: int) -> float:
        return self.arrays.high if side == 1 else self.arrays.low

    def evaluate_poses(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and their derivative (n, bodies, 3) at values (n,) of the coordinate: tabulated ones, or solved a little beyond."""
        low, high = self.edge(0), self.edge(1)
        is_periodic = self.table.periodicity[PeriodIndex.PERIOD] != 0.0
        if is_periodic or (values.min(initial=high) >= low and values.max(initial=low) <= high):
            poses, tangents = evaluate_poses(self.table, np.ascontiguousarray(values))
            return poses, tangents
        beyond = np.flatnonzero((values < low) | (values > high))
        inner_values = np.clip(values, low, high)
        poses, tangents = evaluate_poses(self.table, inner_values)
        distances = (values - inner_values)[beyond, np.newaxis, np.newaxis]
        nodes, is_solved = self._solver.try_solve_nodes(poses[beyond] + distances * tangents[beyond], values[beyond])
        poses[beyond[is_solved]] = nodes[is_solved, 0]
        tangents[beyond[is_solved]] = nodes[is_solved, 1]
        return poses, tangents

    def count_solved(self, values: FloatArray) -> int:
        """Return the number of values (n,) a little beyond the table, from the first on, at which the joints close."""
        inner_values = np.clip(values, self.edge(0), self.edge(1))
        poses, tangents = evaluate_poses(self.table, np.ascontiguousarray(inner_values))
        guesses = poses + (values - inner_values)[:, np.newaxis, np.newaxis] * tangents
        is_solved = self._solver.try_solve_nodes(guesses, values)[1]
        return len(values) if is_solved.all() else int(np.argmin(is_solved))

    @cached_property
    def _solver(self) -> CoordinateSolver:
        return CoordinateSolver(parts_with_coordinate(self.scene)[0][1].mechanism)
