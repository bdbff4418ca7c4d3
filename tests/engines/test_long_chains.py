"""Mechanisms with many bodies: chains of four-bar loops match one bar, and engines agree on long hanging chains."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from chain_mechanisms import four_bar_acceleration, four_bar_chain, hanging_chain
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.results.records import Outcome

LOOPS = 12
"""Number of loops; enough for the sparse solution of the equations."""


def exact_crank_angle(times):
    """Return the crank angle from its single equation of motion, to rounding."""
    solution = solve_ivp(
        lambda _, y: (y[1], four_bar_acceleration(LOOPS, y[0], 9.81)), (0.0, times[-1]), (math.pi / 2, -1.0),
        method="DOP853", t_eval=times, rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    return solution.y[0]


@pytest.mark.parametrize(("engine", "accuracy"), [("multibody", 1e-9), ("reduced", 1e-9), ("impulse", 1e-4)])
def test_a_chain_of_loops_matches_its_single_equation_of_motion(engine, accuracy):
    scene = four_bar_chain(LOOPS, duration=0.5, output_interval=0.05)
    run = gm.run(scene, engine, accuracy=accuracy)
    assert run.outcome is Outcome.DONE
    assert np.max(np.abs(run.readings["crank_angle"] - exact_crank_angle(run.times))) < accuracy


def test_both_engines_agree_on_a_long_hanging_chain():
    scene = hanging_chain(30, duration=0.3, output_interval=0.05)
    assert PositionSolver(scene.part.mechanism).mobility == 30
    multibody_run = gm.run(scene, "multibody", accuracy=1e-9)
    impulse_run = gm.run(scene, "impulse", accuracy=1e-5)
    for name, values in multibody_run.readings.items():
        assert np.max(np.abs(impulse_run.readings[name] - values)) < 1e-5
    assert multibody_run.energy.drift < 1e-9


def test_initial_accelerations_of_a_hanging_chain_match_lagrange_equations():
    """Rods start at a common angle; the reference solves the dense equations of their angles, without joints."""
    count, lean, length, gravity = 20, -1.2, 0.1, 9.81
    inertia, pull = np.zeros((count, count)), np.zeros(count)
    for k in range(count):  # the mass centre of rod k depends on all rods before it
        arm = np.where(np.arange(count) < k, length, np.where(np.arange(count) == k, length / 2, 0.0))
        inertia += 0.1 * np.outer(arm, arm)
        inertia[k, k] += 0.1 * length**2 / 12
        pull -= 0.1 * gravity * math.cos(lean) * arm
    expected = np.linalg.solve(inertia, pull)[0]
    instant = 1e-3
    run = gm.run(hanging_chain(count, duration=instant, output_interval=instant), "multibody", accuracy=1e-12)
    # the rate is a t, with a relative error of order t^2
    assert run.rates["lean"][-1] / instant == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("loops", [3, LOOPS])
def test_few_and_many_rows_have_the_rank_of_their_dense_jacobian(loops):
    """Also where all bars are in one line, and one constraint of each loop depends on the others."""
    solver = PositionSolver(four_bar_chain(loops, duration=0.5, output_interval=0.05).part.mechanism)
    for angle, n_free in ((math.pi / 2, 1), (0.0, 1 + loops)):
        poses = solver.initial_guess.copy()
        poses[:, :2] = [
            (k / 2 + 0.5 * math.cos(angle), 0.5 * math.sin(angle)) if k % 2 == 0 else (k / 2 + math.cos(angle), math.sin(angle))
            for k in range(len(poses))
        ]
        poses[::2, 2] = angle
        rows = solver.equations.evaluate(poses)
        np.testing.assert_array_equal(rows.sparse_jacobian().toarray(), rows.jacobian.reshape(len(rows.residuals), -1))
        assert np.max(np.abs(rows.residuals)) < 1e-12
        assert solver.count_degrees_of_freedom(poses) == n_free
