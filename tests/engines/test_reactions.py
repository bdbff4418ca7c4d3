"""Joint reactions of pendulums, beams and redundant structures with known forces, and by Newton's laws."""

import math
from dataclasses import replace

import numpy as np
import pytest

import joint_mechanisms as cases
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.force_elements import Force
from governor_mechanism.model.joints import GROUND, Distance, Pin, Point, Slider
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes import library
from scene_parts import body_angle, body_point, ground_point, point_mass, rod_body, rotating_body, x_reading, y_reading

EVERY = [(MultibodyEngine(), 1e-10), (ImpulseEngine(), 1e-6), (ReducedEngine(), 1e-10)]
NAMES = [engine.name for engine, _ in EVERY]
ENGINES = pytest.mark.parametrize(("engine", "accuracy"), EVERY, ids=NAMES)
# Mechanisms with two degrees of freedom, or at a turning point of their coordinate: the reduced engine cannot run them.
NOT_REDUCED = pytest.mark.parametrize(("engine", "accuracy"), EVERY[:2], ids=NAMES[:2])
# Forces follow from poses and velocities by Newton's law and have their accuracy, relative to the largest force. Squares
# of speeds and large derivatives amplify errors, but the estimate is conservative by as much.
FOLLOWS = 1.0


def complex_force(run: Trajectory, name: str):
    """Return the force of a joint on its second body as complex numbers (n,)."""
    return run.reactions[name].force @ np.array([1.0, 1j])


# --- pendulums --------------------------------------------------------------------------------------------------------


def link_pendulum(*, by_pin: bool, swapped: bool = False, start: float = 1.9) -> Scene:
    """Return a mass at the end of a massless rod, on a link or as a lever on a pin; 0.7 m, 1.3 kg."""
    length, mass = 0.7, 1.3
    place = (length * math.sin(start), -length * math.cos(start))
    if by_pin:
        joint = Pin(name="rod", first=ground_point(), second=body_point("bob", y=length))
        body, reading = rotating_body("bob", mass, 0.0), body_angle("bob", "angle")
    else:
        joint = Distance(name="rod", first=ground_point(), second=body_point("bob"), length=length)
        body, reading = point_mass("bob", mass), x_reading("bob")
    if swapped:
        joint = replace(joint, first=joint.second, second=joint.first)
    return cases.make_scene(bodies=[body], joints=[joint], readings=[reading], sketch=[(*place, start if by_pin else 0.0)], size=length)


@ENGINES
@pytest.mark.parametrize("by_pin", [False, True], ids=["link", "pin"])
def test_rod_force_of_a_pendulum(engine, accuracy, by_pin):
    run = engine.run(link_pendulum(by_pin=by_pin), accuracy=accuracy)
    angle, rate = cases.released_pendulum(run.times, cases.GRAVITY / 0.7, 1.9)
    pull = 1.3 * (cases.GRAVITY * np.cos(angle) + 0.7 * rate**2)
    inward = 1j * np.exp(1j * angle)
    allowed = FOLLOWS * accuracy * np.max(np.abs(pull))
    # A massless rod or a frictionless pin has no transverse force.
    np.testing.assert_allclose(complex_force(run, "rod"), pull * inward, atol=allowed)
    np.testing.assert_allclose(run.reactions["rod"].magnitude, np.abs(pull), atol=allowed)
    np.testing.assert_allclose(run.reactions["rod"].moment, 0.0, atol=allowed * 0.7)
    assert run.reactions["rod"].determined.all()
    assert np.any(pull < 0)  # compression above the horizontal


@ENGINES
@pytest.mark.parametrize("by_pin", [False, True], ids=["link", "pin"])
def test_reaction_changes_sign_with_the_order_of_the_bodies(engine, accuracy, by_pin):
    runs = [engine.run(link_pendulum(by_pin=by_pin, swapped=swapped), accuracy=accuracy) for swapped in (False, True)]
    # The equations differ in order and sign only, so that the motions differ by rounding (times 1e3, its growth over a
    # second of oscillation).
    there, back = (complex_force(run, "rod") for run in runs)
    np.testing.assert_allclose(back, -there, atol=1e-12 * np.max(np.abs(there)))


