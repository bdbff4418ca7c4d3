"""Effects of a scene are drawn where and as they act; effects that it does not list are not drawn."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from decoding import assert_words_are_clear, boxes_of, paint_frames, painter_of
from drawing_checks import Drawn, assert_shapes_keep, assert_within, of_role
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Clearance, DryFriction, Stops
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.model.events import Event
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.geometry.primitives import Circle, Lines, bounding_box
from governor_mechanism.render.machines.pendulum import clearance_magnification
from governor_mechanism.render.machines.registry import drawing_of
from stub_effects import ListedEvents, fake_run_with_effects
from stub_machines import fake_machine_run
from stub_run import GOVERNOR_DIMENSIONS, fake_run

PORTER = GOVERNOR_DIMENSIONS["porter"]
FRICTION_FORCE = InputFunction(values=(40.0,))
RODS = RodMasses(arm_mass=0.6, link_mass=0.5, ball_radius=0.05)
ARM_STOPS = Stops(reading="arm_angle", low=math.radians(30), high=math.radians(49), restitution=0.3)
SLEEVE_STOPS = Stops(reading="sleeve_lift", low=0.05, high=0.22)
SHOES = {"shoe", "held shoe"}
LISTED = {
    "rods": ([RODS], {"rod"}),
    "light links": ([RodMasses(arm_mass=0.6)], set()),
    "spring over the sleeve": ([OutputSpring(reading="sleeve_lift", rate=2e3)], {"spring", "seat"}),
    "spring under the sleeve": ([OutputSpring(reading="sleeve_lift", rate=2e3, zero=0.3)], {"spring", "seat"}),
    "spring on the arms": ([OutputSpring(reading="arm_angle", rate=5.0)], {"spring"}),
    "spring between the balls": ([OutputSpring(reading="ball_radius", rate=500.0)], {"spring"}),
    "friction of the sleeve": ([DryFriction(reading="sleeve_lift", force=FRICTION_FORCE)], SHOES),
    "friction of the arms": ([DryFriction(reading="arm_angle", force=FRICTION_FORCE)], SHOES),
    "friction on the balls' radius": ([DryFriction(reading="ball_radius", force=FRICTION_FORCE)], SHOES),
    "dashpot": ([Dashpot(reading="sleeve_lift", linear=120.0)],
                {"dashpot", "bore", "oil", "wall", "piston", "piston rod"}),
    "rotary dampers": ([Dashpot(reading="arm_angle", linear=2.0)], {"drum", "damper"}),
    "stops of the arms": ([ARM_STOPS], {"bracket", "stop", "stop hatching", "burst"}),
    "one stop of the balls": ([Stops(reading="ball_radius", high=0.3)], {"bracket", "stop", "stop hatching", "burst"}),
    "stops of the sleeve": ([SLEEVE_STOPS], {"stop", "stop hatching", "burst"}),
    "clearance": ([Clearance(width=5e-4)], {"slot", "lens", "eyelet", "struck"}),
}  # fmt: skip
"""Effects, and the roles that only they add."""

EVERYTHING = [
    RodMasses(arm_mass=0.6, ball_radius=0.05), OutputSpring(reading="sleeve_lift", rate=2e3),
    *(DryFriction(reading=reading, force=FRICTION_FORCE) for reading in ("sleeve_lift", "arm_angle")),
    Dashpot(reading="sleeve_lift", linear=120.0), Dashpot(reading="arm_angle", linear=2.0),
    SLEEVE_STOPS, ARM_STOPS, Clearance(width=5e-4),
]  # fmt: skip


def draw(effects, events=(), duration=1.0, **options):
    """Return the drawing of a Porter governor with effects, which swings."""
    return Drawn(fake_run_with_effects(PORTER, effects, events, duration=duration, **options))


@pytest.mark.parametrize("name", LISTED)
def test_only_listed_effects_are_drawn(name):
    effects, expected_roles = LISTED[name]
    bare, shown = draw([]).roles(), draw(effects).roles()
    assert {role for role in shown - bare if not role.endswith(" key")} == expected_roles
    assert bare - shown == ({"link"} if "rod" in expected_roles else set())


CASES = ("porter", "crossed", "extended", "uncrossed links")


@pytest.mark.parametrize(("name", "case"), [*itertools.product(["all"], CASES), *zip(LISTED, itertools.cycle(CASES), strict=False)])
def test_all_shapes_stay_within_the_view_and_keep_their_types(case, name):
    effects = EVERYTHING if name == "all" else LISTED[name][0]
    impacts = [Event(time=0.3, kind="strikes its stop", subject=each.reading) for each in effects
             if isinstance(each, Stops)]  # fmt: skip
    motion = {"duration": 1.0, "output_interval": 0.05, "mean_angle": 35.0, "amplitude": 8.0}
    assert_shapes_keep(Drawn(fake_run_with_effects(GOVERNOR_DIMENSIONS[case], effects, impacts, **motion)))


def test_no_texts_overlap_with_every_effect_in_the_frame():
    picture = painter_of(draw(EVERYTHING, output_interval=0.05).run, 26)
    picture.update(25)
    boxes = boxes_of(picture.figure)
    assert any(words.startswith("clearance, ") for words, _ in boxes)
    assert_words_are_clear(boxes)


def test_a_ball_on_a_heavy_arm_is_drawn_at_the_arms_end_and_in_its_own_size():
    drawn, bare = draw([RODS]), fake_run(PORTER, duration=1.0)
    assert not np.allclose(drawn.run.poses[7, 0, :2], bare.poses[7, 0, :2], atol=1e-3)  # the mass centres differ
    _, ball, *_ = balls = of_role(drawn.at(7), "ball")
    assert (ball.x, ball.y) == pytest.approx(tuple(bare.poses[7, 0, :2]), abs=1e-12)
    assert {one.radius for one in balls} == {0.05}
    mark = of_role(drawn.drawing.dial_shapes(drawn.run.poses[7], 0.0, 1.0), "mark")[0]
    assert mark.x == pytest.approx(bare.poses[7, 0, 0], abs=1e-12)


def test_links_with_mass_are_centred_on_their_bodies():
    drawn = draw([RODS])
    for k in (0, 50):
        for rod, body in zip(of_role(drawn.at(k), "rod"), drawn.run.poses[k, [4, 3]], strict=True):
            x0, x1, y0, y1 = bounding_box([rod])
            assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx(tuple(body[:2]), abs=1e-9)


def test_a_shoe_is_coloured_while_it_sticks():
    told = [(0.3, "sticks", "sleeve_lift"), (0.4, "sticks", "arm_angle"), (0.6, "slips", "sleeve_lift")]
    events = [Event(time=time, kind=kind, subject=subject) for time, kind, subject in told]
    drawn = draw([DryFriction(reading="sleeve_lift", force=FRICTION_FORCE)], events)
    for shapes, time in zip(drawn.moving, drawn.run.times, strict=True):
        held = 0.3 <= time < 0.6
        assert all(bool(shoe.points) == held for shoe in of_role(shapes, "held shoe"))
        assert all(bool(shoe.points) != held for shoe in of_role(shapes, "shoe"))


@pytest.mark.parametrize(("swing", "events", "held"), [
    (8.0, [], False),
    (0.0, [], True),
    (8.0, [Event(time=0.6, kind="slips", subject="sleeve_lift")], True),
])  # fmt: skip
def test_the_initial_hold_follows_from_motion_and_events(swing, events, held):
    friction = [DryFriction(reading="sleeve_lift", force=FRICTION_FORCE)]
    assert draw(friction, events, amplitude=swing).drawing.is_held("sleeve_lift", 0.1) == held


@pytest.mark.parametrize(("zero", "sign"), [(0.0, -1), (0.3, 1)])
def test_a_spring_over_the_sleeve_is_shortened_by_the_lift_and_one_under_it_lengthened(zero, sign):
    drawn = draw([OutputSpring(reading="sleeve_lift", rate=2e3, zero=zero)], duration=2.0)
    long = [np.ptp(bounding_box(of_role(shapes, "spring"))[2:]) for shapes in drawn.moving]
    np.testing.assert_allclose(np.diff(long), sign * np.diff(drawn.run.readings["sleeve_lift"]), atol=1e-9)
    assert min(long) > 0.02


def test_the_piston_stays_in_its_cylinder_and_moves_with_the_sleeve():
    drawn = draw([Dashpot(reading="sleeve_lift", linear=120.0)], duration=2.0)
    pistons = [of_role(shapes, "piston") for shapes in drawn.moving]
    assert_within(itertools.chain(*pistons), bounding_box(of_role(drawn.still, "bore")))
    bottoms = [bounding_box(one)[2] for one in pistons]
    np.testing.assert_allclose(np.diff(bottoms), np.diff(drawn.run.readings["sleeve_lift"]), atol=1e-12)


def test_the_arms_meet_their_blocks_at_the_angles_of_the_stops():
    blocks = of_role(draw([ARM_STOPS]).still, "stop")
    assert len(blocks) == 4
    half = 0.058 * 0.3 / 2
    distances = []
    for block, angle in zip(blocks[2:], (ARM_STOPS.low, ARM_STOPS.high), strict=True):
        # Distance of each corner from the centre line of the arm, positive toward larger angles.
        distances.append([(x - 0.04) * math.cos(angle) + y * math.sin(angle) for x, y in block.points])
    assert max(distances[0]) == pytest.approx(-half)
    assert min(distances[1]) == pytest.approx(half)


def test_the_sleeve_meets_its_collars_at_its_stops():
    drawn = draw([SLEEVE_STOPS], duration=2.0)
    blocks = [bounding_box([block]) for block in of_role(drawn.still, "stop")]
    top = max(high for _, _, _, high in blocks if high < -0.5)
    base = min(low for _, _, low, _ in blocks if low > -0.5)
    for k in (0, 90):
        _, _, low, high = bounding_box(of_role(drawn.at(k), "sleeve")[-1:])
        lift = drawn.run.readings["sleeve_lift"][k]
        assert low - top == pytest.approx(lift - SLEEVE_STOPS.low)
        assert base - high == pytest.approx(SLEEVE_STOPS.high - lift)


def test_impacts_flash_at_their_stop():
    impact = Event(time=0.425, kind="strikes its stop", subject="arm_angle")  # the swing is highest there
    drawn = draw([ARM_STOPS], [impact])
    bursts = [of_role(shapes, "burst", Lines) for shapes in drawn.moving]
    assert [bool(rays.lines) for (rays,) in bursts] == [0.425 <= time < 0.675 for time in drawn.run.times]
    x0, x1, y0, y1 = bounding_box(of_role(drawn.still, "stop")[3:4])
    assert any(x0 - 0.03 < x < x1 + 0.03 and y0 - 0.03 < y < y1 + 0.03 for line in bursts[45][0].lines for x, y in line)


def test_a_slowed_film_flashes_for_the_same_film_time():
    impact = Event(time=0.1, kind="strikes its stop", subject="arm_angle")
    run = fake_run_with_effects(PORTER, [ARM_STOPS], [impact], duration=1.0)
    drawing = drawing_of(run, run.scene.part, slow_down=10.0)
    assert drawing.struck_side("arm_angle", 0.12)
    assert not drawing.struck_side("arm_angle", 0.13)


def test_the_clearance_is_drawn_with_the_stated_magnification():
    drawn = draw([Clearance(width=5e-4)])
    magnification = clearance_magnification(drawn.drawing)
    assert magnification == 100.0  # the roundest that draws 0.5 mm as at most 72 mm, 0.24 of the arm
    eyes = np.array([of_role(shapes, "eyelet")[0].y for shapes in drawn.moving])
    # A sleeve high in its clearance has the eye low in its slot.
    np.testing.assert_allclose(eyes - eyes.mean(), -magnification * drawn.run.readings["sleeve_clearance"], atol=1e-4)
    slot, radius = of_role(drawn.at(0), "slot")[-1], of_role(drawn.at(0), "eyelet")[0].radius
    ends = eyes.min() - radius, eyes.max() + radius  # the samples miss the exact ones
    assert bounding_box([slot])[2:] == pytest.approx(ends, abs=2e-5)


def test_an_eye_flashes_at_an_impact():
    impact = Event(time=0.5, kind="strikes its stop", subject="sleeve_clearance")
    drawn = draw([Clearance(width=5e-4)], [impact])
    flashes = [of_role(shapes, "struck", Circle) for shapes in drawn.moving]
    assert [flash.radius > 0 for (flash,) in flashes] == [0.5 <= time < 0.75 for time in drawn.run.times]


def along(run, effects, events=()):
    """Return a run whose last body's x coordinate is a reading, with these effects."""
    part = run.scene.part
    body = part.mechanism.bodies[-1].name
    displacement = PointCoordinate(name="displacement", quantity="length", point=Point(body=body), direction_x=1.0, direction_y=0.0)
    mechanism = dataclasses.replace(part.mechanism, readings=(*part.mechanism.readings, displacement))
    scene = run.scene.with_changes(mechanism=mechanism, effects=(*run.scene.effects, *effects))
    readings = dict(run.readings) | {"displacement": run.poses[:, -1, 0]}
    return dataclasses.replace(run, scene=scene, readings=readings, deferred_results=ListedEvents(tuple(events)))


def test_effects_on_a_point_coordinate_are_drawn_for_any_mechanism():
    bare = fake_machine_run("slider-crank", count=101)
    low, high = float(bare.poses[:, -1, 0].min()), float(bare.poses[:, -1, 0].max())
    effects = [
        *(Stops(reading="displacement", low=low, high=high), DryFriction(reading="displacement", force=FRICTION_FORCE)),
        *(Dashpot(reading=reading, linear=1.0) for reading in ("displacement", "turn_of_crank")),
        OutputSpring(reading="displacement", rate=1.0),
    ]
    run = along(bare, effects, [Event(time=0.0, kind="strikes its stop", subject="displacement")])
    drawn = Drawn(run)
    assert drawn.roles() - Drawn(bare).roles() == {"shoe", "held shoe", "burst", "damper"}
    assert_shapes_keep(drawn)
    # The walls are fixed, although they are drawn from the moving point.
    first, last = (np.array(of_role(drawn.at(k), "wall")[0].lines[0]) for k in (0, 30))
    np.testing.assert_allclose(first, last, atol=1e-12)
    assert len(paint_frames(run)[0]) == 480
