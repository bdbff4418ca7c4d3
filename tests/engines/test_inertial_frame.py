"""Points in space against the printed references, and the engine against the points in space."""

from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_scenes import governor_scene
from inertial_frame_reference import Governor, driven_motion, free_motion
from reference import zehnder

PORTER, START = zehnder.PORTER_OPEN, zehnder.PORTER_OPEN_MOTION
TIMES = np.linspace(0.0, START["time"], 201)

# Steps of 1e-13 add up to about 1e-12 in two seconds, and the references are printed to 13 or 14 digits; it leaves the
# witness a hundred times finer than the 1e-9 it is to judge by.
WITNESS = 1e-11  # rad, rad/s
TORQUE_PRINTED = 1e-10  # N m, two units of the last printed digit
CARTESIAN_TORQUE_PRINTED = 1.5e-9  # N m, a unit and a half of the last printed digit, in which the references differ


def porter():
    return Governor(**PORTER["dimensions"], spindle_inertia=PORTER["rest_inertia"], gravity=9.81)


def start(sense=1.0, rate=1.0):
    """The reference's start, the spindle's sense of turning and the arms' start rate reversed by signs."""
    return {"speed": sense * START["spindle_speed"], "arm_angle": START["arm_angle"], "arm_rate": rate * START["arm_rate"]}


@cache
def motion_from_start(motion_of, sense=1.0, rate=1.0):
    """Return the motion at TIMES, once for all tests."""
    return motion_of(porter(), **start(sense, rate), times=TIMES)


SENSES = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)]
NAMES = ["arms rising", "arms falling", "turning the other way"]


# The witness by itself.


def test_a_driven_porter_is_where_the_reference_says():
    motion = motion_from_start(driven_motion)
    expected = START["constant_speed"]
    assert motion.arm_angle[-1] == pytest.approx(expected["arm_angle"], abs=WITNESS)
    assert motion.arm_rate[-1] == pytest.approx(expected["arm_rate"], abs=WITNESS)
    assert motion.torque[-1] == pytest.approx(expected["drive_torque"], abs=TORQUE_PRINTED)
    assert motion.torque[-1] == pytest.approx(START["cartesian_drive_torque"], abs=CARTESIAN_TORQUE_PRINTED)


def test_a_free_porter_is_where_the_reference_says():
    motion = motion_from_start(free_motion)
    expected = START["free_spindle"]
    assert motion.arm_angle[-1] == pytest.approx(expected["arm_angle"], abs=WITNESS)
    assert motion.arm_angle[-1] == pytest.approx(START["cartesian_free_arm_angle"], abs=WITNESS)
    assert motion.arm_rate[-1] == pytest.approx(expected["arm_rate"], abs=WITNESS)
    assert motion.theta[-1] == pytest.approx(expected["turned"], abs=WITNESS)
    assert motion.omega[-1] == pytest.approx(expected["spindle_speed"], abs=WITNESS)
    assert motion.angular_momentum[0] == pytest.approx(START["angular_momentum"], rel=1e-14)  # printed to 15 digits


# The engine against the witness. An accuracy of 1e-10 of each reading's scale promises 1e-10 rad, 1.3e-9 rad/s (scale:
# the spindle's speed) and 5e-8 N m (scale: hundreds of N m); its steps are chosen for the worst of all and keep well
# within that, so one number serves everything.

ALLOWED = 1e-9  # rad, rad/s, N m


def scene(spindle, rate):
    begin = {"angle": START["arm_angle"], "rate": rate * START["arm_rate"]}
    built = governor_scene(PORTER["dimensions"], speed=START["spindle_speed"], **begin, duration=START["time"])
    return built.with_changes(spindle=spindle)


@pytest.mark.parametrize("motion_of", [pytest.param(driven_motion, marks=pytest.mark.long), free_motion], ids=["driven", "free"])
@pytest.mark.parametrize(("sense", "rate"), SENSES, ids=NAMES)
def test_the_engine_moves_the_porter_as_points_in_space_go(motion_of, sense, rate):
    motion, speed = motion_from_start(motion_of, sense, rate), sense * START["spindle_speed"]
    is_free = motion_of is free_motion
    spindle = FreeSpindle(inertia=PORTER["rest_inertia"], start_speed=speed) if is_free else Spindle(speeds=(speed,))
    run = gm.run(scene(spindle, rate), engine="multibody", accuracy=1e-10, times=TIMES)
    run.raise_if_failed()
    pairs = {"arm_angle": motion.arm_angle} | (
        {"spindle_speed": motion.omega, "spindle_angle": motion.theta} if is_free else {"spindle_torque": motion.torque}
    )
    for name, expected in pairs.items():
        assert np.max(np.abs(run.readings[name] - expected)) < ALLOWED, name
    assert np.max(np.abs(run.rates["arm_angle"] - motion.arm_rate)) < ALLOWED
