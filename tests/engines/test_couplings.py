"""Coupled parts: exact motions of geared discs, a geared governor, laws of conservation, followed speeds and loads that follow readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part, engine_part, porter_part
from governor_mechanism.model.couplings import GearCoupling
from governor_mechanism.model.force_elements import TorsionSpring
from governor_mechanism.model.trajectory import Outcome

BELT = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", ratio=2.0)


def run_multibody(scene, accuracy=1e-10, **options):
    run = gm.run(scene, engine="multibody", accuracy=accuracy, **options)
    assert run.outcome is Outcome.DONE, run.message
    return run


@pytest.mark.parametrize("ratio", [2.0, -0.75])
def test_geared_discs_with_elastic_rims_move_as_the_exponential_of_their_matrix(ratio):
    """Each part is a wheel that a torsion spring couples to its rim; gears couple the wheels: theta_2 = ratio * theta_1."""
    (hub_1, rim_1, stiffness_1), (hub_2, rim_2, stiffness_2) = (1.2, 0.7, 40.0), (0.4, 0.9, 15.0)
    parts = [
        discs_part(name, {"wheel": hub, "rim": rim}, TorsionSpring(name="spokes", first="wheel", second="rim", stiffness=k), rates=rates)
        for name, hub, rim, k, rates in (
            ("engine", hub_1, rim_1, stiffness_1, {"wheel": 3.0, "rim": -1.0}),
            ("governor", hub_2, rim_2, stiffness_2, {"rim": 2.0}),
        )
    ]
    gear = GearCoupling(name="belt", first="engine.wheel_angle", second="governor.wheel_angle", ratio=ratio)
    run = run_multibody(coupled_scene(*parts, couplings=(gear,)))
    # Coordinates: angles of the first wheel, the first rim and the second rim.
    mass = np.diag([hub_1 + ratio**2 * hub_2, rim_1, rim_2])
    stiffness = np.array(
        [
            [stiffness_1 + ratio**2 * stiffness_2, -stiffness_1, -ratio * stiffness_2],
            [-stiffness_1, stiffness_1, 0.0],
            [-ratio * stiffness_2, 0.0, stiffness_2],
        ]
    )
    matrix = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(mass, stiffness), np.zeros((3, 3))]])
    expected = np.array([expm(matrix * time) @ [0.0, 0.0, 0.0, 3.0, -1.0, 2.0] for time in run.times])
    for column, name in enumerate(("engine.wheel_angle", "engine.rim_angle", "governor.rim_angle")):
        np.testing.assert_allclose(run.readings[name], expected[:, column], atol=1e-9)  # ten times the requested accuracy
        np.testing.assert_allclose(run.rates[name], expected[:, 3 + column], atol=1e-8)  # rates are ten times larger
    np.testing.assert_allclose(run.readings["governor.wheel_angle"], ratio * run.readings["engine.wheel_angle"], atol=1e-11)
    # The gear acts with -ratio times its torque on the first part and with its torque on the second one.
    first, second = (run.rates[f"{part}.wheel_angle"] * hub + run.rates[f"{part}.rim_angle"] * rim for part, hub, rim in (
        ("engine", hub_1, rim_1), ("governor", hub_2, rim_2)
    ))  # fmt: skip
    assert np.ptp(first) > 0.1
    np.testing.assert_allclose(first + ratio * second, first[0] + ratio * second[0], rtol=1e-10)


@pytest.mark.parametrize(("ratio", "disc_inertia"), [(1.0, 0.3), (2.0, 2.0), (-0.5, 0.1)])
def test_a_geared_disc_adds_its_reduced_inertia_to_a_free_spindle(ratio, disc_inertia):
    """With ratio 1 the shaft of the governor is only cut in two."""
    belt = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", ratio=ratio)
    geared = run_multibody(coupled_scene(engine_part(disc_inertia), porter_part(), couplings=(belt,)))
    part = porter_part(inertia=0.2 + disc_inertia / ratio**2)
    alone = run_multibody(coupled_scene(part))
    for name, values in alone.readings.items():
        # Twice the sum of both requested accuracies, for the scale of the speed, 13 rad/s, and the torque of up to 100 N m.
        np.testing.assert_allclose(geared.readings[f"governor.{name}"], values, atol=4e-10 * max(1.0, np.abs(values).max()), err_msg=name)
    np.testing.assert_allclose(geared.readings["engine.crank_angle"], alone.readings["spindle_angle"] / ratio, atol=1e-9)


def test_energy_and_momentum_of_a_geared_governor_are_conserved():
    scene = coupled_scene(engine_part(), porter_part(), couplings=(BELT,), duration=5.0)
    run = run_multibody(scene)
    assert run.energy.drift < 1e-9  # ten times the requested accuracy
    inertia = 0.2 + 2 * 5.0 * run.readings["governor.ball_radius"] ** 2
    momentum = 2.0 * run.rates["engine.crank_angle"] + BELT.ratio * inertia * run.readings["governor.spindle_speed"]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)
    assert np.ptp(run.rates["engine.crank_angle"]) > 0.1  # the governor acts on the engine
