"""Motion tables: poses and outputs along the coordinate, periods, and where a table ends."""

import math
from dataclasses import replace

import numpy as np
import pytest

from data_files import read_data
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    evaluate_output_second_derivative,
    evaluate_static_force,
    evaluate_table_output,
)
from governor_mechanism.mechanics.reduction.lagrangian import make_reduction_workspace
from governor_mechanism.mechanics.reduction.motion_table import MotionTable, lower_reduced_scene
from governor_mechanism.mechanics.reduction.reduced_model import N_STATES, lay_out_events
from governor_mechanism.mechanics.reduction.table import ON_TABLE, EndReason, ExtensionStatus, PeriodIndex, allocate_table, find_piece
from governor_mechanism.mechanics.reduction.table_refinement import MAX_DISTANCE, extend_table
from governor_mechanism.model.joints import GROUND, Gear, Pin, Point
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import Limit, LineAngle
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import governor_document
from scene_parts import body_angle, body_point, ground_point, make_mechanism, rotating_body, scene_of

CRANK, ROD = 0.1, 0.3
TABLE_ERROR = 1e-12
"""Truncation of 1e-13 of a scale, m and rad, and the rounding of a few turns."""


SCENES = read_data(__file__)


def slider_crank(**changes):
    """Return a slider crank with readings of crank and slider, and changes of its mechanism."""
    scene = parse_scene_document(SCENES["slider_crank"])
    return scene.with_changes(mechanism=replace(scene.mechanism, **changes))


def start_table(scene, angle=0.4):
    """Return the table of a scene from an angle of the crank on."""
    return MotionTable(scene, angle, PositionSolver(scene.mechanism).solve({"crank_angle": angle}))


def extend_to(table, low, high):
    """Extend a table as far as two values, or as far as it can be."""
    for side, value in enumerate((low, high)):
        while (table.end_coordinate(side) - value) * (1 if side else -1) < 0 and table.extend(side):
            pass
    return table


def exact_slider(angles):
    """Return position of the slider and its derivative by the angle of the crank."""
    sine, cosine = CRANK * np.sin(angles), CRANK * np.cos(angles)
    root = np.sqrt(ROD**2 - sine**2)
    return cosine + root, -sine - sine * cosine / root


@pytest.mark.parametrize("ends", [(0.4, 2.0), (-2.0, 0.4), (-1.0, 1.0)])
def test_poses_and_tangents_on_both_sides_of_the_start(ends):
    table = extend_to(start_table(slider_crank()), *ends)
    angles = np.linspace(*ends, 37)
    poses, tangents = table.evaluate_poses(angles)
    x, slope = exact_slider(angles)
    np.testing.assert_allclose(poses[:, 2, 0], x, atol=TABLE_ERROR)
    np.testing.assert_allclose(tangents[:, 2, 0], slope, atol=10 * TABLE_ERROR)
    np.testing.assert_allclose(poses[:, 0, 2], angles, atol=TABLE_ERROR)


def test_a_table_may_begin_on_either_side_also_where_its_first_width_is_refused():
    """The piece below covers what the one above does in the mirror; a first width of 2 rad is too large for the fit tolerance."""
    scene = slider_crank()
    arrays, _, _ = lower_reduced_scene(scene)
    workspace, poses = make_reduction_workspace(arrays), PositionSolver(scene.mechanism).solve({"crank_angle": 0.0})
    widths = []
    for side in (0, 1):
        table = allocate_table(arrays, 4, 0.0, poses)
        table.next_widths[:] = 2.0
        assert extend_table(arrays, workspace, table, side) == ExtensionStatus.PIECE_ADDED
        assert table.intervals[0, 1 - side] == 0.0
        widths.append(table.intervals[0, 1] - table.intervals[0, 0])
    assert widths[0] == widths[1] < 2.0


