"""Mechanisms composed in Python: the documents of custom scene files, with first configurations that close."""

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.building.handles import BuiltRod
from governor_mechanism.scenes import library
from refusing import refusal

MAX_GAP = 1e-12
"""Largest difference of a position (m) or angle (rad) of order 1: the assembly closes joints to 1e-13 of the length scale."""

SIX_BAR = """
import governor_mechanism as gm

m = gm.Mechanism.build("Six-bar")
crank = m.rod("crank", length="100 mm", mass=1.0, angle="60 deg")
coupler = m.rod("coupler", length="300 mm", mass=2.0)
rocker = m.rod("rocker", length="250 mm", mass=2.0)
second = m.rod("second coupler", length="350 mm", mass=2.0)
ram = m.block("ram", mass=5.0)
m.pin(m.ground(0, 0), crank.start)
m.pin(crank.end, coupler.start)
m.pin(coupler.end, rocker.end, second.start)
m.pin(m.ground("300 mm", 0), rocker.start)
m.pin(second.end, ram.centre)
m.slider(m.ground(0, "100 mm"), ram.centre)
m.motor(crank, rate="90 rpm")
gm.film(gm.run(m.scene(duration="2 s")), "six_bar.gif")
"""


def circles_cross(first: tuple[float, float], radius: float, second: tuple[float, float], other_radius: float) -> list[complex]:
    """The two points at given distances from two others, left of the line from the first to the second at first."""
    p, q = complex(*first), complex(*second)
    distance = abs(q - p)
    along = (radius**2 - other_radius**2 + distance**2) / (2 * distance)
    across = math.sqrt(radius**2 - along**2)
    return [p + (q - p) / distance * complex(along, side) for side in (across, -across)]


def four_bar(lengths: tuple[float, ...] = (0.1, 0.3, 0.25, 0.3), **angles: Any) -> gm.MechanismBuilder:
    m = gm.Mechanism.build("Four-bar")
    crank, coupler, rocker = (
        m.rod(name, length=length, mass=1.0, angle=angles.get(name))
        for name, length in zip(("crank", "coupler", "rocker"), lengths, strict=False)
    )
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, coupler.start)
    m.pin(coupler.end, rocker.end)
    m.pin(m.ground(lengths[3], 0), rocker.start)
    return m


def ends(m: gm.MechanismBuilder) -> dict[str, complex]:
    """The end of each rod in the first configuration, from positions and angles of the document, SI."""
    bodies = {body["name"]: body for body in m.scene().document["body"]}
    return {
        name: complex(*body["at"]) + body["rod"]["length"] * np.exp(1j * (math.radians(60) if body["angle"] == "60 deg" else body["angle"]))
        for name, body in bodies.items()
    }


