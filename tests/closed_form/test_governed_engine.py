"""Closed form of the loop of engine and governor: against the simulation's linearisation, quadrature, and Vyshnegradskii's limit."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import governor_mechanism as gm
from governor_mechanism.closed_form import governed_engine, pendulum, pendulum_sizing
from governor_mechanism.closed_form import governed_engine as closed
from governor_mechanism.closed_form.flywheel_engine import AirEngine, closing_load_pressure, gas_torque
from governor_mechanism.closed_form.flywheel_equilibrium import energy_fluctuation
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.scenes.changed_document import parse_scene_with
from reference import flywheel as printed
from refusing import refuses

ENGINE = AirEngine(**printed.ENGINE)
GOVERNOR = PendulumGovernor(arm=0.3, offset=0.04, ball_mass=5.0, sleeve_mass=21.0)
CLOSING, LOAD = -0.2 / 0.04, 150.0
"""Opening of the throttle by the lift of the shipped scene, 1/m, and its load after the step, N m."""


def equilibrium_angle():
    """Return the arm angle (rad) at which the throttle gives the torque of the load, from z = 2 l (1 - cos a)."""
    opening = 1 - (governed_engine.full_throttle_torque(ENGINE) - LOAD) / governed_engine.throttle_torque(ENGINE)
    lift = 0.08 + (opening - 1) / CLOSING
    return math.acos(1 - lift / (2 * GOVERNOR.arm))


@pytest.mark.parametrize("reacts", [True, False])
def test_the_polynomial_is_that_of_the_linear_equations(reacts):
    """I q'' + D q' + K q = N w and Jt w' + h w = M' q - N q', with N = r w_s J'."""
    inertia, damping, stiffness, total, slope, regulation = 0.7, 2.0, 40.0, 90.0, -25.0, 3.0
    ratio, speed, inertia_slope = 1.3, 11.0, 1.9
    coupling = ratio * speed * inertia_slope
    matrix = [
        [0.0, 1.0, 0.0],
        [-stiffness / inertia, -damping / inertia, coupling / inertia],
        [slope / total, -coupling / total if reacts else 0.0, -regulation / total],
    ]
    found = closed.characteristic_coefficients(
        coordinate_inertia=inertia,
        coordinate_damping=damping,
        stiffness=stiffness,
        spindle_inertia_derivative=inertia_slope,
        spindle_speed=speed,
        shaft_inertia=total,
        torque_derivative=slope,
        gear_ratio=ratio,
        self_regulation=regulation,
        reacts=reacts,
    )
    assert (1.0, found.a, found.b, found.c) == pytest.approx(tuple(np.poly(matrix)), rel=1e-12)
    np.testing.assert_allclose(np.sort_complex(found.roots()), np.sort_complex(np.linalg.eigvals(matrix)), rtol=1e-10)


@pytest.mark.parametrize(
    ("changes", "arguments"),
    [
        ({}, {}),
        (
            {"coupling.gear.ratio": 1.3, "part.governor.spindle.inertia": 4.0, "part.engine.start.crank_rate": "94 rpm"},
            {"gear_ratio": 1.3, "spindle_inertia": 4.0},
        ),
        ({"part.engine.dimensions.inertia": 20.0}, {"flywheel_inertia": 20.0}),
        ({"part.engine.dimensions.load_damping": 3.0}, {"self_regulation": 3.0}),
        ({"part.governor.effects.rods": {"arm_mass": 0.6, "link_mass": 0.5}}, {}),
    ],
    ids=["shipped", "geared up, heavy spindle", "light flywheel", "load that grows with the speed", "rods with mass"],
)
def test_the_polynomial_has_the_eigenvalues_of_the_simulation(changes, arguments):
    scene = parse_scene_with(gm.load("governed_engine_mean_torque").document, changes.items())
    linear = gm.linearise(scene)
    arguments = {"flywheel_inertia": 800.0, "sleeve_damping": 300.0} | arguments
    masses = changes.get("part.governor.effects.rods", {})
    governor = replace(GOVERNOR, **masses)
    if "self_regulation" not in arguments:
        assert linear.readings["governor.arm_angle"] == pytest.approx(equilibrium_angle(), abs=1e-12)
    angle = linear.readings["governor.arm_angle"]
    slope = CLOSING * governed_engine.throttle_torque(ENGINE)
    coefficients = closed.pendulum_coefficients(governor, arm_angle=angle, torque_slope=slope, **arguments)
    # The linearisation states errors of 1e-12 1/s.
    np.testing.assert_allclose(np.sort_complex(linear.eigenvalues), np.sort_complex(coefficients.roots()), rtol=1e-9)
    assert linear.stable == (np.prod(closed.vyshnegradskii_parameters(coefficients)) > 1)


def test_a_governor_that_only_follows_has_the_classical_polynomial():
    scene = gm.load("governed_engine_mean_torque")
    scene = parse_scene_with(scene.document, {"coupling.gear.type": "follow"}.items())
    slope = CLOSING * governed_engine.throttle_torque(ENGINE)
    arguments = {"arm_angle": equilibrium_angle(), "torque_slope": slope, "flywheel_inertia": 800.0, "sleeve_damping": 300.0}
    coefficients = closed.pendulum_coefficients(GOVERNOR, **arguments, reacts=False)
    np.testing.assert_allclose(np.sort_complex(gm.linearise(scene).eigenvalues), np.sort_complex(coefficients.roots()), rtol=1e-9)


