"""The shipped cams with a roller and with a flat follower: laws of lift, lift-off, flight, energy, friction, and refused overlaps."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import governor_mechanism as gm
from contact_scenes import events_of
from governor_mechanism.closed_form.disc_cam import CamRise, lift_at, lift_off_share, lift_off_speed
from governor_mechanism.model.events import EventKind

DWELL = math.radians(30)
"""Angle by which either cam turns before its follower rises; the return begins half a turn after the rise."""

ROLLER, FLAT = "disc_cam", "disc_cam_flat_follower"
RISE = CamRise(law="cycloidal", lift=0.015, angle=math.radians(120), mass=0.4, stiffness=2000.0, preload=20.0 + 0.4 * 9.81)
FLAT_CAM = {"lift": 0.01, "angle": math.radians(150), "mass": 0.3, "stiffness": 2000.0, "preload": 30.0 + 0.3 * 9.81}
LAWS = {ROLLER: (RISE, RISE), FLAT: (CamRise(law="cycloidal", **FLAT_CAM), CamRise(law="harmonic", **FLAT_CAM))}
"""Rise and return of each, the return backwards."""

CAMS = pytest.mark.parametrize("name", LAWS)


def lift_of_cam(name, angles):
    """The lift of the follower while it stays on the cam, which has turned by an angle."""
    angles = (angles - DWELL) % (2 * math.pi)
    rise, fall = LAWS[name]
    risen, fallen = lift_at(rise, share=np.clip(angles / rise.angle, 0, 1)), 1 - (angles - math.pi) / fall.angle
    return np.where(angles < math.pi, risen, lift_at(fall, share=np.clip(fallen, 0, 1)))


def cam_at(name, speed):
    return gm.load(name).replace({"joint.motor.rate": f"{-speed!r} rad/s"})


@CAMS
def test_the_follower_rises_by_its_law_and_stays_on_its_cam(name):
    run = gm.run(name)
    assert run.outcome is gm.Outcome.DONE
    assert not run.events
    np.testing.assert_allclose(run.readings["lift"], lift_of_cam(name, 20 * math.pi * run.times), atol=1e-14)
    assert np.abs(run.readings["roller_gap" if name == ROLLER else "flat_gap"]).max() < 1e-14
    assert run.energy.drift < 1e-6


@CAMS
@pytest.mark.parametrize("ratio", [0.999, 1.001])
def test_the_follower_leaves_the_cam_above_the_speed_at_which_its_spring_no_longer_holds_it(name, ratio):
    rise, fall = LAWS[name]
    speed = ratio * lift_off_speed(rise)
    run = gm.run(cam_at(name, speed), times=np.linspace(0, 2 * math.pi / speed, 21))
    separations = events_of(run, EventKind.SEPARATION)
    assert len(separations) == (lift_off_speed(rise) < speed) + (lift_off_speed(fall) < speed)
    if separations:
        share = lift_off_share(rise, speed=speed)
        assert separations[0] == pytest.approx((DWELL + share * rise.angle) / speed, abs=1e-7)


@pytest.mark.parametrize(("name", "speed", "turn"), [(ROLLER, 30 * math.pi, 5.65), (FLAT, 1.1 * lift_off_speed(LAWS[FLAT][0]), 6.0)])
def test_a_follower_in_flight_swings_on_its_spring_until_it_strikes_the_cam(name, speed, turn):
    rise = LAWS[name][0]
    run = gm.run(cam_at(name, speed), accuracy=1e-9, times=np.linspace(0, turn / speed, 121))
    separation, impact = events_of(run, EventKind.SEPARATION)[0], events_of(run, EventKind.IMPACT)[0]
    share = lift_off_share(rise, speed=speed)
    assert separation == pytest.approx((DWELL + share * rise.angle) / speed, abs=1e-10)
    pull, omega = rise.preload / rise.stiffness, math.sqrt(rise.stiffness / rise.mass)
    lift, rate = lift_at(rise, share=share), speed * lift_at(rise, share=share, derivative=1)

    def flight(time):
        angle = omega * (time - separation)
        return (lift + pull) * np.cos(angle) + rate / omega * np.sin(angle) - pull

    flies = (run.times > separation) & (run.times < impact)
    assert flies.sum() > (20 if name == ROLLER else 5)
    np.testing.assert_allclose(run.readings["lift"][flies], flight(run.times[flies]), atol=1e-11)
    assert flight(impact) == pytest.approx(float(lift_of_cam(name, speed * impact)), abs=1e-10)
    assert np.all(run.readings["roller_gap" if name == ROLLER else "flat_gap"][flies] > 0)


def test_a_cam_that_runs_out_gives_its_energy_to_spring_and_follower():
    """Without a motor the energy of cam, follower and spring stays as it is while the roller stays on the cam."""
    document = dict(gm.load(ROLLER).document)
    document["joint"] = [joint for joint in document["joint"] if joint.get("name") != "motor"]
    document["start"] = {"cam_angle": "120 deg", "cam_rate": -60.0, "roller_gap": 0.0, "roller_rate": 0.0}
    run = gm.run(gm.Scene.from_dict(document), accuracy=1e-8, times=np.linspace(0, 0.2, 41))
    assert run.outcome is gm.Outcome.DONE
    assert not run.events
    lift = lift_of_cam(ROLLER, math.radians(120) - run.readings["cam_angle"])
    np.testing.assert_allclose(run.readings["lift"], lift, atol=1e-13)
    inertia = 1.5 * 0.04**2 / 2
    energy = inertia * run.rates["cam_angle"] ** 2 / 2 + 0.2 * run.rates["lift"] ** 2 + RISE.preload * lift + 1000 * lift**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


@pytest.mark.parametrize(
    ("name", "place", "sentence"),
    [
        (ROLLER, "86 mm", r"contact 'roller', .* overlaps the outline of 'cam' by 4 mm"),
        (FLAT, "39 mm", r"the curve of contact 'flat', with its centre at \(0 mm, 0 mm\), overlaps .* 'follower' by 1 mm"),
    ],
)
def test_a_cam_that_overlaps_its_follower_at_the_start_is_refused_with_depth_and_place(name, place, sentence):
    with pytest.raises(gm.MechanismError, match=sentence):
        gm.run(gm.load(name).replace({"body.follower.at": [0, place]}))


def test_a_run_is_the_same_bit_for_bit_twice_and_from_a_state_on():
    scene, times = cam_at(ROLLER, 30 * math.pi), np.linspace(0, 0.04, 21)
    first, second = (gm.run(scene, times=times) for _ in range(2))
    assert first.events == second.events
    np.testing.assert_array_equal(first.readings["lift"], second.readings["lift"])
    later = gm.run(scene, start=first.state(0.02), times=[0.0, 0.02], accuracy=1e-9)
    assert later.readings["lift"][-1] == pytest.approx(first.readings["lift"][-1], abs=1e-7)


def test_friction_under_a_flat_follower_takes_the_power_of_its_force_at_the_speed_of_the_cam():
    """The cam slides along the flat at its angular velocity times the height; normal force: spring, weight and inertia of the follower."""
    friction, speed, base, rise = 0.15, 20 * math.pi, 0.04, LAWS[FLAT][0]

    def power(time):
        share = (speed * time - DWELL) / rise.angle
        lift, bend = lift_at(rise, share=share), lift_at(rise, share=share, derivative=2)
        force = rise.preload + rise.stiffness * lift + rise.mass * bend * speed**2
        return friction * force * speed * (base + lift)

    start, end = (DWELL + 0.1 * rise.angle) / speed, (DWELL + 0.9 * rise.angle) / speed
    scene = gm.load(FLAT).replace({"contact.flat.friction": friction})
    run = gm.run(scene, times=[0.0, start, end], accuracy=1e-9)
    lost = run.energy.dissipated_energy[2] - run.energy.dissipated_energy[1]
    assert lost == pytest.approx(quad(power, start, end, epsabs=1e-13)[0], rel=1e-8)