def test_a_table_that_has_gone_round_repeats_itself_in_both_directions():
    table = start_table(slider_crank())
    while table.extend(1):
        pass
    n_pieces = table.n_pieces
    angles = 0.4 + math.tau * np.array([-3.0, -1.0, -0.37, 0.0, 0.5, 1.0, 4.25])
    poses, tangents = table.evaluate_poses(angles)
    x, slope = exact_slider(angles)
    np.testing.assert_allclose(poses[:, 2, 0], x, atol=TABLE_ERROR)
    np.testing.assert_allclose(tangents[:, 2, 0], slope, atol=10 * TABLE_ERROR)
    np.testing.assert_allclose(poses[:, 0, 2], angles, atol=4 * TABLE_ERROR)  # four turns
    assert not table.extend(0)
    assert not table.extend(1)
    assert table.n_pieces == n_pieces


@pytest.mark.parametrize(("limits", "side", "value"), [((0.25, 0.42), 1, 0.25), ((0.25, 0.39), 0, 0.39)])
def test_a_table_ends_where_another_reading_reaches_its_limit(limits, side, value):
    limit = Limit(reading="slider_x", low=limits[0], high=limits[1], low_message="too far in", high_message="too far out")
    table = extend_to(start_table(slider_crank(limits=(limit,))), -3.0, 3.0)
    end = table.end_coordinate(side)
    assert exact_slider(np.array([end]))[0][0] == pytest.approx(value, abs=1e-9)  # bisection to rounding on a table of 1e-13
    is_at_limit, message = table.end_message(side)
    assert is_at_limit
    assert message == ("slider_x: too far in" if side == 1 else "slider_x: too far out")
    assert not table.extend(side)


@pytest.mark.parametrize("limit", [None, Limit(reading="slider_x", low=0.25, high=1.0, low_message="near", high_message="far")])
def test_a_table_ends_at_a_turning_point_of_its_coordinate(limit):
    scene = slider_crank(coordinate="slider_x", limits=() if limit is None else (limit,))
    poses = PositionSolver(scene.mechanism).solve({"slider_x": 0.35})
    table = MotionTable(scene, 0.35, poses)  # pieces become narrower and narrower there
    extend_to(table, 0.0, 1.0)
    is_at_limit, message = table.end_message(1)
    assert not is_at_limit
    assert "turning point" in message
    assert table.end_coordinate(1) == pytest.approx(CRANK + ROD, abs=1e-3)
    if limit is not None:
        assert table.end_message(0) == (True, "slider_x: near")
        assert table.end_coordinate(0) == 0.25


def test_a_piece_that_would_lead_beyond_a_turning_point_becomes_narrower():
    scene = slider_crank(coordinate="slider_x")
    table = MotionTable(scene, 0.38, PositionSolver(scene.mechanism).solve({"slider_x": 0.38}))
    table.table.next_widths[1] = 0.1
    assert table.extend(1)
    assert 0.38 < table.end_coordinate(1) < CRANK + ROD


def parallelogram(start):
    """Return a parallelogram, and a table from an angle of its cranks on; all its links lie in one line at angles 0 and pi."""
    crank, ground = 0.1, 0.4
    bodies = [Body(name=name, mass=1.0, second_moments=SecondMoments(xx=0.01)) for name in ("crank", "coupler", "rocker")]
    end = crank * np.array([math.cos(start), math.sin(start)])
    joints = [
        Pin(name="A", first=ground_point(), second=body_point("crank")),
        Pin(name="B", first=body_point("crank", crank), second=body_point("coupler")),
        Pin(name="C", first=body_point("coupler", ground), second=body_point("rocker", crank)),
        Pin(name="D", first=body_point("rocker"), second=ground_point(ground)),
    ]
    sketch = [(0.0, 0.0, start), (*end.tolist(), 0.0), (ground, 0.0, start)]
    mechanism = make_mechanism(bodies, joints, [body_angle("crank", "angle")], sketch, size=ground)
    return MotionTable(scene_of(mechanism), start, PositionSolver(mechanism).solve({}))


