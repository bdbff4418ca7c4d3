"""Every joint, drive and force element: simulated motions against closed forms and integration by scipy."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.special import ellipk

import joint_mechanisms as cases
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.evaluation import time_scale

ROUNDING = 1e-13
"""Accumulated rounding of a thousand steps, relative to the scale of a reading, in the run and in scipy's integration."""


@cache
def case(name: str) -> cases.ExactCase:
    return cases.CASES[name]()


@cache
def exact_readings(name: str, times: tuple[float, ...]) -> cases.ExactReadings:
    """Return the exact readings of a case, once for all engines and tests."""
    return case(name).exact(np.array(times))


def exact_at_times_of(run: Trajectory, name: str) -> cases.ExactReadings:
    return exact_readings(name, tuple(run.times.tolist()))


@cache
def impulse_run(name: str) -> Trajectory:
    return ImpulseEngine().run(case(name).scene, accuracy=1e-5)


def max_errors(run: Trajectory, exact: cases.ExactReadings) -> tuple[float, float]:
    """Return the largest error of any reading and of any rate, relative to its scale."""
    value_errors = [np.max(np.abs(run.readings[name] - exact[name][0])) / run.scales[name] for name in exact]
    rate_errors = [np.max(np.abs(run.rates[name] - exact[name][1])) / run.scales[name] for name in exact]
    return max(value_errors), max(rate_errors) * time_scale(run.scene)


def has_one_degree_of_freedom(name: str) -> bool:
    """Return whether the reduced engine can simulate a case."""
    position_solver = PositionSolver(case(name).scene.part.mechanism)
    return position_solver.mobility == 1 and not position_solver.equations.is_driven.any()


IMPULSE = [name for name in cases.CASES if case(name).impulse]
FINE = [(MultibodyEngine(), name) for name in cases.CASES]
# The bead in the arc slot passes the largest x of the slot, a turning point of the coordinate x.
FINE += [(ReducedEngine(), name) for name in cases.CASES if has_one_degree_of_freedom(name) and name != "arc slot in the ground"]
BOTH = pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=["multibody", "reduced"])


@pytest.mark.parametrize(("engine", "name"), FINE, ids=[f"{engine.name}-{name}" for engine, name in FINE])
def test_multibody_and_reduced_engines_match_the_exact_motion(engine, name):
    one = case(name)
    run = engine.run(one.scene, accuracy=1e-10)
    assert run.outcome is Outcome.DONE
    exact = exact_at_times_of(run, name)
    assert set(exact) == set(run.readings)
    # The requested accuracy and the error estimate of the run; scipy's error at 1e-13 is ten times smaller.
    assert max(max_errors(run, exact)) <= min(1e-10, run.error_estimate + ROUNDING)
    # Joints are closed to 1e-14 of the length scale at every step, and once more after interpolation.
    assert run.joint_gap.max() < 1e-12 * one.scene.part.mechanism.length_scale
    # The energy balance is as accurate as the motion.
    assert run.energy.drift < 1e-10


@pytest.mark.parametrize("name", IMPULSE)
def test_impulse_engine_matches_the_exact_motion(name):
    one, run = case(name), impulse_run(name)
    assert run.outcome is Outcome.DONE
    # The requested accuracy and the error estimate of the run.
    assert max(max_errors(run, exact_at_times_of(run, name))) <= min(1e-5, run.error_estimate + ROUNDING)
    assert run.joint_gap.max() < 1e-5 * one.scene.part.mechanism.length_scale


@pytest.mark.parametrize("name", IMPULSE)
def test_the_energy_balance_of_an_impulse_run_is_as_accurate_as_its_motion(name):
    # With the work of drives, dampers and applied forces, the drift is only the error of the motion.
    assert impulse_run(name).energy.drift < 1e-5


