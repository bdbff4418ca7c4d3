"""The shipped Geneva wheel: its angle law to the clearance, its peak speed, its lock under a torque, and what it loses."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.geneva import engaged_angle, speed_ratio, wheel_angle
from governor_mechanism.model.events import EventKind

DISTANCE, CRANK = 0.1, 0.1 * math.sin(math.pi / 4)


def exact_angle(driver_angles):
    """The angle of the wheel without clearance; it starts at 45 deg and turns back by 90 deg at every turn of the driver."""
    angles = np.remainder(driver_angles + math.pi, math.tau) - math.pi
    turns = np.round((driver_angles - angles) / math.tau) - 1
    engaged = np.clip(angles, -engaged_angle(4), engaged_angle(4))
    return -np.asarray(wheel_angle(4, driver_angle=engaged)) - turns * math.pi / 2


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