def test_torque_of_the_throttle_by_quadrature():
    def mean_torque(engine):
        limits = [0.0, *engine.interval_limits, math.pi]
        return sum(quad(lambda angle: gas_torque(engine, crank_angle=angle), *ends, epsabs=1e-10)[0] for ends in pairwise(limits)) / math.pi

    assert governed_engine.full_throttle_torque(ENGINE) == pytest.approx(mean_torque(ENGINE), rel=1e-12)
    # Without a pump, a throttle of 0.8 is the supply at a lower pressure.
    engine = replace(ENGINE, pump_area=1e-30)
    throttled = replace(engine, supply_pressure=1.5e5 + 0.8 * 2.5e5)
    assert 0.2 * governed_engine.throttle_torque(ENGINE) == pytest.approx(mean_torque(engine) - mean_torque(throttled), rel=1e-11)


def test_stored_work_behind_a_throttle():
    open_engine = replace(ENGINE, load_pressure=closing_load_pressure(ENGINE))
    expected = energy_fluctuation(open_engine).energy
    assert governed_engine.find_stored_work_range(ENGINE, throttle=1.0).energy == pytest.approx(expected, rel=1e-13)
    angles = np.linspace(0.0, math.pi, 20001)
    works = governed_engine.throttled_stored_work(ENGINE, crank_angle=angles, throttle=0.85)
    torques = governed_engine.throttled_gas_torque(ENGINE, crank_angle=angles, throttle=0.85)
    step = angles[1]
    by_trapezoids = np.concatenate([[0.0], np.cumsum(0.5 * (torques[1:] + torques[:-1]) * step)])
    mean = by_trapezoids[-1] / math.pi
    # The trapezoidal rule has errors of the square of the step, 2.5e-8, times 2.5 kN m.
    np.testing.assert_allclose(works, by_trapezoids - mean * angles, atol=1e-4)
    found = governed_engine.find_stored_work_range(ENGINE, throttle=0.85)
    # Between the points of the grid an extreme differs by the square of their distance.
    assert (found.lowest, found.highest) == pytest.approx((works.min(), works.max()), abs=1e-4)
    assert governed_engine.throttle_for_torque(ENGINE, torque=mean) == pytest.approx(0.85, abs=1e-7)


@pytest.mark.parametrize("ratio", [1.02, 1.05, 1.1])
def test_the_offset_for_a_ratio_of_speeds(ratio):
    inner = pendulum_sizing.angle_of_lift(arm=0.3, lift=0.08)
    outer = pendulum_sizing.angle_of_lift(arm=0.3, lift=0.13)
    assert 0.6 * (1 - math.cos(inner)) == pytest.approx(0.08, rel=1e-14)
    offset = pendulum_sizing.offset_for_speed_ratio(arm=0.3, inner_angle=inner, outer_angle=outer, ratio=ratio)
    slow, fast = (math.sqrt(math.tan(angle) / (offset + 0.3 * math.sin(angle))) for angle in (inner, outer))
    assert fast / slow == pytest.approx(ratio, rel=1e-14)
    assert pendulum_sizing.speed_ratio(arm=0.3, offset=offset, inner_angle=inner, outer_angle=outer) == pytest.approx(ratio, rel=1e-14)


def test_crossed_arms_are_neutral_at_the_smallest_stable_offset():
    offset = pendulum_sizing.smallest_stable_offset(arm=0.3, arm_angle=0.5)
    governor = PendulumGovernor(arm=0.3, offset=offset, ball_mass=5.0, sleeve_mass=21.0)
    assert pendulum.least_stable_angle(governor) == pytest.approx(0.5, rel=1e-14)


def test_masses_by_the_rule_of_zehnder():
    ball = pendulum_sizing.ball_mass_for_insensitivity(resistance=9.0, mass_ratio=3.0, insensitivity=0.02, gravity=9.81)
    force = pendulum_sizing.sleeve_force(ball_mass=ball, sleeve_mass=3 * ball, gravity=9.81)
    assert 9.0 / force == pytest.approx(0.02, rel=1e-14)
    # Zehnder's (1) and (2) less each other, over (3): (w'^2 - w''^2) / w^2 = 2 W / (P + Q).
    up, down = (math.sqrt((force + sign * 9.0) / force) for sign in (1, -1))
    assert (up**2 - down**2) / 2 == pytest.approx(0.02, rel=1e-13)


def test_the_limit_of_vyshnegradskii_is_where_two_roots_lie_on_the_imaginary_axis():
    # (s + p)(s^2 + w^2) has a b = c, that is, x y = 1.
    p, w = 0.7, 3.1
    coefficients = closed.CharacteristicCoefficients(a=p, b=w**2, c=p * w**2)
    x, y = closed.vyshnegradskii_parameters(coefficients)
    assert x * y == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose(coefficients.roots(), [1j * w, -1j * w, -p], atol=1e-14)  # rounding of numbers of the order of one


def test_refusals():
    with pytest.raises(MechanismError, match="let the rising sleeve close the throttle"):
        closed.vyshnegradskii_parameters(closed.CharacteristicCoefficients(a=1.0, b=1.0, c=-1.0))
    refuses("nothing to hold back", governed_engine.throttle_torque, replace(ENGINE, back_pressure=4e5))
