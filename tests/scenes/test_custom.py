"""A scene file with a mechanism of the user's own becomes the values it describes, or is refused in sentences."""

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from governor_mechanism.errors import MechanismError
from governor_mechanism.model import force_elements as forces
from governor_mechanism.model import joints
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.part import EQUILIBRIUM, FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import Harmonic, InputFunction, PrescribedMotion
from governor_mechanism.scenes import library
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.problems import Problem
from invalid_scenes.cases import BODY, SPINDLE, Case, body_with, custom_scene, each_case, force_table, joint_table, read_cases

# The rod is 100 mm long: its mass centre lies 50 mm from its start.
START, END = Point(body="crank", x=-0.05), Point(body="crank", x=0.05)
O = Point(body=GROUND)  # noqa: E741 - the name of the point in the scene


def scene(*more: str, **tables: str) -> Scene:
    return parse_scene_document(tomllib.loads(custom_scene(*more, **tables)))


def mechanism(*more: str, **tables: str) -> Mechanism:
    return scene(*more, **tables).part.mechanism


def body(*lines: str, mass: str | None = '"2 kg"') -> tuple[Body, tuple[float, float, float]]:
    """The only body of a scene and its pose."""
    found = mechanism(
        body=body_with(*lines, mass=mass), joint=joint_table("pin", ends=("ground.O", "crank.origin")), top='machine = "custom"\nsize = 1\n'
    )
    return found.bodies[0], found.initial_guess[0]


def problems_of(text: str) -> tuple[str, ...]:
    with pytest.raises(MechanismError) as caught:
        parse_scene_document(tomllib.loads(text), "own.toml")
    assert all(problem.startswith("own.toml: ") for problem in caught.value.problems)
    return tuple(problem.removeprefix("own.toml: ") for problem in caught.value.problems)


def test_the_smallest_scene() -> None:
    found = scene()
    assert (found.title, found.part.name, found.part.machine) == ("A crank", "mechanism", "custom")
    assert (found.part.plane, dict(found.part.dimensions)) == ("fixed", {})
    own = found.part.mechanism
    # 2 kg * (0.1 m)^2 / 12
    assert (own.bodies[0].name, own.bodies[0].mass, own.bodies[0].can_rotate) == ("crank", 2.0, True)
    assert own.bodies[0].second_moments.in_plane == pytest.approx((1 / 600, 0.0, 0.0), rel=1e-14)
    assert own.joints == (joints.Pin(name="A", first=O, second=START),)
    assert own.initial_guess == ((0.05, 0.0, 0.0),)
    assert own.length_scale == pytest.approx(0.1, rel=1e-14)
    assert own.readings == (BodyAngle(name="crank_angle", quantity="angle", body="crank"),)
    assert own.coordinate == "crank_angle"
    assert (own.limits, own.internal_outputs, own.force_elements) == ((), (), ())
    assert found.start.values == {}


