"""Outlines that touch outlines: an eccentric disc that bounces and rocks, against a reference."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import governor_mechanism as gm
from contact_scenes import FLOOR, GRAVITY, contact_document, events_of, readings_of, start_of
from governor_mechanism.model.events import EventKind

RADIUS, OFFSET, INERTIA = 0.045, 0.005, 8e-4
"""An eccentric disc of 1 kg: radius, distance of its middle from its mass centre, and moment of inertia about that."""


def disc_document(height, turn, turn_rate, restitution, side_rate=0.1):
    """The disc above a floor, as the profile of a cam with harmonic lift over a full turn."""
    lifts = [{"over": "180 deg", "lift": 2 * OFFSET, "law": "harmonic"}, {"over": "180 deg", "lift": -2 * OFFSET, "law": "harmonic"}]
    curve = {"radius": RADIUS - OFFSET, "lifts": lifts, "follower": "flat"}
    disc = {"name": "disc", "mass": 1.0, "inertia": INERTIA, "at": [0, height], "angle": turn, "outline": {"curve": curve}}
    contact = {"name": "floor", "first": "disc", "second": "block", "restitution": restitution}
    start = start_of((0.0, height, turn), (side_rate, 0.0, turn_rate))
    return contact_document(FLOOR, [disc], [contact], readings_of("disc"), start, run=(0.8, 0.02))


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