@ENGINES
def test_pin_carries_the_weight_at_rest(engine, accuracy):
    scene = cases.pendulum_on_a_pin().scene
    run = engine.run(scene.with_changes(start=replace(scene.start, values={"rod": -math.pi / 2})), accuracy=accuracy)
    # At rest only the rounding of -pi/2 matters.
    np.testing.assert_allclose(run.reactions["hinge"].force, np.tile([0.0, 2.0 * cases.GRAVITY], (len(run.times), 1)), atol=1e-12)
    np.testing.assert_allclose(run.reactions["hinge"].moment, 0.0, atol=1e-12)


@ENGINES
def test_weld_carries_force_and_moment(engine, accuracy):
    one = cases.bent_pendulum()
    run = engine.run(one.scene, accuracy=accuracy)
    told = one.exact(run.times)
    (first, rate), (second, _) = told["first"], told["second"]
    # Angle and rate give the acceleration; lengths 0.5 m and 0.4 m, 2 kg and 1.5 kg, welded at 0.7 rad.
    tip = 0.5 + np.exp(0.7j) * 0.2
    moment = 2.0 * 0.25 + 1.5 * tip
    inertia = 2.0 * 0.5**2 / 3 + 1.5 * (0.4**2 / 12 + abs(tip) ** 2)
    bend = -cases.GRAVITY * (moment * np.exp(1j * first)).real / inertia
    acceleration = (1j * bend - rate**2) * tip * np.exp(1j * first)
    force = 1.5 * (acceleration + 1j * cases.GRAVITY)
    arm = 0.2 * np.exp(1j * second)  # from the weld to the mass centre of the second rod
    twist = 1.5 * 0.4**2 / 12 * bend + (arm.conj() * force).imag
    allowed = FOLLOWS * accuracy * np.max(np.abs(force))
    np.testing.assert_allclose(complex_force(run, "weld"), force, atol=allowed)
    np.testing.assert_allclose(run.reactions["weld"].moment, twist, atol=allowed * 0.4)
    assert run.reactions["weld"].determined.all()


@NOT_REDUCED
def test_prismatic_joint_has_a_normal_force_and_a_moment(engine, accuracy):
    one = cases.collar_on_a_turning_rod()
    run = engine.run(one.scene, accuracy=accuracy)
    told = one.exact(run.times)
    (turn, rate), (way, speed) = told["turn"], told["way"]
    offset = 0.06 + 0.09j  # mass centre of the collar from the guided point, along and across; 0.7 kg, 0.02 kg m2
    line = np.exp(1j * (turn + 0.3))
    place = way + offset
    # Angular momentum and the transverse acceleration of the rod: two equations for two unknowns.
    whole = 2.0 / 3 + 0.02 + 0.7 * np.abs(place) ** 2
    cross = -0.7 * offset.imag  # position x line direction, times mass
    right = -0.7 * 2 * place.real * speed * rate, 0.7 * place.real * rate**2
    bend = (right[0] - cross * right[1] / 0.7) / (whole - cross**2 / 0.7)
    growth = (right[1] - cross * bend) / 0.7
    acceleration = (growth + 2j * rate * speed + (1j * bend - rate**2) * place) * line
    force = 0.7 * acceleration
    twist = 0.02 * bend + ((offset * line).conj() * force).imag
    allowed = FOLLOWS * accuracy * np.max(np.abs(force))
    np.testing.assert_allclose((force / line).real, 0.0, atol=1e-9)  # no force along the line
    np.testing.assert_allclose(complex_force(run, "bore"), force, atol=allowed)
    np.testing.assert_allclose(run.reactions["bore"].moment, twist, atol=allowed)