@pytest.mark.parametrize(
    ("lines", "moments"),
    [
        (['inertia = "3 kg m^2"'], {"xx": 1.5, "yy": 1.5}),
        (["moments = { xx = 1, yy = 2, xy = -0.5, zz = 4 }"], {"xx": 1.0, "yy": 2.0, "xy": -0.5, "zz": 4.0}),
        # 2 kg * (0.4 m)^2 / 4, and 2 kg * (0.3 m)^2 / 12
        (['disc = { radius = "400 mm" }'], {"xx": 0.08, "yy": 0.08}),
        (['disc = { radius = "400 mm", thickness = "300 mm" }'], {"xx": 0.08, "yy": 0.08, "zz": 0.015}),
        # 2 kg * (0.6 m)^2 / 12 and 2 kg * (0.3 m)^2 / 12
        (['plate = { width = "600 mm", height = "300 mm" }'], {"xx": 0.06, "yy": 0.015}),
    ],
)
def test_how_the_mass_lies(lines: list[str], moments: dict[str, float]) -> None:
    found, pose = body(*lines)
    assert found.can_rotate
    got = {name: getattr(found.second_moments, name) for name in ("xx", "yy", "xy", "zz")}
    assert got == pytest.approx({"xx": 0.0, "yy": 0.0, "xy": 0.0, "zz": 0.0, **moments}, rel=1e-14)
    assert pose == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("lines", "mass", "centre", "moments"),
    [
        # The middle of the rod and the ball of 2 kg * (0.1 m)^2 / 5 are 0.1 m from their common mass centre.
        (
            ['mass = "2 kg"', 'rod = { length = "600 mm" }', 'point_masses = [{ mass = "2 kg", at = ["500 mm", 0], radius = "100 mm" }]'],
            4.0,
            (0.4, 0.0),
            {"xx": 0.06 + 2 * 2 * 0.1**2 + 0.004, "yy": 0.004, "xy": 0.0, "zz": 0.004},
        ),
        # 3 kg and 1 kg on a line of 0.4 m and 0.8 m: a reduced mass of 3/4 kg.
        (
            ["point_masses = [{ mass = 3, at = [0.1, 0] }, { mass = 1, at = [0.5, 0.8] }]"],
            4.0,
            (0.2, 0.2),
            {"xx": 0.75 * 0.4**2, "yy": 0.75 * 0.8**2, "xy": 0.75 * 0.4 * 0.8, "zz": 0.0},
        ),
        (['point_masses = [{ mass = "5 kg", at = ["300 mm", 0] }]'], 5.0, (0.3, 0.0), {"xx": 0.0, "yy": 0.0, "xy": 0.0, "zz": 0.0}),
        (["mass = 0"], 0.0, (0.0, 0.0), {"xx": 0.0, "yy": 0.0, "xy": 0.0, "zz": 0.0}),
    ],
)
def test_a_body_of_point_masses(lines: list[str], mass: float, centre: tuple[float, float], moments: dict[str, float]) -> None:
    found, pose = body(*lines, mass=None)
    assert (found.can_rotate, found.mass) == (True, mass)
    assert {name: getattr(found.second_moments, name) for name in moments} == pytest.approx(moments, rel=1e-13)
    assert pose == pytest.approx((*centre, 0.0), rel=1e-14)


@pytest.mark.parametrize("lines", [["point = true"], ["turns = false"]])
def test_a_body_that_never_turns_needs_no_inertia(lines: list[str]) -> None:
    found, _ = body(*lines)
    assert (found.can_rotate, found.second_moments) == (False, SecondMoments())


def test_the_sketch_holds_mass_centres() -> None:
    lines = ["inertia = 1", 'centre = ["30 mm", "40 mm"]', 'at = ["1 m", "2 m"]', 'angle = "90 deg"']
    _, pose = body(*lines, 'points = { A = ["10 mm", 0] }')
    # A quarter turn takes (30, 40) mm to (-40, 30) mm.
    assert pose == pytest.approx((0.96, 2.03, math.pi / 2), rel=1e-14)
    own = mechanism(body=body_with(*lines, 'points = { A = ["10 mm", 0] }'), joint=joint_table("pin", ends=("ground.O", "crank.A")))
    assert (own.joints[0].second.x, own.joints[0].second.y) == pytest.approx((-0.02, -0.04), rel=1e-14)
    # Between origin (-30, -40) mm and mass centre (0, 0); A lies nearer to both.
    assert own.length_scale == pytest.approx(0.05, rel=1e-14)


TWO = BODY + body_with('rod = { length = "200 mm" }', 'at = ["100 mm", 0]', 'angle = "0.5 rad"', name="rod")
# Where things stand: the crank lies along x, its end and the start of the rod at x = 100 mm.
ENDS = ("crank.end", "rod.start")
FIRST, SECOND = Point(body="crank", x=0.05), Point(body="rod", x=-0.1)
BETWEEN = {"name": "J", "first": FIRST, "second": SECOND}
BODIES = ("crank", "rod")
WOBBLE = Harmonic(amplitude=math.pi / 2, frequency=3 / (2 * math.pi), phase=0.5)
OF_BODIES = {"name": "J", "first": Point(body="crank"), "second": Point(body="rod")}


def steady(start: float, rate: float) -> PrescribedMotion:
    return PrescribedMotion(times=(0.0, 1.0), values=(start, start + rate))