def test_a_six_bar_linkage_is_built_run_and_filmed_in_at_most_fifteen_statements(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = [line for line in SIX_BAR.splitlines() if line]
    assert len(lines) - 1 <= 15  # beside the import
    quick = SIX_BAR.replace('"2 s")', '"0.2 s")').replace('"six_bar.gif")', '"six_bar.gif", frames_per_second=1, size=320)')
    exec(compile(quick, "six_bar", "exec"), {})
    assert (tmp_path / "six_bar.gif").read_bytes().startswith(b"GIF89a")


def test_the_joints_close_as_the_circles_cross():
    """Of the two configurations the higher one is taken, unless further angles are nearer to the lower one."""
    crank_end = 0.1 * np.exp(1j * math.radians(60))
    upper, lower = circles_cross((crank_end.real, crank_end.imag), 0.3, (0.3, 0.0), 0.25)
    assert upper.imag > lower.imag
    assert abs(ends(four_bar(crank="60 deg"))["coupler"] - upper) < MAX_GAP
    crossed = four_bar(crank="60 deg", coupler="-50 deg", rocker="-120 deg")
    assert abs(ends(crossed)["coupler"] - lower) < MAX_GAP
    assert abs(ends(crossed)["crank"] - crank_end) < MAX_GAP
    assert crossed.scene().document["body"][0]["angle"] == "60 deg"  # as it was written


JANSEN_LENGTHS = {"b": 41.5, "c": 39.3, "d": 40.1, "e": 55.8, "f": 39.4, "g": 36.7, "h": 65.7, "i": 49.0, "j": 50.0, "k": 61.9, "m": 15.0}
"""Lengths of Jansen's leg, mm; the pivot of b and c lies at (-38, -7.8) from the crank."""


def apex(base: float, left: float, right: float) -> tuple[float, float]:
    """Third corner of a triangle whose base lies along x."""
    x = (base**2 + left**2 - right**2) / (2 * base)
    return x, math.sqrt(left**2 - x**2)


def jansen_leg(angles: dict[str, float], pen_mass: float | None) -> gm.MechanismBuilder:
    """The leg from its lengths, with its crank at 0 and further angles, deg; with a pen on its foot if that has a mass."""
    lengths = JANSEN_LENGTHS
    m = gm.Mechanism.build("Jansen leg")
    given = {name: f"{angle} deg" for name, angle in angles.items()}
    crank = m.rod("crank", length=f"{lengths['m']} mm", mass=0.1, angle=0.0)
    j, k, f, c, b, g = (m.rod(name, length=f"{lengths[name]} mm", mass=0.1, angle=given.get(name)) for name in "jkfcbg")
    left = b.point(*(f"{x} mm" for x in apex(lengths["b"], lengths["d"], lengths["e"])), "left")
    foot = g.point(*(f"{x} mm" for x in apex(lengths["g"], lengths["i"], lengths["h"])), "foot")
    m.pin(m.ground(0, 0), crank.start)
    m.pin(m.ground("-38 mm", "-7.8 mm"), b.start, c.start)
    m.pin(crank.end, j.start, k.start)
    m.pin(j.end, b.end)
    m.pin(left, f.start)
    m.pin(k.end, c.end, g.start)
    m.pin(f.end, g.end)
    if pen_mass is not None:
        m.pin(foot, m.point_mass("pen", mass=pen_mass).centre)
    return m


def jansen_configurations() -> list[dict[str, float]]:
    """Angles of b, c and g, rad, in all ways in which three pairs of circles cross."""
    lengths = JANSEN_LENGTHS
    crank_end, pivot, found = complex(lengths["m"], 0.0), complex(-38.0, -7.8), []

    def crossings(first: complex, radius: float, second: complex, other_radius: float) -> list[complex]:
        return circles_cross((first.real, first.imag), radius, (second.real, second.imag), other_radius)

    for upper in crossings(crank_end, lengths["j"], pivot, lengths["b"]):
        direction = (upper - pivot) / lengths["b"]
        left = pivot + direction * complex(*apex(lengths["b"], lengths["d"], lengths["e"]))
        for lower in crossings(crank_end, lengths["k"], pivot, lengths["c"]):
            for knee in crossings(left, lengths["f"], lower, lengths["g"]):
                found.append({name: float(np.angle(z)) for name, z in (("b", direction), ("c", lower - pivot), ("g", knee - lower))})
    return found


@pytest.mark.parametrize("angles", [{"c": -80, "b": 80, "g": 170}, {"c": -60, "b": 60, "g": 120}, {"c": 100, "b": -60, "g": -80}], ids=str)
@pytest.mark.parametrize("pen_mass", [None, 0.001])
def test_a_leg_closes_in_the_one_of_its_eight_ways_that_is_closest_to_the_given_angles(angles, pen_mass):
    def distance(one: dict[str, float]) -> float:
        return sum(math.remainder(one[name] - math.radians(angle), math.tau) ** 2 for name, angle in angles.items())

    configurations = jansen_configurations()
    closest = min(configurations, key=distance)
    assert len(configurations) == 8
    bodies = {body["name"]: body["angle"] for body in jansen_leg(angles, pen_mass).document()["body"] if body["name"] in angles}
    assert {name: math.remainder(angle - closest[name], math.tau) for name, angle in bodies.items()} == pytest.approx(
        dict.fromkeys(angles, 0.0), abs=1e3 * MAX_GAP
    )


def test_without_any_angle_the_joints_close_too():
    positions = ends(four_bar())
    assert abs(abs(positions["coupler"] - positions["crank"]) - 0.3) < MAX_GAP
    assert abs(positions["coupler"] - positions["rocker"]) < MAX_GAP
    assert positions["coupler"].imag > 0


def test_a_chain_without_loop_keeps_angles_of_zero():
    m = gm.Mechanism.build("Double pendulum")
    first, second = m.rod("first", length=1.0, mass=1.0), m.rod("second", length=1.0, mass=1.0)
    m.pin(m.ground(0.5, 0.25), first.start)
    m.pin(first.end, second.start)
    assert [(body["at"], body["angle"]) for body in m.scene().document["body"]] == [([0.5, 0.25], 0.0), ([1.5, 0.25], 0.0)]


@pytest.mark.parametrize("seed", range(4))
def test_a_linkage_that_was_drawn_closed_is_assembled_from_its_lengths(seed):
    """A Stephenson linkage of two loops between seven random points: only the angle of its crank is given."""
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, size=(7, 2)).tolist()
    pivot, crank_end, b, c, rocker_pivot, e, last_pivot = points
    m = gm.Mechanism.build("Stephenson linkage")
    angle = math.atan2(crank_end[1] - pivot[1], crank_end[0] - pivot[0])
    crank = m.rod("crank", length=math.dist(pivot, crank_end), mass=1.0, angle=angle)
    ternary = m.body("ternary", mass=1.0, inertia=0.1)
    b_on_ternary, c_on_ternary = (ternary.point(one[0] - crank_end[0], one[1] - crank_end[1]) for one in (b, c))
    rocker = m.rod("rocker", length=math.dist(rocker_pivot, b), mass=1.0)
    second, last = m.rod("second", length=math.dist(c, e), mass=1.0), m.rod("last", length=math.dist(last_pivot, e), mass=1.0)
    for first, other in ((crank.start, pivot), (rocker.start, rocker_pivot), (last.start, last_pivot)):
        m.pin(m.ground(*other), first)
    for first, other in ((crank.end, ternary.origin), (b_on_ternary, rocker.end), (c_on_ternary, second.start), (second.end, last.end)):
        m.pin(first, other)
    scene = m.scene()
    assert not any("open" in note for note in gm.run(scene, times=[0.0], certify=False).notes)  # the start needed no closing
    assert scene.document["body"][0]["angle"] == angle


