"""Distance of a roller from an outline: against the nearest of many points, and its derivatives against differences."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import BOWL, CUP
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.curves import outline_kernels
from governor_mechanism.mechanics.curves.outlines import bounding_circle, chains_of, edges_of, is_inside, make_pieces, outline_points
from governor_mechanism.mechanics.dynamics.arrays import from_mass_centres
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_ends, evaluate_join, keep_features, release_features
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.curves import CornerOutline, CurveOutline
from governor_mechanism.model.joints.base import RowKind
from interpreted_kernels import interpret_kernels

MIXED = [[0, 0, -0.08], [0.1, 0], [0.12, 0.05, 0.05], [0.08, 0.08], [0, 0.07]]
"""Straight edges, an arc that bulges and a hollow one, with corners that stand out."""
CAM = {"curve": {"radius": 0.05, "harmonics": [{"amplitude": 0.01, "order": 2, "phase": 0.3}, {"amplitude": 0.004, "order": 3}]}}
LIFTS = [{"over": 2.0, "lift": 0.02}, {"over": 1.0}, {"over": 1.5, "lift": -0.02, "law": "harmonic"}, {"over": 2 * math.pi - 4.5}]


kernels_as_python = interpret_kernels(outline_kernels)


def make_mechanism(outline, radius=0.01, **contact):
    """Two bodies that move freely in the plane, the roller off its mass centre, and the outline too."""
    tables = {
        "machine": "custom",
        "body": [
            {"name": "cam", "mass": 1.0, "inertia": 1.0, "centre": [0.02, -0.01], "outline": outline},
            {"name": "arm", "mass": 1.0, "inertia": 1.0, "at": [1.0, 1.0], "points": {"tip": [0.03, 0.02]}},
        ],
        "force": [{"type": "spring", "first": "ground.origin", "second": "cam.origin", "stiffness": 1.0}],
        "contact": [{"name": "c", "first": "arm.tip", "radius": radius, "second": "cam", **contact}],
        "size": 0.1,
    }
    return gm.Scene.from_dict(tables).mechanism


def random_states(rng, count):
    """Poses and velocities with the roller near the outline, at any angle."""
    poses = rng.uniform(-0.1, 0.1, (count, 2, 3))
    poses[..., 2] = rng.uniform(-4, 4, (count, 2))
    return poses, rng.uniform(-1, 1, (count, 2, 3))


def place_of_roller(poses):
    """The centre of the roller in the axes of the outline."""
    (x1, y1, a1), (x2, y2, a2) = poses
    turn = lambda angle, x, y: (math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y)  # noqa: E731
    tip, origin = turn(a2, 0.03, 0.02), turn(a1, -0.02, 0.01)
    return turn(-a1, x2 + tip[0] - x1 - origin[0], y2 + tip[1] - y1 - origin[1])


def distance_of_chords(points, place):
    starts = np.array(points)
    chords = np.roll(starts, -1, axis=0) - starts
    shares = np.clip(((place - starts) * chords).sum(axis=1) / (chords**2).sum(axis=1), 0, 1)
    return np.hypot(*(place - starts - shares[:, None] * chords).T).min()


def test_the_distance_from_lines_and_arcs_is_that_of_the_nearest_of_many_points_and_negative_inside():
    mechanism = make_mechanism(MIXED)
    outline = mechanism.outlines[0].outline
    points = [edge.point(k / 2000) for edge in edges_of(outline) for k in range(2000)]
    poses, _ = random_states(np.random.default_rng(1), 100)
    for pose, value in zip(poses, evaluate_output(mechanism, "c_gap", poses).value, strict=True):
        place = place_of_roller(pose)
        side = -1 if is_inside(points[::20], *place) else 1
        assert value + 0.01 == pytest.approx(side * distance_of_chords(points, place), abs=1e-8)  # sagitta of the chords


@pytest.mark.parametrize("curve", [CAM["curve"], {"radius": 0.04, "lifts": LIFTS}], ids=["harmonics", "lifts"])
def test_the_distance_from_a_curve_is_that_of_the_nearest_of_many_points_and_negative_inside(curve):
    def radius_at(angle):
        if "harmonics" in curve:
            return 0.05 + 0.01 * np.sin(2 * angle + 0.3) + 0.004 * np.sin(3 * angle)
        rise, fall = angle / 2.0, (angle - 3.0) / 1.5
        risen = 0.04 + 0.02 * (rise - np.sin(2 * np.pi * rise) / (2 * np.pi))
        return np.select([angle < 2, angle < 3, angle < 4.5], [risen, 0.06, 0.06 - 0.01 * (1 - np.cos(np.pi * fall))], 0.04)

    mechanism = make_mechanism({"curve": curve, "inset": 0.004}, radius=0.001)
    angles = np.linspace(0, 2 * math.pi, 20_001)[:-1]
    points = np.stack([radius_at(angles) * np.cos(angles), radius_at(angles) * np.sin(angles)], axis=1)
    poses, _ = random_states(np.random.default_rng(2), 100)
    for pose, value in zip(poses, evaluate_output(mechanism, "c_gap", poses).value, strict=True):
        x, y = place_of_roller(pose)
        if math.hypot(x, y) > 0.02:  # near the middle two sides are as near
            side = 1 if math.hypot(x, y) > radius_at(np.array(math.atan2(y, x) % (2 * math.pi))) else -1
            assert value == pytest.approx(side * distance_of_chords(points, (x, y)) + 0.004 - 0.001, abs=2e-9)


@pytest.mark.parametrize("outline", [MIXED, CAM, {"curve": {"radius": 0.04, "lifts": LIFTS}}], ids=["edges", "harmonics", "lifts"])
def test_gradient_and_quadratic_term_are_those_of_differences(outline):
    """d'' along uniform velocities is the quadratic term; where the nearest piece changes within a difference, both are left out."""
    mechanism = make_mechanism(outline)
    poses, velocities = random_states(np.random.default_rng(3), 200)
    h = 1e-6
    before, here, after = (evaluate_output(mechanism, "c_gap", poses + k * h * velocities, velocities) for k in (-1, 0, 1))
    smooth = np.abs(after.quadratic_velocity_term - before.quadratic_velocity_term) < 0.02 * (1 + np.abs(here.quadratic_velocity_term))
    assert smooth.mean() > 0.8
    rates = (after.value - before.value) / (2 * h)
    np.testing.assert_allclose(here.rate(velocities)[smooth], rates[smooth], atol=1e-7)
    # of rates rather than of values, whose rounding over h^2 is 1e-6
    bends = (after.rate(velocities) - before.rate(velocities)) / (2 * h)
    np.testing.assert_allclose(here.quadratic_velocity_term[smooth], bends[smooth], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("outline", [MIXED, CAM], ids=["edges", "curve"])
def test_the_slip_is_the_velocity_of_both_surfaces_along_each_other(outline):
    """At the place where the roller would touch, a distance of its radius from its centre; and its derivative is that of differences."""
    mechanism = make_mechanism(outline, friction=0.1)
    poses, velocities = random_states(np.random.default_rng(5), 200)
    gap, slip = (evaluate_output(mechanism, name, poses, velocities) for name in ("c_gap", "c_slip"))
    normal = np.array([gap.rate(np.broadcast_to([[0, 0, 0], direction], poses.shape)) for direction in ([1.0, 0, 0], [0, 1.0, 0])]).T
    arms = np.array([[math.cos(a) * 0.03 - math.sin(a) * 0.02, math.sin(a) * 0.03 + math.cos(a) * 0.02] for a in poses[:, 1, 2]])
    place = poses[:, 1, :2] + arms - 0.01 * normal
    first, second = (
        velocities[:, k, :2] + velocities[:, k, 2:] * np.stack([poses[:, k, 1] - place[:, 1], place[:, 0] - poses[:, k, 0]], axis=1)
        for k in (0, 1)
    )
    along = (second - first)[:, 1] * normal[:, 0] - (second - first)[:, 0] * normal[:, 1]
    np.testing.assert_allclose(slip.value, 0.0)
    np.testing.assert_allclose(slip.rate(velocities), along, atol=1e-12)
    h = 1e-6
    before, after = (evaluate_output(mechanism, "c_slip", poses + k * h * velocities, velocities) for k in (-1, 1))
    smooth = np.abs(after.quadratic_velocity_term - before.quadratic_velocity_term) < 0.02 * (1 + np.abs(slip.quadratic_velocity_term))
    assert smooth.mean() > 0.8
    bends = (after.rate(velocities) - before.rate(velocities)) / (2 * h)
    np.testing.assert_allclose(slip.quadratic_velocity_term[smooth], bends[smooth], rtol=1e-5, atol=1e-5)


def test_of_rollers_that_repeat_the_nearest_one_counts():
    repeated, rollers = make_mechanism(MIXED, repeat=5), []
    for k in range(5):
        cosine, sine = math.cos(math.tau * k / 5), math.sin(math.tau * k / 5)
        place = [0.03 * cosine - 0.02 * sine, 0.03 * sine + 0.02 * cosine]
        rollers.append(make_mechanism(MIXED, first=["arm", *place]))
    poses, velocities = random_states(np.random.default_rng(6), 100)
    gaps = [evaluate_output(one, "c_gap", poses, velocities) for one in rollers]
    values, rates = np.array([gap.value for gap in gaps]), np.array([gap.rate(velocities) for gap in gaps])
    nearest, ordered = np.argmin(values, axis=0), np.sort(values, axis=0)
    apart = -0.01 - ordered[0] < ordered[1] + 0.01  # of their centres none lies deeper inside than another one is away
    assert set(nearest[apart]) == {0, 1, 2, 3, 4}
    found = evaluate_output(repeated, "c_gap", poses, velocities)
    np.testing.assert_allclose(found.value[apart], np.choose(nearest, values)[apart], atol=1e-15)
    np.testing.assert_allclose(found.rate(velocities)[apart], np.choose(nearest, rates)[apart], atol=1e-13)


def test_the_parts_between_hollow_corners_have_gaps_of_their_own():
    names = [reading.name for reading in make_mechanism(CUP).readings if reading.name.startswith("c_gap")]
    assert names == ["c_gap_1", "c_gap_2"]
    assert [reading.name for reading in make_mechanism(BOWL).readings][-1] == "c_gap"
    (outline,) = (one.outline for one in make_mechanism(CUP).outlines)
    bottom, outside = sorted(chains_of(outline), key=len)
    assert [edge.point(0.5) for edge in bottom] == [pytest.approx((0, 0))]
    assert len(outside) == 7


def test_the_direction_in_which_an_outline_is_written_does_not_matter():
    around = [[0.0, 0.0], [0.1, 0.0, 0.06], [0.1, 0.1], [0.0, 0.1, -0.07]]
    back = [[0.0, 0.0, -0.07], [0.0, 0.1], [0.1, 0.1, 0.06], [0.1, 0.0]]
    poses, _ = random_states(np.random.default_rng(4), 50)
    first, second = (evaluate_output(make_mechanism(one), "c_gap", poses).value for one in (around, back))
    np.testing.assert_allclose(first, second, atol=1e-15)


def test_points_of_an_outline_lie_on_it():
    (mixed, cam) = (make_mechanism(one).outlines[0].outline for one in (MIXED, {**CAM, "inset": 0.004}))
    assert isinstance(mixed, CornerOutline)
    assert isinstance(cam, CurveOutline)
    assert any(math.dist(point, (0.1, 0)) < 1e-15 for point in outline_points(mixed))
    mechanism = make_mechanism({**CAM, "inset": 0.004}, radius=0.0)
    for x, y in outline_points(cam)[::7]:
        poses = np.array([[[0.02, -0.01, 0.0], [x - 0.03, y - 0.02, 0.0]]])
        assert evaluate_output(mechanism, "c_gap", poses).value[0] == pytest.approx(0, abs=1e-15)


SQUARE = [[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]]
STADIUM = [[0, 0], [0.1, 0, 0.05], [0.1, 0.1], [0, 0.1, 0.05]]
"""Two straight edges, and half circles that join them smoothly."""


def pieces_of(corners):
    return make_pieces(make_mechanism(corners).outlines[0].outline, 0)


def walk(pieces, feature, is_at_end):
    """The features from one on, to the first that comes again."""
    seen = []
    while feature not in seen:
        seen.append(feature)
        feature = outline_kernels.next_feature(pieces, 0, len(pieces), feature, is_at_end)
    return [*seen, feature]


def test_a_roller_that_keeps_no_edge_is_beyond_the_end_of_none():
    scene = gm.load("ratchet")
    system = make_system(scene)[0]
    rows, motion = system.output_rows, from_mass_centres(system, *initial_state(scene))
    i = int(np.flatnonzero(rows.table["kind"] == RowKind.PIECES_DISTANCE)[0])
    assert evaluate_join(rows, i, *motion) == -1.0
    keep_features(rows, *motion)
    assert rows.table["kept_feature"][i] != outline_kernels.NO_FEATURE
    assert -1.0 < evaluate_join(rows, i, *motion) <= 0.0
    assert max(evaluate_ends(rows, i, *motion)) == evaluate_join(rows, i, *motion)  # of both ends the nearer one
    release_features(rows)
    assert evaluate_join(rows, i, *motion) == -1.0


def test_round_a_square_edges_and_corners_take_turns_both_ways():
    pieces = pieces_of(SQUARE)
    assert walk(pieces, 1, True) == [1, 2, 3, 4, 5, 6, 7, 8, 1]
    assert walk(pieces, 1, False) == [1, 8, 7, 6, 5, 4, 3, 2, 1]


def test_round_a_stadium_there_are_no_corners():
    pieces = pieces_of(STADIUM)
    assert walk(pieces, 1, True) == [1, 3, 5, 7, 1]
    assert walk(pieces, 1, False) == [1, 7, 5, 3, 1]


def test_the_way_ends_at_hollow_corners():
    pieces = pieces_of(CUP)
    last = 2 * len(pieces) - 1
    assert walk(pieces, 1, True)[-2:] == [last, last]
    assert walk(pieces, last, False)[-2:] == [1, 1]


BULGE = [[0, 0], [0.1, 0, 0.06], [0.1, 0.1], [0, 0.1]]
"""A square of which one edge bulges."""


@pytest.mark.parametrize(("outline", "before"), [(SQUARE, math.pi / 2), (BULGE, math.pi / 2 + math.asin(0.05 / 0.06))])
@pytest.mark.parametrize("share", [0.2, 0.7])
def test_round_a_corner_the_extents_are_the_sines_of_the_angles_to_its_edges(outline, before, share):
    """The edge before the corner, straight or bent, ends in a direction, and the next one goes to the left."""
    turn = math.pi - before
    normal = before + share * turn - math.pi / 2
    found = outline_kernels.extent_of_feature(
        pieces_of(outline), 4, outline_kernels.EdgePoint(0.1, 0.1, math.cos(normal), math.sin(normal), 1.0)
    )
    assert found == pytest.approx((-math.sin(share * turn), -math.sin((1 - share) * turn)), abs=1e-14)


@pytest.mark.parametrize(
    ("outline", "normal", "rate", "feature"),
    [(SQUARE, (0.6, -0.8), 1.0, 2), (SQUARE, (0.6, -0.8), -1.0, 2), (STADIUM, (0.0, -1.0), 1.0, 3), (STADIUM, (0.0, -1.0), -1.0, 1)],
)
def test_where_edges_join_a_corner_is_touched_if_there_is_one_and_else_the_edge_ahead(outline, normal, rate, feature):
    pieces = pieces_of(outline)
    assert outline_kernels.find_feature(pieces, 0, len(pieces), outline_kernels.EdgePoint(0.1, 0.0, *normal, rate)) == feature


@pytest.mark.parametrize("corners", [[0, 2, 1, 3], [0, 1, 3, 2]])
def test_an_outline_whose_edges_cross_is_refused(corners):
    with pytest.raises(gm.MechanismError, match="the outline crosses itself"):
        make_mechanism([SQUARE[k] for k in corners])


def test_the_circle_round_a_square_has_its_middle_and_is_not_much_wider():
    middle_x, middle_y, radius = bounding_circle(edges_of(make_mechanism(SQUARE).outlines[0].outline))
    assert (middle_x, middle_y) == pytest.approx((0.05, 0.05))
    assert 0.05 * math.sqrt(2) <= radius <= 0.05 * math.sqrt(2) + 0.1 / 4 + 1e-12


@pytest.mark.parametrize("outline", [SQUARE, BULGE], ids=["straight", "bent"])
def test_the_distance_from_a_corner_is_that_of_two_points(outline):
    pieces = pieces_of(outline)
    c = pieces.shape[1] - outline_kernels.N_PIECE_VALUES
    corners = {2 * k + 2: pieces[(k + 1) % len(pieces), c : c + 2] for k in range(len(pieces))}
    for feature, (x, y) in corners.items():
        found = outline_kernels.distance_from_feature(pieces, feature, x + 3e-3, y - 4e-3)
        assert (found.value, found.normal_x, found.normal_y) == pytest.approx((5e-3, 0.6, -0.8), rel=1e-12)
        assert found.curvature == pytest.approx(200.0, rel=1e-12)
    assert {tuple(np.round(one, 9)) for one in corners.values()} == {tuple(map(float, one[:2])) for one in outline}


COMB = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [0.06, 0.05], [0.06, 0.0], [0.02, 0.0], [0.02, 0.05], [-0.1, 0.05, -0.3]]
"""A slot 40 mm wide in a block, and behind a hollow corner a hollow arc as its last edge."""


@pytest.mark.parametrize(("outline", "deepest"), [(COMB, 0.05), (CUP, 0.1)])
def test_behind_hollow_corners_the_distance_is_negative_inside_up_to_half_the_way_to_the_next_parts(outline, deepest):
    """Never outside; inside wherever the outline is nearer than half of its least thickness."""
    mechanism = make_mechanism(outline)
    polygon = outline_points(mechanism.outlines[0].outline)
    names = [reading.name for reading in mechanism.readings if reading.name.startswith("c_gap")]
    count = 2000
    poses, _ = random_states(np.random.default_rng(4), count)
    distances = np.array([evaluate_output(mechanism, name, poses).value for name in names]) + 0.01
    places = [place_of_roller(pose) for pose in poses]
    inside = np.array([is_inside(polygon, *place) for place in places])
    nearest = distances[np.abs(distances).argmin(axis=0), np.arange(count)]
    assert inside.sum() > 100
    assert np.all(distances[:, ~inside] > 0)
    shallow = inside & (np.abs(nearest) < 0.4 * deepest * 0.4)
    assert shallow.sum() > 50
    assert np.all(nearest[shallow] < 0)