@pytest.mark.parametrize(
    ("kind", "ends", "lines", "expected"),
    [
        ("pin", ENDS, "", joints.Pin(**BETWEEN)),
        ("weld", ENDS, "", joints.Weld(**BETWEEN, relative_angle=0.5)),
        ("weld", ENDS, 'turn = "1 rad"', joints.Weld(**BETWEEN, relative_angle=1.0)),
        ("prismatic", ENDS, 'angle = "2 rad"', joints.Prismatic(**BETWEEN, angle=2.0, relative_angle=0.5)),
        ("slider", ENDS, 'angle = "2 rad"', joints.Slider(**BETWEEN, angle=2.0)),
        ("arc", ENDS, 'radius = "70 mm"', joints.ArcSlot(**BETWEEN, radius=0.07)),
        (
            *("curve", ENDS, 'curve = { coefficients = ["10 mm", 0.5, 3, 0, 0, 7] }\nangle = 1'),
            joints.CurveSlot(**BETWEEN, angle=1.0, curve=PolynomialCurve(coefficients=(0.01, 0.5, 3.0, 0.0, 0.0, 7.0))),
        ),
        (
            *("curve", ENDS, 'curve = { points = [[0, 0], ["20 mm", 0.03]] }'),
            joints.CurveSlot(**BETWEEN, curve=SplineCurve(x=(0.0, 0.02), y=(0.0, 0.03))),
        ),
        ("gear", BODIES, 'ratio = -2\noffset = "1 rad"', joints.Gear(**OF_BODIES, ratio=-2.0, offset=1.0)),
        ("gear", BODIES, "ratio = 0.5", joints.Gear(**OF_BODIES, ratio=0.5, offset=0.5)),  # 0.5 rad - 0.5 * 0 rad
        (
            *("rack", ("crank", "rod.start"), 'radius = "20 mm"\noffset = "5 mm"\nangle = 1'),
            joints.RackAndPinion(**OF_BODIES | {"second": SECOND}, radius=0.02, angle=1.0, offset=0.005),
        ),
        ("driven_turn", BODIES, 'rate = "2 rad/s"', joints.RotationalDriver(**OF_BODIES, motion=steady(0.5, 2.0))),
        (
            *("driven_turn", ("crank", "rod.centre"), 'rate = "60 rpm"\nstart = 1'),
            joints.RotationalDriver(**OF_BODIES, motion=steady(1.0, 2 * math.pi)),
        ),
        (
            *("driven_turn", BODIES),
            'motion = { start = 1, rate = "60 rpm", harmonics = [{ amplitude = "90 deg", frequency = "3 rad/s", phase = 0.5 }] }',
            joints.RotationalDriver(**OF_BODIES, motion=replace(steady(1.0, 2 * math.pi), harmonics=(WOBBLE,))),
        ),
        (
            *("driven_slide", ENDS, "motion = [[0, 0], [2, '30 mm']]\nangle = 0"),
            joints.TranslationalDriver(**BETWEEN, angle=0.0, motion=PrescribedMotion(times=(0.0, 2.0), values=(0.0, 0.03))),
        ),
    ],
)
def test_each_type_of_joint(kind: str, ends: tuple[str, str], lines: str, expected: joints.Joint) -> None:
    own = mechanism(joint_table(kind, lines, name="J", ends=ends), body=TWO)
    assert own.joints[0] == joints.Pin(name="A", first=O, second=START)
    assert own.joints[1] == expected


def test_what_a_rack_and_a_driven_slide_take_from_the_sketch() -> None:
    turned = BODY + body_with("turns = false", 'at = ["80 mm", "60 mm"]', name="rod")
    turned = turned.replace('length = "100 mm" }', 'length = "100 mm" }\nangle = "90 deg"')
    rack = joint_table("rack", 'radius = "20 mm"', name="R", ends=("crank.start", "rod.centre"))
    slide = joint_table("driven_slide", "rate = 1", "angle = 0", name="S", ends=("crank.start", "rod.centre"))
    _, found, slid = mechanism(rack, slide, body=turned).joints
    assert isinstance(found, joints.RackAndPinion)
    assert isinstance(slid, joints.TranslationalDriver)
    # 80 mm along x, less 20 mm for each radian of a quarter turn.
    assert found.offset == pytest.approx(0.08 - 0.02 * math.pi / 2, rel=1e-13)
    # Along the crank, which points up: 60 mm.
    assert slid.motion.values == pytest.approx((0.06, 1.06), rel=1e-13)


def test_a_link_is_as_long_as_in_the_sketch() -> None:
    link = '[[link]]\nfirst = ["ground", "130 mm", "40 mm"]\nsecond = "crank.end"\n'
    end, above = END, Point(body=GROUND, x=0.13, y=0.04)
    found = mechanism(link).joints[1]
    assert isinstance(found, joints.Distance)
    assert (found.name, found.first, found.second) == ("link of ground and crank", above, end)
    assert found.length == pytest.approx(0.05, rel=1e-14)
    assert mechanism(link + 'length = "2 m"\n').joints[1].length == 2.0
    assert mechanism(link + 'length = "2 m"\n').length_scale == 2.0
    assert [joint.name for joint in mechanism(link, link).joints] == ["A", "link of ground and crank", "link of ground and crank 2"]


