"""Coupled parts: exact motions of geared discs, a geared governor, laws of conservation, followed speeds and loads that follow readings."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.linalg import expm

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part, engine_part, porter_part
from governor_mechanism.model.coupling.couplings import ControlCoupling, FollowCoupling, GearCoupling
from governor_mechanism.model.force_elements import Torque, TorsionSpring
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.time_functions import AngleHarmonic, HarmonicFunction, InputFunction, LinearFunction, TableFunction
from governor_scenes import PORTER

BELT = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", ratio=2.0)


def run_multibody(scene, accuracy=1e-10, **options):
    run = gm.run(scene, engine="multibody", accuracy=accuracy, **options)
    assert run.outcome is Outcome.DONE, run.message
    return run


def governor_momentum(run):
    """Return the angular momentum (n,) kg m2/s of the governor of `porter_part` about its spindle."""
    return (0.2 + 2 * PORTER["ball_mass"] * run.readings["governor.ball_radius"] ** 2) * run.readings["governor.spindle_speed"]


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
    first = run.rates["engine.wheel_angle"] * hub_1 + run.rates["engine.rim_angle"] * rim_1
    second = run.rates["governor.wheel_angle"] * hub_2 + run.rates["governor.rim_angle"] * rim_2
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


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_energy_and_momentum_of_a_geared_governor_are_conserved(engine):
    run = gm.run(coupled_scene(engine_part(), porter_part(), couplings=(BELT,), duration=10.0), engine=engine, accuracy=1e-10)
    assert run.energy.drift < 1e-11  # requirement
    momentum = 2.0 * run.rates["engine.crank_angle"] + BELT.ratio * governor_momentum(run)
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-11)  # requirement
    assert np.ptp(run.rates["engine.crank_angle"]) > 0.1  # the governor acts on the engine


def test_a_broken_belt_transmits_no_torque():
    run = run_multibody(coupled_scene(engine_part(), porter_part(), couplings=(replace(BELT, until=1.0),)))
    after = run.times >= 1.0
    for momentum in (2.0 * run.rates["engine.crank_angle"], governor_momentum(run)):
        np.testing.assert_allclose(momentum[after], momentum[after][0], rtol=1e-9)  # ten times the requested accuracy
        assert np.ptp(momentum[~after]) > 0.01
    assert np.all(run.reactions["belt"].moment[run.times > 1.0] == 0.0)
    whole = run_multibody(coupled_scene(engine_part(), porter_part(), couplings=(BELT,)))
    before = run.times <= 1.0
    np.testing.assert_allclose(run.readings["governor.arm_angle"][before], whole.readings["governor.arm_angle"][before], atol=1e-9)
    np.testing.assert_allclose(run.reactions["belt"].moment[run.times < 1.0], whole.reactions["belt"].moment[run.times < 1.0], atol=1e-6)
    assert run.energy.drift < 1e-9


def test_a_governor_that_follows_an_engine_moves_as_at_a_given_speed():
    """The engine feels nothing and speeds up evenly."""
    torque = InputFunction(values=(1.0,))
    follow = FollowCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", ratio=2.0)
    parts = engine_part(rate=6.0, torque=torque), porter_part(inertia=0.0, start_speed=None)
    run = run_multibody(coupled_scene(*parts, couplings=(follow,)))
    np.testing.assert_allclose(run.rates["engine.crank_angle"], 6.0 + 0.5 * run.times, rtol=1e-10)
    alone = run_multibody(coupled_scene(replace(parts[1], spindle=Spindle(times=(0.0, 2.0), speeds=(12.0, 14.0)))))
    for name in ("arm_angle", "spindle_speed"):
        np.testing.assert_allclose(run.readings[f"governor.{name}"], alone.readings[name], rtol=1e-9)
    np.testing.assert_allclose(run.readings["governor.spindle_angle"], 2.0 * run.readings["engine.crank_angle"], rtol=1e-12)
    assert run.energy.drift < 1e-9


def test_a_governor_that_follows_a_given_spindle_moves_as_at_its_own_speed():
    leader = Spindle(speeds=(12.5,), speed_fluctuation=0.1, cycles_per_turn=2.2)
    parts = replace(porter_part(), name="engine", spindle=leader), porter_part(inertia=0.0, start_speed=None)
    follow = FollowCoupling(name="belt", first="engine.spindle_angle", second="governor.spindle_angle", ratio=1.1)
    run = run_multibody(coupled_scene(*parts, couplings=(follow,)))
    own = Spindle(speeds=(13.75,), speed_fluctuation=0.1, cycles_per_turn=2.0)
    alone = run_multibody(coupled_scene(replace(parts[1], spindle=own)))
    for name in ("arm_angle", "spindle_speed", "spindle_torque"):
        np.testing.assert_allclose(run.readings[f"governor.{name}"], alone.readings[name], atol=1e-9, rtol=1e-9)
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize(("lag", "method"), [(0.15, "explicit"), (1e-5, "stiff from t = 0 s")])
def test_loads_that_follow_angles_directly_and_with_a_lag(lag, method):
    """J_1 q_1'' = u, T u' + u = g (q_2 - a), J_2 q_2'' = -k q_2 + h q_1: linear, with the lag u at its value at the start."""
    inertia_1, inertia_2, stiffness, gain, about, feedback = 2.0, 0.5, 30.0, 12.0, 0.2, 4.0
    engine = discs_part("engine", {"crank": inertia_1}, Torque(name="load", second="crank", moment=InputFunction()))
    loads = Torque(name="load", second="wheel", moment=InputFunction()), TorsionSpring(name="spring", second="wheel", stiffness=stiffness)
    governor = discs_part("governor", {"wheel": inertia_2}, *loads, rates={"wheel": 5.0})
    throttle = LinearFunction(reading="governor.wheel_angle", gain=gain, about=about, lag=lag)
    couplings = (
        ControlCoupling(name="throttle", target="engine.load", function=throttle),
        ControlCoupling(name="return", target="governor.load", function=LinearFunction(reading="engine.crank_angle", gain=feedback)),
    )
    run = run_multibody(coupled_scene(engine, governor, couplings=couplings))
    assert run.cost.method.startswith(method)
    matrix = np.zeros((6, 6))  # q_1, q_2, q_1', q_2', u, 1
    matrix[0, 2] = matrix[1, 3] = 1.0
    matrix[2, 4] = 1 / inertia_1
    matrix[3, :2] = feedback / inertia_2, -stiffness / inertia_2
    matrix[4] = 0.0, gain / lag, 0.0, 0.0, -1 / lag, -gain * about / lag
    expected = np.array([expm(matrix * time) @ [0.0, 0.0, 0.0, 5.0, -gain * about, 1.0] for time in run.times])
    for column, name in enumerate(("engine.crank_angle", "governor.wheel_angle")):
        np.testing.assert_allclose(run.readings[name], expected[:, column], atol=1e-9)  # ten times the requested accuracy
        np.testing.assert_allclose(run.rates[name], expected[:, 2 + column], atol=1e-8)  # rates are ten times larger


