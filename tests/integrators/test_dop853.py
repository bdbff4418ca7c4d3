"""DOP853 on an oscillator and a stiff decay with known solutions: states, events, and the ways in which an integration ends."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from governor_mechanism.integrators import step_record
from governor_mechanism.integrators.dop853 import StepLimits, make_dop853
from governor_mechanism.integrators.equation import EquationFunctions, EventStep, StepBuffers, make_step_buffers
from governor_mechanism.integrators.stages import END_STAGE, Stages, StepCounter, make_take_step
from governor_mechanism.integrators.tableau import NODES
from governor_mechanism.numerics.interpolation import quintic_hermite_jit
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

N_COMPONENTS = 2

pytestmark = pytest.mark.long  # a compiler takes seconds for an integrator of its own; runs of engines hold the same laws


class Oscillator(NamedTuple):
    """x'' = -stiffness x - damping x', not a number behind a time; in a time span its quality is not 1. x falls through a level."""

    stiffness: float
    damping: float
    undefined: tuple[float, float]
    quality: float
    last_time: float
    level: float
    counts: IntArray


@jit_in_place
def evaluate(problem: Oscillator, time: float, state: FloatArray, derivatives: FloatArray, stage: int) -> float:
    problem.counts[StepCounter.EVALUATIONS] += 1
    derivatives[0, stage] = state[1]
    derivatives[1, stage] = -problem.stiffness * state[0] - problem.damping * state[1] if time <= problem.last_time else math.nan
    return problem.quality if problem.undefined[0] < time < problem.undefined[1] else 1.0


@jit_in_place
def finish_step(problem: Oscillator, time: float, quality: float, stages: Stages) -> float:
    for i in range(N_COMPONENTS):
        stages.next_state[i], stages.next_derivative[i, 0] = stages.end[i], stages.derivatives[i, END_STAGE]
    return quality


@jit_in_place
def finish_output(problem: Oscillator, step: EventStep, fraction: float, state: FloatArray) -> None:
    """Every state is possible."""


@jit_in_place
def project_errors(problem: Oscillator, errors: FloatArray) -> None:
    """Every error is possible."""


@jit_in_place
def evaluate_events(problem: Oscillator, time: float, state: FloatArray, event_values: FloatArray) -> None:
    if event_values.size > 0:
        event_values[0] = problem.level - state[0]


@jit_in_place
def sample_events(problem: Oscillator, step: EventStep, fraction: float, event_values: FloatArray) -> None:
    start, end, stages = step.state, step.buffers.stages.next_state, step.buffers.stages
    accelerations = stages.derivatives[1, 0], stages.next_derivative[1, 0]
    x = quintic_hermite_jit(start[0], start[1], accelerations[0], end[0], end[1], accelerations[1], step.h, fraction)[0]
    event_values[0] = problem.level - x


@jit_in_place
def check_step(problem: Oscillator, time: float, h: float, state: FloatArray, stages: Stages, quality: float) -> float:
    return quality


FUNCTIONS = evaluate, jit_in_place(make_take_step(evaluate)), finish_step, finish_output, project_errors
_integrate = jit_in_place(make_dop853(EquationFunctions(*FUNCTIONS, evaluate_events, sample_events, check_step)))


@jit_in_place
def integrate_oscillator(
    problem: Oscillator,
    buffers: StepBuffers,
    span: tuple[float, float],
    state: FloatArray,
    limits: StepLimits,
    times: FloatArray,
    states: FloatArray,
) -> tuple[step_record.IntegrationStatus, float, int, float]:
    return _integrate(problem, buffers, span, 0.0, state, limits, times, states)


def integrate(
    times,
    *,
    stiffness=1.0,
    damping=0.0,
    undefined=(math.inf, math.inf),
    quality=step_record.BELOW_DOMAIN,
    last_time=math.inf,
    level=None,
    max_steps=10_000,
    **limits,
):
    """Return status, states at the times, and the time of the end, of an oscillator that starts at 1 without a speed."""
    problem = Oscillator(stiffness, damping, undefined, quality, last_time, level or 0.0, np.zeros(len(StepCounter), dtype=np.int64))
    tolerances = np.zeros(0 if level is None else 1)
    buffers = make_step_buffers(N_COMPONENTS, N_COMPONENTS, np.ones(N_COMPONENTS), tolerances, problem.counts)
    state, states = np.array([1.0, 0.0]), np.full((len(times), N_COMPONENTS), np.nan)
    usual = {"tolerance": 1e-10, "step": 0.1, "max_step": math.inf, "max_steps": max_steps, "min_stiff_steps": math.inf}
    given, span = StepLimits(**usual | limits), (0.0, float(times[-1]))
    status, _, _, time = integrate_oscillator(problem, buffers, span, state, given, np.asarray(times, dtype=float), states)
    return status, states, time


def record_of(length, n):
    """Return the record of another run with n equal steps."""
    record = step_record.make_step_record(n)
    for k in range(n):
        step_record.record_step(record, (k + 1) * length, length, 1.0)
    return record


def test_states_at_all_times_are_those_of_the_solution():
    times = np.linspace(0.0, 10.0, 41)[1:]
    status, states, time = integrate(times)
    assert status == step_record.IntegrationStatus.DONE
    assert time == 10.0
    np.testing.assert_allclose(states, np.stack([np.cos(times), -np.sin(times)], axis=-1), atol=1e-8)  # a hundred errors of one step