AT_END = ('first = "ground.O"', 'second = "crank.end"')


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            force_table("spring", *AT_END, 'stiffness = "2 N/mm"', "free_length = 0.1"),
            forces.Spring(name="load", first=O, second=END, stiffness=2000.0, free_length=0.1),
        ),
        (force_table("damper", *AT_END, 'damping = "120 N s/m"'), forces.Damper(name="load", first=O, second=END, damping=120.0)),
        (
            force_table("torsion_spring", 'second = "crank"', 'stiffness = "3 N m/rad"', 'free_angle = "1 rad"'),
            forces.TorsionSpring(name="load", second="crank", stiffness=3.0, free_angle=1.0),
        ),
        (
            force_table("torsion_damper", 'second = "crank"', 'damping = "0.5 N m s/rad"'),
            forces.TorsionDamper(name="load", second="crank", damping=0.5),
        ),
        (
            force_table("torque", 'body = "crank"', 'moment = "5 N m"'),
            forces.Torque(name="load", second="crank", moment=InputFunction(values=(5.0,))),
        ),
        (
            force_table("torque", 'body = "crank"', 'moment = [[0, 0], ["2 s", "6 N m"]]'),
            forces.Torque(name="load", second="crank", moment=InputFunction(times=(0.0, 2.0), values=(0.0, 6.0))),
        ),
        (
            force_table("force", 'point = "crank.end"', 'y = "-40 N"'),
            forces.Force(name="load", point=END, x=InputFunction(), y=InputFunction(values=(-40.0,))),
        ),
    ],
)
def test_each_type_of_force(text: str, expected: forces.ForceElement) -> None:
    assert mechanism(text).force_elements == (expected,)


def test_a_force_without_a_name_is_called_after_what_it_is_of() -> None:
    torque = '[[force]]\ntype = "torque"\nbody = "crank"\nmoment = 1\n'
    damper = '[[force]]\ntype = "torsion_damper"\nsecond = "crank"\ndamping = 1\n'
    names = [load.name for load in mechanism(torque, damper, torque).force_elements]
    assert names == ["torque of ground and crank", "torsion damper of ground and crank", "torque of ground and crank 2"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('angle = "crank"', BodyAngle(name="r", quantity="angle", body="crank")),
        ('angle = "rod", against = "crank"', BodyAngle(name="r", quantity="angle", body="rod", reference_body="crank")),
        ('line = ["ground.O", "crank.end"]', LineAngle(name="r", quantity="angle", start=O, end=END, zero=math.pi / 2)),
        ('x = "crank.end"', PointCoordinate(name="r", quantity="length", point=END, direction_x=1.0, direction_y=0.0)),
        (
            'y = "rod.start", from = "crank.end"',
            PointCoordinate(name="r", quantity="length", point=SECOND, direction_x=0.0, direction_y=1.0, origin=FIRST),
        ),
        ('distance = ["ground.O", "crank.end"]', PointDistance(name="r", quantity="length", first=O, second=END)),
    ],
)
def test_each_kind_of_reading(text: str, expected: Reading) -> None:
    own = mechanism(joint_table("pin", name="J", ends=ENDS), f"[readings]\nr = {{ {text} }}\n", body=TWO)
    assert own.readings == (expected,)


@pytest.mark.parametrize(("dx", "dy", "degrees"), [(1, 0, 0), (1, 1, 45), (1, -1, -45), (0, -1, -90), (-1, -1, -135)])
def test_a_line_leans_anticlockwise_from_x(dx: float, dy: float, degrees: float) -> None:
    (line,) = mechanism('[readings]\nr = { line = ["ground.O", "crank.end"] }\n').readings
    assert isinstance(line, LineAngle)
    # The definition of LineAngle: from the downward vertical, positive toward +x.
    assert math.degrees(math.atan2(dx, -dy) - line.zero) == pytest.approx(degrees, abs=1e-12)


