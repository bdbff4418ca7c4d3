"""The drawing of Hartung's governor: in true proportions, the same shapes at every pose, springs that shorten."""

import math
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from drawing_checks import assert_shapes_keep
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.geometry.primitives import Lines, Polygon, bounding_box
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.style import ROLE_STYLES
from hartung_scenes import PAPER_DIMENSIONS, hartung_scene

HUNG = {**PAPER_DIMENSIONS, "hanger": 0.3, "lug_offset": 0.02}
EVERYTHING = (
    BellCrankMasses(mass=3.0, weight_width=0.12, weight_height=0.15),
    Stops(reading="lever_angle", low=-0.1, high=0.2, restitution=0.3),
    Dashpot(reading="sleeve_lift", linear=200.0),
    DryFriction(reading="sleeve_lift", force=InputFunction(values=(40.0,))),
    OutputSpring(reading="sleeve_lift", rate=500.0),
)
CASES: dict[str, tuple[dict[str, Any], tuple[Any, ...]]] = {
    "vertical": (PAPER_DIMENSIONS, ()),
    "hung": (HUNG, ()),
    "everything": ({**HUNG, "spring_rate": 33e3}, EVERYTHING),
}


@pytest.fixture(params=CASES)
def drawn(request: pytest.FixtureRequest) -> Any:
    dimensions, more = CASES[request.param]
    scene = hartung_scene(dimensions, speed=21.6, angle=0.12, rate=-0.6, more_effects=more, duration=1.0, output_interval=0.02)
    run = gm.run(scene, engine="multibody", accuracy=1e-5)
    return run, drawing_of(run, run.scene.part)


def test_shapes_keep_their_kinds_within_the_view_and_have_a_style(drawn: Any) -> None:
    run, drawing = drawn
    assert_shapes_keep(drawing, run)
    shapes = [*drawing.background_shapes(), *drawing.moving_shapes(run.poses[0], 0.0)]
    assert {shape.role for shape in shapes} <= set(ROLE_STYLES)


def test_springs_shorten_by_as_much_as_the_weights_move_out(drawn: Any) -> None:
    run, drawing = drawn
    lengths = []
    for pose in run.poses:
        (coil,) = (s for s in drawing.moving_shapes(pose, 0.0) if isinstance(s, Lines) and s.role == "coil")
        xs = [x for line in coil.lines for x, _ in line if x > 0]
        lengths.append(max(xs) - min(xs))
    # From the first strand's beginning to the last one's middle: (8 - 0.1 - 0.45) of 8 pitches.
    expected = -7.45 / 8 * np.diff(run.readings["weight_radius"])
    np.testing.assert_allclose(np.diff(lengths), expected, atol=1e-12)


def test_bell_cranks_keep_their_arms_and_hangers_their_length(drawn: Any) -> None:
    run, drawing = drawn
    dimensions = run.scene.part.dimensions
    for pose in run.poses[:: len(run.poses) // 5]:
        shapes = list(drawing.moving_shapes(pose, 0.0))
        bars = [shape for shape in shapes if isinstance(shape, Polygon) and shape.role == "arm"]
        found = sorted(round(length_of(one), 9) for one in bars)
        assert found == pytest.approx(sorted([0.115, 0.17] * 2), abs=1e-9)
        hangers = [shape for shape in shapes if isinstance(shape, Polygon) and shape.role == "link"]
        wanted = 1.5 * 0.115 if math.isinf(dimensions["hanger"]) else dimensions["hanger"]
        # As accurate as the run that is drawn.
        assert [length_of(one) for one in hangers] == pytest.approx([wanted, wanted], abs=1e-6)


def length_of(shape: Polygon) -> float:
    """Between the middles of a bar's round ends."""
    points = np.array(shape.points)
    half = len(points) // 2
    tip, tail = (points[k : k + half] for k in (0, half))
    ends = [0.5 * (piece[0] + piece[-1]) for piece in (tip, tail)]
    return float(np.hypot(*(ends[1] - ends[0])))


def test_vertical_hangers_stay_within_the_slot_of_the_sleeve() -> None:
    scene = hartung_scene({**PAPER_DIMENSIONS, "sleeve_arm": 0.4}, speed=21.6, angle=0.12, rate=-0.6, duration=0.5, output_interval=0.02)
    run = gm.run(scene, engine="multibody", accuracy=1e-5)
    drawing = drawing_of(run, run.scene.part)
    for pose, time in zip(run.poses, run.times, strict=True):
        shapes = list(drawing.moving_shapes(pose, float(time)))
        (slot,) = (shape for shape in shapes if isinstance(shape, Polygon) and shape.role == "slot")
        left, right, _, _ = bounding_box([slot])
        turn = PAPER_DIMENSIONS["bell_crank_angle"] + float(pose[0, 2])
        foot = abs(PAPER_DIMENSIONS["fulcrum_radius"] - 0.4 * math.sin(turn))
        assert left < -foot < foot < right


def test_the_walls_of_the_weights_hide_springs_and_cross_rod(drawn: Any) -> None:
    run, drawing = drawn
    roles = [shape.role for shape in drawing.moving_shapes(run.poses[0], 0.0)]
    assert max(roles.index("rod"), roles.index("coil"), roles.index("coil edge")) < roles.index("weight section")
    # The bore is open outward, and its edge is the inner wall, through which nothing shows.
    for bore, wall in zip(*([s for s in drawing.moving_shapes(run.poses[0], 0.0) if s.role == role] for role in SECTION), strict=True):
        assert {(round(x, 9), round(y, 9)) for x, y in bore.points} <= {(round(x, 9), round(y, 9)) for x, y in wall.points}


def test_the_outer_stops_are_fixed_to_brackets(drawn: Any) -> None:
    _, drawing = drawn
    still = list(drawing.background_shapes())
    frames = [bounding_box([shape]) for shape in still if shape.role == "frame"]
    for stop in (bounding_box([shape]) for shape in still if shape.role == "stop"):
        assert any(f[0] < stop[1] + 1e-9 and f[1] > stop[0] - 1e-9 and f[2] < stop[3] and f[3] > stop[2] for f in frames)


SECTION = ("weight bore", "weight section")
"""Roles of a bore and of the walls around it."""


def test_both_halves_are_drawn_alike(drawn: Any) -> None:
    run, drawing = drawn
    left, right, _, _ = bounding_box(s for s in drawing.moving_shapes(run.poses[0], 0.0) if s.role in ("ball", "rod"))
    assert left == pytest.approx(-right, abs=1e-12)


def test_the_plan_turns_with_the_spindle() -> None:
    run = gm.run(hartung_scene(PAPER_DIMENSIONS, duration=0.01), engine="multibody", accuracy=1e-5)
    pose = np.array(run.scene.part.mechanism.initial_guess)
    drawing = drawing_of(run, run.scene.part)
    upright, turned = (drawing.dial_shapes(pose, angle, 0.0, 0.3) for angle in (0.0, math.pi / 2))
    for before, after in zip(upright, turned, strict=True):
        if isinstance(before, Polygon) and isinstance(after, Polygon):
            found = np.array(before.points) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
            np.testing.assert_allclose(found, after.points, atol=1e-12)
