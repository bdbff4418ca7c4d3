"""Interpolated paths: cubic paths are reproduced, ends are clamped, a period in front is the path one period earlier."""

import numpy as np
import pytest

from governor_mechanism.mechanics.kinematics.continuation import MIN_PATH_INTERVALS, PATH_BISECTIONS, PathInterpolant, PathPoint, build_path
from governor_mechanism.model.joints import Slider
from scene_parts import body_point, ground_point, make_mechanism, point_mass, x_reading

ARCS = np.array([0.0, 0.4, 1.0, 1.7])

BISECTION_ERROR = 2.0**-PATH_BISECTIONS * 0.7 * 20
"""Last bisection of the longest interval, times the largest derivative of a pose."""


def cubic_poses(arcs):
    """Return poses (n, 1, 3) and their derivatives by the arc length, polynomials of the third degree."""
    poses = np.stack([arcs, 1 + arcs**2, arcs - 2 * arcs**3], axis=-1)
    tangents = np.stack([np.ones_like(arcs), 2 * arcs, 1 - 6 * arcs**2], axis=-1)
    return poses[:, np.newaxis], tangents[:, np.newaxis]


def coordinate(arcs):
    """Return the leading coordinate, which rises with the arc length, and its derivative."""
    return 0.5 * arcs + arcs**3, 0.5 + 3 * arcs**2


def cubic_path(arcs=ARCS):
    """Return the path through points at some arc lengths."""
    return PathInterpolant.from_points([PathPoint(*numbers) for numbers in zip(arcs, *coordinate(arcs), *cubic_poses(arcs), strict=True)])


def test_a_cubic_path_is_reproduced_over_its_whole_range():
    arcs = np.linspace(0.0, 1.7, 35)
    predicted = cubic_path().predict_poses(coordinate(arcs)[0])
    np.testing.assert_allclose(predicted, cubic_poses(arcs)[0], atol=BISECTION_ERROR)


def test_beyond_its_ends_a_path_stays_at_them():
    low, high = coordinate(ARCS)[0][[0, -1]]
    predicted = cubic_path().predict_poses(np.array([low - 1.0, high + 1.0]))
    np.testing.assert_allclose(predicted, cubic_poses(ARCS[[0, -1]])[0], atol=BISECTION_ERROR)


def test_points_at_which_the_coordinate_does_not_rise_are_left_out():
    path = cubic_path(np.array([0.0, 0.4, 0.4, 1.0]))
    np.testing.assert_array_equal(path.arc_lengths, [0.0, 0.4, 1.0])
    np.testing.assert_array_equal(path.values, coordinate(np.array([0.0, 0.4, 1.0]))[0])


def test_a_period_in_front_is_the_path_one_period_earlier():
    path, arcs = cubic_path(), np.linspace(0.1, 0.9, 7)  # the seam takes the tangents of a periodic path, which this one is not
    period = float(path.values[-1] - path.values[0])
    increment = path.poses[-1] - path.poses[0]
    longer, values = path.with_previous_period(increment, period), coordinate(arcs)[0]
    assert np.all(np.diff(longer.values) > 0)
    assert np.all(np.diff(longer.arc_lengths) > 0)
    assert longer.values[-1] - longer.values[0] == pytest.approx(2 * period, rel=1e-15)
    np.testing.assert_allclose(longer.predict_poses(values), path.predict_poses(values), atol=BISECTION_ERROR)
    np.testing.assert_allclose(longer.predict_poses(values - period), path.predict_poses(values) - increment, atol=BISECTION_ERROR)


def test_a_straight_path_needs_no_more_points_than_the_least():
    """The tangents predict every point of it, so that no step is shortened; the ends and the initial guess are points."""
    bar = Slider(name="bar", first=ground_point(), second=body_point("block"), angle=0.0)
    mechanism = make_mechanism([point_mass("block", 1.0)], [bar], [x_reading("block")], [(0.5, 0.0, 0.0)], size=0.1)
    path = build_path(mechanism, 0.0, 1.0)
    np.testing.assert_allclose(path.values, np.linspace(0.0, 1.0, MIN_PATH_INTERVALS + 1), atol=1e-15)
    np.testing.assert_allclose(path.poses[:, 0, 0], path.values, atol=1e-15)