@pytest.mark.parametrize("level", [-0.6, 0.3])
def test_an_integration_ends_where_a_function_rises_through_zero(level):
    status, states, time = integrate([1.0, 10.0], level=level)
    assert time > 1.0
    assert status == step_record.IntegrationStatus.EVENT
    assert time == pytest.approx(math.acos(level), abs=1e-9)
    assert states[0, 0] == pytest.approx(math.cos(1.0), abs=1e-9)
    assert np.isnan(states[1, 0])


@pytest.mark.parametrize(
    ("options", "status", "last_time"),
    [
        ({"undefined": (-1.0, 1.0)}, step_record.IntegrationStatus.BELOW_TABLE, 0.0),
        ({"undefined": (0.5, 9.0)}, step_record.IntegrationStatus.BELOW_TABLE, 0.5),
        ({"max_steps": 5}, step_record.IntegrationStatus.STEP_LIMIT, 5.0),
        ({"last_time": 2.0}, step_record.IntegrationStatus.STALLED, 2.0),
        ({"coarser_steps": record_of(1e-9, 3000)}, step_record.IntegrationStatus.STALLED, 1e-5),
        ({"stiffness": 1e4, "damping": 1e4, "min_stiff_steps": 0.0, "tolerance": 1e-4}, step_record.IntegrationStatus.STIFF, 0.1),
    ],
)
def test_an_integration_that_cannot_go_on_says_why(options, status, last_time):
    end, states, time = integrate([10.0], **options)
    assert end == status
    assert 0.0 <= time <= last_time
    assert np.isnan(states[0, 0])


def test_a_motion_that_needs_very_many_steps_does_not_stall():
    status, states, _ = integrate([2.5], max_step=1e-3)
    assert status == step_record.IntegrationStatus.DONE
    assert states[0, 0] == pytest.approx(math.cos(2.5), abs=1e-12)


def test_a_stage_of_the_dense_output_outside_the_domain_ends_the_integration():
    h = 0.1
    node = NODES[END_STAGE + 2] * h  # a stage that only times within a step need
    hole = (node - 1e-6, node + 1e-6)
    assert min(abs(NODES[:END_STAGE] * h - node)) > 1e-4
    assert integrate([0.05, 0.1], step=h, undefined=hole)[0] == step_record.IntegrationStatus.BELOW_TABLE
    assert integrate([0.1], step=h, undefined=hole, max_step=h)[0] == step_record.IntegrationStatus.BELOW_TABLE


@pytest.mark.parametrize(
    ("quality", "factor"),
    [(step_record.FAR_OUTSIDE_DOMAIN, 0.25), (1e-3 * step_record.MIN_STAGE_QUALITY, 0.83), (step_record.MIN_STAGE_QUALITY, 1.0)],
)
def test_a_stage_far_outside_or_at_a_singularity_makes_a_step_shorter(quality, factor):
    h, steps = 0.1, step_record.make_step_record(100)
    node = NODES[END_STAGE - 2] * h  # the two behind it are at the end
    status, states, _ = integrate([h], step=h, undefined=(node - 1e-6, node + 1e-6), quality=quality, steps=steps)
    assert status == step_record.IntegrationStatus.DONE
    assert steps.ends[0] == pytest.approx(factor * h, rel=1e-14)
    assert states[0, 0] == pytest.approx(math.cos(h), abs=1e-10)


def test_each_end_of_a_motion_has_its_own_name():
    names = ("BELOW_DOMAIN", "ABOVE_DOMAIN", "OUT_OF_RANGE", "TURNED_BACK", "LEFT_LIMITS")
    qualities = [getattr(step_record, name) for name in names]
    statuses = [step_record.IntegrationStatus(step_record.domain_status(quality)).name for quality in qualities]
    assert statuses == ["BELOW_TABLE", "ABOVE_TABLE", *names[2:]]


def test_the_next_step_but_one_has_a_singularity_in_its_gap():
    previous_angle, h, step = 0.3, 0.1, 0.2
    for angle in (0.27, 0.22, 0.2, 0.12, 0.02):
        distance = angle * h / (previous_angle - angle)  # the angle falls in proportion to the time
        length = step_record.steer_step_over_singularity(angle, previous_angle, h, step)
        assert 0.0 < length <= max(step, distance / step_record.STAGE_GAP_FRACTION)
        if distance > (1 + step_record.STAGE_GAP_FRACTION) * step or distance <= 0.1 * step:
            assert length == step
        elif distance > step_record.STAGE_GAP_FRACTION * step + 0.02 * step:  # the step behind this one has it in its gap
            assert distance - length == pytest.approx(step_record.STAGE_GAP_FRACTION * step, rel=1e-12)
        else:  # this one has it
            assert distance == pytest.approx(step_record.STAGE_GAP_FRACTION * length, rel=1e-12)


def test_steps_near_a_singular_configuration_add_to_its_amplification():
    record = step_record.make_step_record(4)
    for end, quality in ((1.0, 0.8), (1.5, 0.02), (2.0, 0.0), (3.0, 0.5)):
        step_record.record_step(record, end, 0.5, quality)
    assert record.singular_amplification[0] == pytest.approx(0.5 / (0.02 / 0.8) ** 1.5, rel=1e-12)
