"""An engine that its Watt governor controls: limit, onset and size of hunting against integrations on both sides of the limit."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference import scaled_watt_engine as watt_engine
from reference import speed_loop
from reference import watt_engine as reference
from reference.scaled_watt_engine import WattEngine
from reference.watt_engine import GovernedEngine

SOFT = WattEngine(control=reference.SOFT["alpha"], cosine=reference.SOFT["beta"], damping=0.69)
HARD = WattEngine(control=reference.HARD["alpha"], cosine=reference.HARD["beta"], damping=0.515)


def scaled(engine: GovernedEngine, load: float) -> WattEngine:
    """Return the scaled problem of an engine under a load."""
    dimensions = asdict(engine)
    lift = dimensions.pop("zero_torque_lift") - load / engine.torque_gain
    return watt_engine.scale_engine(**dimensions, equilibrium_lift=lift)


def peaks(engine: WattEngine, offset: float, periods: int) -> np.ndarray:
    """Return the heights of the turning points of x, relative to the equilibrium, in a motion released at an offset (rad)."""
    angle, speed = watt_engine.equilibrium(engine)
    times = np.linspace(0, periods * 2 * math.pi / speed_loop.limit_frequency(watt_engine.linearise(engine)), 400 * periods)
    motion = reference.scaled_trajectory(times, np.array([angle + offset, 0.0, speed]), engine.control, engine.cosine, engine.damping)[0]
    inner = motion[1:-1]
    return inner[(inner > motion[:-2]) & (inner >= motion[2:])] - angle


@pytest.mark.parametrize("engine", [SOFT, HARD])
def test_the_linear_limit(engine: WattEngine) -> None:
    limit, cosine = watt_engine.damping_limit(engine), engine.cosine
    loop = watt_engine.linearise(replace(engine, damping=limit))
    assert_allclose(speed_loop.critical_damping(loop), limit, rtol=1e-14)
    assert_allclose(speed_loop.limit_frequency(loop), math.sqrt((1 - cosine**2) / cosine), rtol=1e-14)
    # complex steps through the equations of motion; the roots of the cubic carry some roundings
    angle, speed = watt_engine.equilibrium(engine)
    columns = [
        reference.scaled_derivative(np.array([angle, 0.0, speed]) + 1e-30j * direction, engine.control, cosine, limit).imag / 1e-30
        for direction in np.eye(3)
    ]
    expected = np.sort_complex(np.linalg.eigvals(np.array(columns).T))
    assert_allclose(np.sort_complex(speed_loop.eigenvalues(loop)), expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("engine", [SOFT, HARD])
@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_small_oscillation_grows_below_the_limit_and_decays_above_it(engine: WattEngine, factor: float) -> None:
    engine = replace(engine, damping=factor * watt_engine.damping_limit(engine))
    pair = max(speed_loop.eigenvalues(watt_engine.linearise(engine)), key=np.imag)
    tops = peaks(engine, 1e-4, 12)[2:]
    growth = math.log(tops[-1] / tops[0])
    # tops are read from 400 samples a period: within 3e-5 of their height, beside a growth of 2 to 10 %
    assert_allclose(growth, pair.real * 2 * math.pi / pair.imag * (len(tops) - 1), atol=1e-3)
    assert (growth > 0) == (factor < 1)


def test_the_onset_by_the_lyapunov_coefficient() -> None:
    assert watt_engine.first_lyapunov_coefficient(SOFT) < 0 < watt_engine.first_lyapunov_coefficient(HARD)
    # without control the border is at beta^2 = 3/5
    border = WattEngine(control=1e-3, cosine=math.sqrt(0.6), damping=0.0)
    assert abs(watt_engine.first_lyapunov_coefficient(border)) < 1e-2 * abs(
        watt_engine.first_lyapunov_coefficient(replace(border, cosine=0.5))
    )


# Kuznetsov's formula evaluated from derivatives of the equations with 40 digits, by alpha and beta.
LYAPUNOV_COEFFICIENTS = {
    (0.8, 0.7): -0.170988757917919,
    (0.3, 0.9): 0.485378329760361,
    (0.5, 0.85): 0.119099078292658,
    (1.5, 0.5): -0.332220584879087,
    (0.1, 0.78): 0.00425311881258397,
}


@pytest.mark.parametrize("parameters", LYAPUNOV_COEFFICIENTS)
def test_the_lyapunov_coefficient(parameters: tuple[float, float]) -> None:
    engine = WattEngine(control=parameters[0], cosine=parameters[1], damping=0.0)
    # its factors cancel near the border: 3 - 5 beta^2 has lost two digits at most
    assert_allclose(watt_engine.first_lyapunov_coefficient(engine), LYAPUNOV_COEFFICIENTS[parameters], rtol=1e-12)


@pytest.mark.parametrize(
    ("engine", "cycles"), [(SOFT, reference.SOFT_CYCLES), (HARD, reference.HARD_CYCLES)], ids=["soft onset", "hard onset"]
)
def test_the_amplitude_of_hunting_near_the_limit(engine: WattEngine, cycles: dict[float, dict[str, float]]) -> None:
    damping = engine.damping
    cycle = cycles[damping]
    amplitude = (cycle["highest"] - cycle["lowest"]) / 2
    # the next term is of the order of the squared amplitude: 0.04 and 0.01
    assert_allclose(watt_engine.hunting_amplitude(engine), amplitude, rtol=0.05)


def test_a_hard_onset_divides_oscillations_that_die_out_from_those_that_grow() -> None:
    amplitude = (reference.HARD_CYCLES[0.515]["highest"] - reference.HARD_CYCLES[0.515]["lowest"]) / 2
    small, large = (peaks(HARD, factor * amplitude, 40) for factor in (0.7, 1.3))
    assert small[-1] < 0.9 * small[3]
    assert large[-1] > 1.1 * large[3]


def test_a_soft_onset_leads_to_the_same_cycle_from_inside_and_outside() -> None:
    engine = replace(SOFT, damping=0.65)
    expected = reference.SOFT_CYCLES[0.65]["highest"] - watt_engine.equilibrium(engine)[0]
    for offset in (0.1, 0.6):
        # the offsets have decayed after 50 periods; tops are read from 400 samples a period: within 3e-5 of their height
        assert_allclose(peaks(engine, offset, 50)[-1], expected, rtol=2e-4)


@pytest.mark.parametrize(
    ("engine", "settling_time", "cycle"),
    [
        (SOFT, 600, reference.SOFT_CYCLES[0.69]),
        (replace(SOFT, damping=0.65), 300, reference.SOFT_CYCLES[0.65]),
        (HARD, 28, reference.HARD_CYCLES[0.515]),
    ],
)
def test_the_reference_cycles(engine: WattEngine, settling_time: float, cycle: dict[str, float]) -> None:
    found = reference.limit_cycle(engine.control, engine.cosine, engine.damping, 0.1, settling_time)
    # printed to 10 digits
    assert_allclose([found[key] for key in cycle], list(cycle.values()), rtol=2e-9)


@pytest.mark.parametrize("damping", [reference.HUNTING_DAMPING, reference.STABLE_DAMPING])
def test_the_scaled_problem_is_the_one_in_si_units(damping: float) -> None:
    governed = GovernedEngine(arm_damping=damping)
    engine = scaled(governed, reference.LOADS[1])
    unit = watt_engine.scaled_time_unit(arm=governed.arm)
    before = governed.equilibrium(reference.LOADS[0])
    times = np.array([0.5, 2.0, 5.0, 9.0])
    expected = governed.trajectory(reference.STEP_TIME + times, reference.LOADS, reference.STEP_TIME)
    start = np.array([before[0], 0.0, governed.ratio * before[2] * unit])
    angle, _, speed = reference.scaled_trajectory(times / unit, start, engine.control, engine.cosine, engine.damping)
    # two integrations at 1e-13 per step, 5e-13 apart
    assert_allclose(angle, expected[0], rtol=1e-11)
    assert_allclose(speed / unit / governed.ratio, expected[2], rtol=1e-11)
    assert (engine.damping < watt_engine.damping_limit(engine)) == (damping == reference.HUNTING_DAMPING)


@pytest.mark.parametrize(
    ("damping", "rows"), [(reference.HUNTING_DAMPING, reference.HUNTING_MOTION), (reference.STABLE_DAMPING, reference.STABLE_MOTION)]
)
def test_the_reference_motion(damping: float, rows: list[tuple[float, ...]]) -> None:
    table = np.array(rows).T
    motion = GovernedEngine(arm_damping=damping).trajectory(table[0], reference.LOADS, reference.STEP_TIME)
    # what two integrations were seen to differ by, twofold
    assert_allclose(motion, table[1:], atol=2e-11)


def test_the_motion_in_si_units_ends_in_the_cycle() -> None:
    engine = GovernedEngine(arm_damping=reference.HUNTING_DAMPING)
    times = np.linspace(60, 64, 4001)
    angle, _, speed = engine.trajectory(times, reference.LOADS, reference.STEP_TIME)
    cycle = reference.HUNTING_CYCLE
    found = [angle.max(), angle.min(), speed.max(), speed.min()]
    # extremes among samples 1 ms apart: 1e-6 of curvature; the start has decayed to 4e-6
    assert_allclose(found, [cycle["highest"], cycle["lowest"], cycle["fastest"], cycle["slowest"]], rtol=3e-5)
