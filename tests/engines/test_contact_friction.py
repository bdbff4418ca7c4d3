"""Friction between rollers and outlines: sliding, sticking, rolling, impacts, against closed forms and scipy; jams by name."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from contact_scenes import BOWL, FLOOR, GRAVITY, ROLLER, ball_document, contact_document, disc_document, events_of, run_ball
from governor_mechanism.model.events import EventKind

DISC_MASS, DISC_INERTIA = 1.5, 4e-4


def run_disc(outline, place, rates, spin, **options):
    """Run a disc that turns, as a roller of the radius of the ball, under gravity."""
    document = disc_document(outline, place, (*rates, spin), DISC_MASS, DISC_INERTIA, friction=0.3, **options)
    document["run"]["readings"] = ["contact.ball"]
    return gm.run(gm.Scene.from_dict(document))


def test_a_ball_slides_on_a_floor_until_friction_stops_it_and_stays_there():
    document = ball_document(FLOOR, (0.0, ROLLER), (1.0, 0.0), friction=0.25)
    document["run"]["readings"] = ["contact.ball"]
    run = gm.run(gm.Scene.from_dict(document))
    stop = 1 / (0.25 * GRAVITY)
    assert run.outcome is gm.Outcome.DONE
    assert events_of(run, EventKind.STICK) == pytest.approx([stop], abs=1e-14)
    assert len(run.events) == 1
    time = np.minimum(run.times, stop)
    np.testing.assert_allclose(run.readings["x"], time - 1.25 * time**2, atol=1e-14)
    np.testing.assert_allclose(run.readings["contact.ball.force"], GRAVITY, rtol=1e-14)
    np.testing.assert_allclose(run.readings["contact.ball.friction"], np.where(run.times < stop - 1e-9, 2.5, 0.0), atol=1e-12)
    assert run.energy.dissipated_energy[-1] == pytest.approx(0.5, rel=1e-13)
    assert run.energy.drift < 1e-13


@pytest.mark.parametrize(("slope", "event"), [(14.0, None), (14.1, EventKind.SLIP)])
def test_a_ball_sticks_on_a_slope_up_to_the_angle_of_friction(slope, event):
    """tan(14.036 deg) = 0.25."""
    angle = math.radians(slope)
    along, normal = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    corners = [(-2 * along).tolist(), (-2 * along - normal).tolist(), (2 * along - normal).tolist(), (2 * along).tolist()]
    run = run_ball(corners, ROLLER * normal, friction=0.25)
    way = np.hypot(run.readings["x"] - run.readings["x"][0], run.readings["y"] - run.readings["y"][0])
    acceleration = GRAVITY * (math.sin(angle) - 0.25 * math.cos(angle)) if event else 0.0
    np.testing.assert_allclose(way, acceleration / 2 * run.times**2, atol=1e-14)


def test_a_disc_with_back_spin_slides_and_then_rolls_without_losses():
    speed, spin = 0.5, 40.0
    run = run_disc(FLOOR, (0.0, ROLLER), (speed, 0.0), spin)
    ratio = DISC_MASS * ROLLER**2 / DISC_INERTIA
    slowing = 0.3 * GRAVITY
    stop = (speed + ROLLER * spin) / (slowing * (1 + ratio))
    rolling = speed - slowing * stop
    assert events_of(run, EventKind.STICK) == pytest.approx([stop], abs=1e-13)
    before, after = np.minimum(run.times, stop), np.maximum(run.times - stop, 0.0)
    np.testing.assert_allclose(run.readings["x"], speed * before - slowing / 2 * before**2 + rolling * after, atol=1e-13)
    np.testing.assert_allclose(run.rates["turn"][run.times > stop], -rolling / ROLLER, rtol=1e-12)
    np.testing.assert_allclose(run.readings["contact.ball.friction"][run.times > stop], 0.0, atol=1e-11)
    lost = (DISC_MASS * (speed**2 - rolling**2) + DISC_INERTIA * (spin**2 - (rolling / ROLLER) ** 2)) / 2
    np.testing.assert_allclose(run.energy.dissipated_energy[-1], lost, rtol=1e-12)
    assert run.energy.drift < 1e-13


@pytest.mark.parametrize("rolls", [True, False])
def test_a_disc_rolls_down_a_slope_unless_it_is_too_steep(rolls):
    ratio = DISC_MASS * ROLLER**2 / DISC_INERTIA
    angle = math.atan(0.3 * (1 + ratio)) + (-0.01 if rolls else 0.01)
    along, normal = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    corners = [(-2 * along).tolist(), (-2 * along - normal).tolist(), (4 * along - normal).tolist(), (4 * along).tolist()]
    run = run_disc(corners, (ROLLER * normal).tolist(), (0.0, 0.0), 0.0, run=(0.4, 0.05))
    way = np.hypot(run.readings["x"] - run.readings["x"][0], run.readings["y"] - run.readings["y"][0])
    acceleration = GRAVITY * (math.sin(angle) * ratio / (1 + ratio) if rolls else math.sin(angle) - 0.3 * math.cos(angle))
    np.testing.assert_allclose(way, acceleration / 2 * run.times**2, atol=1e-13)
    spin = -acceleration / ROLLER if rolls else -0.3 * math.cos(angle) * GRAVITY * ratio / ROLLER
    np.testing.assert_allclose(run.rates["turn"], spin * run.times, atol=1e-11)


def swing_with_friction(angle, friction, length, times):
    """Integrate a ball that slides in a bowl: friction is the coefficient times the force of the bowl, which the speed raises."""
    states, time, state, stops = np.full((len(times), 2), np.nan), 0.0, np.array([angle, 0.0]), []
    while True:
        sign = -math.copysign(1.0, state[0])

        def slide(t, y, sign=sign):
            return [y[1], -GRAVITY / length * math.sin(y[0]) - sign * friction * (GRAVITY / length * math.cos(y[0]) + y[1] ** 2)]

        def stop(t, y, start=time, sign=sign):
            return y[1] if t > start + 1e-6 else sign

        stop.terminal = True
        solution = solve_ivp(slide, (time, times[-1]), state, events=stop, dense_output=True, rtol=1e-13, atol=1e-15, method="DOP853")
        here = (times >= time) & (times <= solution.t[-1])
        states[here] = solution.sol(times[here]).T
        if solution.status != 1:
            return states, stops
        time, state = float(solution.t[-1]), np.array([solution.y[0, -1], 0.0])
        stops.append(time)
        if abs(math.tan(state[0])) <= friction:
            states[times >= time] = state
            return states, stops


def test_a_ball_in_a_bowl_swings_with_friction_until_it_sticks_as_scipy_integrates():
    length, angle = 0.15 - ROLLER, 1.2
    document = ball_document(BOWL, (length * math.sin(angle), -length * math.cos(angle)), friction=0.15)
    document["run"] |= {"duration": 2.0, "accuracy": 1e-10}
    run = gm.run(gm.Scene.from_dict(document))
    states, stops = swing_with_friction(angle, 0.15, length, run.times)
    assert len(stops) == 3
    assert events_of(run, EventKind.STICK) == pytest.approx(stops[-1:], abs=1e-10)
    assert len(run.events) == 1  # where it turns back it slides on
    np.testing.assert_allclose(run.readings["x"], length * np.sin(states[:, 0]), atol=1e-10)
    np.testing.assert_allclose(run.rates["x"], length * np.cos(states[:, 0]) * states[:, 1], atol=1e-9)
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize("spin", [-200.0, -30.0, 0.0, 150.0])
def test_an_impact_with_friction_stops_the_sliding_or_is_limited_by_coulombs_law(spin):
    restitution, speed, fall = 0.5, 0.4, 0.3
    place = (0.0, ROLLER + fall**2 / (2 * GRAVITY))
    run = run_disc(FLOOR, place, (speed, 0.0), spin, restitution=restitution, run=(0.05, 0.01))
    (impact,) = events_of(run, EventKind.IMPACT)
    assert impact == pytest.approx(fall / GRAVITY, abs=1e-12)
    ratio = DISC_MASS * ROLLER**2 / DISC_INERTIA
    normal = DISC_MASS * (1 + restitution) * fall
    slip = speed + ROLLER * spin
    stopping = -DISC_MASS * slip / (1 + ratio)
    tangential = stopping if abs(stopping) <= 0.3 * normal else -math.copysign(0.3 * normal, slip)
    assert run.rates["x"][-1] == pytest.approx(speed + tangential / DISC_MASS, abs=1e-11)
    assert run.rates["turn"][-1] == pytest.approx(spin + ROLLER * tangential / DISC_INERTIA, abs=1e-9)
    assert run.rates["y"][-1] == pytest.approx(restitution * fall - GRAVITY * (0.05 - impact), abs=1e-11)
    assert run.energy.drift < 1e-12


def test_a_ball_that_bounces_to_rest_loses_sliding_speed_in_all_its_strikes():
    """Friction is proportional to the normal impulse, which is that of the weight over the time of the motion and of the fall."""
    fall, restitution, speed, friction = 0.5, 0.4, 2.5, 0.2
    run = run_ball(FLOOR, (0.0, ROLLER + fall**2 / (2 * GRAVITY)), (speed, 0.0), restitution=restitution, friction=friction)
    (rest,) = events_of(run, EventKind.REST)
    assert rest == pytest.approx(fall / GRAVITY * (1 + 2 * restitution / (1 - restitution)), abs=1e-9)
    np.testing.assert_allclose(run.rates["x"][run.times > rest], speed - friction * GRAVITY * run.times[run.times > rest], atol=1e-9)


@pytest.mark.parametrize("holds", [True, False])
def test_a_ladder_on_a_rough_floor_and_a_smooth_wall_slips_where_statics_says_so(holds):
    """Moments about the place where its round foot touches: the wall pushes with L/2 sin(a) W / (L cos(a) + R), at most friction W."""
    friction = 0.4
    limit = math.atan(2 * friction) + math.asin(2 * friction * ROLLER / (0.5 * math.hypot(1, 2 * friction)))
    angle = limit + (-1e-6 if holds else 1e-6)
    foot, top = np.array([0.5 * math.sin(angle), ROLLER]), np.array([0.0, 0.5 * math.cos(angle) + ROLLER])
    room = [[-0.1, -0.2], [2.1, -0.2], [2.1, 2], [2, 2], [2, 0], [-ROLLER, 0], [-ROLLER, 2], [-0.1, 2]]
    turn = math.atan2(*(top - foot)[::-1])
    ladder = {"name": "ladder", "mass": 2.0, "rod": {"length": 0.5}, "at": foot.tolist(), "angle": turn}
    contacts = [
        {"name": "foot", "first": "ladder.start", "radius": ROLLER, "second": "block", "friction": friction},
        {"name": "top", "first": "ladder.end", "radius": ROLLER, "second": "block"},
    ]
    readings = {"x": {"x": "ladder.start"}, "y": {"y": "ladder.end"}}
    document = contact_document(room, [ladder], contacts, readings, {"foot_gap_1": 0.0, "top_gap_2": 0.0}, run=(0.2, 0.05))
    document["run"]["readings"] = ["contact.top.force"]
    run = gm.run(gm.Scene.from_dict(document))
    assert run.outcome is gm.Outcome.DONE
    assert (abs(run.readings["x"][-1] - run.readings["x"][0]) < 1e-12) == holds
    if holds:
        push = 2 * GRAVITY * 0.25 * math.sin(angle) / (0.5 * math.cos(angle) + ROLLER)
        assert run.readings["contact.top.force"][-1] == pytest.approx(push, rel=1e-9)


def rod_on_floor(friction, angle, turn_rate):
    """A rod that slides along a floor on its lower end, its mass centre behind, and turns."""
    rod = {"name": "rod", "mass": 1.0, "rod": {"length": 0.4}, "at": [0.0, 1e-3], "angle": angle}
    contact = {"name": "tip", "first": "rod.start", "radius": 1e-3, "second": "block", "friction": friction}
    start = {"tip_gap": 0.0, "tip_rate": 0.0, "x": 0.0, "x_rate": -1.0, "turn": angle, "turn_rate": turn_rate}
    readings = {"x": {"x": "rod.start"}, "turn": {"angle": "rod"}}
    document = contact_document(FLOOR, [rod], [contact], readings, start, run=(0.02, 0.01))
    return gm.Scene.from_dict(document)


@pytest.mark.parametrize("turn_rate", [0.0, 20.0], ids=["no motion", "two motions"])
@pytest.mark.parametrize(("friction", "jams"), [(1.2, False), (2.0, True)])
def test_a_rod_that_rubs_beyond_painleves_limit_ends_by_name(friction, jams, turn_rate):
    """A uniform rod at the angle a with its mass centre behind, jams where 1 + 3 cos(a) (cos(a) - friction sin(a)) < 0.

    Where its tip would rise without a force, as it turns fast, it may then go on sliding or leave the floor; else it can do neither.
    """
    angle = math.radians(45)
    run = gm.run(rod_on_floor(friction, angle, turn_rate))
    determinant = 1 + 3 * math.cos(angle) * (math.cos(angle) - friction * math.sin(angle))
    rise = 0.2 * turn_rate**2 * math.sin(angle) - GRAVITY
    assert (determinant < 0) == jams
    assert (run.outcome is gm.Outcome.STALLED) == jams
    assert ("friction jams" in run.detail) == jams
    if not jams:
        assert (run.readings["tip_gap"][-1] > 1e-4) == (rise > 0)


BEND_X, BEND_Y = 0.5 * math.sin(0.5), 0.5 * math.cos(0.5) - 0.5
TABLE_WITH_ROUND_EDGE = [
    *([-0.5, -0.4], [BEND_X + 0.3 * math.cos(0.5), -0.4], [BEND_X + 0.3 * math.cos(0.5), BEND_Y - 0.3 * math.sin(0.5)]),
    *([BEND_X, BEND_Y, 0.5], [0, 0], [-0.5, 0]),
]
"""A flat top that bends down smoothly at (0, 0)."""


def test_balls_on_one_block_that_rests_do_not_disturb_each_other():
    """One slides over the join of two edges while the other falls, strikes the top and stays there."""
    place, other = (-0.05, ROLLER), (-0.3, ROLLER + 1e-3)
    document = ball_document(TABLE_WITH_ROUND_EDGE, place, (0.5, 0.0), friction=0.1)
    document["body"].append({"name": "other", "mass": 1.0, "point": True, "at": list(other)})
    document["contact"].append({"name": "other", "first": "other.origin", "radius": ROLLER, "second": "block", "friction": 0.1})
    document["readings"] |= {"other_x": {"x": "other.origin"}, "other_y": {"y": "other.origin"}}
    document["start"] |= {"other_x": other[0], "other_y": other[1], "other_x_rate": 0, "other_y_rate": 0}
    document["run"] |= {"duration": 0.3}
    both = gm.run(gm.Scene.from_dict(document))
    alone = run_ball(TABLE_WITH_ROUND_EDGE, place, (0.5, 0.0), times=both.times, friction=0.1)
    assert both.readings["x"][-1] > 0.05
    for name in ("x", "y"):
        assert both.readings[name] == pytest.approx(alone.readings[name], abs=1e-10)
    assert events_of(both, EventKind.IMPACT) == pytest.approx([math.sqrt(2e-3 / GRAVITY)], rel=1e-9)
    assert (both.readings["other_x"][-1], both.readings["other_y"][-1]) == pytest.approx((-0.3, ROLLER), abs=1e-12)
