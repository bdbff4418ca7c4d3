"""Moving points of the ground: scenes against equations of motion written out here and integrated by scipy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from data_files import read_data
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.parser import parse_scene_document

GRAVITY = 9.81
SCENES = read_data(__file__)
HUNG = (SCENES["LINKED"], SCENES["PINNED"])


def pivot(times, order):
    """Derivatives of the position x + iy of the pivot."""
    wave = 12.0**order * np.array([0.05 * np.sin(12 * times + (order + 1) * np.pi / 2), 0.03 * np.sin(12 * times + order * np.pi / 2)])
    line = [0.1 + 0.2 * times, np.full_like(times, 0.2), np.zeros_like(times)][order]
    return wave[0], wave[1] + line


@pytest.mark.parametrize("bodies", HUNG, ids=["link", "massless rod"])
def test_a_pendulum_on_a_moving_pivot(bodies):
    run = gm.run(parse_scene_document(SCENES["CIRCLING_PIVOT"] | bodies), engine="multibody", accuracy=1e-10)
    length, mass, start = 0.5, 2.0, -math.pi / 3

    def state_rate(time, state):
        """The angle is from the x axis: length * angle'' = -(g + y'') cos(angle) + x'' sin(angle)."""
        ax, ay = pivot(np.float64(time), 2)
        return [state[1], (ax * math.sin(state[0]) - (GRAVITY + ay) * math.cos(state[0])) / length]

    solution = solve_ivp(state_rate, (0, 2), (start, 0.5), method="DOP853", rtol=1e-13, atol=1e-13, t_eval=run.times)
    angle, rate = solution.y
    assert run.outcome is Outcome.DONE
    # The requested accuracy.
    np.testing.assert_allclose(run.readings["swing"], angle, atol=1e-10)
    np.testing.assert_allclose(run.readings["x"], pivot(run.times, 0)[0] + length * np.cos(angle), atol=1e-10)
    np.testing.assert_allclose(run.readings["pivot"], pivot(run.times, 0)[1], atol=1e-14)
    # The drivers carry the whole force on the bob; forces are as accurate as accelerations of about 100 m/s2.
    acceleration = np.array([state_rate(time, state)[1] for time, state in zip(run.times, solution.y.T, strict=True)])
    force = mass * (pivot(run.times, 2)[0] - length * (acceleration * np.sin(angle) + rate**2 * np.cos(angle)))
    np.testing.assert_allclose(run.reactions["x of ground.P"].force[:, 0], force, atol=1e-7)
    assert run.energy.drift < 1e-9


def test_a_massless_rod_strikes_a_stop_as_a_link_does():
    """An impact changes the speed of the bob alone: the rod adds no inertia, and the moving pivot keeps its speed."""
    effects = {"effects": {"gravity": True, "stops": {"swing": ["-80 deg", "none"], "restitution": 0.5}}}
    linked, pinned = (
        gm.run(parse_scene_document(SCENES["CIRCLING_PIVOT"] | bodies | effects), engine="multibody", accuracy=1e-10) for bodies in HUNG
    )
    impacts = [[event.time for event in run.events if event.kind == EventKind.IMPACT] for run in (linked, pinned)]
    assert len(impacts[0]) > 1
    np.testing.assert_allclose(impacts[0], impacts[1], rtol=0, atol=1e-9)  # the requested accuracy at about 0.1 rad/s
    np.testing.assert_allclose(linked.readings["swing"], pinned.readings["swing"], rtol=0, atol=1e-9)  # impacts double errors at most
    assert linked.energy.drift < 1e-9


def test_the_axle_of_the_shipped_model_matches_its_equations_of_motion():
    mass, length, stiffness, free_length = 80.0, 1.5, 1e5, 0.5
    run = gm.run("car_axis_like", accuracy=1e-10)

    def state_rate(time, state):
        """Height of the left end and angle of a uniform rod on two springs, by Lagrange's equations."""
        y, angle, _, rate = state
        sine, cosine, road = math.sin(angle), math.cos(angle), 0.04 * math.sin(3 * math.pi * time)
        dx, dy = length * (cosine - 1), y + length * sine - road
        left_force, right_force = stiffness * (y - free_length), stiffness * (1 - free_length / math.hypot(dx, dy))
        matrix = mass * np.array([[1, length / 2 * cosine], [length / 2 * cosine, length**2 / 3]])
        forces = [
            mass * length / 2 * rate**2 * sine - mass * GRAVITY - left_force - right_force * dy,
            -mass * GRAVITY * length / 2 * cosine - right_force * length * (dy * cosine - dx * sine),
        ]
        return [*state[2:], *np.linalg.solve(matrix, forces)]

    solution = solve_ivp(state_rate, (0, 3), (0.496, 0, 0, 0), method="DOP853", rtol=1e-13, atol=1e-14, t_eval=run.times)
    # The requested accuracy relative to the axle of 1.5 m, and the error of the integration by scipy.
    np.testing.assert_allclose(run.readings["left_height"], solution.y[0], atol=1e-9)
    np.testing.assert_allclose(run.readings["axle_angle"], solution.y[1], atol=1e-9)
    np.testing.assert_allclose(run.readings["right_height"], solution.y[0] + length * np.sin(solution.y[1]), atol=1e-9)
    # A moving point follows its motion as closely as joints close: to rounding of a length of 1.5 m over several projections.
    np.testing.assert_allclose(run.readings["road_height"], 0.04 * np.sin(3 * np.pi * run.times), atol=1e-14)


@pytest.mark.parametrize("engine", ["impulse", "reduced"])
def test_other_engines_refuse_a_moving_point_by_name(engine):
    with pytest.raises(gm.UnsupportedEffect, match=r"moving points of the ground: ground\.right_wheel|drives move this mechanism"):
        gm.run("car_axis_like", engine=engine)
