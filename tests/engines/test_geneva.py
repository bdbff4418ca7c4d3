"""The shipped Geneva wheel: its angle law to the clearance, its peak speed, its lock under a torque, and what it loses."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.geneva import acceleration_ratio, engaged_angle, speed_ratio, wheel_angle
from governor_mechanism.model.events import EventKind

DISTANCE, CRANK = 0.1, 0.1 * math.sin(math.pi / 4)


def exact_angle(driver_angles, slots=4):
    """The angle of the wheel without clearance; it starts half a slot ahead and turns back by a slot at every turn of the driver."""
    angles = np.remainder(driver_angles + math.pi, math.tau) - math.pi
    turns = np.round((driver_angles - angles) / math.tau) - 1
    engaged = np.clip(angles, -engaged_angle(slots), engaged_angle(slots))
    return -np.asarray(wheel_angle(slots, driver_angle=engaged)) - turns * math.tau / slots


def run_wheel(duration=1.0, torque=None, **dimensions):
    document = dict(gm.load("geneva").replace({f"dimensions.{name}": value for name, value in dimensions.items()}).document)
    document["run"] = {"duration": duration, "output_interval": 0.0025}
    if torque is not None:
        document["force"] = [{"type": "torque", "body": "wheel", "moment": torque}]
    return gm.run(gm.Scene.from_dict(document))


def test_the_wheel_turns_by_a_quarter_a_turn_as_its_law_says_up_to_the_clearance():
    run = run_wheel(2.25)
    assert run.outcome is gm.Outcome.DONE
    differences = np.abs(run.readings["wheel_angle"] - exact_angle(run.readings["driver_angle"]))
    # The pin is nearest to the wheel's shaft on the line of centres.
    assert 0.5 < differences.max() / math.asin(0.0002 / (DISTANCE - CRANK)) < 1.01
    assert run.readings["wheel_angle"][-1] == pytest.approx(math.pi / 4 - math.pi, abs=0.0002 / CRANK * 1.01)
    impacts = [event for event in run.events if event.kind is EventKind.IMPACT]
    assert {event.subject for event in impacts} == {"pin_gap"}
    for name in ("pin_gap", *(f"horn_{k}_gap" for k in range(1, 9)), "edge_1_gap", "edge_2_gap"):
        assert run.readings[name].min() > -1e-12
    assert run.energy.drift < 1e-6


def test_the_law_is_met_the_better_the_smaller_the_clearance():
    errors = []
    for clearance in ("0.2 mm", "0.02 mm"):
        run = run_wheel(clearance=clearance)
        errors.append(np.abs(run.readings["wheel_angle"] - exact_angle(run.readings["driver_angle"])).max())
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.02)
    # On the line of centres the wheel turns fastest; the pin then crosses the clearance, and the wheel keeps its speed.
    speed = np.abs(run.rates["wheel_angle"]).max() / math.tau
    assert speed == pytest.approx(float(speed_ratio(4, driver_angle=0.0)), rel=0.01)


@pytest.mark.parametrize("torque", ["0.1 N m", "-0.1 N m"])
def test_the_disc_holds_the_wheel_against_a_torque_of_either_sense(torque):
    run = run_wheel(0.24, torque)  # later the edge of the disc comes to the line of centres, where its lever arm ends
    assert any(event.kind is EventKind.REST and event.subject.startswith("horn") for event in run.events)
    turned = run.readings["wheel_angle"][-1] - math.pi / 4
    # A horn touches the disc after the clearance over its lever arm, the distance of the wheel's shaft from the normal there.
    assert turned == pytest.approx(math.copysign(0.0002 / CRANK, float(torque.split()[0])), rel=0.02)


def test_a_number_of_slots_that_no_wheel_has_is_refused():
    for repeat in (1, 2.5, True, 10**6):
        with pytest.raises(gm.MechanismError, match="repeat must be a whole number from 2 to 500"):
            gm.load("geneva").replace({"body.wheel.outline.repeat": repeat})


def test_a_wheel_without_friction_touches_its_lock_without_a_force_and_stays_there():
    document = {key: value for key, value in gm.load("geneva").document.items() if key != "effects"}
    run = gm.run(gm.Scene.from_dict(document), times=np.linspace(0, 2, 41))
    assert run.outcome is gm.Outcome.DONE
    locked = (run.times > 0.65) & (run.times < 1.36)
    assert np.ptp(run.readings["wheel_angle"][locked]) < 0.01  # the clearance of the lock
    assert len(run.events) < 30


def wheel_of(slots, clearance):
    """The scene with another number of slots and another clearance (m); the pin, the disc and the hollow of the driver fit both."""
    half, pin, tip, disc = math.pi / slots, 0.004, 0.0005, 0.5 * DISTANCE * math.sin(math.pi / slots) + 0.012
    crank, outer, slot, arc = DISTANCE * math.sin(half), DISTANCE * math.cos(half), pin + clearance, disc + clearance
    bottom, cut = DISTANCE - crank - tip, math.pi / 2 - half
    tooth = [[outer, arc - crank], [outer, -slot], [bottom, -slot, -slot], [bottom, slot], [outer, slot], [outer, crank - arc, -arc]]
    x, y = disc * math.cos(cut), disc * math.sin(cut)
    back = [[-0.8 * disc, 0.6 * disc, disc], [-0.8 * disc, -0.6 * disc, disc]]
    document = dict(gm.load("geneva").document)
    del document["dimensions"]
    driver, wheel = ({**body} for body in document["body"])
    driver |= {"disc": {"radius": disc}, "points": {"pin": [crank, 0]}, "outline": [[x, y, disc], *back, [x, -y, -1.2 * y]]}
    wheel |= {"disc": {"radius": outer}, "at": [DISTANCE, 0], "angle": half, "outline": {"corners": tooth, "repeat": slots}}
    contacts = [{"name": "pin", "first": "driver.pin", "radius": pin, "second": "wheel"}]
    side = crank - math.sqrt((arc + tip) ** 2 - tip**2)
    for k in range(2 * slots):
        angle, y = k // 2 * math.tau / slots, side * (-1) ** k
        place = [(outer - tip) * math.cos(angle) - y * math.sin(angle), (outer - tip) * math.sin(angle) + y * math.cos(angle)]
        contacts.append({"name": f"horn_{k + 1}", "first": ["wheel", *place], "radius": tip, "second": "driver"})
    edge = cut + math.radians(0.6)
    for k, sign in ((1, 1), (2, -1)):
        place = [(disc - tip) * math.cos(edge), sign * (disc - tip) * math.sin(edge)]
        contacts.append({"name": f"edge_{k}", "first": ["driver", *place], "radius": tip, "second": "wheel"})
    tables = {"ground": {"O": [0, 0], "W": [DISTANCE, 0]}, "body": [driver, wheel], "contact": contacts}
    return gm.Scene.from_dict({**document, **tables})


@pytest.mark.parametrize(("slots", "speed"), [(4, 2.414), (6, 1.000)])
def test_wheels_of_four_and_six_slots_follow_their_law_to_the_clearance_and_have_its_peak_speed(slots, speed):
    for clearance in (2e-4, 2e-5):
        run = gm.run(wheel_of(slots, clearance), times=np.arange(0, 1.001, 0.0025))
        assert run.outcome is gm.Outcome.DONE
        difference = np.abs(run.readings["wheel_angle"] - exact_angle(run.readings["driver_angle"], slots)).max()
        # On the line of centres the pin lies at the side of the slot, at its distance from the wheel's shaft.
        assert difference == pytest.approx(math.asin(clearance / (DISTANCE * (1 - math.sin(math.pi / slots)))), rel=1e-6)
        assert np.abs(run.rates["wheel_angle"]).max() / math.tau == pytest.approx(speed, abs=0.0005)  # half of the last digit
        subjects = {event.subject for event in run.events if event.kind is EventKind.IMPACT}
        assert len(subjects) == 1
        assert subjects.pop().startswith("pin_gap")


@pytest.mark.parametrize(("slots", "acceleration"), [(4, 5.41), (6, 1.35)])
def test_the_peak_acceleration_is_that_of_handbooks(slots, acceleration):
    """While the pin drives the wheel, which is before the line of centres."""
    angles = np.linspace(-engaged_angle(slots), 0, 10_001)
    angle = angles[np.argmax(acceleration_ratio(slots, driver_angle=angles))]
    moment, step = 0.5 + angle / math.tau, 1e-5
    run = gm.run(wheel_of(slots, 1e-6), times=[0.0, moment - step, moment + step])
    peak = -np.diff(run.rates["wheel_angle"])[-1] / (2 * step) / math.tau**2
    assert peak == pytest.approx(acceleration, rel=2e-3)
