"""The dead-beat escapement: energy and rate against the motion of a pendulum under the torque of its pallets, integrated by scipy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from governor_mechanism.closed_form.escapement import (
    DeadBeat,
    beat_period,
    circular_error,
    impulse_energy,
    kick_phase,
    lost_energy,
    steady_amplitude,
)

CLOCK = DeadBeat(torque=1e-3, travel=0.08, lift=0.03, unlock=0.01, inertia=0.06, frequency=6.0, damping=2.5e-3)


def beat(clock, amplitude, time, is_linear=True):
    """Integrate a beat from an extreme position: the torque of the pallet acts from `unlock` before the middle on; return end and time."""
    torque = clock.torque * clock.travel / clock.lift
    pull = (lambda x: x) if is_linear else math.sin
    state, start, ends = np.array([-amplitude, 0.0]), 0.0, [-clock.unlock, clock.lift - clock.unlock, None]
    for k, end in enumerate(ends):
        acts = torque / clock.inertia if k == 1 else 0.0

        def swing(t, y, acts=acts):
            return [y[1], -(clock.frequency**2) * pull(y[0]) - clock.damping / clock.inertia * y[1] + acts]

        def reach(t, y, end=end):
            return y[1] if end is None else y[0] - end

        reach.terminal, reach.direction = True, -1 if end is None else 1
        solution = solve_ivp(swing, (start, start + time), state, events=reach, rtol=1e-12, atol=1e-15, method="DOP853")
        start, state = float(solution.t[-1]), solution.y[:, -1]
    return state[0], start


def test_the_steady_amplitude_is_that_at_which_a_beat_ends_as_it_began():
    """The balance takes the loss to the air of a free oscillation: it is good to the loss of a beat over the energy."""
    amplitude = steady_amplitude(CLOCK)
    assert impulse_energy(CLOCK, amplitude=amplitude) == pytest.approx(CLOCK.torque * CLOCK.travel, rel=1e-14)
    assert lost_energy(CLOCK, amplitude=amplitude) == pytest.approx(CLOCK.torque * CLOCK.travel, rel=1e-9)
    end, _ = beat(CLOCK, amplitude, 2.0)
    decay = math.pi * CLOCK.damping / (CLOCK.inertia * CLOCK.frequency)
    assert end == pytest.approx(amplitude, rel=decay**2)


def test_the_rate_has_circular_error_and_airys_error():
    light = replace(CLOCK, torque=1e-5, damping=2.5e-5)
    amplitude = steady_amplitude(light)
    _, linear = beat(light, amplitude, 2.0)
    _, exact = beat(light, amplitude, 2.0, is_linear=False)
    free, error = math.pi / light.frequency, float(circular_error(amplitude))
    expected = beat_period(light, amplitude=amplitude)
    assert linear / free - 1 == pytest.approx(expected / (free * error) - 1, rel=0.02)
    assert exact == pytest.approx(expected, rel=0.02 * abs(linear / free - 1))
    later = beat_period(replace(light, unlock=0.0), amplitude=amplitude)
    about_the_middle = beat_period(replace(light, unlock=light.lift / 2), amplitude=amplitude)
    assert about_the_middle == pytest.approx(free * error, rel=1e-15)
    assert later > expected > about_the_middle


def test_the_circular_error_is_the_series_of_the_elliptic_integral():
    for amplitude in (0.02, 0.1, 0.3):
        exact = 2 / math.pi * ellipk(math.sin(amplitude / 2) ** 2)
        assert abs(circular_error(amplitude) - exact) < 173 / 737280 * amplitude**6 * 1.1  # the next term


@pytest.mark.parametrize("position", [-0.03, -0.01, 0.0, 0.02])
def test_a_kick_sets_the_phase_as_airy_says(position):
    """From x = A sin(phase), v = A w cos(phase) before and behind the kick."""
    amplitude, frequency, kick = 0.05, 6.0, 1e-6
    speed = frequency * math.sqrt(amplitude**2 - position**2)
    before, after = (math.atan2(position * frequency, v) for v in (speed, speed + kick))
    gain = kick_phase(position=position, speed_change=kick, amplitude=amplitude, frequency=frequency)
    assert gain == pytest.approx(after - before, rel=2e-5, abs=1e-15)


def test_friction_takes_its_share_by_the_slope_of_the_pallet():
    """A wedge of the slope s passes on (s - f) / (1 + f s) of a force, of which s without friction."""
    rough, amplitude = replace(CLOCK, friction=0.1), 0.05
    assert rough.slope == pytest.approx(0.08 / 0.03)
    share = math.tan(math.atan(rough.slope) - math.atan(0.1)) / rough.slope
    assert impulse_energy(rough, amplitude=amplitude) == pytest.approx(share * CLOCK.torque * CLOCK.travel, rel=1e-13)
    rubbing = lost_energy(rough, amplitude=amplitude) - lost_energy(CLOCK, amplitude=amplitude)
    assert rubbing == pytest.approx(0.1 * CLOCK.torque * (2 * amplitude - 0.03), rel=1e-12)
    heavy = replace(CLOCK, wheel_inertia=1e-6)
    speed = 0.08 / 0.03 * 6.0 * math.sqrt(amplitude**2 - 0.02**2)
    assert impulse_energy(heavy, amplitude=amplitude) == pytest.approx(8e-5 - 0.5e-6 * speed**2, rel=1e-13)