def test_a_table_ends_before_a_change_point_with_accurate_poses():
    """A parallelogram may fold there into an antiparallelogram."""
    table = extend_to(parallelogram(1.3), -10.0, 10.0)
    ends = [table.end_coordinate(side) for side in (0, 1)]
    assert 0.0 < ends[0] < 0.2
    assert math.pi - 0.2 < ends[1] < math.pi
    for side in (0, 1):
        is_at_limit, message = table.end_message(side)
        assert not is_at_limit
        assert "change point" in message
    angles = np.linspace(*ends, 301)
    poses, tangents = table.evaluate_poses(angles)
    np.testing.assert_allclose(poses[:, :, 2], np.stack([angles, 0 * angles, angles], axis=1), atol=TABLE_ERROR)
    np.testing.assert_allclose(tangents[:, :, 2], np.tile([1.0, 0.0, 1.0], (301, 1)), atol=TABLE_ERROR)


def test_a_table_that_starts_where_links_nearly_fold_ends_before_they_do():
    table = extend_to(parallelogram(0.06), -10.0, 0.06)
    end = table.end_coordinate(0)
    assert 0.0 < end < 0.06
    angles = np.linspace(end, 0.06, 31)
    np.testing.assert_allclose(table.evaluate_poses(angles)[0][:, :, 2], np.stack([angles, 0 * angles, angles], axis=1), atol=TABLE_ERROR)


@pytest.mark.parametrize("start", [1.45, 1.46])
def test_a_table_reaches_a_bound_at_which_its_links_fold(start):
    """The arms and links of a rhombic governor lie in one line where the arms are horizontal."""
    scene = parse_scene_document(governor_document({"arm": 0.3, "offset": 0.0, "ball_mass": 5, "sleeve_mass": 20}))
    table = extend_to(MotionTable(scene, start, PositionSolver(scene.mechanism).solve({"arm_angle": start})), start, 2.0)
    assert table.end_coordinate(1) == math.pi / 2
    assert table.end_message(1)[0]
    angles = np.linspace(start, table.edge(1), 31)
    sleeve = scene.mechanism.body_index("sleeve")
    np.testing.assert_allclose(table.evaluate_poses(angles)[0][:, sleeve, 1], -0.6 * np.cos(angles), atol=10 * TABLE_ERROR)


def test_a_table_ends_at_a_limit_of_its_coordinate():
    limit = Limit(reading="crank_angle", low=-0.5, high=0.9, low_message="far back", high_message="far on")
    line = Limit(reading="slider_x", low=0.1, high=0.9, low_message="near", high_message="far")
    table = extend_to(start_table(slider_crank(limits=(line, limit))), -2.0, 2.0)
    assert [table.end_coordinate(side) for side in (0, 1)] == [-0.5, 0.9]
    assert [table.end_message(side) for side in (0, 1)] == [(True, "crank_angle: far back"), (True, "crank_angle: far on")]


def test_a_table_does_not_start_farther_out_than_crank_and_rod_reach():
    sliding = slider_crank(coordinate="slider_x")
    assert not MotionTable(sliding, 0.5, PositionSolver(sliding.mechanism).solve({"crank_angle": 0.4})).is_started


def test_a_table_grows_as_far_as_it_has_room_and_no_farther_than_its_bound():
    scene = slider_crank()
    arrays, _, _ = lower_reduced_scene(scene)
    workspace, poses = make_reduction_workspace(arrays), PositionSolver(scene.mechanism).solve({"crank_angle": 0.4})
    table = allocate_table(arrays, 1, 0.4, poses)
    assert extend_table(arrays, workspace, table, 1) == ExtensionStatus.PIECE_ADDED
    assert extend_table(arrays, workspace, table, 1) == ExtensionStatus.TABLE_FULL
    table = allocate_table(arrays, 3, 0.4, poses)
    assert extend_table(arrays, workspace, table, 1) == ExtensionStatus.PIECE_ADDED
    table.periodicity[PeriodIndex.START] = -2.0 * MAX_DISTANCE  # as if it had started there
    assert extend_table(arrays, workspace, table, 1) == ExtensionStatus.TABLE_ENDED
    assert table.end_reasons[1] == EndReason.TOO_FAR


