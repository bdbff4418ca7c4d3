"""Simulated equilibria: every tabulated one, stable or not, against Zehnder's closed-form numbers."""

import math

import numpy as np
import pytest

from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.verification.machines.comparisons import relax_to_equilibrium
from governor_scenes import governor_scene
from reference import zehnder

SNAP_DIMENSIONS = {"arm": zehnder.FOLD_JUMP["arm"], "offset": zehnder.FOLD_JUMP["offset"], "ball_mass": zehnder.FOLD_JUMP["ball_mass"]}

# (dimensions, angle in degrees, speed in rad/s, stable)
ROWS = [
    (table["dimensions"], row[0], row[1], row[5] > 0)
    for table in (zehnder.WATT_ON_AXIS, zehnder.WATT_OPEN, zehnder.PORTER_OPEN, zehnder.PORTER_ON_AXIS, zehnder.CROSSED)
    for row in table["rows"]
] + [(SNAP_DIMENSIONS, row[0], row[1], row[3] > 0) for row in zehnder.FOLD_JUMP["rows"]]
STABLE = [row[:3] for row in ROWS if row[3]]
UNSTABLE = [row[:3] for row in ROWS if not row[3]]


def test_the_tables_hold_stable_and_unstable_rows():
    assert (len(STABLE), len(UNSTABLE)) == (32, 8)


@pytest.mark.parametrize(("dimensions", "degrees", "speed"), STABLE)
def test_the_governor_settles_at_zehnders_equilibrium(dimensions, degrees, speed):
    scene = governor_scene(dimensions, speed=speed, angle=0.5)
    start = math.radians(degrees) + 0.05  # to the stable side of a fold
    # 1e-8 rad: the step causes no error at rest; the speeds are printed to 12 digits, the joints close to 1e-12.
    assert relax_to_equilibrium(scene, start) == pytest.approx(math.radians(degrees), abs=1e-8)


@pytest.mark.parametrize(
    ("dimensions", "degrees", "speed"),
    [(zehnder.CROSSED_ARMS_OPEN_LINKS["dimensions"], row[0], row[2]) for row in zehnder.CROSSED_ARMS_OPEN_LINKS["rows"]]
    + [(zehnder.EXTENDED_ARM["dimensions"], zehnder.EXTENDED_ARM["arm_angle_deg"], zehnder.EXTENDED_ARM["spindle_speed"])],
)
def test_linkages_with_levers_settle_at_the_exact_equilibrium(dimensions, degrees, speed):
    scene = governor_scene(dimensions, speed=speed, angle=0.5)
    assert relax_to_equilibrium(scene, math.radians(degrees) + 0.05) == pytest.approx(math.radians(degrees), abs=1e-8)


@pytest.mark.parametrize(("dimensions", "degrees", "speed"), UNSTABLE)
def test_an_unstable_equilibrium_diverges_at_the_tabulated_rate(dimensions, degrees, speed):
    angle = math.radians(degrees)
    scene = governor_scene(dimensions, speed=speed, angle=angle)
    assert abs(_arm_acceleration_from_rest(scene, angle, speed)) < 1e-8 * speed**2

    growth = math.sqrt(-_table_squared(dimensions, degrees))
    perturbation = 1e-6  # rad; after five e-foldings 7e-5, where the second-order term is still 1e-4 of the first
    scene = governor_scene(dimensions, speed=speed, angle=angle + perturbation, duration=5 / growth, output_interval=1 / growth)
    deviation = ImpulseEngine().run(scene, accuracy=1e-8).readings["arm_angle"] - angle
    assert math.acosh(deviation[-1] / perturbation) / (5 / growth) == pytest.approx(growth, rel=0.01)


def test_growth_rates_of_the_crossed_governor_are_the_printed_ones():
    for degrees, rate in zehnder.CROSSED_MARKS["growth_rates"]:
        assert math.sqrt(-_table_squared(zehnder.CROSSED["dimensions"], degrees)) == pytest.approx(rate, rel=1e-11)


@pytest.mark.parametrize(("dimensions", "degrees", "speed", "stable"), ROWS)
def test_the_equilibrium_speed_of_the_mechanism_is_the_tabulated_one(dimensions, degrees, speed, stable):
    scene = governor_scene(dimensions, speed=speed, angle=0.5)
    # 1e-11: half a unit of the twelfth printed digit, doubled for joints closed to 1e-13.
    assert equilibrium_speed_at(scene, np.array([math.radians(degrees)]))[0] == pytest.approx(speed, rel=1e-11)


def test_both_equilibria_of_the_improved_watt_are_found_with_their_stability():
    scene = governor_scene(SNAP_DIMENSIONS, speed=6.4, angle=0.5)
    low, high = find_equilibria(scene, zehnder.FOLD_JUMP["stop_speed"])
    assert (low.stable, high.stable) == (False, True)
    assert math.degrees(low.coordinate) == pytest.approx(25, abs=1e-8)
    assert math.degrees(high.coordinate) == pytest.approx(40, abs=1e-8)


def _table_squared(dimensions, degrees):
    rows = zehnder.CROSSED["rows"] if dimensions is zehnder.CROSSED["dimensions"] else zehnder.FOLD_JUMP["rows"]
    column = 5 if dimensions is zehnder.CROSSED["dimensions"] else 3
    return next(row[column] for row in rows if row[0] == degrees)


def _arm_acceleration_from_rest(scene, angle, speed):
    """Return the change of the arm rate in one short first half step, divided by its duration."""
    position_solver = PositionSolver(scene.part.mechanism)
    poses = position_solver.solve_at_coordinate(angle)
    model, h = PymunkModel(scene, iterations=200), 1e-3
    model.start(poses, np.zeros_like(poses), TimeInputs(scene).start_inputs(h))
    _, velocities = model.to_mass_centres(*model.state())
    return float(evaluate_output(scene.part.mechanism, "arm_angle", poses).rate(velocities)) / (h / 2)