@pytest.mark.parametrize("name", IMPULSE)
def test_single_impulse_runs_are_of_second_order(name):
    one = case(name)
    step_errors = []
    for halvings in range(2):
        # With 160 iterations the solver error is far below the error of the scheme.
        engine = ImpulseEngine(step=one.step / 2**halvings, runs=1, iterations=160)
        run = engine.run(one.scene, certify=False)
        step_errors.append(max_errors(run, exact_at_times_of(run, name)))
    if one.order == cases.NO_ERROR:
        # Steps of constant acceleration reproduce a parabola in time, so that only rounding remains.
        assert np.max(step_errors) < ROUNDING
        return
    # Steps of 5 ms (2.5 ms for the fast crank) are about 50 per radian: the next error term, of order 3 or 4, changes
    # the ratio of 4 by less than a tenth, and errors near 1e-5 are far above rounding.
    ratios = np.divide(*step_errors)
    assert np.all(ratios > 3.4), ratios
    assert np.all(ratios < 4.6), ratios


def test_the_period_of_a_bead_in_an_arc_slot_is_the_elliptic_integral():
    radius, start = 0.4, 2.2
    period = 4 * math.sqrt(radius / cases.GRAVITY) * float(ellipk(math.sin(start / 2) ** 2))
    run = MultibodyEngine().run(cases.bead_in_a_round_slot().scene, times=np.array([0.0, period / 2, period]), accuracy=1e-10)
    # After half a period the bead is on the other side, after a period at its start.
    x = radius * math.sin(start)
    np.testing.assert_allclose(run.readings["x"] - 0.2, [x, -x, x], atol=1e-10 * radius)
    np.testing.assert_allclose(run.rates["x"], 0.0, atol=1e-10 * math.sqrt(cases.GRAVITY * radius))


@BOTH
def test_a_table_of_a_parabola_gives_the_same_motion_as_the_parabola(engine):
    runs = [engine.run(one().scene, accuracy=1e-10) for one in (cases.bead_on_a_parabola, cases.bead_on_a_table_of_the_parabola)]
    # The curves are equal except for rounding in the coefficients of the spline, divided by (0.05 m)^2 in its second derivative.
    np.testing.assert_allclose(runs[0].readings["x"], runs[1].readings["x"], atol=1e-12)


@pytest.mark.parametrize(
    ("one", "motion"),
    [
        (cases.driven_slider_crank(), lambda times: (0.3 + 12.0 * times, np.full_like(times, 12.0), np.zeros_like(times))),
        (cases.slider_crank_driven_by_a_table(), cases.crank_motion),
        (cases.slider_crank_driven_by_a_formula(), cases.wobbling_crank_motion),
    ],
    ids=["steady", "table", "formula"],
)
@pytest.mark.parametrize(("engine", "accuracy"), [(MultibodyEngine(), 1e-10), (ImpulseEngine(), 1e-6)])
def test_the_torque_of_a_drive_matches_virtual_work(engine, accuracy, one, motion):
    run = engine.run(one.scene, accuracy=accuracy)
    angle, rate, acceleration = motion(run.times)
    torque = cases.ENGINE_KINEMATICS.torque(angle, rate, acceleration, cases.CRANK_INERTIA)
    drive = run.reactions["drive"]
    # Forces follow from poses and velocities: they are as accurate relative to the largest torque, except for a factor
    # of about ten by which the connecting rod amplifies errors.
    np.testing.assert_allclose(drive.moment, torque, atol=10 * accuracy * np.max(np.abs(torque)))
    np.testing.assert_allclose(drive.force, 0.0, atol=1e-12 * np.max(np.abs(torque)))
    assert drive.determined.all()
    # The energy balance includes the work of the drive: kinetic and potential energy alone vary.
    mechanical_energy = run.energy.kinetic + run.energy.potential
    assert np.ptp(mechanical_energy) > 100 * run.energy.drift * run.energy.scale


def test_a_driven_mechanism_has_no_degree_of_freedom():
    run = MultibodyEngine().run(cases.driven_slider_crank().scene)
    assert run.mobility == 0