# --- gears and racks --------------------------------------------------------------------------------------------------


@ENGINES
def test_gear_moments_have_the_gear_ratio(engine, accuracy):
    run = engine.run(cases.geared_wheels().scene, accuracy=accuracy)
    # 0.6 N m on the first wheel; 0.04 kg m2 and 0.3 kg m2, ratio -0.5.
    bend = 0.6 / (0.04 + 0.25 * 0.3)
    teeth = run.reactions["teeth"]
    # A constant moment: only rounding remains.
    np.testing.assert_allclose(teeth.moment, 0.3 * -0.5 * bend, rtol=1e-12)
    np.testing.assert_allclose(0.6 + 0.5 * teeth.moment, 0.04 * bend, rtol=1e-12)
    np.testing.assert_allclose(teeth.force, 0.0, atol=1e-12)
    assert all(reaction.determined.all() for reaction in run.reactions.values())


@pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=["multibody", "reduced"])
def test_rack_force_is_along_its_direction_and_the_guide_force_across(engine):
    run = engine.run(cases.falling_rack().scene, accuracy=1e-10)
    # 2 kg at 1.2 rad, a pinion of 0.03 kg m2 and 0.1 m.
    along, weight = np.exp(1.2j), 2.0 * cases.GRAVITY
    pull = weight * math.sin(1.2) * (1 - 1 / (1 + 0.03 / (2.0 * 0.1**2)))
    # A constant force: only rounding remains.
    np.testing.assert_allclose(complex_force(run, "teeth"), pull * along, rtol=1e-11)
    np.testing.assert_allclose(complex_force(run, "guide"), 1j * along * weight * math.cos(1.2), rtol=1e-11)


# --- beams ------------------------------------------------------------------------------------------------------------


def beam(*, speed: float = 0.0, load: float = 0.0) -> Scene:
    """A beam of 2 m and 10 kg on two level supports at -0.8 m and +0.6 m, with a bead of 3 kg that runs along it.

    A load (N) presses down at +0.9 m.
    """
    press = Force(name="load", point=body_point("beam", 0.9), x=InputFunction(), y=InputFunction(values=(-load,)))
    return cases.make_scene(
        bodies=[rod_body("beam", 10.0, 2.0), point_mass("bead", 3.0)],
        joints=[
            Slider(name="left", first=ground_point(), second=body_point("beam", -0.8), angle=0.0),
            Slider(name="right", first=ground_point(), second=body_point("beam", 0.6), angle=0.0),
            Slider(name="top", first=body_point("beam"), second=body_point("bead"), angle=0.0),
        ],
        readings=[x_reading("beam"), x_reading("bead", "bead_x")],
        sketch=[(0.0, 0.0, 0.0), (-0.4, 0.0, 0.0)],
        loads=[press] if load else [],
        rates={"bead_x": speed, "x": 0.0},
        size=2.0,
    )


@NOT_REDUCED
@pytest.mark.parametrize(("speed", "load"), [(0.0, 0.0), (0.0, 50.0), (0.7, 50.0)], ids=["rest", "load", "running"])
def test_beam_on_two_supports(engine, accuracy, speed, load):
    run = engine.run(beam(speed=speed, load=load), accuracy=accuracy)
    bead_at = -0.4 + speed * run.times
    # Moments about the left support: beam, bead, load.
    right = (10.0 * cases.GRAVITY * 0.8 + 3.0 * cases.GRAVITY * (bead_at + 0.8) + load * 1.7) / 1.4
    left = 13.0 * cases.GRAVITY + load - right
    for name, expected in (("left", left), ("right", right), ("top", np.full_like(left, 3.0 * cases.GRAVITY))):
        # All speeds are constant, so only rounding remains; the guide has no moment.
        np.testing.assert_allclose(run.reactions[name].force[:, 1], expected, rtol=1e-12)
        np.testing.assert_allclose(run.reactions[name].force[:, 0], 0.0, atol=1e-12)
        np.testing.assert_allclose(run.reactions[name].moment, 0.0, atol=1e-11)
        assert run.reactions[name].determined.all()
    assert run.mobility == 2