def test_readings_left_out_tell_of_every_body() -> None:
    bodies = BODY + body_with("turns = false", name="cross head") + body_with("point = true", name="1st")
    ties = [joint_table("pin", name=name, ends=("ground.O", f"{name}.centre")) for name in ("cross head", "1st")]
    names = [reading.name for reading in mechanism(*ties, body=bodies).readings]
    assert names == ["crank_angle", "cross_head_x", "cross_head_y", "body_1st_x", "body_1st_y"]


def test_the_coordinate_is_what_the_start_names_first() -> None:
    readings = '[readings]\nx = { x = "crank.end" }\ny = { y = "crank.end" }\na = { angle = "crank" }\n'
    assert mechanism(readings).coordinate == "x"
    found = scene(readings, '[start]\na_rate = "2 rad/s"\ny = "10 mm"\n')
    assert found.part.mechanism.coordinate == "a"
    assert (found.start.values, found.start.rates) == ({"y": 0.01}, {"a": 2.0})
    assert scene(readings, '[start]\na = "equilibrium"\n').start.values == {"a": EQUILIBRIUM}


def test_rates_of_readings_that_begin_alike_are_told_apart() -> None:
    readings = '[readings]\nend_x = { x = "crank.end" }\nend_y = { y = "crank.end" }\n'
    assert scene(readings, '[start]\nend_y_rate = "10 mm/s"\n').start.rates == {"end_y": 0.01}


def test_a_run_ends_where_a_point_leaves_its_table() -> None:
    slot = joint_table("curve", "curve = { points = [[-0.1, 0], [0.2, 0.1]] }", "angle = 2", name="cam", ends=ENDS)
    own = mechanism(slot, body=TWO)
    (limit,), (way,) = own.limits, own.internal_outputs
    assert isinstance(way, PointCoordinate)
    assert (limit.reading, limit.low, limit.high) == (way.name, -0.1, 0.2)
    assert limit.low_message == "the point leaves the table of curve slot 'cam' at its first point"
    assert (way.point, way.origin) == (SECOND, FIRST)
    assert (way.direction_x, way.direction_y) == pytest.approx((math.cos(2.0), math.sin(2.0)), rel=1e-15)


def test_the_size_is_given_or_that_of_the_widest_body_or_of_the_sketch() -> None:
    assert mechanism(top='machine = "custom"\nsize = "3 m"\n').length_scale == 3.0
    bob = body_with("point = true", 'at = ["3 m", "4 m"]')
    assert mechanism(body=bob, joint=joint_table("slider", "angle = 0", ends=("ground.O", "crank.centre"))).length_scale == 5.0


def test_a_plane_turns_with_the_spindle_unless_it_is_fixed() -> None:
    assert scene(SPINDLE).part.plane == "turning"
    assert scene(SPINDLE, top='machine = "custom"\nplane = "fixed"\n').part.plane == "fixed"


def test_a_spindle_may_be_left_to_itself() -> None:
    text = '[spindle]\ninertia = "0.5 kg m^2"\nstart_speed = "60 rpm"\n'
    effects = "[effects]\ncentrifugal = true\n"
    free = scene(text, effects).spindle
    assert isinstance(free, FreeSpindle)
    assert (free.inertia, free.start_speed, free.torque) == (0.5, pytest.approx(2 * math.pi, rel=1e-15), InputFunction())
    driven = scene(text + 'torque = [[0, "1 N m"], [2, "3 N m"]]\n', effects).spindle
    assert isinstance(driven, FreeSpindle)
    assert driven.torque == InputFunction(times=(0.0, 2.0), values=(1.0, 3.0))


@each_case("custom")
def test_every_mistake_of_a_scene_is_found_at_its_key_and_told_with_its_cure(case: Case) -> None:
    with pytest.raises(MechanismError) as caught:
        parse_scene_document(tomllib.loads(case.text))
    assert [(problem.code, problem.key) for problem in map(Problem, caught.value.problems)] == case.mistakes
    assert set(case.messages) <= set(caught.value.problems)


def test_each_of_several_mistakes_is_told_once() -> None:
    assert len(problems_of(read_cases("custom")["several mistakes at once"].text)) == 5


