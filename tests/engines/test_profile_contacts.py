"""Outlines that touch outlines: the cam with a flat follower, and an eccentric disc that bounces and rocks, against a reference."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import governor_mechanism as gm
from contact_scenes import GRAVITY, events_of
from governor_mechanism.closed_form.disc_cam import CamRise, lift_at, lift_off_share, lift_off_speed
from governor_mechanism.model.events import EventKind

OVER, DWELL = math.radians(150), math.radians(30)
PRELOAD = 30.0 + 0.3 * 9.81
RISE = CamRise(law="cycloidal", lift=0.01, angle=OVER, mass=0.3, stiffness=2000.0, preload=PRELOAD)
FALL = CamRise(law="harmonic", lift=0.01, angle=OVER, mass=0.3, stiffness=2000.0, preload=PRELOAD)
"""Rise and return of the shipped cam, the return backwards."""


def lift_of_cam(angles):
    """The lift of the follower of the shipped cam while it stays on the cam, which begins in the middle of the lower dwell."""
    angles = (angles - DWELL) % (2 * math.pi)
    rise, fall = angles / OVER, 1 - (angles - math.pi) / OVER
    risen, fallen = (lift_at(one, share=np.clip(share, 0, 1)) for one, share in ((RISE, rise), (FALL, fall)))
    return np.where(angles < math.pi, risen, fallen)


def cam_at(speed, **values):
    return gm.load("disc_cam_flat_follower").replace({"joint.motor.rate": f"{-speed!r} rad/s", **values})


def test_the_flat_follower_of_the_shipped_cam_rises_by_its_law_and_stays_on_it():
    run = gm.run(gm.load("disc_cam_flat_follower"))
    assert run.outcome is gm.Outcome.DONE
    assert not run.events
    # from 120 deg on, with the follower at 90 deg: the first dwell is half over when the rise is 15 deg away
    np.testing.assert_allclose(run.readings["lift"], lift_of_cam(20 * math.pi * run.times), atol=1e-14)
    assert np.abs(run.readings["flat_gap"]).max() < 1e-14
    assert run.energy.drift < 1e-6


@pytest.mark.parametrize("ratio", [0.999, 1.001])
def test_the_follower_leaves_the_cam_above_the_speed_at_which_its_spring_no_longer_holds_it(ratio):
    least = lift_off_speed(RISE)
    assert least < lift_off_speed(FALL)
    run = gm.run(cam_at(ratio * least), times=np.linspace(0, math.pi / (ratio * least), 21))
    separations = events_of(run, EventKind.SEPARATION)
    assert len(separations) == (ratio > 1)
    if separations:
        share = lift_off_share(RISE, speed=ratio * least)
        assert separations[0] == pytest.approx((DWELL + share * OVER) / (ratio * least), abs=1e-7)


def test_a_follower_in_flight_swings_on_its_spring_until_it_strikes_the_cam():
    speed = 1.1 * lift_off_speed(RISE)
    run = gm.run(cam_at(speed), accuracy=1e-9, times=np.linspace(0, 6 / speed, 121))
    separation, impact = events_of(run, EventKind.SEPARATION)[0], events_of(run, EventKind.IMPACT)[0]
    share = lift_off_share(RISE, speed=speed)
    pull, omega = RISE.preload / RISE.stiffness, math.sqrt(RISE.stiffness / RISE.mass)
    lift, rate = lift_at(RISE, share=share), speed * lift_at(RISE, share=share, derivative=1)

    def flight(time):
        turn = omega * (time - separation)
        return (lift + pull) * np.cos(turn) + rate / omega * np.sin(turn) - pull

    assert separation == pytest.approx((DWELL + share * OVER) / speed, abs=1e-10)
    assert flight(impact) == pytest.approx(float(lift_of_cam(speed * impact)), abs=1e-10)
    flies = (run.times > separation) & (run.times < impact)
    assert flies.sum() > 5
    np.testing.assert_allclose(run.readings["lift"][flies], flight(run.times[flies]), atol=1e-11)


def test_a_cam_that_overlaps_its_follower_at_the_start_is_refused_with_depth_and_place():
    with pytest.raises(
        gm.MechanismError, match=r"the curve of contact 'flat', with its centre at \(0 mm, 0 mm\), overlaps .* 'follower' by 1 mm"
    ):
        gm.run(gm.load("disc_cam_flat_follower").replace({"body.follower.at": [0, "39 mm"]}))


RADIUS, OFFSET, INERTIA = 0.045, 0.005, 8e-4
"""An eccentric disc of 1 kg: radius, distance of its middle from its mass centre, and moment of inertia about that."""

FLOOR = [[-2, -0.2], [2, -0.2], [2, 0], [-2, 0]]


def disc_document(height, turn, turn_rate, restitution, side_rate=0.1):
    """The disc above a floor, as the profile of a cam with harmonic lift over a full turn."""
    lifts = [{"over": "180 deg", "lift": 2 * OFFSET, "law": "harmonic"}, {"over": "180 deg", "lift": -2 * OFFSET, "law": "harmonic"}]
    curve = {"radius": RADIUS - OFFSET, "lifts": lifts, "follower": "flat"}
    return {
        "machine": "custom",
        "size": 0.1,
        "body": [
            {"name": "floor", "mass": 1.0, "inertia": 1.0, "outline": FLOOR},
            {"name": "disc", "mass": 1.0, "inertia": INERTIA, "at": [0, height], "angle": turn, "outline": {"curve": curve}},
        ],
        "joint": [{"type": "weld", "first": "ground.origin", "second": "floor.origin"}],
        "contact": [{"name": "floor", "first": "disc", "second": "floor", "restitution": restitution}],
        "readings": {"x": {"x": "disc.origin"}, "y": {"y": "disc.origin"}, "turn": {"angle": "disc"}},
        "effects": {"gravity": GRAVITY},
        "start": {"x": 0.0, "y": height, "turn": turn, "x_rate": side_rate, "y_rate": 0.0, "turn_rate": turn_rate},
        "run": {"duration": 0.8, "output_interval": 0.02, "accuracy": 1e-9},
    }


def bounce_disc(height, turn, turn_rate, restitution, times):
    """Height, angle and impacts of the disc: parabolas and steady turning between impacts, whose times are roots."""

    def gap(state, time):
        y, rate, angle, spin = state
        # the middle of the disc lies on the axis of its cam that points back from the side of the rise
        return y + rate * time - GRAVITY * time**2 / 2 - OFFSET * math.sin(angle + spin * time) - RADIUS

    state, now, impacts, rows = (height, 0.0, turn, turn_rate), 0.0, [], []
    while True:
        samples = np.linspace(1e-9 if impacts else 0.0, times[-1] - now, 20_000)
        below = np.flatnonzero([gap(state, time) < 0 for time in samples])
        flight = (
            brentq(lambda time, at=state: gap(at, time), samples[below[0] - 1], samples[below[0]], xtol=1e-15) if len(below) else math.inf
        )
        for time in times[len(rows) :]:
            if time > now + flight:
                break
            after = time - now
            rows.append((state[0] + state[1] * after - GRAVITY * after**2 / 2, state[2] + state[3] * after))
        if len(rows) == len(times):
            return np.array(rows), impacts
        y, rate, angle, spin = state
        y, rate, angle = y + rate * flight - GRAVITY * flight**2 / 2, rate - GRAVITY * flight, angle + spin * flight
        lever = -OFFSET * math.cos(angle)  # of the vertical force at the lowest point
        impulse = -(1 + restitution) * (rate + spin * lever) / (1 + lever**2 / INERTIA)
        state, now = (y, rate + impulse, angle, spin + impulse * lever / INERTIA), now + flight
        impacts.append(now)


def test_an_eccentric_disc_that_bounces_on_a_floor_follows_its_parabolas():
    times = np.arange(0, 0.801, 0.02)
    run = gm.run(gm.Scene.from_dict(disc_document(0.15, 0.4, 7.0, 0.8)), times=times)
    rows, impacts = bounce_disc(0.15, 0.4, 7.0, 0.8, times)
    assert len(impacts) >= 3
    assert events_of(run, EventKind.IMPACT) == pytest.approx(impacts, abs=1e-10)
    np.testing.assert_allclose(run.readings["y"], rows[:, 0], atol=1e-9)
    np.testing.assert_allclose(run.readings["turn"], rows[:, 1], atol=1e-8)
    np.testing.assert_allclose(run.readings["x"], 0.1 * times, atol=1e-12)


def test_an_eccentric_disc_that_rocks_on_a_floor_keeps_its_energy_as_scipy_does():
    """Without friction the mass centre moves up and down alone: h = R + r sin, and (J + m h'^2) w' = -m (h' h'' w^2 + g h')."""

    def rate(_, state):
        angle, spin = state
        slope, bend = OFFSET * math.cos(angle), -OFFSET * math.sin(angle)
        return spin, -(slope * bend * spin**2 + GRAVITY * slope) / (INERTIA + slope**2)

    times, turn = np.arange(0, 0.801, 0.02), -0.6
    run = gm.run(gm.Scene.from_dict(disc_document(RADIUS + OFFSET * math.sin(turn), turn, 0.0, 0.0, 0.0)), times=times)
    exact = solve_ivp(rate, (0, times[-1]), (turn, 0.0), t_eval=times, rtol=1e-12, atol=1e-14, method="DOP853")
    assert not run.events
    np.testing.assert_allclose(run.readings["turn"], exact.y[0], atol=1e-9)
    np.testing.assert_allclose(run.readings["y"], RADIUS + OFFSET * np.sin(exact.y[0]), atol=1e-10)
    assert np.ptp(exact.y[0]) > 0.1
