"""Distance of a convex curve from lines and arcs: against the nearest of many points, and its derivatives against differences."""

import math

import numpy as np
import pytest
from matplotlib.path import Path
from scipy.spatial import cKDTree

import governor_mechanism as gm
from governor_mechanism.closed_form.disc_cam import CamRise, curvature_radius_under_flat, lift_at
from governor_mechanism.mechanics.curves.outlines import edges_of, find_circle, outline_points
from governor_mechanism.mechanics.curves.segments import make_curve_segments
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.curves import Corner, CornerOutline, CurveOutline, Lift, LiftCurve, PolarHarmonics

CAM = {"curve": {"radius": 0.05, "harmonics": [{"amplitude": 0.01, "order": 1, "phase": 0.3}, {"amplitude": 0.002, "order": 2}]}}
OVAL = {"curve": {"polar": [[0, 0.05], [1.5, 0.06], [3.0, 0.05], [4.5, 0.055]]}, "inset": 0.003}
PLATE = [[0, 0, 0.08], [0.1, 0], [0.12, 0.15, -0.25], [-0.08, 0.18], [-0.05, 0.07]]
"""An edge that bulges, straight ones and a hollow one, between corners that stand out."""


def make_mechanism(outline, curve=CAM):
    """Two bodies that move freely in the plane, the outlines off their mass centres."""
    tables = {
        "machine": "custom",
        "body": [
            {"name": "plate", "mass": 1.0, "inertia": 1.0, "centre": [0.02, -0.01], "outline": outline},
            {"name": "cam", "mass": 1.0, "inertia": 1.0, "centre": [0.003, 0.002], "outline": curve, "at": [1.0, 1.0]},
        ],
        "force": [{"type": "spring", "first": "ground.origin", "second": "cam.origin", "stiffness": 1.0}],
        "contact": [{"name": "c", "first": "cam", "second": "plate", "friction": 0.1}],
        "size": 0.1,
    }
    return gm.Scene.from_dict(tables).mechanism


def random_states(rng, count):
    poses = rng.uniform(-0.25, 0.25, (count, 2, 3))
    poses[..., 2] = rng.uniform(-4, 4, (count, 2))
    return poses, rng.uniform(-1, 1, (count, 2, 3))


def place(points, centre, pose):
    cosine, sine = math.cos(pose[2]), math.sin(pose[2])
    return (np.array(points) - centre) @ np.array([[cosine, sine], [-sine, cosine]]) + pose[:2]


@pytest.mark.parametrize("curve", [CAM, OVAL], ids=["harmonics", "spline"])
def test_the_distance_is_that_of_the_nearest_of_many_points_and_negative_where_they_overlap(curve):
    mechanism = make_mechanism(PLATE, curve)
    plate, cam = (one.outline for one in mechanism.outlines)
    edge_points = [edge.point(k / 400) for edge in edges_of(plate) for k in range(400)]
    poses, _ = random_states(np.random.default_rng(1), 60)
    n_apart = 0
    for pose, value in zip(poses, evaluate_output(mechanism, "c_gap", poses).value, strict=True):
        edge, around = place(edge_points, [0.02, -0.01], pose[0]), place(outline_points(cam), [0.003, 0.002], pose[1])
        if Path(edge).contains_points(around).any() or Path(around).contains_points(edge).any():
            assert value < 1e-4  # what the points between do not show
            continue
        n_apart += 1
        assert value == pytest.approx(cKDTree(edge).query(around)[0].min(), abs=1e-4)  # of the distances between points
        assert value > 0
    assert 30 < n_apart < 59


@pytest.mark.parametrize("curve", [CAM, OVAL], ids=["harmonics", "spline"])
def test_gradient_and_quadratic_term_are_those_of_differences(curve):
    mechanism = make_mechanism(PLATE, curve)
    poses, velocities = random_states(np.random.default_rng(3), 150)
    check_derivatives(mechanism, "c_gap", poses, velocities, share=0.95)


@pytest.mark.parametrize("curve", [CAM, OVAL], ids=["harmonics", "spline"])
def test_the_slip_is_the_velocity_of_the_lowest_point_of_the_curve_along_the_outline(curve):
    """Lowest against the normal, which is the gradient of the gap: the velocity is that of both bodies there; and its derivative."""
    mechanism = make_mechanism(PLATE, curve)
    cam = mechanism.outlines[1].outline
    poses, velocities = random_states(np.random.default_rng(4), 150)
    gradients = evaluate_output(mechanism, "c_gap", poses).gradient
    slip = evaluate_output(mechanism, "c_slip", poses, velocities)
    for pose, velocity, gradient, rate in zip(poses, velocities, gradients, slip.rate(velocities), strict=True):
        normal = gradient[1, :2]
        lowest = np.min(place(outline_points(cam), [0.003, 0.002], pose[1]) @ normal)  # good to the square of their spacing
        along = velocity[:, :2] @ [-normal[1], normal[0]]
        plate, own = along + velocity[:, 2] * (lowest - pose[:, :2] @ normal)
        assert rate == pytest.approx(own - plate, abs=2e-5)
    h = 1e-6
    before, after = (evaluate_output(mechanism, "c_slip", poses + k * h * velocities, velocities).rate(velocities) for k in (-1, 1))
    bends = (after - before) / (2 * h)
    assert np.mean(np.abs(slip.quadratic_velocity_term - bends) < 1e-6 * (1 + np.abs(bends))) > 0.95  # the nearest piece changes in a few