def test_a_table_that_starts_at_a_limit_ends_there():
    x = float(exact_slider(np.array([0.4]))[0][0])
    limit = Limit(reading="slider_x", low=x, high=1.0, low_message="too far in", high_message="too far out")
    table = start_table(slider_crank(limits=(limit,)))
    assert not table.extend(1)
    assert table.end_message(1) == (True, "slider_x: too far in")


@pytest.mark.long  # in the daily tests a run counts the turns of a spring, tests/engines/test_reduced.py
def test_a_spring_that_is_wound_up_has_another_torque_after_each_turn():
    scene = slider_crank().with_changes(effects=(OutputSpring(reading="crank_angle", rate=70.0, zero=0.0),))
    table = extend_to(start_table(scene), 0.4, 8.0)
    model = table.model.on_table(table.table, np.zeros((1, 5)), np.array([0]))
    for angle in (1.0, 1.0 + math.tau):
        piece, t, side = find_piece(table.table.intervals, table.table.neighbours, table.table.periodicity, angle, 0)
        assert side == ON_TABLE
        assert evaluate_static_force(model, piece, t, np.zeros(N_STATES), 0.0)[0] == pytest.approx(-70.0 * angle, rel=1e-9)


def test_a_table_of_a_gear_at_half_the_speed_closes_after_two_turns():
    bodies = [rotating_body(name, 1.0, 0.01) for name in ("first", "wheel")]
    pins = [Pin(name=body, first=ground_point(x), second=body_point(body)) for body, x in (("first", 0.0), ("wheel", 0.3))]
    gear = Gear(name="gear", first=body_point("first"), second=body_point("wheel"), ratio=0.5)
    mechanism = make_mechanism(bodies, [*pins, gear], [body_angle("first", "angle")], [(0.0, 0.0, 0.0), (0.3, 0.0, 0.0)], size=0.3)
    table = MotionTable(scene_of(mechanism), 0.0, PositionSolver(mechanism).solve({}))
    while table.extend(1):
        assert table.end_coordinate(1) < 13.0
    assert table.table.periodicity[PeriodIndex.PERIOD] == pytest.approx(2 * math.tau, rel=1e-12)
    poses, _ = table.evaluate_poses(np.array([30.0]))
    np.testing.assert_allclose(poses[0, :, 2], [30.0, 15.0], atol=10 * TABLE_ERROR)


def test_poses_are_followed_along_a_coordinate_up_to_where_it_turns():
    solver = CoordinateSolver(slider_crank(coordinate="slider_x").mechanism)
    poses = solver.solve({"crank_angle": 0.4})
    found = solver.follow(poses, np.array([0.38, 0.36, 0.34, 0.5, 0.36]))  # 0.5 m is out of reach
    np.testing.assert_allclose(found[:, 0, 2, 0], [0.38, 0.36, 0.34], atol=TABLE_ERROR)
    np.testing.assert_allclose(exact_slider(found[:, 0, 0, 2])[0], [0.38, 0.36, 0.34], atol=TABLE_ERROR)
    straight = solver.solve({"crank_angle": 0.0})
    _, is_solved = solver.try_solve_nodes(np.stack([poses, straight, poses]), np.array([0.3895, CRANK + ROD, CRANK + ROD + 1e-7]))
    assert is_solved.tolist() == [True, False, False]  # where it turns it does not determine the poses


def test_one_coordinate_does_not_determine_the_poses_of_two_degrees_of_freedom():
    mechanism = slider_crank().mechanism
    solver = CoordinateSolver(replace(mechanism, joints=mechanism.joints[:-1]))
    _, is_solved = solver.try_solve_nodes(solver.initial_guess[np.newaxis], np.array([0.4]))
    assert not is_solved[0]


