"""Dimensions of a mechanism of one's own for a path: a known linkage is found again, a straight line gives Chebyshev's lambda."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.synthesis.dimensions import _PathDistance, find_nearest
from interruptions import interrupt_at_call

OVER = {f"dimensions.{name}": ("1.5 m", "3.5 m") for name in ("base", "rocker", "rod", "extension")}
START = {"dimensions.base": "1.7 m", "dimensions.rocker": "2.2 m", "dimensions.rod": "2.3 m", "dimensions.extension": "2.7 m"}
LINE = np.column_stack([np.linspace(0.0, 4.0, 21), np.full(21, 4.0)])


@pytest.fixture(scope="module")
def wrong():
    """Chebyshev's lambda with other dimensions."""
    return gm.load("chebyshev_lambda").replace(START)


def path_of_pen(angles, base, rocker, rod, extension):
    """Path of the pen of a lambda with a crank of 1 m, by the intersection of two circles."""
    pin, pivot = np.exp(1j * angles), base
    distance = np.abs(pivot - pin)
    along = (rod**2 - rocker**2 + distance**2) / (2 * distance)
    joint = pin + (pivot - pin) / distance * (along + 1j * np.sqrt(rod**2 - along**2))
    pen = pin + (joint - pin) * (rod + extension) / rod
    return np.column_stack([pen.real, pen.imag])


def test_the_dimensions_that_drew_a_path_are_found(wrong):
    truth = (2.1, 2.6, 2.4, 2.2)
    angles = np.linspace(0.3, 5.0, 17)
    found = gm.synthesise_dimensions(wrong, OVER, "rod.end", path_of_pen(angles, *truth), starts=1)
    assert found.ok
    assert list(found.rows[0].values.values()) == pytest.approx(truth, rel=1e-6)
    assert found.rows[0].largest_distance < 1e-6
    motion = gm.kinematics(found.rows[0].scene, "crank_angle", angles)
    assert motion.paths["rod.end"] == pytest.approx(path_of_pen(angles, *truth), abs=1e-6)


def test_a_straight_line_gives_the_lambda_of_chebyshev(wrong):
    """Of all dimensions the nearest to the line are about Chebyshev's, and nearer in the mean of squares, which he did not minimise."""
    own = find_nearest(gm.kinematics("chebyshev_lambda").paths["rod.end"], LINE) - LINE
    found = gm.synthesise_dimensions(wrong, OVER, "rod.end", LINE, starts=1)
    best = found.rows[0]
    assert found.ok
    assert best.distance < np.sqrt(np.mean(np.sum(own**2, axis=1)))
    assert list(best.values.values()) == pytest.approx([2.0, 2.5, 2.5, 2.5], rel=0.01)


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_points_are_passed_in_order_wherever_the_path_begins(order):
    """A figure of eight passes its middle twice: the nearest point there depends on what comes before and after."""
    turn = np.linspace(0.0, 2 * np.pi, 181)
    curve = np.column_stack([np.sin(turn), np.sin(2 * turn)])
    phases = np.linspace(2.0, 2.0 + 1.9 * np.pi, 24)
    points = np.column_stack([np.sin(phases), np.sin(2 * phases)])[order]
    assert find_nearest(curve, points) == pytest.approx(points, abs=1e-6)
    shifted = points + 0.01 * np.column_stack([np.cos(phases), 2 * np.cos(2 * phases)])[order]
    assert np.max(np.hypot(*(find_nearest(curve, shifted) - shifted).T)) < 3e-4


def test_impossible_dimensions_lie_outside(wrong):
    wrong = wrong.replace({f"dimensions.{name}": value for name, value in (("base", "2 m"), ("rod", "2.5 m"), ("extension", "2.5 m"))})
    over = {"dimensions.rocker": ("1 m", "6 m")}
    found = gm.synthesise_dimensions(wrong, over, "rod.end", LINE, starts=2, seed=1)
    assert found.as_json() == gm.synthesise_dimensions(wrong, over, "rod.end", LINE, starts=2, seed=1).as_json()
    assert found.rows[0].distance < 0.01
    assert found.plot().axes
    assert found.to_dataframe().shape[0] == len(found.rows)


def test_ctrl_c_keeps_the_best_values_so_far(wrong, monkeypatch):
    interrupt_at_call(monkeypatch, _PathDistance, "residuals", 12)
    found = gm.synthesise_dimensions(wrong, OVER, "rod.end", LINE, starts=1)
    assert not found.ok
    assert "interrupted in start 1 of 1" in str(found)
    assert found.rows[0].distance > 0.0