# --- redundant structures ---------------------------------------------------------------------------------------------

LINK, SPREAD = 0.5, (-0.3, 0.1, 0.4)


def table_on_links(count: int) -> cases.ExactCase:
    """Return a table of 4 kg hung on parallel links of 0.5 m, and a mass of 1 kg on a link below it."""
    start = 0.6
    down = LINK * math.sin(start), -LINK * math.cos(start)
    links = [
        Distance(name=f"link {k}", first=ground_point(x), second=body_point("table", x), length=LINK)
        for k, x in enumerate(SPREAD)
        if k < count
    ]
    hanger = Distance(name="hanger", first=body_point("table", 0.2), second=body_point("bob"), length=0.4)
    scene = cases.make_scene(
        bodies=[rotating_body("table", 4.0, 0.3), point_mass("bob", 1.0)],
        joints=[*links, hanger],
        readings=[x_reading("table"), y_reading("table"), x_reading("bob", "bob_x")],
        sketch=[(*down, 0.0), (down[0] + 0.2, down[1] - 0.4, 0.0)],
        size=LINK,
    )
    return cases.ExactCase(scene=scene, exact=lambda times: {})


@NOT_REDUCED
def test_third_parallel_link_keeps_the_motion_and_makes_three_forces_indeterminate(engine, accuracy):
    runs = [engine.run(table_on_links(count).scene, accuracy=accuracy) for count in (2, 3)]
    # Accuracy of each, m and rad.
    np.testing.assert_allclose(runs[0].poses, runs[1].poses, atol=2 * accuracy)
    two, three = (run.reactions for run in runs)
    assert all(reaction.determined.all() for reaction in two.values())
    assert [name for name, reaction in three.items() if reaction.determined.any()] == ["hanger"]
    assert len(three) == 4
    assert three["hanger"].determined.all()
    assert runs[0].mobility == runs[1].mobility == 2
    # The resultant of all links is determinate: force, and moment about the mass centre of the table.
    allowed = FOLLOWS * accuracy * np.max(two["link 0"].magnitude)
    for reactions in (two, three):
        links = [(reaction, SPREAD[int(name[-1])]) for name, reaction in reactions.items() if name != "hanger"]
        together = sum(reaction.force for reaction, _ in links)
        about = sum(x * reaction.force[:, 1] for reaction, x in links)
        if reactions is two:
            expected, expected_about = together, about
        np.testing.assert_allclose(together, expected, atol=allowed)
        np.testing.assert_allclose(about, expected_about, atol=allowed)
    np.testing.assert_allclose(two["hanger"].force, three["hanger"].force, atol=allowed)


def door(hinges: int) -> Scene:
    """Return a rod on one hinge or two on the same axis, with another rod hung from its end."""
    pins = [Pin(name=f"hinge {k}", first=ground_point(), second=body_point("door", -0.4)) for k in range(hinges)]
    return cases.make_scene(
        bodies=[rod_body("door", 2.0, 0.8), rod_body("tail", 1.0, 0.5)],
        joints=[*pins, Pin(name="knee", first=body_point("door", 0.4), second=body_point("tail", -0.25))],
        readings=[body_angle("door"), body_angle("tail")],
        sketch=[(0.4, 0.0, 0.0), (0.8, -0.25, -math.pi / 2)],
        size=0.8,
        duration=0.5,
        output_interval=0.05,
    )