def test_the_poses_of_a_table_close_the_joints():
    scene = slider_crank()
    table = extend_to(start_table(scene), 0.0, 1.0)
    poses, _ = table.evaluate_poses(np.linspace(0.0, 1.0, 11))
    solver = PositionSolver(scene.mechanism)
    assert np.max(np.abs(solver.equations.residuals(poses))) < TABLE_ERROR


LINE = LineAngle(name="line", quantity="angle", start=Point(body=GROUND), end=Point(body="crank", x=CRANK), zero=math.pi / 2)
"""Direction of the crank from the x axis, from -pi - pi / 2 to pi / 2."""


def line_limit(low: float, high: float) -> Limit:
    return Limit(reading="line", low=low, high=high, low_message="too far back", high_message="too far on")


@pytest.mark.parametrize(("side", "ends"), [(0, (-10.0, 0.4)), (1, (0.4, 10.0)), (1, (1.5, 10.0))])  # the last one jumps in the first piece
def test_the_angle_of_a_line_goes_on_over_a_whole_turn(side, ends):
    """Its limit lies beyond the half turn at which the angle of a line jumps, and pieces begin on both sides of the jump."""
    for bound in (2.5, 4.0, 5.5):
        scene = slider_crank(limits=(line_limit(-bound, bound),))
        mechanism = replace(scene.mechanism, readings=(*scene.mechanism.readings, LINE))
        table = extend_to(start_table(scene.with_changes(mechanism=mechanism), ends[1 - side]), *ends)
        assert table.end_coordinate(side) == pytest.approx(math.copysign(bound, ends[side]), abs=1e-9)
        assert table.end_message(side) == (True, "line: too far on" if side else "line: too far back")


@pytest.mark.parametrize("angle", [0.4, 0.0])  # there the slider is at its dead centre, and derivatives vanish
def test_a_table_with_outputs_and_without_inertia_about_a_spindle_closes(angle):
    scene = slider_crank(limits=(line_limit(-9.0, 9.0), Limit(reading="slider_x", low=0.0, high=1.0, low_message="", high_message="")))
    table = start_table(scene.with_changes(mechanism=replace(scene.mechanism, readings=(*scene.mechanism.readings, LINE))), angle)
    while table.extend(1):
        assert table.end_coordinate(1) < 7.0
    x, _ = exact_slider(np.array([20.0]))
    np.testing.assert_allclose(table.evaluate_poses(np.array([20.0]))[0][:, 2, 0], x, atol=TABLE_ERROR)


def exact_slider_second_derivative(angles):
    """Return the second derivative of the position of the slider."""
    s, c = np.sin(angles), np.cos(angles)
    root = np.sqrt(ROD**2 - CRANK**2 * s**2)
    return -CRANK * c - CRANK**2 * (c * c - s * s) / root - CRANK**4 * (s * c) ** 2 / root**3


@pytest.mark.long
def test_outputs_and_static_force_on_both_sides_of_the_start():
    springs = [OutputSpring(reading=name, rate=70.0, zero=zero, one_sided=True) for name, zero in (("crank_angle", 0.0), ("slider_x", 0.3))]
    scene = slider_crank().with_changes(effects=tuple(springs))
    table = extend_to(start_table(scene), -1.0, 1.5)
    arrays = table.table
    model = table.model.on_table(arrays, np.zeros((1, 5)), np.array([0, 0, 1]))
    for angle in (-0.9, 0.2, 0.5, 1.4):
        piece, t, side = find_piece(arrays.intervals, arrays.neighbours, arrays.periodicity, angle, 0)
        assert side == ON_TABLE
        x, slope = exact_slider(angle)
        assert evaluate_table_output(model, piece, t, 0) == pytest.approx((angle, 1.0), abs=TABLE_ERROR)
        assert evaluate_table_output(model, piece, t, 1) == pytest.approx((x, slope), abs=10 * TABLE_ERROR)
        second = exact_slider_second_derivative(angle)
        assert evaluate_output_second_derivative(model, piece, t, 1) == pytest.approx(second, abs=1e3 * TABLE_ERROR)  # pieces of 0.1 rad
        force, limit = evaluate_static_force(model, piece, t, np.zeros(N_STATES), 0.0)
        assert force == pytest.approx(-70.0 * (x - 0.3) * slope, rel=1e-9)
        assert limit == 0.0


