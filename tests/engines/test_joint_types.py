"""Every joint, drive and load, simulated by both engines, against closed forms and scipy's integration of others."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy.special import ellipk

from engines.joint_mechanisms import (
    CASES,
    CRANK_INERTIA,
    ENGINE_KINEMATICS,
    GRAVITY,
    NO_ERROR,
    ExactCase,
    ExactReadings,
    bead_in_a_round_slot,
    bead_on_a_parabola,
    bead_on_a_table_of_the_parabola,
    crank_motion,
    driven_slider_crank,
    falling_rack,
    slider_crank_driven_by_a_table,
)
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.observables.evaluation import time_scale

ROUNDING = 1e-13
"""In scales: what a thousand steps' rounding may leave, in the run and in scipy's integration."""


@cache
def case(name: str) -> ExactCase:
    return CASES[name]()


def errors(run: Trajectory, told: ExactReadings) -> tuple[float, float]:
    """The largest error of any reading, and of any rate, each in its scale."""
    second = time_scale(run.scene)
    off = [np.max(np.abs(run.readings[name] - told[name][0])) / run.scales[name] for name in told]
    fast = [np.max(np.abs(run.rates[name] - told[name][1])) / run.scales[name] * second for name in told]
    return max(off), max(fast)


def of_one_freedom(name: str) -> bool:
    """Whether a case is one that the reduced engine follows."""
    assembler = PositionSolver(case(name).scene.part.mechanism)
    return assembler.mobility == 1 and not assembler.equations.is_driven.any()


IMPULSE = [name for name in CASES if name != "rack"]
FINE = [(MultibodyEngine(), name) for name in CASES]
# The bead of a round slot passes the end of its slot's width, where x tells no longer where it is.
FINE += [(ReducedEngine(), name) for name in CASES if of_one_freedom(name) and name != "arc slot in the ground"]
BOTH = pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=["multibody", "reduced"])


@pytest.mark.parametrize(("engine", "name"), FINE, ids=[f"{engine.name}-{name}" for engine, name in FINE])
def test_fine_engines_move_as_the_closed_form_says(engine, name):
    one = case(name)
    run = engine.run(one.scene, accuracy=1e-10)
    assert run.outcome is Outcome.DONE
    assert set(one.exact(run.times)) == set(run.readings)
    # What was asked, and what the run says of itself; scipy at 1e-13 leaves an order of magnitude below that.
    assert max(errors(run, one.exact(run.times))) <= min(1e-10, run.error_estimate + ROUNDING)
    # Joints are closed at every step to 1e-14 of the size; interpolation between steps is closed once more.
    assert run.joint_gap.max() < 1e-12 * one.scene.part.mechanism.length_scale
    # Energy is as good as the motion: nothing else changes it.
    assert run.energy.drift < 1e-10


@pytest.mark.parametrize("name", IMPULSE)
def test_impulse_moves_as_the_closed_form_says(name):
    one = case(name)
    run = ImpulseEngine().run(one.scene, accuracy=1e-5)
    assert run.outcome is Outcome.DONE
    # The accuracy asked for, and the estimate of the run itself.
    assert max(errors(run, one.exact(run.times))) <= min(1e-5, run.error_estimate + ROUNDING)
    assert run.joint_gap.max() < 1e-5 * one.scene.part.mechanism.length_scale


@pytest.mark.parametrize("name", IMPULSE)
def test_the_ledger_of_an_impulse_run_is_as_good_as_its_motion(name):
    # The work of drives, dampers and loads too: what is left over is an error, and no larger than the motion's.
    assert ImpulseEngine().run(case(name).scene, accuracy=1e-5).energy.drift < 1e-5


@pytest.mark.parametrize("name", IMPULSE)
def test_single_impulse_runs_are_of_second_order(name):
    one = case(name)
    found = []
    for halvings in range(3):
        # So many iterations that the solver's error is none of the scheme's.
        engine = ImpulseEngine(step=one.step / 2**halvings, runs=1, iterations=160)
        run = engine.run(one.scene, certify=False)
        found.append(errors(run, one.exact(run.times)))
    if one.order == NO_ERROR:
        # A parabola in time is what a step of constant acceleration follows, so only rounding is left.
        assert np.max(found) < ROUNDING
        return
    # Steps of 5 ms (2.5 ms for the fast crank), some 50 to a radian: there the next term of the error, of order 3 or 4
    # in the step, changes a ratio of 4 by less than a tenth, and errors near 1e-5 are far above rounding.
    ratios = np.array(found[:-1]) / np.array(found[1:])
    assert np.all(ratios > 3.4), ratios
    assert np.all(ratios < 4.6), ratios


def test_a_round_slot_has_the_period_of_the_elliptic_integral():
    radius, start = 0.4, 2.2
    period = 4 * math.sqrt(radius / GRAVITY) * float(ellipk(math.sin(start / 2) ** 2))
    run = MultibodyEngine().run(bead_in_a_round_slot().scene, times=np.array([0.0, period / 2, period]), accuracy=1e-10)
    # Half a period later it stands on the other side, and then where it began.
    x = radius * math.sin(start)
    np.testing.assert_allclose(run.readings["x"] - 0.2, [x, -x, x], atol=1e-10 * radius)
    np.testing.assert_allclose(run.rates["x"], 0.0, atol=1e-10 * math.sqrt(GRAVITY * radius))


def test_a_coordinate_that_turns_back_on_its_way_ends_a_reduced_run_by_name():
    one = bead_in_a_round_slot()
    run = ReducedEngine().run(one.scene, accuracy=1e-10)
    assert run.outcome is Outcome.DEAD_CENTRE
    assert "'x' stands at a dead centre" in run.message
    assert 0 < run.times[-1] < one.scene.run.duration
    assert max(errors(run, one.exact(run.times))) <= 1e-10  # asked, up to there


@BOTH
def test_a_table_through_a_parabola_is_that_parabola(engine):
    runs = [engine.run(one().scene, accuracy=1e-10) for one in (bead_on_a_parabola, bead_on_a_table_of_the_parabola)]
    # Equal curves but for rounding in the spline's coefficients, whose second derivatives divide by 0.05^2 m2.
    np.testing.assert_allclose(runs[0].readings["x"], runs[1].readings["x"], atol=1e-12)


def test_the_impulse_engine_refuses_a_rack_by_name():
    with pytest.raises(UnsupportedEffect, match=r"engine 'impulse' cannot model \['Rack'\]"):
        ImpulseEngine().run(falling_rack().scene)


@pytest.mark.parametrize("by_table", [False, True], ids=["steady", "table"])
@pytest.mark.parametrize(("engine", "accuracy"), [(MultibodyEngine(), 1e-10), (ImpulseEngine(), 1e-6)])
def test_a_drive_gives_the_torque_that_the_motion_takes(engine, accuracy, by_table):
    one = slider_crank_driven_by_a_table() if by_table else driven_slider_crank()
    run = engine.run(one.scene, accuracy=accuracy)
    if by_table:
        angle, rate, bend = crank_motion(run.times)
    else:
        angle, rate, bend = 0.3 + 12.0 * run.times, np.full_like(run.times, 12.0), np.zeros_like(run.times)
    torque = ENGINE_KINEMATICS.torque(angle, rate, bend, CRANK_INERTIA)
    drive = run.reactions["drive"]
    # Forces follow from poses and velocities: as accurate as those, in the scale of the largest torque, and some
    # tenfold less for the lever by which the rod multiplies errors.
    np.testing.assert_allclose(drive.moment, torque, atol=10 * accuracy * np.max(np.abs(torque)))
    np.testing.assert_allclose(drive.force, 0.0, atol=1e-12 * np.max(np.abs(torque)))
    assert drive.determined.all()
    # What the drive has put in is in the ledger: without its work, kinetic and potential energy would not balance.
    given = run.energy.kinetic + run.energy.potential
    assert np.ptp(given) > 100 * run.energy.drift * run.energy.scale


def test_a_driven_mechanism_has_no_freedom_left():
    run = MultibodyEngine().run(driven_slider_crank().scene)
    assert run.mobility == 0