def test_a_slider_crank_moves_by_the_formula():
    """x = r cos a + sqrt(l^2 - r^2 sin^2 a), and the motor goes on from the first configuration."""
    m = gm.Mechanism.build("Slider-crank")
    crank, rod = m.rod("crank", length="100 mm", mass="1 kg", angle="40 deg"), m.rod("rod", length="400 mm", mass="2 kg")
    piston = m.block("piston", mass="3 kg")
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, rod.start)
    m.pin(rod.end, piston.centre)
    m.slider(m.ground(0, 0), piston.centre)
    m.motor(crank, rate="60 rpm")
    m.reading("piston_x", x=piston.centre)
    run = gm.run(m.scene(duration="1 s", accuracy=1e-9), times=[0.0, 0.1, 0.35])
    angles = math.radians(40) + 2 * math.pi * run.times
    expected = 0.1 * np.cos(angles) + np.sqrt(0.4**2 - (0.1 * np.sin(angles)) ** 2)
    assert np.max(np.abs(run.readings["piston_x"] - expected)) < 1e-9  # the accuracy asked for, in lengths of 0.4 m


def test_a_shipped_machine_is_built_in_python():
    """The quick return of the file with another guess: equal bodies, joints and forces, and a configuration of the same angles."""
    shipped = library.load_scene("quick_return")
    m = gm.Mechanism.build(shipped.title)
    crank = m.disc("crank", radius="100 mm", mass="4 kg", angle=0.0)
    lever, ram = m.rod("lever", length="400 mm", mass="3 kg"), m.block("ram", mass="10 kg")
    pivot, shaft, guide = m.ground(0, 0, "pivot"), m.ground(0, "200 mm", "shaft"), m.ground(0, "420 mm", "guide")
    m.pin(pivot, lever.start)
    m.pin(shaft, crank.origin)
    m.slider(lever.start, crank.point("80 mm", 0, "pin"), name="slot")
    m.slider(guide, ram.centre, name="guide")
    m.motor(crank, rate="60 rpm", name="motor")
    m.link(lever.end, ram.centre, "160 mm", name="link")
    m.damper(guide, ram.centre, damping="200 N s/m", name="cut")
    m.reading("ram_position", x=ram.centre)
    m.reading("lever_angle", angle=lever)
    m.gravity()
    built = m.scene(duration="3 s", accuracy=1e-8)
    assert built.mechanism.bodies == shipped.mechanism.bodies
    assert built.mechanism.joints == shipped.mechanism.joints
    assert built.mechanism.force_elements == shipped.mechanism.force_elements
    assert built.mechanism.readings == shipped.mechanism.readings
    assert built.effects == shipped.effects
    angle, length = math.atan2(0.2, 0.08), math.hypot(0.2, 0.08)  # of the pin from the pivot
    assert built.mechanism.initial_guess[1][2] == pytest.approx(angle, abs=MAX_GAP)
    assert length < 0.4
    assert gm.Scene.from_dict(tomllib.loads(built.to_toml())) == built