@NOT_REDUCED
def test_door_on_two_hinges_moves_as_on_one(engine, accuracy):
    runs = [engine.run(door(hinges), accuracy=accuracy) for hinges in (1, 2)]
    np.testing.assert_allclose(runs[0].poses, runs[1].poses, atol=2 * accuracy)
    one, two = (run.reactions for run in runs)
    determined = {name: (reaction.determined.all(), reaction.determined.any()) for name, reaction in two.items()}
    assert determined == {"hinge 0": (False, False), "hinge 1": (False, False), "knee": (True, True)}
    assert all(reaction.determined.all() for reaction in one.values())
    allowed = FOLLOWS * accuracy * np.max(one["hinge 0"].magnitude)
    np.testing.assert_allclose(two["hinge 0"].force + two["hinge 1"].force, one["hinge 0"].force, atol=allowed)
    np.testing.assert_allclose(two["knee"].force, one["knee"].force, atol=allowed)


# --- Newton's laws ----------------------------------------------------------------------------------------------------


def loads_on(run: Trajectory, body: str):
    """Return force (n,) as complex numbers and moment (n,) about the mass centre of all joints on one body."""
    mechanism = run.scene.part.mechanism
    poses = run.poses[:, mechanism.body_index(body)]
    force, moment = np.zeros(len(run.times), dtype=complex), np.zeros(len(run.times))
    for joint in mechanism.joints:
        acting = complex_force(run, joint.name)
        for point, sign in ((joint.second, 1.0), (joint.first, -1.0)):
            if point.body == body:
                # The force on both bodies acts at the second point.
                arm = place_of(run, joint.second) - (poses[:, 0] + 1j * poses[:, 1])
                force += sign * acting
                moment += sign * ((arm.conj() * acting).imag + run.reactions[joint.name].moment)
    return force, moment


def place_of(run: Trajectory, point: Point):
    """Return the position of a point (n,) as complex numbers."""
    if point.body == GROUND:
        return np.full(len(run.times), complex(point.x, point.y))
    pose = run.poses[:, run.scene.part.mechanism.body_index(point.body)]
    return pose[:, 0] + 1j * pose[:, 1] + complex(point.x, point.y) * np.exp(1j * pose[:, 2])


@ENGINES
def test_forces_on_every_bar_of_the_chain_equal_mass_times_acceleration(engine, accuracy):
    scene = library.load_scene("four_bar_chain")
    times = np.linspace(0.0, 0.5, 51)
    run = engine.run(scene, times=times, accuracy=accuracy)
    angle, rate = run.readings["crank_angle"], run.rates["crank_angle"]
    # Bars of 1 m and 1 kg, three cranks in parallel and two couplers: J = 3/3 + 2, and the weight's moment 3/2 + 2.
    bend = -3.5 * scene.gravity * np.cos(angle) / 3.0
    end = (1j * bend - rate**2) * np.exp(1j * angle)  # acceleration of the cranks' ends
    allowed = FOLLOWS * accuracy * max(reaction.magnitude.max() for reaction in run.reactions.values())
    for name in ("first crank", "middle crank", "last crank", "first coupler", "second coupler"):
        force, moment = loads_on(run, name)
        crank = "crank" in name
        np.testing.assert_allclose(force - 1j * scene.gravity, end * (0.5 if crank else 1.0), atol=allowed)
        np.testing.assert_allclose(moment, bend / 12 if crank else 0.0 * bend, atol=allowed)
    # The ground carries the total weight less the inertia forces.
    held = sum(complex_force(run, joint) for joint in run.reactions if joint.startswith("pin of ground"))
    np.testing.assert_allclose(held, 5j * scene.gravity + 3.5 * end, atol=3 * allowed)
    assert all(reaction.determined.all() for reaction in run.reactions.values())


@NOT_REDUCED
def test_reaction_on_the_ground_as_second_body(engine, accuracy):
    scene = cases.make_scene(
        bodies=[point_mass("lamp", 2.0)],
        joints=[Distance(name="cord", first=body_point("lamp"), second=ground_point(0.0, 1.0), length=0.6)],
        readings=[y_reading("lamp"), x_reading("lamp")],
        sketch=[(0.0, 0.4, 0.0)],
    )
    run = engine.run(scene, accuracy=accuracy)
    # At rest the lamp pulls the ground, the second body, down by its weight.
    np.testing.assert_allclose(run.reactions["cord"].force, np.tile([0.0, -2.0 * cases.GRAVITY], (len(run.times), 1)), atol=1e-12)


