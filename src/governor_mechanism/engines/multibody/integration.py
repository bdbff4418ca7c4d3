"""Integration of a mechanism, projected onto its constraints, in checked limits, after every step: DOP853 with events; compiled."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.certificate import ErrorControlSettings
from governor_mechanism.engines.exit_location import LastStep
from governor_mechanism.integrators.dop853 import StepLimits, make_dop853
from governor_mechanism.integrators.equation import LAST_SAMPLE, ROUNDING, EquationFunctions, EventStep, StepBuffers, count_located
from governor_mechanism.integrators.event_location import is_any_above, is_any_positive
from governor_mechanism.integrators.stages import N_STAGES, Stages, StepCounter, make_take_step
from governor_mechanism.integrators.step_record import (
    LEFT_LIMITS,
    NEAR_SINGULAR_QUALITY,
    OUT_OF_RANGE,
    STEERING_QUALITY,
    TURNED_BACK,
    UNDETERMINED,
    IntegrationStatus,
)
from governor_mechanism.mechanics.dynamics.arrays import StateLayout, System, SystemWorkspace, body_reference_point
from governor_mechanism.mechanics.dynamics.constrained_solution import (
    apply_jacobian,
    equal_mass_pivot_ratio,
    project_state,
    subtract_minv_jt,
)
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import JAMMED, evaluate_inputs_at, evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.event_functions import GAS_KINKS, EventFunctionKind, evaluate_event_functions
from governor_mechanism.mechanics.dynamics.inputs import HOLD_KINDS, NOT_HELD, output_rate
from governor_mechanism.mechanics.dynamics.output_forces import IN_NO_PHASE, evaluate_gas_phase, evaluate_travel_in_stroke
from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    evaluate_rows,
    keep_feature,
    keep_features,
    release_feature,
    release_features,
)
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows, RowColumn
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows
from governor_mechanism.model.events import Event
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import StrokeHold
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.interpolation import cubic_hermite_jit, quintic_hermite_jit
from governor_mechanism.numerics.jit import jit_in_place, jit_inlined
from governor_mechanism.numerics.linear_equations import solve_band_system
from governor_mechanism.types import NO_INDEX, FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class MultibodySettings(ErrorControlSettings):
    """Numerical settings of the multibody engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    constraint_tolerance_ratio
        Constraint tolerance of the projection as a fraction of the length scale: rounding.
    max_distance_ratio
        Distance from the origin, in length scales, beyond which a body has flown away: rounding exceeds the accuracy there.
    implicit_step_cost
        Number of explicit steps that take as long as an implicit one in a small mechanism; measured from 1 to 30 bodies: 2 to 5.
    implicit_step_cost_per_state
        Additional ones per component of the state: the linear equations of an implicit step are dense.
    restart_step_ratio
        Largest step size after an event, as a fraction of the largest step.
    event_time_tolerance
        Events closer than this, in units of the time scale, are simultaneous.
    max_simultaneous_events
        Largest number of successive events at one time; more are endless chattering.
    """

    constraint_tolerance_ratio: float = 1e-14
    max_distance_ratio: float = 1e6
    implicit_step_cost: float = 4.0
    implicit_step_cost_per_state: float = 0.02
    restart_step_ratio: float = 0.04
    event_time_tolerance: float = 1e-13
    max_simultaneous_events: int = 30


class LimitRows(NamedTuple):
    """Readings with limits."""

    rows: ConstraintRows  # output rows of the readings
    bounds: FloatArray  # low and high limit of each, SI; shape (readings, 2)
    row_values: FloatArray  # buffer; shape (readings, 5)
    jacobian: FloatArray  # buffer; shape (readings, 2, 3)
    # start_values, end_values, sample_values: buffers: value and rate of each reading at the start, the end
    # and inside of a step, SI; shape (readings, 2)
    start_values: FloatArray
    end_values: FloatArray
    sample_values: FloatArray


def make_limit_rows(mechanism: Mechanism, is_empty: bool = False) -> LimitRows:
    """Return the limits of a mechanism for poses of its body origins."""
    limits = () if is_empty else mechanism.limits
    origins = {body.name: body_reference_point(mechanism, body) for body in mechanism.bodies}
    n = len(limits)
    return LimitRows(
        rows=make_output_rows(mechanism, [limit.reading for limit in limits], origins),
        bounds=np.array([(limit.low, limit.high) for limit in limits], dtype=np.float64).reshape(n, 2),
        row_values=np.zeros((n, N_ROW_COLUMNS)),
        jacobian=np.zeros((n, 2, 3)),
        start_values=np.zeros((n, 2)),
        end_values=np.zeros((n, 2)),
        sample_values=np.zeros((n, 2)),
    )


@jit_in_place
def evaluate_limit_rows(limits: LimitRows, layout: StateLayout, state: FloatArray, values: FloatArray) -> None:
    """Fill the value and the rate (readings, 2) of each reading in a state."""
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    evaluate_rows(limits.rows, poses, velocities, limits.row_values, limits.jacobian)
    for i in range(values.shape[0]):
        values[i, 0] = limits.row_values[i, RowColumn.RESIDUAL]
        values[i, 1] = output_rate(limits.rows, limits.jacobian, i, velocities)


DEAD_CENTRE_TOLERANCE = 1e-8
"""Sine of the crank angle at which an event is one of a dead centre: above the error of its location, and below all that a step covers."""

CUT_OFF_TOLERANCE = 1e-8
"""Travel before a cut-off, relative to the stroke, at which an event is that of the cut-off; for the same reason."""

FROM_DEAD_CENTRE = HOLD_KINDS.index(StrokeHold.FROM_DEAD_CENTRE)
FROM_CUT_OFF = HOLD_KINDS.index(StrokeHold.FROM_CUT_OFF)

TURNING_POINT_BISECTIONS = 20
"""Bisections of a turning point within a step: its value is good to the square of 1e-6 of the change within the step."""

SINGULAR_CONSTRAINT_TOLERANCE_RATIO = 1e-3
"""Factor on the constraint tolerance near a change point, where the error that a violation causes grows like 1 / e."""


class MultibodyEquation(NamedTuple):
    """Equation of a mechanism in one contact mode."""

    system: System  # mechanism, force elements and contact mode as arrays
    workspace: SystemWorkspace  # arrays of one evaluation, overwritten
    input_cubics: FloatArray  # local cubics of the input functions and their integrals; shape (functions, 5)
    constraint_tolerance: float  # largest constraint violation left by the projection, m
    max_distance: float  # distance from the origin beyond which a body has flown away, m
    shafts: IntArray  # indices of the bodies that must not turn back
    limits: LimitRows  # readings with limits
    # result: state at the start of the step in which the motion ends, and its local time, s; shape
    # (components + 1,)
    step_start: FloatArray
    derivative: FloatArray  # buffer; shape (components,)
    projected_state: FloatArray  # buffer; shape (components,)
    counts: IntArray  # counters, indexed by `StepCounter`


@jit_in_place
def _project_to(equation: MultibodyEquation, local_time: float, state: FloatArray, tolerance_ratio: float) -> None:
    layout = equation.system.state_layout
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    tolerance = tolerance_ratio * equation.constraint_tolerance
    project_state(equation.system, equation.workspace, equation.input_cubics, local_time, poses, velocities, tolerance)


@jit_inlined
def _evaluate(equation: MultibodyEquation, local_time: float, state: FloatArray, derivatives: FloatArray, k: int) -> float:
    """Evaluate the state derivative, near a change point after a projection, and return the pivot ratio of the constraint rows."""
    pivot_ratio, is_projected = 0.0, False
    while True:
        pivot_ratio = evaluate_state_derivative(
            equation.system, equation.workspace, equation.input_cubics, local_time, state, equation.derivative
        )
        equation.counts[StepCounter.EVALUATIONS] += 1
        if is_projected or not 0.0 < pivot_ratio < NEAR_SINGULAR_QUALITY:
            break
        copy_array(equation.projected_state, state)
        state, is_projected = equation.projected_state, True
        _project_to(equation, local_time, state, SINGULAR_CONSTRAINT_TOLERANCE_RATIO)
    copy_array(derivatives[:, k], equation.derivative)
    return UNDETERMINED if pivot_ratio == JAMMED else pivot_ratio


_take_step = jit_in_place(make_take_step(_evaluate))


@jit_in_place
def _finish_step(equation: MultibodyEquation, local_time: float, quality: float, stages: Stages) -> float:
    copy_array(stages.next_state, stages.end)
    is_regular = quality > NEAR_SINGULAR_QUALITY
    _project_to(equation, local_time, stages.next_state, 1.0 if is_regular else SINGULAR_CONSTRAINT_TOLERANCE_RATIO)
    return _evaluate(equation, local_time, stages.next_state, stages.next_derivative, 0)


@jit_in_place
def _project_errors(equation: MultibodyEquation, errors: FloatArray) -> None:
    """Remove from the errors of poses and velocities what violates the constraints, at the poses of the last evaluation."""
    rows = equation.system.constraint_rows
    workspace = equation.workspace
    layout = equation.system.state_layout
    for i in range(2):
        for first in (0, layout.velocities):
            block = errors[i, first : first + layout.velocities].reshape(-1, 3)
            apply_jacobian(rows.row_bodies, workspace.jacobian, block, workspace.multipliers)
            solve_band_system(workspace.band, workspace.factor, workspace.eigen, workspace.multipliers)
            subtract_minv_jt(rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, block)


@jit_in_place
def _evaluate_events(equation: MultibodyEquation, local_time: float, state: FloatArray, event_values: FloatArray) -> None:
    evaluate_event_functions(equation.system, equation.workspace, state, event_values)


@jit_in_place
def _sample_motion(layout: StateLayout, h: float, start: FloatArray, stages: Stages, fraction: float, sample: FloatArray) -> None:
    """Fill poses and velocities at a fraction of a step of length h (s) from a state, on the quintic interpolant of the poses."""
    end = stages.next_state
    for k in range(layout.velocities):
        i = layout.velocities + k
        acceleration = stages.derivatives[i, 0]
        end_acceleration = stages.next_derivative[i, 0]
        sample[k], sample[i] = quintic_hermite_jit(start[k], start[i], acceleration, end[k], end[i], end_acceleration, h, fraction)


@jit_in_place
def _finish_output(equation: MultibodyEquation, step: EventStep, fraction: float, state: FloatArray) -> None:
    """Project an interpolated state; near a change point its velocities follow from both ends of the step."""
    _project_to(equation, step.local_time + fraction * step.h, state, 1.0)
    # At an angle e from a change point, joints determine velocities to 1 / e^2 times the rounding of the poses, and the stages nearest to
    # it are as uncertain. The ends of the step are farther away.
    if not 0.0 < step.buffers.progress[0].lowest_quality < STEERING_QUALITY:
        return
    if equal_mass_pivot_ratio(equation.system, equation.workspace) < NEAR_SINGULAR_QUALITY:
        layout, sample = equation.system.state_layout, step.buffers.stages.stage_state
        _sample_motion(layout, step.h, step.state, step.buffers.stages, fraction, sample)
        copy_array(state[layout.velocities : layout.work], sample[layout.velocities : layout.work])


@jit_in_place
def _sample_events_from(equation: MultibodyEquation, step: EventStep, fraction: float, event_values: FloatArray, first: int) -> None:
    """Evaluate the event functions from one on at a fraction of the step, on the quintic interpolant of the poses."""
    stages = step.buffers.stages
    event_functions = equation.system.event_functions
    start = step.state
    end, sample = stages.next_state, stages.stage_state
    _sample_motion(equation.system.state_layout, step.h, start, stages, fraction, sample)
    for i in range(equation.system.state_layout.work, start.size):
        sample[i] = start[i] + fraction * (end[i] - start[i])
    needs_forces = False
    for i in range(first, event_functions.size):
        needs_forces = needs_forces or event_functions[i].kind == EventFunctionKind.FORCE or event_functions[i].input_index != NO_INDEX
    if needs_forces:
        _evaluate(equation, step.local_time + fraction * step.h, sample, stages.derivatives, N_STAGES - 1)
    evaluate_event_functions(equation.system, equation.workspace, sample, event_values, first)


@jit_in_place
def _sample_events(equation: MultibodyEquation, step: EventStep, fraction: float, event_values: FloatArray) -> None:
    _sample_events_from(equation, step, fraction, event_values, 0)


@jit_in_place
def _sample_kinks(equation: MultibodyEquation, step: EventStep, fraction: float, event_values: FloatArray) -> None:
    _sample_events_from(equation, step, fraction, event_values, count_located(step.buffers))


@jit_in_place
def _check_step(equation: MultibodyEquation, local_time: float, h: float, state: FloatArray, stages: Stages, quality: float) -> float:
    """Return a negative quality if a body flies away, a shaft turns back, or a reading may leave its limits within a step."""
    layout, end = equation.system.state_layout, stages.next_state
    positions = end[: layout.velocities].reshape(-1, 3)
    velocities = end[layout.velocities : layout.work].reshape(-1, 3)
    for i in range(equation.shafts.size):
        if velocities[equation.shafts[i], 2] < 0.0:
            quality = TURNED_BACK
    if equation.limits.bounds.size > 0 and _may_leave_limits(equation, h, state, stages):
        quality = LEFT_LIMITS
    for k in range(positions.shape[0]):
        if not abs(positions[k, 0]) + abs(positions[k, 1]) <= equation.max_distance:
            quality = OUT_OF_RANGE
    if quality in (TURNED_BACK, LEFT_LIMITS):
        copy_array(equation.step_start[: state.size], state)
        equation.step_start[state.size] = local_time
    return quality


@jit_in_place
def _may_leave_limits(equation: MultibodyEquation, h: float, state: FloatArray, stages: Stages) -> bool:
    """Return whether a reading is outside its limits after a step, or may be at a turning point within it."""
    # The turning point is that of the quintic interpolant, whose error is at most that of the cubic
    # one.
    limits = equation.limits
    layout = equation.system.state_layout
    end = stages.next_state
    sample = stages.stage_state
    evaluate_limit_rows(limits, layout, state, limits.start_values)
    evaluate_limit_rows(limits, layout, end, limits.end_values)
    for i in range(limits.bounds.shape[0]):
        start_value, start_rate = limits.start_values[i, 0], limits.start_values[i, 1]
        end_value, end_rate = limits.end_values[i, 0], limits.end_values[i, 1]
        if not limits.bounds[i, 0] < end_value < limits.bounds[i, 1]:
            return True
        reach = h * max(abs(start_rate), abs(end_rate))
        margin = min(start_value - limits.bounds[i, 0], end_value - limits.bounds[i, 0])
        if start_rate > 0.0:
            margin = min(limits.bounds[i, 1] - start_value, limits.bounds[i, 1] - end_value)
        if start_rate * end_rate >= 0.0 or margin > reach:
            continue
        low, high = 0.0, 1.0
        for _ in range(TURNING_POINT_BISECTIONS):
            middle = 0.5 * (low + high)
            _sample_motion(layout, h, state, stages, middle, sample)
            evaluate_limit_rows(limits, layout, sample, limits.sample_values)
            if limits.sample_values[i, 1] * start_rate > 0.0:
                low = middle
            else:
                high = middle
        peak = limits.sample_values[i, 0]
        error = abs(peak - cubic_hermite_jit(start_value, end_value, start_rate, end_rate, h, high))
        if not limits.bounds[i, 0] < peak - error or not peak + error < limits.bounds[i, 1]:
            return True
    return False


_EQUATION = EquationFunctions(
    _evaluate, _take_step, _finish_step, _finish_output, _project_errors, _evaluate_events, _sample_events, _check_step, _sample_kinks
)
_integrate_to_event = jit_in_place(make_dop853(_EQUATION))


@jit_in_place
def _evaluate_inputs(equation: MultibodyEquation, local_time: float, state: FloatArray) -> None:
    layout, cubics = equation.system.state_layout, equation.input_cubics
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    evaluate_inputs_at(equation.system, equation.workspace, poses, velocities, cubics, local_time, state[layout.lags :])


@jit_in_place
def _keep_phases(equation: MultibodyEquation, is_kept: bool) -> None:
    """Keep all gas in its phase of the cycle at the last evaluation up to the next kink, or let the phase follow from the state again."""
    force_elements = equation.workspace.force_elements
    rows = equation.workspace.output_row_values
    for i in range(force_elements.size):
        gas = force_elements[i]
        if gas.argument_index != NO_INDEX:
            travel = rows[gas.output_index, RowColumn.RESIDUAL]
            crank_angle = rows[gas.argument_index, RowColumn.RESIDUAL]
            gas.phase = int(evaluate_gas_phase(gas.coefficients, travel, crank_angle)) if is_kept else IN_NO_PHASE


@jit_in_place
def _keep_features(equation: MultibodyEquation, poses: FloatArray, velocities: FloatArray) -> None:
    """Keep what each constraint row and each row of what slides touches; behind an end of that kept before, what follows."""
    constraint_rows = equation.system.constraint_rows
    output_rows = equation.system.output_rows
    rubbing = equation.system.rubbing
    keep_features(constraint_rows, poses, velocities)
    for k in range(rubbing.size):
        keep_feature(output_rows, rubbing[k].output_index, poses, velocities)


@jit_in_place
def _end_phases(equation: MultibodyEquation) -> None:
    """Let the phase of all gas follow from the state again, and all rows find what they touch."""
    _keep_phases(equation, False)
    constraint_rows = equation.system.constraint_rows
    output_rows = equation.system.output_rows
    rubbing = equation.system.rubbing
    release_features(constraint_rows)
    for k in range(rubbing.size):
        release_feature(output_rows, rubbing[k].output_index)


@jit_in_place
def _begin_phases(equation: MultibodyEquation, buffers: StepBuffers, local_time: float, state: FloatArray) -> None:
    """Keep all gas in the phase that begins or goes on here, and what touches outlines on its edge; let kinks that are not negative wait.

    Those are functions of the kink at which the integration goes on. Before they rise again there is a dead centre, at which they are
    armed.
    """
    event_functions = equation.system.event_functions
    is_armed = equation.workspace.is_armed
    values = buffers.event_values[LAST_SAMPLE]
    if buffers.n_kinks == 0:
        return
    is_armed[:] = True
    layout = equation.system.state_layout
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    _keep_features(equation, poses, velocities)
    _keep_phases(equation, False)
    _evaluate(equation, local_time, state, buffers.stages.derivatives, 0)
    _evaluate_events(equation, local_time, state, values)
    _keep_phases(equation, True)
    for i in range(event_functions.size):
        is_armed[i] = values[i] < 0.0 or event_functions[i].kind not in GAS_KINKS


@jit_in_place
def _find_switch(equation: MultibodyEquation, input_index: int) -> int:
    """Return the index of the event function of the switch that an input sets."""
    event_functions, i = equation.system.event_functions, 0
    while event_functions[i].kind != EventFunctionKind.SWITCH or event_functions[i].input_index != input_index:
        i += 1
    return i


@jit_in_place
def _update_holds(equation: MultibodyEquation, local_time: float, state: FloatArray) -> None:
    """Set the states of the holds: at a dead centre of their own crank new ones, and behind a cut-off the travel at which it was passed."""
    system = equation.system
    rows = equation.workspace.output_row_values
    inputs = equation.workspace.inputs
    lag_states = state[system.state_layout.lags :]
    for k in range(system.lags.size):
        lag = system.lags[k]
        if lag.hold == 0:
            continue
        _evaluate_inputs(equation, local_time, state)
        switch = system.event_functions[_find_switch(equation, lag.input_index)]
        travel = rows[switch.source_index, RowColumn.RESIDUAL]
        angle = rows[switch.argument_index, RowColumn.RESIDUAL]
        if abs(math.sin(angle)) <= DEAD_CENTRE_TOLERANCE:
            lag_states[k] = NOT_HELD
            if lag.hold == FROM_DEAD_CENTRE:
                _evaluate_inputs(equation, local_time, state)
                lag_states[k] = inputs[lag.input_index]
        elif lag_states[k] >= NOT_HELD:
            travel_ratio = evaluate_travel_in_stroke(switch.sign, travel, angle)
            if travel_ratio >= inputs[lag.input_index] - CUT_OFF_TOLERANCE:
                lag_states[k] = travel_ratio


@jit_in_place
def integrate_multibody(
    equation: MultibodyEquation,
    buffers: StepBuffers,
    span: tuple[float, float],
    times: FloatArray,
    state: FloatArray,
    limits: StepLimits,
    states: FloatArray,
) -> tuple[IntegrationStatus, float, int, float]:
    """Integrate the state of a mechanism in place over an interval without breakpoints of its inputs, up to the first event of a contact.

    state holds poses and velocities of the body origins, the energy states and the lags. The input cubics begin at span[0] (s); states
    are filled at the times. Steps end at kinks of the forces. Returns status, next step (s), number of times reached, and time of the
    state (s).
    """
    time, end = span
    step = limits.step
    n_reached = 0
    n_events = count_located(buffers)
    is_at_kink = False
    at_event = buffers.event_values[LAST_SAMPLE]
    while True:
        _update_holds(equation, time - span[0], state)
        _begin_phases(equation, buffers, time - span[0], state)
        if is_at_kink and is_any_above(at_event, buffers.event_tolerances[ROUNDING], n_events):  # as a force that jumps there
            _end_phases(equation)
            return IntegrationStatus.EVENT, step, n_reached, time
        next_limits = StepLimits(
            limits.tolerance, step, limits.max_step, limits.max_steps, limits.min_stiff_steps, limits.coarser_steps, limits.steps
        )
        status, step, n_new, time = _integrate_to_event(
            equation, buffers, (time, end), span[0], state, next_limits, times[n_reached:], states[n_reached:]
        )
        n_reached, is_at_kink = n_reached + n_new, True
        if status != IntegrationStatus.EVENT or is_any_positive(at_event, n_events):
            _end_phases(equation)
            return status, step, n_reached, time


MultibodyStep = LastStep[ContactMode | None]
"""Last step of this engine; without contacts it has no mode."""


@dataclass(frozen=True)
class IntegrationResult:
    """States (monitor times reached, components), status, last step size (s) and end (s) of one integration.

    For a scene with contacts also the contact mode at each monitor time and the events; for a motion that leaves its range its last step.
    """

    states: FloatArray
    status: IntegrationStatus
    last_step: float
    end_time: float
    exit_step: MultibodyStep | None = None
    contact_modes: tuple[ContactMode, ...] = ()
    events: tuple[Event, ...] = ()