def test_each_method_writes_the_table_of_a_scene_file():
    m = gm.Mechanism.build("All", plane="turning", size="1 m")
    a, b = m.rod("a", length=1.0, mass=1.0, angle=0.1, at=(0, 0)), m.plate("b", width=1.0, height=0.5, mass=2.0, at=(0, 1))
    c = m.body("c", mass=1.0, moments={"xx": 0.1}, centre=(0.1, 0), at=(0, 0))
    d, o = m.point_mass("d", mass=0.5, at=(0, 0)), m.ground([[0, 0], [1, "5 mm"]], 0)
    a.add_mass("2 kg", a.end, radius="10 mm")
    a.add_mass("2 kg", (0, 0.5))
    m.weld(a.end, b.origin, "5 deg")
    m.prismatic(a.start, b.centre, "90 deg", 0.0, name="guide")
    m.arc(o, d.centre, 0.5)
    m.curve(o, d.centre, coefficients=[0, 0, 5], angle="1 deg")
    m.curve(o, d.centre, points=[(0, 0), (1, 1)])
    m.gear(a, b.centre, -2.0, 0.0)
    m.rack(a, b, "20 mm", "3 deg")
    m.motor(b, motion=[[0, 0], [1, 1]], against=a)
    m.actuator(o, a.point(0.1, 0), rate="1 mm/s", start=0.0)
    m.spring(o, c.centre, stiffness="2 N/mm", free_length=0.1)
    m.torsion_spring(a, stiffness=1.0, against=b, name="coil")
    m.torsion_damper(a, damping=2.0)
    m.torque(a, [[0, 1], [1, 2]], against=b)
    m.force(c.centre, y={"reading": "x", "gain": 1.0})
    m.reading("x", x=c.centre, origin=o)
    m.reading("line", line=(o, a.end))
    m.reading("gap", distance=(o, a.end))
    m.reading("turn", angle=a, against=b)
    m.effect("dry_friction", {"x": "1 N"})
    m.spindle("60 rpm")
    m.start({"x": 0.1})
    m.event("pass", "x", "1 mm", "up")
    written = tomllib.loads(Path(__file__).with_name("every_table.toml").read_text(encoding="utf-8"))
    assert m._keys | m._lists | m._tables == written


def test_what_does_not_close_is_named_with_gap_and_direction():
    """The bars are 0.1 + 0.1 + 0.1 m long, and the pivots 0.5 m apart."""
    message = refusal(four_bar((0.1, 0.1, 0.1, 0.5)).scene)
    assert "joint 'pin of ground and rocker' stays open by 0.2 m" in message
    assert "its point on 'ground' is at [0.5, 0] m and its point on 'rocker' is at [0.3, 0] m, 180.0 deg from there" in message


def test_an_angle_that_the_mechanism_cannot_have_is_named():
    """With the crank at 180 deg the pivot of the rocker is 0.65 m from the end of the crank, and the bars reach 0.55 m."""
    message = refusal(four_bar((0.2, 0.3, 0.25, 0.45), crank="180 deg").scene)
    assert "cannot be assembled at the given angle of 'crank'" in message
    assert "stays open by 0.1 m" in message