# --- forces as readings -----------------------------------------------------------------------------------------------


def with_reactions(scene: Scene, *joints: str) -> Scene:
    """Return a scene whose run reports the forces of joints."""
    return scene.with_changes(run=replace(scene.run, readings=tuple(f"reaction.{name}" for name in joints)))


@ENGINES
def test_the_error_of_a_joint_force_lies_within_its_estimate(engine, accuracy):
    run = engine.run(with_reactions(link_pendulum(by_pin=True), "rod"), accuracy=accuracy)
    angle, rate = cases.released_pendulum(run.times, cases.GRAVITY / 0.7, 1.9)
    exact = 1.3 * (cases.GRAVITY * np.cos(angle) + 0.7 * rate**2) * 1j * np.exp(1j * angle)
    readings = {"x": exact.real, "y": exact.imag, "magnitude": np.abs(exact)}
    for component, values in readings.items():
        name = f"reaction.rod.{component}"
        assert run.units[name] == "N"
        assert np.max(np.abs(run.readings[name] - values)) <= run.reading_errors[name] + 1e-13 * run.scales[name]
        assert run.reading_errors[name] <= run.error_estimate * run.scales[name] * (1 + 1e-12)


@ENGINES
def test_a_weld_reports_its_moment_and_a_pin_none(engine, accuracy):
    run = engine.run(with_reactions(cases.bent_pendulum().scene, "weld", "hinge"), accuracy=accuracy)
    weld = [name.removeprefix("reaction.weld.") for name in run.readings if name.startswith("reaction.weld.")]
    pin = [name.removeprefix("reaction.hinge.") for name in run.readings if name.startswith("reaction.hinge.")]
    assert (weld, pin) == (["x", "y", "magnitude", "moment"], ["x", "y", "magnitude"])
    np.testing.assert_array_equal(run.readings["reaction.weld.moment"], run.reactions["weld"].moment)


def test_joint_forces_that_are_not_determined_or_not_there_are_refused():
    scene = door(2)
    with pytest.raises(MechanismError, match=r"'reaction\.hinge 0', a joint whose force rigid-body mechanics does not determine"):
        MultibodyEngine().run(with_reactions(scene, "hinge 0", "knee"), accuracy=1e-8)
    with pytest.raises(MechanismError, match=r"run\.readings names 'reaction\.kne': no joint 'kne'; .*Did you mean 'knee'"):
        with_reactions(scene, "kne")


def test_the_polar_plot_in_the_axes_of_a_pendulum_is_a_line_along_its_rod():
    run = MultibodyEngine().run(link_pendulum(by_pin=True), accuracy=1e-10)
    angle, rate = cases.released_pendulum(run.times, cases.GRAVITY / 0.7, 1.9)
    pull = 1.3 * (cases.GRAVITY * np.cos(angle) + 0.7 * rate**2)
    (panel,) = run.plot_reactions("rod", axes="body").axes
    across, along = next(line.get_xydata().T for line in panel.lines if len(line.get_xydata()) == len(run.times))
    np.testing.assert_allclose(across, 0.0, atol=1e-7)
    np.testing.assert_allclose(along, pull, atol=1e-7)


def test_a_polar_plot_refuses_what_it_cannot_draw():
    run = MultibodyEngine().run(door(2), accuracy=1e-8)
    for wrong, message in (
        ({"axes": "wheel"}, "axes of a polar plot must be one of plane, body; found 'wheel'"),
        ({"joints": ["hinge 0"]}, "a rigid model does not determine the force of 'hinge 0'"),
        ({"joints": ["kne"]}, "Did you mean 'knee'"),
    ):
        with pytest.raises(MechanismError, match=message):
            run.plot_reactions(*wrong.pop("joints", ["knee"]), **wrong)