def check_derivatives(mechanism, name, poses, velocities, share):
    """Compare with differences of values and rates, but for the few states between which the nearest piece changes."""
    h = 1e-6
    before, here, after = (evaluate_output(mechanism, name, poses + k * h * velocities, velocities) for k in (-1, 0, 1))
    rate_errors = np.abs(here.rate(velocities) - (after.value - before.value) / (2 * h))
    bends = (after.rate(velocities) - before.rate(velocities)) / (2 * h)
    bend_errors = np.abs(here.quadratic_velocity_term - bends) / (1 + np.abs(bends))
    assert np.mean((rate_errors < 1e-8) & (bend_errors < 1e-6)) > share


def test_a_cam_in_a_hollow_touches_its_arcs_from_inside():
    """About a point inside the hollow arcs of radius 0.15 and 0.1 m, the gap is their radius less the distance and that of a disc."""
    hollow = [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.0], [0.2, 0.0, -0.2], [-0.2, 0.0], [-0.3, 0.0]]
    mechanism = make_mechanism(hollow, {"curve": {"radius": 0.05, "harmonics": [{"amplitude": 1e-9, "order": 2}]}})
    rng = np.random.default_rng(5)
    angles, reach = rng.uniform(-2.7, -0.4, 50), rng.uniform(0.05, 0.14, 50)
    origins = np.stack([reach * np.cos(angles), reach * np.sin(angles)], axis=1)
    poses = np.zeros((50, 2, 3))
    poses[:, 0, :2] = [0.02, -0.01]
    poses[:, 1, :2] = origins + np.array([0.003, 0.002])
    values = evaluate_output(mechanism, "c_gap", poses).value
    np.testing.assert_allclose(values, 0.2 - reach - 0.05, atol=2e-9)
    check_derivatives(make_mechanism(hollow), "c_gap", poses, rng.uniform(-1, 1, (50, 2, 3)), share=0.98)


@pytest.mark.parametrize("law", ["cycloidal", "harmonic"])
def test_the_profile_under_a_flat_follower_has_the_law_as_the_distance_of_its_tangents(law):
    over = math.radians(150)
    lifts = (
        Lift(over=over, lift=0.01, law=law),
        Lift(over=math.pi - over),
        Lift(over=over, lift=-0.01, law=law),
        Lift(over=math.pi - over),
    )
    segments = make_curve_segments(LiftCurve(radius=0.04, lifts=lifts, follower="flat"))
    rise = CamRise(law=law, lift=0.01, angle=over, mass=1.0)
    for start, radius, slope, second in zip(segments[:, 0] + 0.01, *evaluate(segments, segments[:, 0] + 0.01), strict=True):
        normal = start - math.atan(slope / radius)
        height = radius * math.cos(start - normal)
        curvature = (radius**2 + 2 * slope**2 - radius * second) / math.hypot(radius, slope) ** 3
        angle = normal % (2 * math.pi)
        share = min((angle if angle < math.pi else 2 * math.pi - angle - (math.pi - over)) / over, 1.0)
        if 0.0 < share < 1.0:  # the return is the rise backwards
            assert height == pytest.approx(0.04 + lift_at(rise, share=share), abs=1e-16)
            assert 1 / curvature == pytest.approx(curvature_radius_under_flat(rise, base=0.04, share=share), rel=1e-13)
        else:
            assert height == pytest.approx(0.05 if angle < math.pi else 0.04, abs=1e-16)
            assert 1 / curvature == pytest.approx(height, rel=1e-13)


def evaluate(segments, angles):
    """Radius, slope and second derivative of polynomial segments at angles."""
    places = np.searchsorted(segments[:, 0], angles, side="right") - 1
    polynomials = [(np.poly1d(segments[k, 1:]), angle - segments[k, 0]) for k, angle in zip(places, angles, strict=True)]
    return [np.array([polynomial.deriv(order)(x) for polynomial, x in polynomials]) for order in range(3)]


def test_harmonic_lift_over_a_full_turn_is_an_eccentric_disc():
    lifts = (Lift(over=math.pi, lift=0.01, law="harmonic"), Lift(over=math.pi, lift=-0.01, law="harmonic"))
    outline = CurveOutline(curve=LiftCurve(radius=0.04, lifts=lifts, follower="flat"))
    assert [math.hypot(x + 0.005, y) for x, y in outline_points(outline)] == pytest.approx([0.045] * 256, abs=1e-16)


def test_a_circle_is_found_of_arcs_and_as_a_curve():
    halves = CornerOutline(corners=(Corner(x=0.3, y=0.1, radius=0.1), Corner(x=0.1, y=0.1, radius=0.1)))
    assert find_circle(halves) == pytest.approx((0.2, 0.1, 0.1))
    lens = CornerOutline(corners=(Corner(x=0.3, y=0.1, radius=0.2), Corner(x=0.1, y=0.1, radius=0.2)))
    assert find_circle(lens) is None
    assert find_circle(CornerOutline(corners=(Corner(x=0.3, y=0.1), Corner(x=0.1, y=0.1, radius=0.1)))) is None
    assert find_circle(CurveOutline(curve=PolarHarmonics(radius=0.1), inset=0.02)) == (0.0, 0.0, 0.08)
    assert find_circle(CurveOutline(curve=LiftCurve(radius=0.1, lifts=(Lift(over=2 * math.pi),)))) is None


def test_a_curve_whose_origin_is_behind_all_edges_overlaps_one_of_them():
    square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
    mechanism = make_mechanism(square)
    cam = mechanism.outlines[1].outline
    poses = np.array([[0.02, -0.01, 0.0], [0.13, 0.02, 0.4]])  # the corners are those of the drawing
    around = place(outline_points(cam), [0.003, 0.002], poses[1])
    overlaps = [float((direction * around[:, axis]).min()) - 0.2 for axis in (0, 1) for direction in (1.0, -1.0)]
    found = float(evaluate_output(mechanism, "c_gap", poses).value)
    assert found == pytest.approx(max(overlaps), abs=1e-4)  # of many points of the curve
