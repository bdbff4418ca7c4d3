"""The astatic governor: one equilibrium speed, neutral everywhere, and the time of its drift."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine, select_engine
from governor_mechanism.engines.base import state_reason
from governor_mechanism.machines.parabolic import ParabolicGovernor
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.part import Spindle, Start

# Zehnder's parabola for m = 4 at 4 pi rad/s: from x = 0.10 m at 0.05 m/s to 0.20 m; by quadrature and by Taylor series.
PARAMETER, TRANSIT, ARRIVAL = 0.621225507207, 2.54294404015, 0.0319576953357


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_the_transit_takes_zehnders_time(engine):
    run = gm.run("parabolic", engine=engine, accuracy=1e-10, times=[0.0, TRANSIT])
    assert run.readings["ball_radius"][-1] == pytest.approx(0.20, abs=1e-8 * ARRIVAL * 10)
    assert run.rates["ball_radius"][-1] == pytest.approx(ARRIVAL, abs=1e-8)


def test_it_is_neutral_everywhere():
    scene = gm.load("parabolic")
    along = SingleDofReduction(scene).evaluate(np.linspace(0.06, 0.24, 19))
    square = 2 * along.potential_derivative / along.spindle_inertia_derivative
    np.testing.assert_allclose(np.sqrt(square), 4 * math.pi, rtol=1e-11)  # the parameter has twelve digits
    stiffness = along.potential_second_derivative - 0.5 * square * along.spindle_inertia_second_derivative
    assert np.max(np.abs(stiffness) / along.potential_second_derivative) < 1e-11
    (rest,) = gm.equilibria(scene, float(np.sqrt(square[0])))
    assert rest.astatic


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
@pytest.mark.parametrize("radius", [0.06, 0.15, 0.24])
def test_a_ball_left_at_rest_stays(engine, radius):
    scene = gm.load("parabolic")
    # 120 rpm fits the twelve digits of the parameter to 1e-12 only, which over 10 s moves a ball by 1e-9 of its radius.
    neutral = Spindle(speeds=(math.sqrt(2 * scene.gravity * 5 / scene.part.dimensions["double_parameter"]),))
    still = scene.with_changes(spindle=neutral, start=Start(values={"ball_radius": radius}))
    run = gm.run(still, engine=engine, accuracy=1e-10, times=np.linspace(0.0, 10.0, 21))
    assert np.max(np.abs(run.readings["ball_radius"] - radius)) < 1e-10  # asked


def test_the_sleeve_rises_twice_as_far_and_the_scene_is_cross_checked():
    run = gm.run("parabolic")
    x = run.readings["ball_radius"]
    np.testing.assert_allclose(run.readings["sleeve_lift"], 2 * (x**2 - 0.05**2) / PARAMETER, atol=1e-12)
    report = gm.crosscheck("parabolic")
    assert report.passed, str(report)


def test_impulse_is_not_chosen_and_refuses():
    scene = gm.load("parabolic")
    engine, reason = select_engine("auto", scene, 1e-4)
    assert engine.name == "reduced"
    assert "impulse cannot model this scene" in state_reason(reason, None)
    with pytest.raises(gm.UnsupportedEffect, match="Proportion"):
        ImpulseEngine().run(scene)


def test_guides_the_wrong_way_round_are_refused():
    with pytest.raises(gm.MechanismError, match=r"inner_radius \(0.3 m\) must be less than outer_radius \(0.2 m\)"):
        ParabolicGovernor(double_parameter=0.6, inner_radius=0.3, outer_radius=0.2, ball_mass=1.0, sleeve_mass=4.0)