RATE = 3.0
"""Speed of a free disc that drives a load, rad/s."""


def load_by_angle(function, *, value=0.0, scales=False):
    """Return the run of an engine of 2 kg m2 whose load follows the angle RATE * time of a free disc."""
    engine, disc = engine_part(torque=InputFunction(values=(value,))), discs_part("governor", {"wheel": 1.0}, rates={"wheel": RATE})
    control = ControlCoupling(name="cam", target="engine.load", function=function, scales=scales)
    return run_multibody(coupled_scene(engine, disc, couplings=(control,)))


def test_a_load_of_harmonics_of_an_angle():
    harmonics = (
        AngleHarmonic(amplitude=0.5, order=0.0, phase=math.pi / 2),
        AngleHarmonic(amplitude=math.hypot(3.0, 1.0), order=2.0, phase=math.atan2(3.0, -1.0)),
    )
    run = load_by_angle(HarmonicFunction(reading="governor.wheel_angle", harmonics=harmonics))
    phase = 2.0 * RATE * run.times
    expected = 0.5 * run.times + (3.0 * np.sin(phase) + np.cos(phase) - 1.0) / (2.0 * RATE)
    np.testing.assert_allclose(run.rates["engine.crank_angle"], expected / 2.0, atol=1e-9)


@pytest.mark.parametrize("scales", [False, True])
def test_a_load_by_a_table_of_an_angle_has_its_kinks_where_they_are(scales):
    positions, values = np.array([0.5, 1.0, 2.5, 4.0]), np.array([1.0, -4.0, 6.0, 0.0])
    table = TableFunction(reading="governor.wheel_angle", positions=tuple(positions), values=tuple(values))
    run = load_by_angle(table, value=2.0, scales=scales)
    ends = np.array([-1.0, *positions, 10.0])
    torque = make_interp_spline(ends / RATE, [values[0], *values, values[-1]], k=1)
    rate = torque.antiderivative()
    expected = (2.0 * (rate(run.times) - rate(0.0)) if scales else rate(run.times) - rate(0.0) + 2.0 * run.times) / 2.0
    np.testing.assert_allclose(run.rates["engine.crank_angle"], expected, atol=1e-9)


def test_a_load_that_follows_the_speed_of_a_free_spindle():
    """The integral of the speed is the angle of the spindle."""
    gain, about = -3.0, 12.0
    function = LinearFunction(reading="governor.spindle_speed", gain=gain, about=about)
    control = ControlCoupling(name="throttle", target="engine.load", function=function)
    run = run_multibody(coupled_scene(engine_part(torque=InputFunction()), porter_part(), couplings=(BELT, control)))
    impulse = gain * (run.readings["governor.spindle_angle"] - about * run.times)
    momentum = 2.0 * run.rates["engine.crank_angle"] + BELT.ratio * governor_momentum(run)
    np.testing.assert_allclose(momentum - momentum[0], impulse, atol=1e-8)  # of a momentum of 50 kg m2/s