@pytest.mark.parametrize("key", ["body", "joint", "link", "force", "ground", "readings", "start", "size", "plane"])
@pytest.mark.parametrize("junk", [None, 3, "text", [], [[]], [None], {}, {"a": 1}, {5: {}}, [{"name": [3]}], [{5: 6}]])
def test_junk_is_read_or_refused_in_sentences(key: str, junk: Any) -> None:
    nameless = '[[force]]\ntype = "torque"\nbody = "crank"\nmoment = 1\n'
    document = tomllib.loads(custom_scene(nameless)) | {key: junk}
    problems: tuple[str, ...] = ("own.toml: none",)
    try:
        parse_scene_document(document, "own.toml")
    except MechanismError as error:
        problems = error.problems
    assert problems
    assert all(problem.startswith("own.toml: ") for problem in problems)


OWN = {"andrews_squeezer": (7, 10, 2), "four_bar_chain": (5, 7, 0), "pendulum_iftomm": (1, 1, 0), "slider_crank_torque": (3, 4, 1)}


@pytest.mark.parametrize("name", OWN)
def test_the_shipped_mechanisms_have_their_parts(name: str) -> None:
    found = library.load_scene(name)
    own = found.part.mechanism
    assert (len(own.bodies), len(own.joints), len(own.force_elements)) == OWN[name]
    assert found.part.plane == "fixed"


def place(own: Mechanism, point: Point) -> tuple[float, float]:
    x, y, angle = (0.0, 0.0, 0.0) if point.body == GROUND else own.initial_guess[own.body_index(point.body)]
    cosine, sine = math.cos(angle), math.sin(angle)
    return x + cosine * point.x - sine * point.y, y + sine * point.x + cosine * point.y


@pytest.mark.parametrize("name", OWN)
def test_the_shipped_sketches_are_assembled(name: str) -> None:
    own = library.load_scene(name).part.mechanism
    for joint in own.joints:
        apart = math.dist(place(own, joint.first), place(own, joint.second))
        wanted = joint.length if isinstance(joint, joints.Distance) else 0.4 if isinstance(joint, joints.Slider) else 0.0
        # The published start of the squeezing mechanism closes to rounding.
        assert apart == pytest.approx(wanted, abs=1e-15)


def test_the_squeezing_mechanism_is_the_published_one() -> None:
    own = library.load_scene("andrews_squeezer").part.mechanism
    assert [body.mass for body in own.bodies] == [0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498]
    inertias = [2.194e-06, 4.41e-07, 5.255e-06, 5.667e-07, 1.169e-05, 5.667e-07, 1.912e-05]
    assert [body.second_moments.xx + body.second_moments.yy for body in own.bodies] == inertias
    angles = {
        "beta": -0.06171389001427645,
        "Theta": 0.0,
        "gamma": 0.45527981916307037,
        "Phi": 0.22266839016588588,
        "delta": 0.48736497954384256,
        "Omega": -0.22266839016588588,
        "epsilon": 1.2305474445498212,
    }
    turned = {"ground": 0.0} | {body.name: pose[2] for body, pose in zip(own.bodies, own.initial_guess, strict=True)}
    read = {item.name: turned[item.body] - turned[item.reference_body] for item in own.readings}  # type: ignore[attr-defined]
    # Sums of two published angles are rounded once.
    assert read == pytest.approx(angles, rel=1e-15, abs=1e-15)
    assert list(read) == list(angles)
    spring, motor = own.force_elements
    assert spring == forces.Spring(
        name="spring DC",
        first=Point(body="triangle BDE", x=0.02 - 0.01043, y=-0.018 + 0.01874),
        second=Point(body=GROUND, x=0.014, y=0.072),
        stiffness=4530.0,
        free_length=0.07785,
    )
    assert motor == forces.Torque(name="motor", second="crank OF", moment=InputFunction(values=(0.033,)))


def test_the_free_spindle_starts_as_in_its_reference() -> None:
    found = library.load_scene("porter_free_spindle")
    assert found.spindle == FreeSpindle(inertia=0.5, start_speed=13.29538574560537)
    assert found.start.values == {"arm_angle": 0.7781317007977319}
    assert found.part.start.rates == {"arm_angle": 0.15}
    assert found.part.dimensions == library.load_scene("porter").part.dimensions


@pytest.mark.parametrize("name", [*OWN, "porter_free_spindle"])
def test_a_shipped_mechanism_opens_with_a_comment_that_names_its_source(name: str) -> None:
    first = Path(library.shipped_scenes()[name]).read_text(encoding="utf-8").splitlines()[:3]
    assert first[0].startswith("#")
    assert any(word in " ".join(first) for word in ("IFToMM", "EXUDYN", "Test Set", "Zehnder"))
