"""Kinematic analysis against the geometry of the loops, and refusals."""

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.kinematic_analysis import validate_samples
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_readings
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import ArcPosition, BodyAngle, FollowerHeight, LineAngle, PointCoordinate, PointDistance
from scene_parts import make_mechanism

CRANK, ROD = 0.1, 0.3


def slider_crank(angle, rate, acceleration):
    """Return position, speed and acceleration of the slider in closed form."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(ROD**2 - CRANK**2 * s**2)
    x = CRANK * c + root
    first = -CRANK * s - CRANK**2 * s * c / root
    second = -CRANK * c - CRANK**2 * (c * c - s * s) / root - CRANK**4 * (s * c) ** 2 / root**3
    return x, first * rate, second * rate**2 + first * acceleration


def test_a_slider_crank_agrees_with_the_closed_form():
    angles = np.linspace(0.0, 2 * math.pi, 37)
    result = gm.kinematics("slider_crank_torque", "crank_angle", angles, rate=-7.0, acceleration=30.0)
    x, speed, acceleration = slider_crank(angles, -7.0, 30.0)
    # Closed to 1e-13 of the length scale; rates and accelerations follow by linear algebra.
    np.testing.assert_allclose(result.readings["slider_x"], x, atol=1e-13)
    np.testing.assert_allclose(result.rates["slider_x"], speed, atol=1e-12)
    np.testing.assert_allclose(result.reading_accelerations["slider_x"], acceleration, atol=1e-10)
    np.testing.assert_allclose(result.readings["crank_angle"], angles, atol=1e-13)
    np.testing.assert_allclose(result.reading_accelerations["crank_angle"], 30.0, atol=1e-12)
    assert result.poses.shape == result.velocities.shape == result.accelerations.shape == (37, 3, 3)


def test_the_slider_may_be_the_prescribed_reading():
    result = gm.kinematics("slider_crank_torque", "slider_x", [0.35, 0.3, 0.25], rate=0.2)
    x, speed, _ = slider_crank(result.readings["crank_angle"], result.rates["crank_angle"], 0.0)
    np.testing.assert_allclose(x, [0.35, 0.3, 0.25], atol=1e-12)
    np.testing.assert_allclose(speed, 0.2, atol=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_slider_moves_the_crank_on_the_side_on_which_it_starts(side):
    scene = gm.load("slider_crank_torque").replace({"start": {"crank_angle": 0.9 * side}})
    crank = gm.kinematics(scene, over="crank_angle", values=[0.7 * side, 1.1 * side])
    found = gm.kinematics(scene, over="slider_x", values=crank.readings["slider_x"])
    np.testing.assert_allclose(found.readings["crank_angle"], crank.values, atol=1e-11)
    assert "crank_angle" in found
    assert "rate_of_slider_x" in found
    assert "no such reading" not in found


def test_drivers_move_a_mechanism_in_time():
    times = np.linspace(0.0, 1.0, 21)
    result = gm.kinematics("quick_return", "time", times)
    # Crank of 80 mm, 200 mm above the pivot of the lever, one turn per second.
    turn = 2 * math.pi * times
    lever = np.arctan2(0.2 + 0.08 * np.sin(turn), 0.08 * np.cos(turn))
    np.testing.assert_allclose(result.readings["lever_angle"], lever, atol=1e-12)
    x, y = 0.4 * np.cos(lever), 0.4 * np.sin(lever)
    np.testing.assert_allclose(result.readings["ram_position"], x + np.sqrt(0.16**2 - (0.42 - y) ** 2), atol=1e-12)


def test_kinematics_agree_with_the_run_of_the_same_drive():
    run = gm.run("quick_return", engine="multibody")
    result = gm.kinematics("quick_return", "time", run.times)
    for name in run.readings:
        np.testing.assert_allclose(result.readings[name], run.readings[name], atol=1e-11)
        np.testing.assert_allclose(result.rates[name], run.rates[name], atol=1e-10)


def test_drivers_are_removed_if_a_reading_is_prescribed():
    result = gm.kinematics("quick_return", "lever_angle", [1.2, 1.3, 1.4], rate=2.0)
    np.testing.assert_allclose(result.rates["lever_angle"], 2.0, atol=1e-12)
    assert np.all(result.rates["ram_position"] < 0)  # the lever and the ram move back


def test_a_driver_that_does_not_move_the_reading_stands_still():
    """The crank turns once; the reversing lever, which another driver moves in time, stays where it starts."""
    result = gm.kinematics("stephenson_arc_middle", "crank_angle", np.linspace(0.0, 2 * math.pi, 9))
    np.testing.assert_allclose(result.readings["reverser"], 1.0, atol=1e-12)
    assert np.ptp(result.readings["valve_displacement"]) > 0.1
    moved = gm.kinematics("stephenson_arc_middle", "reverser", np.linspace(1.0, -1.0, 9))
    np.testing.assert_allclose(moved.readings["crank_angle"], 0.0, atol=1e-12)


def test_a_part_is_studied_without_the_shaft_of_its_free_spindle():
    angles = np.linspace(0.6, 0.9, 4)
    alone, shipped = (gm.kinematics(name, "arm_angle", angles) for name in ("porter", "porter_free_spindle"))
    for name in alone.readings:
        np.testing.assert_allclose(shipped.readings[name], alone.readings[name], rtol=1e-12)


def test_a_regular_motion_is_followed_and_no_value_is_solved_for_alone(monkeypatch):
    monkeypatch.delattr("governor_mechanism.mechanics.kinematics.kinematic_analysis._solve_motion")
    angles = np.linspace(0.5, 0.8, 30)
    motion = gm.kinematics("porter", "arm_angle", angles, rate=1.3)
    np.testing.assert_allclose(motion.readings["ball_radius"], 0.04 + 0.3 * np.sin(angles), rtol=1e-12)
    np.testing.assert_allclose(motion.rates["ball_radius"], 1.3 * 0.3 * np.cos(angles), rtol=1e-12)


def test_many_values_are_solved_as_few_are():
    """Single values are reached from the start, dense ones each from the one before."""
    dense = np.linspace(0.1, 4.0, 500)
    many = gm.kinematics("quick_return", "lever_angle", 1.55 + 0.3 * np.sin(dense), rate=1.3, acceleration=-0.7)
    for k in (0, 123, 499):
        one = gm.kinematics("quick_return", "lever_angle", [1.55 + 0.3 * math.sin(dense[k])], rate=1.3, acceleration=-0.7)
        for name in one.readings:
            assert abs(one.readings[name][0] - many.readings[name][k]) < 1e-12
            assert abs(one.rates[name][0] - many.rates[name][k]) < 1e-11
            assert abs(one.reading_accelerations[name][0] - many.reading_accelerations[name][k]) < 1e-9


KNEE, HOOK, CENTRE = Point(body="b", x=0.2, y=-0.1), Point(body="b", x=0.2, y=0.1), Point(body="a", x=0.1, y=0.3)
HANGING_FOLLOWER = {"top": Point(body=GROUND, x=0.1, y=0.9), "knee": KNEE, "fraction": 0.6, "guide_x": 0.2, "length": 3.0}
READINGS = [
    LineAngle(name="r", quantity="angle", start=Point(body="a", x=0.2, y=0.1), end=Point(body="b", x=-0.3, y=0.2)),
    BodyAngle(name="r", quantity="angle", body="b", reference_body="a"),
    PointDistance(name="r", quantity="length", first=Point(body="a", y=0.4), second=Point(body="b", x=0.3)),
    PointCoordinate(name="r", quantity="length", point=Point(body="b", x=0.2), direction_x=0.6, direction_y=0.8),
    PointCoordinate(name="r", quantity="length", point=HOOK, direction_x=0.6, direction_y=-0.8, origin=Point(body="a", x=0.1, y=-0.2)),
    PointCoordinate(name="r", quantity="length", point=Point(body=GROUND, x=1.0), direction_x=1.0, direction_y=0.0, zero=0.3),
    ArcPosition(name="r", quantity="length", centre=CENTRE, point=Point(body="b", x=-0.2, y=0.1), radius=-0.7, angle=2.0, zero=0.1),
    FollowerHeight(name="r", quantity="length", zero=0.2, **HANGING_FOLLOWER),
    FollowerHeight(name="r", quantity="length", reference_point=CENTRE, **HANGING_FOLLOWER),
]


def place(point, poses):
    """Return the position of a point as a complex number."""
    if point.body == GROUND:
        return complex(point.x, point.y)
    x, y, angle = poses["ab".index(point.body)]
    return complex(x, y) + complex(point.x, point.y) * cmath.exp(1j * angle)


def expected_value(reading, poses):
    """Return the value of a reading from complex positions."""
    match reading:
        case LineAngle():
            return cmath.phase(1j * (place(reading.end, poses) - place(reading.start, poses))) - reading.zero
        case BodyAngle():
            return poses[1][2] - poses[0][2]
        case ArcPosition():
            direction = cmath.exp(1j * (poses[0][2] + reading.angle))
            return reading.radius * cmath.phase((place(reading.point, poses) - place(reading.centre, poses)) / direction) - reading.zero
        case PointDistance():
            return abs(place(reading.second, poses) - place(reading.first, poses))
        case PointCoordinate():
            turn = 1.0 if reading.origin.body == GROUND else cmath.exp(1j * poses[0][2])
            direction = complex(reading.direction_x, reading.direction_y) * turn
            return ((place(reading.point, poses) - place(reading.origin, poses)) * direction.conjugate()).real - reading.zero
        case FollowerHeight():
            hook = (1 - reading.fraction) * place(reading.top, poses) + reading.fraction * place(reading.knee, poses)
            height = hook.imag - math.sqrt(reading.length**2 - (hook.real - reading.guide_x) ** 2)
            return (height if reading.reference_point is None else place(reading.reference_point, poses).imag - height) - reading.zero


def two_bodies(reading):
    """Return two free bodies with one reading."""
    bodies = [Body(name=name, mass=1.0, second_moments=SecondMoments(xx=1.0)) for name in ("a", "b")]
    return make_mechanism(bodies, [], [reading], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])


@pytest.mark.parametrize("reading", READINGS, ids=lambda reading: type(reading).__name__)
def test_value_and_derivatives_of_a_reading(reading):
    mechanism = two_bodies(reading)
    random = np.random.default_rng(3)
    start, velocity, acceleration = (random.normal(size=(2, 3)) for _ in range(3))

    def value(time):
        return float(evaluate_output(mechanism, "r", start + velocity * time + 0.5 * acceleration * time**2).value)

    h = 1e-4  # differences of fourth order: rounding of 1e-12 / h^2, and h^4
    first = (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)
    second = (16 * (value(h) + value(-h)) - (value(2 * h) + value(-2 * h)) - 30 * value(0)) / (12 * h**2)
    result = evaluate_output(mechanism, "r", start, velocity)
    assert value(0) == pytest.approx(expected_value(reading, start), abs=1e-14)  # rounding
    assert np.sum(result.gradient * velocity) == pytest.approx(first, abs=1e-10)
    assert np.sum(result.gradient * acceleration) + result.quadratic_velocity_term == pytest.approx(second, abs=1e-6)


@pytest.mark.parametrize(
    ("reading", "message"),
    [
        (replace(READINGS[4], direction_x=1.0), "reading 'r' has a direction, relative to a body, of length 1.28062; give a unit vector"),
        (replace(READINGS[-1], top=Point(body="a")), "whose top is on body 'a'; the top must be on the ground"),
    ],
)
def test_readings_without_an_equation_are_refused(reading, message):
    with pytest.raises(gm.MechanismError, match=message):
        evaluate_output(two_bodies(reading), "r", np.zeros((2, 3)))


@pytest.mark.parametrize(
    "call",
    [
        lambda: gm.run("porter", accuracy="fine"),
        lambda: gm.run("porter", times="soon"),
        lambda: gm.kinematics("slider_crank_torque", "crank_angle", [0.5], rate="fast"),
    ],
)
def test_arguments_that_are_not_numbers_are_refused(call):
    with pytest.raises(gm.MechanismError, match=r"(got|found) .fine.|.(soon|fast). has no number"):
        call()


def test_one_value_that_is_not_finite_among_others_is_refused():
    with pytest.raises(gm.MechanismError, match="must be a list of finite numbers"):
        validate_samples("crank_angle", [0.5, float("nan"), 0.7])
    for what in ("rate", "acceleration"):
        for number in (math.nan, math.inf):
            with pytest.raises(gm.MechanismError, match=f"^{what} of 'crank_angle' must be a finite number"):
                validate_samples("crank_angle", [0.5], **{what: number})


def test_a_redundant_joint_changes_nothing():
    scene = gm.load("slider_crank_torque")
    (guide,) = (joint for joint in scene.mechanism.joints if isinstance(joint, Slider))
    doubled = scene.with_changes(mechanism=replace(scene.mechanism, joints=(*scene.mechanism.joints, replace(guide, name="second guide"))))
    expected, result = (gm.kinematics(one, "crank_angle", [0.4, 1.9, 4.0], rate=3.0, acceleration=-20.0) for one in (scene, doubled))
    for name in expected.readings:
        np.testing.assert_allclose(result.readings[name], expected.readings[name], atol=1e-13)
        np.testing.assert_allclose(result.rates[name], expected.rates[name], atol=1e-12)
        np.testing.assert_allclose(result.reading_accelerations[name], expected.reading_accelerations[name], atol=1e-11)


def test_all_readings_at_many_states_are_those_at_each_of_them():
    mechanism, random = gm.load("slider_crank_torque").mechanism, np.random.default_rng(4)
    poses, velocities = random.normal(size=(5, len(mechanism.bodies), 3)), random.normal(size=(5, len(mechanism.bodies), 3))
    values, rates = evaluate_readings(mechanism, poses, velocities)
    for i, k in np.ndindex(len(mechanism.readings), 5):
        output = evaluate_output(mechanism, mechanism.readings[i].name, poses[k])
        assert values[i, k] == pytest.approx(float(output.value), rel=1e-14)
        assert rates[i, k] == pytest.approx(float(output.rate(velocities[k])), rel=1e-13)
