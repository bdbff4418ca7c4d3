"""An anchor escapement: half a tooth a beat, recoil by the shape of its pallets, the balance of its energy, and a rate that gains."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import governor_mechanism as gm
from governor_mechanism.closed_form.escapement import DeadBeat, beat_period, circular_error

TORQUE, RADIUS, TIP, LENGTH, DAMPING = 1.2e-3, 0.05, 1e-4, 0.2485, 2.5e-3
LIFT, UNLOCK, RECOIL = math.radians(2), math.radians(0.7), math.radians(10)
DISTANCE, INERTIA = RADIUS * math.sqrt(2), 2e-4 + LENGTH**2
OUTER, INNER = (
    math.sqrt(DISTANCE**2 + RADIUS**2 - 2 * DISTANCE * RADIUS * math.cos(math.radians(45 + side * 2.5))) - side * TIP for side in (1, -1)
)


def wheel_at_rest(angle, *, is_left):
    """Return the angle of the wheel, within a pitch, at which the round tip of a tooth lies on a resting face of the turned anchor."""
    short, radius, side = math.radians(45) + UNLOCK, OUTER if is_left else INNER, -1.0 if is_left else 1.0
    end = radius * np.array([side * math.sin(short), -math.cos(short)])
    slope = short + side * RECOIL
    along = np.array([side * math.cos(slope), math.sin(slope)])
    off = TIP * np.array([-along[1], along[0]])  # to the left of the way up: outside on the left pallet, inside on the right one
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    start, along = turned @ (end + off), turned @ along

    def excess(way):
        return math.hypot(*(start + way * along - [0, -DISTANCE])) - RADIUS

    x, y = start + brentq(excess, -2e-3, 6e-3, xtol=1e-15) * along - [0, -DISTANCE]
    return math.atan2(y, x)


def run_clock(duration, friction=0.1, **times):
    """Run the shipped escapement."""
    scene = gm.load("anchor_escapement").replace({"contact.pallets.friction": friction, "run.duration": duration})
    return gm.run(scene, certify=False, **times)


def test_the_wheel_advances_by_half_a_tooth_a_beat_and_recoils_by_the_shape_of_the_pallets():
    run = run_clock(4.0, times=np.arange(0.0, 4.0, 0.005))
    swing, wheel = run.readings["pendulum_angle"], run.readings["wheel_angle"]
    assert run.recurrences["beat"].advances["wheel_angle"] == pytest.approx(-math.radians(6), rel=1e-3)
    assert run.recurrences["beat"].count == 8
    lift_end = LIFT - UNLOCK
    for is_left, rests in ((True, swing > lift_end + 2e-3), (False, swing < -lift_end - 2e-3)):
        expected = np.array([wheel_at_rest(angle, is_left=is_left) for angle in swing[rests]])
        off = (wheel[rests] - expected) / (math.tau / 30)
        resting = np.abs(run.readings["pallets_gap"][rests]) < 1e-12
        assert resting.sum() > 100
        np.testing.assert_allclose(off[resting], np.round(off[resting]), atol=1e-7)
    back = np.diff(wheel)[(np.abs(swing[1:]) > 0.03) & (np.diff(np.abs(swing)) > 0)]
    assert np.all(back > 0)  # as the pendulum swings on, the wheel turns back


def test_the_energy_of_a_beat_is_the_work_of_the_weight_less_the_losses():
    """The air takes the integral of the damping times the square of the speed; the rest of the losses is lost at the teeth."""
    run = run_clock(4.0, times=np.linspace(0.0, 4.0, 4001))
    beat, energy = run.recurrences["beat"], run.energy
    assert energy.drift < 1e-9
    assert beat.supplied == pytest.approx(TORQUE * math.radians(6), rel=1e-3)
    air = DAMPING * np.trapezoid(run.rates["pendulum_angle"] ** 2, run.times)
    work = TORQUE * (run.readings["wheel_angle"][0] - run.readings["wheel_angle"][-1])
    gained = sum(one[-1] - one[0] for one in (energy.kinetic, energy.potential))
    assert work == pytest.approx(gained + air + energy.dissipated_energy[-1], abs=1e-6 * work)
    assert beat.lost == pytest.approx((air + energy.dissipated_energy[-1]) / 8, rel=0.02)


def test_recoil_makes_the_clock_gain():
    """A moment M at the angle x changes the relative frequency by - mean(M x) / (I w^2 A^2): at rest a tooth pushes as a spring does.

    The impulse in between is that of a dead-beat escapement, whose loss by Airy's condition is known.
    """
    run = run_clock(6.0, friction=0.0, times=np.linspace(0.0, 6.0, 1201))
    amplitude = float(np.abs(run.readings["pendulum_angle"]).mean()) * math.pi / 2
    slope = math.atan((OUTER - INNER) / (RADIUS * LIFT))
    law = DeadBeat(
        torque=TORQUE,
        travel=(OUTER - INNER + TIP * (1 - math.cos(slope))) / RADIUS,
        lift=LIFT,
        unlock=UNLOCK - TIP * math.sin(slope) / RADIUS,
        inertia=INERTIA,
        frequency=math.sqrt(9.81 * LENGTH / INERTIA),
        wheel_inertia=0.004 * RADIUS**2 / 2,
    )
    angles, step = amplitude * np.cos(np.linspace(0.0, math.pi, 2001)[1:-1]), 1e-6
    moments = np.zeros(len(angles))
    for k, angle in enumerate(angles):  # from the left to the right: at rest on the left pallet, pushed by it, at rest on the right one
        if not law.unlock - law.lift < angle < law.unlock:
            rests = [wheel_at_rest(angle + side * step, is_left=angle > 0) for side in (-1, 1)]
            moments[k] = -TORQUE * (rests[1] - rests[0]) / (2 * step)
    gain = -np.mean(moments * angles) / (INERTIA * (law.frequency * amplitude) ** 2)
    expected = beat_period(law, amplitude=amplitude) * (1 - gain)
    free = math.pi / law.frequency * circular_error(amplitude)
    assert gain > 5e-4
    assert run.recurrences["beat"].interval / free - 1 == pytest.approx(expected / free - 1, rel=0.1)
    assert run.recurrences["beat"].interval < free


@pytest.mark.long
def test_two_hundred_beats_miss_no_tooth():
    """At each turn of the pendulum another tooth rests: half a tooth a beat, within what the recoil of the swing changes."""
    run = run_clock(101.0, times=np.array([0.0, 101.0]))
    beats = [event.time for event in run.events if event.subject == "beat"]
    again = run_clock(101.0, times=np.array([0.0, *beats]))
    wheel = again.readings["wheel_angle"][1:]
    advances = -np.diff(wheel) / math.radians(6)
    assert len(beats) == 202
    np.testing.assert_allclose(advances, 1.0, atol=0.05)
    assert (wheel[0] - wheel[-1]) / math.radians(6) == pytest.approx(201, abs=0.05)
