"""Closed slots over whole turns: motions that scipy integrates, an eccentric as a groove, cam laws, and refusals."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from data_files import read_data
from joint_mechanisms import GRAVITY, integrate_one_coordinate

GROOVED_CAM = read_data(__file__)["GROOVED_CAM"]
BASE, LIFT = 0.06, 0.01
CAM_INERTIA, FOLLOWER_MASS = 2e-3, 0.5


def grooved_cam(curve: dict, **tables) -> gm.Scene:
    """A cam with a groove about its shaft, and a follower that slides upwards above the shaft."""
    groove = {"type": "curve", "name": "groove", "first": "cam.origin", "second": "follower.centre", "curve": curve}
    return gm.Scene.from_dict(GROOVED_CAM | {"joint": [*GROOVED_CAM["joint"], groove]} | tables)


HARMONICS = {"radius": BASE, "harmonics": [{"amplitude": LIFT, "order": 2, "phase": 0.3}, {"amplitude": -0.004, "order": 1}]}


def radius_at(angle):
    """Return the radius of the harmonics in a direction and its first two derivatives."""
    value = BASE + LIFT * math.sin(2 * angle + 0.3) - 0.004 * math.sin(angle)
    slope = 2 * LIFT * math.cos(2 * angle + 0.3) - 0.004 * math.cos(angle)
    return value, slope, -4 * LIFT * math.sin(2 * angle + 0.3) + 0.004 * math.sin(angle)


@pytest.mark.parametrize(("engine", "accuracy"), [("multibody", 1e-9), ("reduced", 1e-9), ("impulse", 1e-4)])
def test_a_cam_that_runs_out_moves_its_follower_over_several_turns(engine, accuracy):
    def inertia(q):
        _, slope, curvature = radius_at(math.pi / 2 - q)
        return CAM_INERTIA + FOLLOWER_MASS * slope**2, -2 * FOLLOWER_MASS * slope * curvature

    def force(q, _):
        return FOLLOWER_MASS * GRAVITY * radius_at(math.pi / 2 - q)[1]

    weight = {"effects": {"gravity": GRAVITY}, "start": {"cam": 0.2, "cam_rate": 20.0}}
    run = gm.run(grooved_cam(HARMONICS, **weight), engine=engine, accuracy=accuracy)
    assert run.outcome is gm.Outcome.DONE
    q, rate = integrate_one_coordinate(inertia, force, (0.2, 20.0), run.times)
    radii = np.array([radius_at(math.pi / 2 - angle)[:2] for angle in q])
    assert q[-1] - q[0] > 3 * 2 * math.pi
    # The requested accuracy, in rad and cam sizes; rates relative to 20 rad/s.
    np.testing.assert_allclose(run.readings["cam"], q, atol=10 * accuracy)
    np.testing.assert_allclose(run.readings["y"], radii[:, 0], atol=10 * accuracy * BASE)
    np.testing.assert_allclose(run.rates["y"], -radii[:, 1] * rate, atol=400 * accuracy * BASE)


def test_a_round_groove_off_centre_is_an_eccentric():
    """The spline through points of the circle tends to the law of the eccentric with the fourth power of their distance."""
    eccentricity, radius = 0.015, 0.05
    turn = np.linspace(0.0, 6 * math.pi, 1201)
    exact = eccentricity * np.sin(turn) + np.sqrt(radius**2 - (eccentricity * np.cos(turn)) ** 2)
    errors = []
    for count in (24, 48):
        around = 2 * math.pi * (np.arange(count) + 0.3) / count
        points = np.stack([eccentricity + radius * np.cos(around), radius * np.sin(around)], axis=1).tolist()
        motion = gm.kinematics(grooved_cam({"closed": points}), "cam", turn)
        errors.append(np.abs(motion.readings["y"] - exact).max())
    assert errors[0] < 1e-4 * radius
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.25)  # the next term is of the sixth power


@pytest.mark.parametrize("shift", [0.0, 200.0, -1234.0])
def test_radius_speed_and_acceleration_of_the_follower_are_those_of_a_table_without_a_seam(shift):
    """Wherever the table of a spline begins: second derivatives are continuous at its seam too."""
    count = 36
    angles = np.radians(shift) + 2 * math.pi * np.arange(count) / count
    table = [[float(angle), radius_at(angle)[0]] for angle in angles]
    turn = np.linspace(-7.0, 13.0, 2001)
    motion = gm.kinematics(grooved_cam({"polar": table}), "cam", turn)
    exact = np.array([radius_at(math.pi / 2 - angle) for angle in turn]).T
    h = 2 * math.pi / count
    # Errors of a periodic cubic spline of sin(2 x): h^4 / 384 of the fourth derivative, h^3 / 24 and h^2 / 12 for the derivatives.
    fourth = 16 * LIFT + 0.004
    np.testing.assert_allclose(motion.readings["y"], exact[0], atol=h**4 / 384 * fourth * 1.1)
    np.testing.assert_allclose(motion.rates["y"], -exact[1], atol=h**3 / 24 * fourth)
    np.testing.assert_allclose(motion.reading_accelerations["y"], exact[2], atol=h**2 / 12 * fourth * 1.1)
    assert np.abs(np.diff(motion.reading_accelerations["y"])).max() < 0.02 * LIFT * 8


def test_harmonics_give_the_law_of_a_cam_exactly():
    turn = np.linspace(-20.0, 20.0, 801)
    motion = gm.kinematics(grooved_cam(HARMONICS), "cam", turn)
    exact = np.array([radius_at(math.pi / 2 - angle) for angle in turn]).T
    for values, expected in zip((motion.readings, motion.rates, motion.reading_accelerations), exact * [[1], [-1], [1]], strict=True):
        np.testing.assert_allclose(values["y"], expected, atol=1e-14)  # rounding


def test_the_order_of_the_points_round_the_groove_does_not_matter():
    points = [[0.05, 0], [0, 0.06], [-0.05, 0], [0, -0.06]]
    curves = [grooved_cam({"closed": one}).mechanism.joints[-1].curve for one in (points, points[::-1])]
    turn = np.linspace(0, 7, 50)
    first, second = (gm.kinematics(grooved_cam({"closed": one}), "cam", turn).readings["y"] for one in (points, points[::-1]))
    np.testing.assert_allclose(first, second, atol=1e-15)
    assert sorted(curves[0].radii) == sorted(curves[1].radii)


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ({"closed": [[0.05, 0], [0, 0.06]]}, r"\"groove\": curve\.closed must be three or more points that go once round"),
        ({"closed": [[0.05, 0], [0, 0.06], [0.05, 0.06], [-0.05, 0], [0, -0.06]]}, "with one point in each direction"),
        ({"closed": [[0.05, 0], [0.06, 0.06], [0.05, 0.06]]}, "less than half a turn"),
        ({"closed": [[0.05, 0], [0, 0.06], [-0.05, 0], [0, -0.06], [0.05, 0]]}, "the curve closes by itself"),
        ({"closed": 3}, r"must be a list of points \[x, y\]"),
        ({"polar": [[0, 0.05], ["90 deg", 0.06]]}, "three points or more"),
        ({"polar": [[0, 0.05], [1, 0.06], ["360 deg", 0.05]]}, "leave out a point that repeats the first"),
        ({"polar": [[0, 0.05], [2, 0.06], [1, 0.05]]}, "angles of a closed curve's points"),
        ({"polar": [[0, 0.05], [1, -0.06], [2, 0.05]]}, "radius of a closed curve's point"),
        ({"radius": 0.05, "harmonics": [{"amplitude": 0.01, "order": 1.5}]}, "closes with orders 1, 2, 3"),
        ({"radius": 0.05, "harmonics": [{"amplitude": 0.06, "order": 1}]}, "must be less than its radius, 0.05 m"),
        ({"radius": 0.05, "points": [[0, 0]]}, r"\{ radius = r, harmonics = \[...\] \} or"),
    ],
)
def test_a_curve_that_does_not_close_once_round_its_origin_is_refused(curve, words):
    with pytest.raises(gm.MechanismError, match=words):
        grooved_cam(curve)


def test_the_builder_has_closed_curves_too():
    def build(**curve):
        m = gm.Mechanism.build("Cam")
        cam = m.disc("cam", mass="1 kg", radius=0.08, angle=0.0)
        follower = m.block("follower", mass="1 kg")
        m.pin(m.ground(0, 0), cam.origin)
        m.slider(m.ground(0, 0), follower.origin, "90 deg")
        m.curve(cam.origin, follower.origin, **curve)
        return m.scene()

    for curve in (HARMONICS, {"polar": [["0 deg", "50 mm"], ["120 deg", "60 mm"], ["240 deg", "55 mm"]]}):
        scene = build(**curve)
        y = scene.mechanism.initial_guess[1][1]
        assert y == pytest.approx(gm.kinematics(grooved_cam(curve), "cam", [0.0]).readings["y"][0])


@pytest.mark.parametrize(("law", "rise"), [("cycloidal", lambda u: u - math.sin(2 * math.pi * u) / (2 * math.pi)), ("harmonic", None)])
def test_a_groove_with_lifts_raises_its_follower_by_their_law(law, rise):
    rise = rise or (lambda u: (1 - math.cos(math.pi * u)) / 2)
    lifts = [{"over": "100 deg", "lift": LIFT, "law": law}, {"over": "80 deg"}, {"over": "180 deg", "lift": -LIFT, "law": law}]
    degrees = np.linspace(0, 720, 145)
    motion = gm.kinematics(grooved_cam({"radius": BASE, "lifts": lifts}), "cam", np.radians(90 - degrees))
    exact = [BASE + LIFT * (rise(one / 100) if one < 100 else 1 if one < 180 else 1 - rise((one - 180) / 180)) for one in degrees % 360]
    np.testing.assert_allclose(motion.readings["y"], exact, atol=1e-14)
