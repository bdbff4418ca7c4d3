"""Effects by themselves: what they refuse, what wire and orifices come to, governors built with rods and play."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.effects.dashpot import Dashpot, orifice_damping_coefficient
from governor_mechanism.effects.gas_pressure import GasPressure
from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance, DryFriction, Stops
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.effects.spring import OutputSpring, helical_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.parabolic import ParabolicGovernor
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.time_functions import InputFunction, LinearFunction, TableFunction
from governor_scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene
from one_coordinate_reference import integrate_one_coordinate
from reference import pendulum as linkage
from reference import zehnder

GOVERNORS = {"Watt": WATT, "Porter": PORTER, "crossed": CROSSED, "extended": EXTENDED, "uncrossed links": UNCROSSED_LINKS}
LOADED = {name: dimensions for name, dimensions in GOVERNORS.items() if "sleeve_mass" in dimensions}
RODS = [
    RodMasses(arm_mass=0.6, link_mass=0.5, ball_radius=0.05),
    RodMasses(arm_mass=0.6),
    RodMasses(link_mass=0.5),
    RodMasses(ball_radius=0.05),
]


def test_a_wire_spring_has_the_rate_of_its_formula():
    # G d^4 / (8 D^3 n) = 80e9 * 2.56e-10 / (8 * 6.4e-5 * 8) = 20.48 / 4.096e-3
    assert helical_spring_rate(wire=4e-3, coil=40e-3, turns=8, modulus=80e9) == pytest.approx(5000.0, rel=1e-14)
    soft = helical_spring_rate(wire=2e-3, coil=40e-3, turns=8, modulus=80e9)
    assert soft == pytest.approx(5000.0 / 16, rel=1e-14)


def test_an_orifice_has_the_coefficient_of_its_formula():
    # Q = A v = 0.62 a sqrt(2 p / rho), force p A = rho A^3 v^2 / (2 (0.62 a)^2): 900 * 8e-9 / (2 * (3.72e-6)^2)
    found = orifice_damping_coefficient(piston=20e-4, hole=12e-6, screw=0.5)
    assert found == pytest.approx(7.2e-6 / (2 * 1.38384e-11), rel=1e-14)
    assert orifice_damping_coefficient(piston=20e-4, hole=12e-6) == pytest.approx(found / 4, rel=1e-14)
    assert orifice_damping_coefficient(piston=20e-4, hole=12e-6, oil=450) == pytest.approx(found / 8, rel=1e-14)


EXAMPLES = [
    OutputSpring(reading="x", rate=2000.0, preload=30.0, zero=0.01),
    OutputSpring(reading="x", rate=2000.0, preload=30.0, zero=0.01, one_sided=True),
    Dashpot(reading="x", linear=3.0, quadratic=40.0),
]


def test_every_force_law_has_an_example_and_a_name_of_its_own():
    assert {type(example) for example in EXAMPLES} | {GasPressure} == set(FORCE_LAWS)  # that of gas: tests/effects/test_gas_pressure.py
    assert len({law.law_name for law in FORCE_LAWS}) == len(FORCE_LAWS)


def potential_above_slack(effect, values):
    """Return energy, slope and curvature (3, n) of an effect; zero where it is slack."""
    return np.where(values < effect.slack_below, 0.0, np.array(effect.potential(effect.coefficients, values)))


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: f"{effect.key} {effect.slack_below:g}")
def test_a_force_either_has_a_potential_or_dissipates(effect):
    values, rates = np.linspace(-0.1, 0.1, 9), np.linspace(-2.0, 2.0, 9)
    if effect.dissipates:
        assert np.all(effect.evaluate(values, rates[:, np.newaxis]) * rates[:, np.newaxis] <= 0.0)  # wherever it moves
        return
    step = 1e-4
    energies, slopes, curvatures = (
        np.array([potential_above_slack(effect, values + k * step) for k in (-1, 0, 1)])[:, i] for i in range(3)
    )
    # Central differences of a parabola are exact up to rounding of the energy over the step; where the force sets in they are not.
    smooth = np.abs(values - effect.free_value) > step
    assert (energies[2] - energies[0])[smooth] / (2 * step) == pytest.approx(slopes[1][smooth], abs=1e-9)
    assert (slopes[2] - slopes[0])[smooth] / (2 * step) == pytest.approx(curvatures[1][smooth], abs=1e-7)
    assert effect.evaluate(values, 0.0) == pytest.approx(-slopes[1], rel=1e-14, abs=1e-12)


def test_a_spring_pulls_nothing_where_it_is_free():
    spring = OutputSpring(reading="sleeve_lift", rate=2000.0, preload=30.0, zero=0.01)
    assert spring.preload + spring.rate * (spring.free_value - spring.zero) == pytest.approx(0.0, abs=1e-14)


def test_a_spring_pulls_and_pushes_unless_it_is_one_sided():
    assert OutputSpring(reading="a", rate=1.0).slack_below == -math.inf
    assert OutputSpring(reading="a", rate=1.0, zero=0.2, one_sided=True).slack_below == 0.2
    assert astuple(OutputSpring(reading="a", rate=1.0)) == ("a", 1.0, 0.0, 0.0, False)


def test_friction_may_depend_on_a_reading_once_a_constant_is_larger():
    function = LinearFunction(reading="b", gain=0.1)
    for values in ((0.0, 5.0), (5.0, 0.0)):  # the table in time need not be positive throughout
        force = InputFunction(times=(0.0, 1.0), values=values, functions=(function,))
        assert DryFriction(reading="a", force=force).contact == {"friction": force}
    for force in (InputFunction(functions=(function,)), InputFunction(factors=(function,))):
        with pytest.raises(MechanismError, match="on 'a' that depends on 'b' must not become negative"):
            DryFriction(reading="a", force=force)
    zero_or_more, below_zero = (TableFunction(reading="b", positions=(0.0, 1.0), values=(value, 1.0)) for value in (0.0, -1.0))
    assert DryFriction(reading="a", force=InputFunction(functions=(zero_or_more,))).force.functions == (zero_or_more,)
    for key in ("functions", "factors"):
        with pytest.raises(MechanismError, match="must not become negative"):
            DryFriction(reading="a", force=InputFunction(values=(5.0,), **{key: (below_zero,)}))


def test_stops_and_play_may_be_dead_or_elastic():
    for restitution in (0.0, 1.0):
        assert Stops(reading="a", low=0.0, restitution=restitution).contact == {"low": 0.0, "high": math.inf, "restitution": restitution}
        assert Clearance(width=2.0, restitution=restitution).stops.contact == {"low": -1.0, "high": 1.0, "restitution": restitution}
    assert Stops(reading="a", high=0.0).restitution == Clearance(width=1.0).restitution == 0.0
    for make in (lambda number: Stops(reading="a", low=0.0, restitution=number), lambda number: Clearance(width=1.0, restitution=number)):
        for number in (-0.01, 1.01, math.nan):
            with pytest.raises(MechanismError, match="must lie between 0 and 1"):
                make(number)


def test_a_dashpot_resists_with_both_its_parts():
    dashpot = Dashpot(reading="a", linear=3.0, quadratic=40.0)
    assert dashpot.evaluate(0.7, np.array([-2.0, 0.0, 0.5])) == pytest.approx([6.0 + 160.0, 0.0, -1.5 - 10.0], rel=1e-15)
    assert dashpot.force(dashpot.linear_coefficients, 0.7, 2.0) == -6.0
    assert astuple(Dashpot(reading="a", linear=1.0)) == ("a", 1.0, 0.0)
    assert astuple(Dashpot(reading="a", quadratic=1.0)) == ("a", 0.0, 1.0)


def test_play_is_stops_of_its_reading():
    stops = Clearance(width=1e-3, restitution=0.2).stops
    assert stops == Stops(reading=CLEARANCE_READING, low=-5e-4, high=5e-4, restitution=0.2)


@pytest.mark.parametrize("force", [InputFunction(values=(-1.0,)), InputFunction(times=(0.0, 1.0), values=(5.0, -1.0))])
def test_friction_below_zero_is_refused(force):
    with pytest.raises(MechanismError, match="on 'a' must not be negative; got -1"):
        DryFriction(reading="a", force=force)


def test_effects_of_a_scene_act_on_readings_that_exist_and_stand_once():
    scene = governor_scene(PORTER, speed=12.0, angle=0.6)
    friction = DryFriction(reading="sleeve_lift")
    with pytest.raises(MechanismError, match=r"no reading 'sleve_lift'; readings are .* Did you mean 'sleeve_lift'"):
        scene.with_changes(effects=(*scene.effects, DryFriction(reading="sleve_lift")))
    with pytest.raises(MechanismError, match="no reading 'sleeve_clearance'"):
        scene.with_changes(effects=(*scene.effects, Clearance(width=1e-3)))
    with pytest.raises(MechanismError, match="effect DryFriction on 'sleeve_lift' is listed twice"):
        scene.with_changes(effects=(friction, friction))
    both = scene.with_changes(effects=(friction, DryFriction(reading="arm_angle")))
    assert both.output_effects == both.effects


@pytest.mark.parametrize("dimensions", GOVERNORS.values(), ids=GOVERNORS)
def test_a_governor_without_rods_and_play_is_as_it_was(dimensions):
    machine = PendulumGovernor(**dimensions)
    assert machine.mechanism_with_effects(()) == machine.mechanism()
    assert machine.mechanism(rod_masses=None, clearance=None) == machine.mechanism()


def test_rods_and_play_are_refused_where_there_are_none():
    guide = ParabolicGovernor(double_parameter=0.6, inner_radius=0.05, outer_radius=0.25, ball_mass=1.0, sleeve_mass=4)
    assert guide.mechanism_with_effects([Stops(reading="ball_radius", low=0.1)]) == guide.mechanism()
    with pytest.raises(MechanismError, match="does not support it") as caught:
        guide.mechanism_with_effects([Clearance(width=1e-3), RodMasses(arm_mass=1.0)])
    assert len(caught.value.problems) == 2
    with pytest.raises(MechanismError, match="a governor without sleeve_mass has none") as caught:
        PendulumGovernor(**WATT).mechanism(RodMasses(link_mass=0.5, ball_radius=0.4), Clearance(width=1e-3))
    assert len(caught.value.problems) == 3  # links, a ball as large as its arm, play
    with pytest.raises(MechanismError, match="link_mass cannot be combined with clearance"):
        PendulumGovernor(**PORTER).mechanism(RodMasses(link_mass=0.5), Clearance(width=1e-3))


def reduced(dimensions, rods, angles):
    """The governor with rods along these arm angles (rad)."""
    scene = governor_scene(dimensions, speed=10.0, angle=0.6)
    mechanism = PendulumGovernor(**dimensions).mechanism(rods)
    return SingleDofReduction(scene.with_changes(mechanism=mechanism)).evaluate(angles)


def test_the_row_of_the_governor_with_massive_rods_is_met():
    table = zehnder.PORTER_MASSIVE_RODS
    rows = np.array(table["rows"])
    given = table["dimensions"]
    radius = math.sqrt(2.5 * given["ball_inertia"] / given["ball_mass"])  # of a solid sphere
    rods = RodMasses(arm_mass=given["arm_mass"], link_mass=given["link_mass"], ball_radius=radius)
    along = reduced(PORTER, rods, np.radians(rows[:, 0]))
    square = 2 * along.potential_derivative / along.spindle_inertia_derivative
    stiffness = along.potential_second_derivative - 0.5 * square * along.spindle_inertia_second_derivative
    frequency = stiffness / along.inertia
    whole = table["rest_inertia"] + along.spindle_inertia
    free = frequency + square * along.spindle_inertia_derivative**2 / (whole * along.inertia)
    found = np.stack([np.sqrt(square), stiffness, along.inertia, frequency, free], axis=-1)
    # Printed to twelve digits: 1e-9, as asked.
    np.testing.assert_allclose(found, rows[:, [1, 3, 4, 5, 6]], rtol=1e-9)


@pytest.mark.parametrize("rods", RODS, ids=lambda rods: f"{rods.arm_mass} {rods.link_mass} {rods.ball_radius}")
@pytest.mark.parametrize("dimensions", GOVERNORS.values(), ids=GOVERNORS)
def test_rods_have_the_inertias_and_weights_of_the_closed_form(dimensions, rods):
    if rods.link_mass and "sleeve_mass" not in dimensions:
        rods = replace(rods, link_mass=0.0, arm_mass=0.3)
    angles = np.radians([28.0, 35.0, 47.0])
    along = reduced(dimensions, rods, angles)
    governor = closed.PendulumGovernor(
        **dimensions, arm_mass=rods.arm_mass, link_mass=rods.link_mass, ball_inertia=0.4 * dimensions["ball_mass"] * rods.ball_radius**2
    )
    for found, expected in (
        (along.inertia, linkage.in_plane_inertia(governor, arm_angle=angles)),
        (along.inertia_derivative, linkage.in_plane_inertia_derivative(governor, arm_angle=angles)),
        (along.spindle_inertia, closed.spindle_inertia(governor, arm_angle=angles)),
        (along.spindle_inertia_derivative, linkage.spindle_inertia_derivative(governor, arm_angle=angles)),
        (along.potential_derivative, linkage.potential_derivative(governor, arm_angle=angles)),
        (along.potential_second_derivative, linkage.potential_second_derivative(governor, arm_angle=angles)),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)  # assembled to 1e-13, twice derived


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
@pytest.mark.parametrize("rods", [RODS[0], RODS[1]], ids=["rods", "arms"])
@pytest.mark.parametrize("dimensions", GOVERNORS.values(), ids=GOVERNORS)
def test_governors_with_rods_move_as_the_closed_form_says(engine, dimensions, rods):
    if rods.link_mass and "sleeve_mass" not in dimensions:
        rods = replace(rods, link_mass=0.0)
    governor = closed.PendulumGovernor(
        **dimensions, arm_mass=rods.arm_mass, link_mass=rods.link_mass, ball_inertia=0.4 * dimensions["ball_mass"] * rods.ball_radius**2
    )
    speed = closed.equilibrium_speed(governor, arm_angle=0.6)
    scene = governor_scene(dimensions, speed=speed, angle=0.6, rate=0.1, duration=0.3, output_interval=0.1)
    mechanism = PendulumGovernor(**dimensions).mechanism(rods)
    scene = scene.with_changes(mechanism=mechanism)
    run = gm.run(scene, engine=engine, accuracy=1e-10)
    assert run.outcome.ok
    expected = integrate_one_coordinate(scene, run.times, governor)
    found = [run.readings["arm_angle"], run.rates["arm_angle"]]
    np.testing.assert_allclose(found, expected, atol=1e-8)  # rates are asked to 1e-10 times some ten rad/s


@pytest.mark.parametrize("rods", [None, *RODS])
@pytest.mark.parametrize("dimensions", GOVERNORS.values(), ids=GOVERNORS)
def test_readings_are_those_of_the_governor_without_rods(dimensions, rods):
    if rods and rods.link_mass and "sleeve_mass" not in dimensions:
        rods = RodMasses(arm_mass=1.0)
    machine = PendulumGovernor(**dimensions)
    plain, other = machine.mechanism(), machine.mechanism(rods)
    for angle in (0.5, 0.8):
        here, there = PositionSolver(plain).solve_at_coordinate(angle), PositionSolver(other).solve_at_coordinate(angle)
        for reading in plain.readings:
            expected = evaluate_output(plain, reading.name, here).value
            assert evaluate_output(other, reading.name, there).value == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("rods", [None, RodMasses(arm_mass=0.6, ball_radius=0.05)], ids=["points", "rods"])
@pytest.mark.parametrize("dimensions", LOADED.values(), ids=LOADED)
def test_play_lets_go_of_the_sleeve(dimensions, rods):
    machine = PendulumGovernor(**dimensions)
    mechanism, linked = machine.mechanism(rods, Clearance(width=1e-3)), machine.mechanism(rods)
    assembler = PositionSolver(mechanism)
    assert assembler.mobility == 2
    assert evaluate_output(mechanism, CLEARANCE_READING, np.array(mechanism.initial_guess)).value == pytest.approx(0.0, abs=1e-15)
    for angle in (0.5, 0.8):
        held = PositionSolver(linked).solve_at_coordinate(angle)
        for risen in (0.0, 4e-4):
            poses = assembler.solve({"arm_angle": angle, CLEARANCE_READING: risen})
            lift = evaluate_output(mechanism, "sleeve_lift", poses).value - evaluate_output(linked, "sleeve_lift", held).value
            assert lift == pytest.approx(risen, abs=1e-12)  # counted upward from where the links hang it
            left = poses[mechanism.body_index("left ball")]
            right = poses[mechanism.body_index("right ball")]
            np.testing.assert_allclose(left[:2], [-right[0], right[1]], atol=1e-12)


@pytest.mark.parametrize("rods", [None, RodMasses(arm_mass=0.6, ball_radius=0.05)], ids=["points", "rods"])
@pytest.mark.parametrize("dimensions", LOADED.values(), ids=LOADED)
@pytest.mark.parametrize("seed", range(2))
def test_derivatives_of_the_play_are_its_differences(dimensions, rods, seed):
    mechanism = PendulumGovernor(**dimensions).mechanism(rods, Clearance(width=1e-3))
    random = np.random.default_rng(seed)
    poses = PositionSolver(mechanism).solve({"arm_angle": 0.6, CLEARANCE_READING: 2e-4})
    velocities, accelerations = (random.normal(size=poses.shape) for _ in range(2))
    step = 1e-3

    def value(k):
        moved = poses + velocities * k * step + 0.5 * accelerations * (k * step) ** 2
        return evaluate_output(mechanism, CLEARANCE_READING, moved).value

    far, near, here, ahead, beyond = (value(k) for k in (-2, -1, 0, 1, 2))
    now = evaluate_output(mechanism, CLEARANCE_READING, poses, velocities)
    # Differences of fourth order: 1e-12 times derivatives of some hundreds, and 1e-16 / step^2 of rounding.
    first = (8 * (ahead - near) - (beyond - far)) / (12 * step)
    second = (16 * (ahead + near) - (beyond + far) - 30 * here) / (12 * step**2)
    assert np.sum(now.gradient * velocities) == pytest.approx(first, abs=1e-7)
    assert np.sum(now.gradient * accelerations) + now.quadratic_velocity_term == pytest.approx(second, abs=1e-5)