def test_a_limit_is_found_at_the_far_end_of_a_piece():
    table = extend_to(start_table(slider_crank()), 0.0, 1.5)
    low, high = table.table.intervals[table.table.end_pieces[1], :2]
    for share in (0.5, 0.99, 0.9999):
        angle = low + share * (high - low)
        limit = Limit(reading="slider_x", low=exact_slider(angle)[0], high=1.0, low_message="", high_message="")
        limited = extend_to(start_table(slider_crank(limits=(limit,))), 0.0, 3.0)
        assert limited.end_coordinate(1) == pytest.approx(angle, abs=1e-11)  # truncation of 1e-13 over the slope of the slider


def test_a_little_beyond_a_table_poses_are_solved():
    scene = slider_crank()
    table = extend_to(start_table(scene), 0.2, 0.6)
    values = np.array([table.edge(0) - 1e-3, 0.4, table.edge(1) + 1e-3])
    poses, tangents = table.evaluate_poses(values)
    solver = PositionSolver(scene.mechanism)
    for value, pose, tangent in zip(values, poses, tangents, strict=True):
        ahead, behind = (solver.solve({"crank_angle": value + step}) for step in (1e-4, -1e-4))
        np.testing.assert_allclose(pose, solver.solve({"crank_angle": value}), atol=1e-12)
        np.testing.assert_allclose(tangent, (ahead - behind) / 2e-4, atol=1e-7)  # the step squared


def test_the_coordinate_is_bounded_by_the_narrowest_of_its_limits():
    said = {"low_message": "low", "high_message": "high"}
    limits = [Limit(reading="crank_angle", low=low, high=high, **said) for low, high in ((-1.0, 0.9), (-0.5, 2.0), (-3.0, 1.5))]
    scene = slider_crank(limits=(*limits, Limit(reading="slider_x", low=0.2, high=0.45, **said)))
    table = extend_to(start_table(scene, 0.4), -2.0, 2.0)
    assert (table.end_coordinate(0), table.end_coordinate(1)) == (-0.5, 0.9)


def test_every_reason_for_an_end_has_its_own_number_and_limits_come_last():
    numbers = [int(reason) for reason in EndReason.__members__.values()]
    assert len(set(numbers)) == len(numbers)
    assert max(numbers) == EndReason.AT_LIMIT  # limits count on from there


def test_every_event_of_a_reduced_run_has_its_own_place():
    n_contacts, n_springs, n_tables = 3, 2, 4
    layout = lay_out_events(n_contacts, n_springs, n_tables)
    lengths = {"sticks": n_contacts, "high_stops": n_contacts, "low_stops": n_contacts, "springs": n_springs, "release_up": 1}
    lengths |= {"release_down": 1, "table_ends": 2 * n_tables}  # kinks come last
    place = 0
    for name, length in lengths.items():
        assert getattr(layout, name) == place, name
        place += length
    assert layout.kinks == place


@pytest.mark.parametrize("angle", [-7.0, 0.45, 3.0, 20.0])
def test_a_far_value_is_reached_step_by_step_on_the_same_branch(angle):
    mechanism = slider_crank().mechanism
    solver = CoordinateSolver(mechanism)
    poses = PositionSolver(mechanism).solve({"crank_angle": 0.4})
    (node,) = solver.follow(poses, np.array([angle]))
    place, slope = exact_slider(np.array([angle]))
    assert node[0, 0, 2] == pytest.approx(angle, abs=1e-12)
    assert node[0, 2, 0] == pytest.approx(place[0], abs=1e-12)
    assert node[1, 2, 0] == pytest.approx(slope[0], abs=1e-11)
