"""The drawing of Hartung's governor: in true proportions, the same shapes at every pose, springs that shorten."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.geometry.primitives import Lines, Polygon, bounding_box
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
CASES = {"vertical": (PAPER_DIMENSIONS, ()), "hung": (HUNG, ()), "everything": ({**HUNG, "spring_rate": 33e3}, EVERYTHING)}


def draw(dimensions, duration=1.0, **options):
    scene = hartung_scene(dimensions, speed=21.6, angle=0.12, rate=-0.6, duration=duration, output_interval=0.02, **options)
    return Drawn(gm.run(scene, engine="multibody", accuracy=1e-5))


@pytest.fixture(scope="module", params=CASES)
def drawn(request):
    dimensions, more = CASES[request.param]
    return draw(dimensions, more_effects=more)


def test_shapes_keep_their_kinds_within_the_view_and_have_a_style(drawn):
    assert_shapes_keep(drawn)
    assert drawn.roles() <= set(ROLE_STYLES)


def test_springs_shorten_by_as_much_as_the_weights_move_out(drawn):
    coils = [of_role(shapes, "coil", Lines) for shapes in drawn.moving]
    lengths = [np.ptp([x for line in coil.lines for x, _ in line if x > 0]) for (coil,) in coils]
    # From the first strand's beginning to the last one's middle: (8 - 0.1 - 0.45) of 8 pitches.
    np.testing.assert_allclose(np.diff(lengths), -7.45 / 8 * np.diff(drawn.run.readings["weight_radius"]), atol=1e-12)


def test_bell_cranks_keep_their_arms_and_hangers_their_length(drawn):
    hanger = drawn.run.scene.part.dimensions["hanger"]
    for shapes in drawn.moving[:: len(drawn.moving) // 5]:
        bars, hangers = ([length_of(one) for one in of_role(shapes, role, Polygon)] for role in ("arm", "link"))
        assert sorted(bars) == pytest.approx(sorted([0.115, 0.17] * 2), abs=1e-9)
        # As accurate as the run that is drawn.
        assert hangers == pytest.approx(2 * [1.5 * 0.115 if math.isinf(hanger) else hanger], abs=1e-6)


def length_of(shape):
    """Between the middles of a bar's round ends."""
    ends = [0.5 * (half[0] + half[-1]) for half in np.split(np.array(shape.points), 2)]
    return math.dist(*ends)


def test_vertical_hangers_stay_within_the_slot_of_the_sleeve():
    drawn = draw({**PAPER_DIMENSIONS, "sleeve_arm": 0.4}, duration=0.5)
    for pose, shapes in zip(drawn.run.poses, drawn.moving, strict=True):
        (slot,) = of_role(shapes, "slot", Polygon)
        left, right, _, _ = bounding_box([slot])
        turn = PAPER_DIMENSIONS["bell_crank_angle"] + float(pose[0, 2])
        foot = abs(PAPER_DIMENSIONS["fulcrum_radius"] - 0.4 * math.sin(turn))
        assert left < -foot < foot < right


def test_the_walls_of_the_weights_hide_springs_and_cross_rod(drawn):
    roles = [shape.role for shape in drawn.at(0)]
    assert max(roles.index("rod"), roles.index("coil"), roles.index("coil edge")) < roles.index("weight section")
    # The bore is open outward, and its edge is the inner wall, through which nothing shows.
    for bore, wall in zip(*(of_role(drawn.at(0), role) for role in ("weight bore", "weight section")), strict=True):
        assert {(round(x, 9), round(y, 9)) for x, y in bore.points} <= {(round(x, 9), round(y, 9)) for x, y in wall.points}


def test_the_outer_stops_are_fixed_to_brackets(drawn):
    frames, stops = ([bounding_box([shape]) for shape in of_role(drawn.still, role)] for role in ("frame", "stop"))
    for stop in stops:
        assert any(f[0] < stop[1] + 1e-9 and f[1] > stop[0] - 1e-9 and f[2] < stop[3] and f[3] > stop[2] for f in frames)


def test_both_halves_are_drawn_alike(drawn):
    left, right, _, _ = bounding_box(shape for shape in drawn.at(0) if shape.role in ("ball", "rod"))
    assert left == pytest.approx(-right, abs=1e-12)


def test_the_plan_turns_with_the_spindle():
    drawn = draw(PAPER_DIMENSIONS, duration=0.02)
    pose = np.array(drawn.run.scene.part.mechanism.initial_guess)
    upright, turned = (drawn.drawing.dial_shapes(pose, angle, 0.3) for angle in (0.0, math.pi / 2))
    for before, after in zip(upright, turned, strict=True):
        if isinstance(before, Polygon) and isinstance(after, Polygon):
            found = np.array(before.points) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
            np.testing.assert_allclose(found, after.points, atol=1e-12)