WRONG_CALLS = [
    (lambda m, rod: m.rod("a", length=-1.0, mass=1.0), 'rod "a": length must be positive; found -1'),
    (lambda m, rod: m.rod("a", length=1.0, mass="1 m", angle=[]), 'rod "a": mass is a mass; "1 m" is a length'),
    (lambda m, rod: m.rod("a", length=1.0, mass="1 m", angle=[]), 'rod "a": angle is an angle; found []'),
    (lambda m, rod: m.rod([], length=1.0, mass=1.0), "name must be one line of text"),
    (lambda m, rod: m.rod("rod", length=1.0, mass=1.0), "there already is a body 'rod'; choose another name"),
    (lambda m, rod: m.rod("a", length=1.0, mass=1.0, at=3), 'rod "a": at must be [x, y]'),
    (lambda m, rod: m.disc("a", radius=None, mass=1.0), 'disc "a": radius is a length; found None'),
    (lambda m, rod: m.body("a", mass=1.0), 'body "a": inertia is missing'),
    (lambda m, rod: m.motor(rod, rate="fast"), 'motor: rate is an angular speed; "fast" has no number'),
    (lambda m, rod: m.motor(rod), "motor: rate or motion is missing"),
    (lambda m, rod: m.motor(rod, rate=1.0, name=[]), "motor: name must be"),
    (lambda m, rod: m.slider(m.ground(0, 0), rod.end, angle="10 mm", name="guide"), "slider 'guide': angle is an angle"),
    (
        lambda m, rod: m.curve(m.ground(0, 0), rod.end, points=[[0, 0], [1, "x"]]),
        'curve: points, point 2: y is a length; "x" has no number',
    ),
    (lambda m, rod: m.pin(rod.start, rod.end), 'pin: both ends are of "rod"'),
    (lambda m, rod: m.link(m.ground(0, 0), rod.end, length=0.0), "link: length must be positive"),
    (lambda m, rod: m.spring(m.ground(0, 0), rod.end, stiffness=-1.0), "spring: stiffness must"),
    (lambda m, rod: m.torque(rod, moment="3 N"), "torque: moment is a torque"),
    (lambda m, rod: m.force(rod.end), "force: x or y is missing"),
    (lambda m, rod: rod.point("mid", 0.1, 0.2), "the name of a point of body 'rod' must be one line of text"),
    (lambda m, rod: rod.point("middle", 0.1), "point of body 'rod': x is a length; \"middle\" has no number"),
    (lambda m, rod: rod.add_mass(1.0, at=3), "mass on body 'rod': at must be [x, y]"),
    (lambda m, rod: rod.add_mass(-1.0, at=[0, 0]), "mass on body 'rod': mass must"),
    (lambda m, rod: m.ground("x", 0), "ground point 'A': x is a length"),
    (lambda m, rod: m.ground([[0, 0], [1, "x"]], 0), "ground point 'A' x, point 2: displacement is a length"),
    (lambda m, rod: m.ground(0, 0, name=[]), "the name of a point of the ground must be one line of text"),
    (lambda m, rod: m.reading("two words", angle=rod), "letters, digits and _"),
    (lambda m, rod: m.reading("nothing"), "one of angle, line, distance, x and y"),
    (lambda m, rod: m.effect([], True), "key must be text; found []"),
    (lambda m, rod: m.event("a", "rod_angle", 1.0, direction="sideways"), 'direction must be "up" or "down"'),
    (lambda m, rod: gm.Mechanism.build("t", plane="round"), "plane must be 'fixed' or 'turning'; found \"round\""),
    (lambda m, rod: gm.Mechanism.build("t", size="big"), "size is a length"),
    (lambda m, rod: gm.Mechanism.build(3), "title must be text; found 3"),
]


@pytest.mark.parametrize(("call", "sentence"), WRONG_CALLS)
def test_a_mistake_is_refused_where_it_is_made(call, sentence):
    """The message names the method and its arguments, and nothing is added."""
    m = gm.Mechanism.build("Wrong")
    rod = m.rod("rod", length=1.0, mass=1.0)
    before = repr(m), repr(rod), repr(rod.table)
    assert sentence in refusal(call, m, rod)
    assert (repr(m), repr(rod), repr(rod.table)) == before


def test_what_holds_for_the_whole_is_refused_by_the_scene():
    assert "body is missing" in refusal(gm.Mechanism.build("Empty").scene)


def test_wrong_arguments_are_refused_in_sentences():
    m = gm.Mechanism.build("Wrong")
    rod, other = m.rod("rod", length=1.0, mass=1.0), BuiltRod("other", {}, lambda table: None)
    m.ground(0, 0, "O")
    m.reading("angle", angle=rod)
    for function, arguments, sentence in (
        (m.pin, (rod, rod.start), "pin takes points; found body 'rod', whose points are rod.start, rod.end"),
        (m.pin, (3, rod.start), "pin takes points, as crank.end"),
        (m.pin, (rod.end,), "two or more bodies"),
        (m.motor, ("rod",), "motor takes a body"),
        (rod.__getitem__, ("strat",), "Did you mean 'start'?"),
        (rod.point, (0.5, 0, "end"), "already has a point 'end'"),
        (rod.add_mass, (1.0, other.end), "needs a point of that body"),
        (rod.add_mass, (1.0, rod.centre), "follows from the masses"),
        (m.ground, (1, 0, "O"), "already has a point 'O'"),
        (lambda: m.reading("line", line=rod), (), "takes two points"),
        (m.start, (3,), "start takes values by reading"),
        (lambda: m.reading("angle", angle=rod), (), "choose another name"),
    ):
        assert sentence in refusal(function, *arguments)
    assert rod["end"] == rod.end
    assert repr(m) == "MechanismBuilder('Wrong'; body: rod)"
