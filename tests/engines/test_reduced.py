"""The reduced engine against multibody, against its own tables' independent witness, and at the ends of its way."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.kinematics.constraint_equations import RowEvaluation, constraint_equations_of
from governor_mechanism.mechanics.kinematics.output_variables import make_output_rows
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction, TableColumn
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.table import ON_TABLE, find_piece
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import Distance, Pin, Slider
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.interpolation import CHEBYSHEV_NODES, N_CHEBYSHEV_NODES, evaluate_piece, fit_piece, quintic_hermite
from governor_mechanism.scenes.library import shipped_scenes
from governor_scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene, random_governor
from joint_mechanisms import make_scene
from one_coordinate_reference import integrate_one_coordinate
from scene_parts import body_angle, body_point, ground_point, point_mass, rod_body, rotating_body, x_reading, y_reading

AGREEMENT_TOLERANCE = 1e-10
"""Allowed difference, in scales, of two engines of order 8 that are each run with a tenth of it."""


def agree(one: gm.Trajectory, two: gm.Trajectory, allowed: float = AGREEMENT_TOLERANCE) -> None:
    """Assert that two runs of one scene have the same readings, rates, poses, energies and events, each in its scale."""
    assert one.outcome is two.outcome, (one.message, two.message)
    np.testing.assert_allclose(one.times, two.times, rtol=4e-16, atol=0)  # a breakpoint may replace a time
    scene, second = one.scene, time_scale(one.scene)
    # Near an event one run may be before it and the other after: only its time is certified.
    event_times = [
        event.time for event in (*one.events, *two.events) if event.kind not in (EventKind.TURNING_POINT, EventKind.CHANGE_POINT)
    ]
    is_compared = np.full(len(one.times), True)
    for time in event_times:
        is_compared &= np.abs(one.times - time) > 1e-8 * second
    for name, values in one.readings.items():
        atol = allowed * one.scales[name]
        np.testing.assert_allclose(values[is_compared], two.readings[name][is_compared], atol=atol, rtol=0)
    for name, rates in one.rates.items():
        there = two.rates[name][is_compared]
        np.testing.assert_allclose(rates[is_compared], there, atol=allowed * one.scales[f"rate of {name}"], rtol=0)
    units = np.array([scene.part.mechanism.length_scale] * 2 + [1.0])
    assert np.max(np.abs(one.poses - two.poses)[is_compared] / units, initial=0.0) < allowed
    for name in ("kinetic", "potential", "rotation", "dissipated_energy"):
        off = np.abs(getattr(one.energy, name) - getattr(two.energy, name))[is_compared]
        assert np.max(off, initial=0.0) < allowed * one.energy.scale, name
    recorded, other = ([event for event in run.events if event.time in event_times] for run in (one, two))
    assert [(event.kind, event.subject) for event in recorded] == [(event.kind, event.subject) for event in other]
    # A slow zero crossing magnifies the error, up to its square root where friction just holds.
    np.testing.assert_allclose([e.time for e in recorded], [e.time for e in other], atol=1e-9 * max(1.0, second))


def both(scene, accuracy: float = 1e-11, **options) -> tuple[gm.Trajectory, gm.Trajectory]:
    """Run the scene with the reduced and the multibody engine."""
    reduced, multibody = (engine().run(scene, accuracy=accuracy, **options) for engine in (ReducedEngine, MultibodyEngine))
    return reduced, multibody


# --- against multibody ------------------------------------------------------------------------------------------------


# Scenes of several parts have tests of their own; at a change point one coordinate does not determine the motion, see the separate test.
OTHERS = ("governed_engine", "watt_engine", "stephenson_reversing", "four_bar_chain")
MODELS = [name for name in shipped_scenes() if not name.startswith(OTHERS)]
# A crank that accelerates, and sliding that just comes to rest, amplify rounding: their tolerance is larger.
SPECIAL_ACCURACY = {"slider_crank_torque": 1e-10, "porter_dry_friction": 1e-8, "watt_improved": 1e-10}


@pytest.mark.parametrize("name", MODELS)
def test_every_shipped_scene_is_refused_or_agrees_with_multibody(name):
    scene = gm.load(name)
    if refusal := ReducedEngine().refusal(scene):
        with pytest.raises(UnsupportedEffect, match="engine 'reduced'") as refused:
            gm.run(scene, engine="reduced")
        assert str(refused.value) == refusal
        return
    reduced, multibody = both(scene, SPECIAL_ACCURACY.get(name, 1e-11))
    assert reduced.outcome is gm.Outcome.DONE, reduced.message
    agree(reduced, multibody)


PROGRAMS = {
    "smooth": Spindle(times=(0.0, 0.3, 0.7, 1.5), speeds=(1.0, 1.03, 0.99, 1.05)),
    "step": Spindle(times=(0.0, 0.237, 0.237, 1.0), speeds=(1.0, 1.0, 1.05, 1.05)),
    "ramp": Spindle(times=(0.2, 0.9), speeds=(0.99, 1.06)),
    "uneven": Spindle(speeds=(1.0,), speed_fluctuation=0.1, cycles_per_turn=2.0),
    "uneven on a curve with a step": Spindle(times=(0.0, 0.5, 1.0, 1.0, 1.6), speeds=(1.0, 1.04, 0.99, 1.02, 1.0), speed_fluctuation=0.06),
    "free": FreeSpindle(inertia=0.4, start_speed=1.0, torque=InputFunction(times=(0.0, 0.7, 0.7, 1.5), values=(1, 2, -3, 1))),
}


@pytest.mark.parametrize(
    ("program", "dimensions"), list(zip(PROGRAMS.values(), [PORTER, CROSSED, UNCROSSED_LINKS] * 2, strict=True)), ids=PROGRAMS
)
def test_every_spindle_program_agrees_with_multibody(program, dimensions):
    speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=0.75))
    if isinstance(program, FreeSpindle):
        spindle = replace(program, start_speed=speed)
    else:
        spindle = replace(program, speeds=tuple(speed * part for part in program.speeds))
    scene = governor_scene(dimensions, speed=speed, angle=0.75, output_interval=0.05).with_changes(spindle=spindle)
    reduced, multibody = both(scene)
    assert reduced.outcome is gm.Outcome.DONE
    agree(reduced, multibody)
    assert reduced.energy.drift < AGREEMENT_TOLERANCE


@pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=["multibody", "reduced"])
def test_a_fluctuating_spindle_speed_depends_on_the_angle(engine):
    """The angle is the integral of the speed program; the reference integrates the program itself."""
    spindle = Spindle(times=(0.0, 0.6, 2.0), speeds=(11.0, 12.8, 13.1), speed_fluctuation=0.2, cycles_per_turn=2.0)
    scene = governor_scene(PORTER, speed=spindle, angle=0.6, output_interval=0.05, accuracy=1e-10)
    run = engine.run(scene)
    angles, rates = integrate_one_coordinate(scene, run.times)
    assert run.outcome is gm.Outcome.DONE
    np.testing.assert_allclose(run.readings["arm_angle"], angles, atol=1e-10)  # requested
    np.testing.assert_allclose(run.rates["arm_angle"], rates, atol=1e-10 * run.scales["spindle_speed"])


def crank(*loads, duration=3.0, rate=9.0, again=False, redundant=False, coordinate="crank", angle=0.5):
    """Return a crank with a flywheel, a rod and a piston; `redundant` guides the piston twice."""
    r, length = 0.1, 0.32
    place = r * np.exp(1j * angle)
    lean = -math.asin(place.imag / length)
    end = place + length * np.exp(1j * lean)
    joints = [
        Pin(name="bearing", first=ground_point(), second=body_point("crank")),
        Pin(name="crank pin", first=body_point("crank", r), second=body_point("rod", -length / 2)),
        Pin(name="gudgeon", first=body_point("rod", length / 2), second=body_point("piston")),
        Slider(name="guide", first=ground_point(), second=body_point("piston"), angle=0.0),
    ]
    if redundant:
        joints.append(Slider(name="guide again", first=ground_point(0.7), second=body_point("piston"), angle=0.0))
    readings = {"crank": body_angle("crank"), "rod": body_angle("rod"), "x": x_reading("piston")}
    first = readings.pop(coordinate)
    return make_scene(
        bodies=[rotating_body("crank", 3.0, 0.05), rod_body("rod", 0.8, length), point_mass("piston", 1.2)],
        joints=joints,
        readings=[first, *readings.values()],
        sketch=[(0.0, 0.0, angle), (((place + end) / 2).real, ((place + end) / 2).imag, lean), (end.real, 0.0, 0.0)],
        loads=loads,
        values={"crank": angle},
        rates={"crank": rate},
        size=0.4,
        duration=duration,
        output_interval=duration / 60,
    )


PULSE = InputFunction(times=(0.0, 0.4, 0.4, 0.9, 1.3), values=(1.0, 1.0, -2.0, 0.5, 1.5))
STILL = InputFunction(values=(0.0,))
LOADS = {
    "spring": Spring(name="load", first=ground_point(0.2, 0.5), second=body_point("rod", 0.05, 0.02), stiffness=60.0, free_length=0.3),
    "damper": Damper(name="load", first=ground_point(0.2, 0.5), second=body_point("rod", 0.05, 0.02), damping=5.0),
    "torsion spring": TorsionSpring(name="load", first="crank", second="rod", stiffness=0.05, free_angle=0.3),
    "torsion damper": TorsionDamper(name="load", first="crank", second="rod", damping=0.01),
    "torque": Torque(name="load", first="rod", second="crank", moment=InputFunction(values=(0.7,))),
    "torque in time": Torque(name="load", first="ground", second="crank", moment=PULSE),
    "force": Force(name="load", point=body_point("rod", 0.1, 0.05), x=InputFunction(values=(3.0,)), y=InputFunction(values=(-2.0,))),
    "force in time": Force(name="load", point=body_point("piston"), x=PULSE, y=STILL),
}


@pytest.mark.parametrize("load", LOADS.values(), ids=LOADS)
def test_every_force_element_agrees_over_several_turns(load):
    # Over 3 s a constant torque turns the crank by 78 rad, where the roundings of the steps alone may exceed the request.
    reduced, multibody = both(crank(load, duration=2.0))
    assert reduced.outcome is gm.Outcome.DONE
    turns = np.ptp(reduced.readings["crank"]) / math.tau
    assert turns > 1  # so that the table is periodic and used again
    agree(reduced, multibody)
    assert reduced.energy.drift < AGREEMENT_TOLERANCE


def test_all_force_elements_together_with_a_redundant_joint():
    loads = [replace(load, name=name) for name, load in LOADS.items()]
    reduced, multibody = both(crank(*loads, redundant=True, duration=2.0))
    agree(reduced, multibody)
    assert {name: bool(one.determined.all()) for name, one in reduced.reactions.items()} == {
        name: bool(one.determined.all()) for name, one in multibody.reactions.items()
    }


def test_more_turns_need_no_more_table_pieces():
    """Without forces everything but the crank angle repeats after a whole turn."""
    one, many = (ReducedEngine().run(crank(duration=d).with_changes(effects=()), accuracy=1e-11) for d in (1.0, 30.0))
    assert np.ptp(many.poses[:, 0, 2]) > 40 * math.tau
    assert many.cost.evaluations["table pieces"] == one.cost.evaluations["table pieces"]
    np.testing.assert_allclose(many.readings["crank"], many.poses[:, 0, 2], atol=1e-12)  # rounding of about 300 rad
    assert np.ptp(many.poses[:, 1, 2]) < 2 * math.asin(0.1 / 0.32) + 1e-9  # the rod oscillates
    place = 0.1 * np.exp(1j * many.readings["crank"])
    np.testing.assert_allclose(many.readings["x"], place.real + np.sqrt(0.32**2 - place.imag**2), atol=1e-12)


@pytest.mark.parametrize(
    "effect",
    [
        Stops(reading="crank", low=-50.0, high=10.0, restitution=0.5),
        OutputSpring(reading="crank", rate=0.02),
        OutputSpring(reading="crank", rate=0.1, zero=8.0, one_sided=True),
        DryFriction(reading="crank", force=InputFunction(values=(0.3,))),
        Dashpot(reading="crank", linear=0.02),
    ],
    ids=["stop", "spring", "one-sided spring", "friction", "dashpot"],
)
def test_effects_along_an_angle_count_its_turns(effect):
    scene = crank()
    reduced, multibody = both(scene.with_changes(effects=(*scene.effects, effect)))
    assert np.ptp(multibody.readings["crank"]) > math.tau  # more than a turn
    agree(reduced, multibody)


@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_governors_agree_with_multibody(seed):
    random = np.random.default_rng(seed)
    dimensions, middle = random_governor(random)
    speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=middle))
    scene = governor_scene(
        dimensions, speed=speed, angle=middle + random.uniform(-0.1, 0.1), rate=random.uniform(-0.3, 0.3), output_interval=0.1
    )
    reduced, multibody = both(scene)
    if reduced.outcome is not multibody.outcome or reduced.outcome is gm.Outcome.LEFT_RANGE:
        assert {reduced.outcome, multibody.outcome} <= {gm.Outcome.LEFT_RANGE, gm.Outcome.ACCURACY_MISSED}
        return
    agree(reduced, multibody)


# --- the tables -------------------------------------------------------------------------------------------------------


def make_table(scene, values):
    """Return a motion table that covers values of the coordinate, and a function that evaluates a column at them."""
    poses, _ = initial_state(scene)
    mechanism = scene.part.mechanism
    start = float(scene.start.values[mechanism.coordinate])
    way = MotionTable(scene, start, poses)
    while way.end_coordinate(1) < max(values) and way.extend(1):
        pass
    while way.end_coordinate(0) > min(values) and way.extend(0):
        pass

    def column(index):
        found = []
        for value in values:
            piece, t, side = find_piece.__wrapped__(way.table.intervals, way.table.neighbours, way.table.periodicity, value, 0)
            assert side == ON_TABLE
            found.append(evaluate_piece.__wrapped__(way.table.coefficients, piece, index, t))
        return np.array(found)

    return way, column


GOVERNORS = {"porter": PORTER, "watt": WATT, "extended": EXTENDED, "crossed": CROSSED, "uncrossed": UNCROSSED_LINKS}


@pytest.mark.parametrize("dimensions", GOVERNORS.values(), ids=GOVERNORS)
def test_tables_agree_with_the_lagrangian_coefficients(dimensions):
    ramp = Spindle(times=(0.0, 1.0), speeds=(9.0, 10.0))
    scene = governor_scene(dimensions, speed=ramp, angle=0.7)
    values = np.random.default_rng(3).uniform(0.5, 0.95, 40)
    way, column = make_table(scene, values)
    coefficients = SingleDofReduction(scene).evaluate(values)
    # A fit is accurate to 1e-13 of the largest value on a piece; the reference is assembled to the same accuracy.
    for index, expected in (
        (TableColumn.INVERSE_INERTIA, 1 / coefficients.inertia),
        (TableColumn.QUADRATIC, -coefficients.inertia_derivative / (2 * coefficients.inertia)),
        (TableColumn.POTENTIAL, -coefficients.potential_derivative / coefficients.inertia),
        (TableColumn.CENTRIFUGAL, coefficients.spindle_inertia_derivative / (2 * coefficients.inertia)),
        (TableColumn.SPINDLE_INERTIA, coefficients.spindle_inertia),
    ):
        np.testing.assert_allclose(column(index), expected, atol=1e-11 * max(1.0, np.max(np.abs(expected))), rtol=0)
    poses, ahead = way.evaluate_poses(values)
    np.testing.assert_allclose(poses, coefficients.poses, atol=1e-12)
    np.testing.assert_allclose(ahead, coefficients.tangents, atol=1e-11)


def test_outputs_and_their_derivatives_are_in_the_tables():
    scene = governor_scene(EXTENDED, speed=9.0, angle=0.7)
    scene = scene.with_changes(effects=(*scene.effects, Dashpot(reading="sleeve_lift", linear=1.0)))
    values = np.linspace(0.5, 0.95, 10)
    _, column = make_table(scene, values)
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate(values)
    np.testing.assert_allclose(column(TableColumn.FIRST_LOAD + 1), reduction.output_derivative(coefficients, "sleeve_lift"), atol=1e-12)
    steps = np.array([-2, -1, 1, 2]) * 1e-3
    near = [make_table(scene, values + step)[1](TableColumn.FIRST_LOAD) for step in steps]
    slope = (8 * (near[2] - near[1]) - (near[3] - near[0])) / 12e-3
    np.testing.assert_allclose(slope, column(TableColumn.FIRST_LOAD + 1), atol=1e-10)  # differences of fourth order: a few 1e-12


def test_the_truncation_error_of_a_fit_is_of_order_twelve_in_the_width():
    def error(half):
        values, coefficients = 1 / (1.3 + half * CHEBYSHEV_NODES), np.empty(N_CHEBYSHEV_NODES)
        fit_piece.__wrapped__(values, coefficients)
        t = np.linspace(-1.0, 1.0, 201)
        return np.max(np.abs(np.polynomial.polynomial.polyval(t, coefficients) - 1 / (1.3 + half * t)))

    # From 1e-8 to 1e-13, above rounding; near the pole the error of a wide piece falls faster.
    orders = np.log2([error(half) / error(half / 2) for half in (0.6, 0.5, 0.4)])
    assert np.all(np.diff(orders) < 0)
    assert orders[-1] == pytest.approx(12, abs=0.75)


# --- where the table ends ---------------------------------------------------------------------------------------------


def test_the_range_ends_as_with_multibody():
    # Spindle at rest, no gravity, an outward start rate: the arm rotates uniformly to 90 degrees.
    scene = governor_scene(WATT, speed=0.0, angle=0.5, rate=4.0, duration=2.0)
    scene = scene.with_changes(effects=scene.effects[1:])
    reduced, multibody = both(scene, 1e-9)
    assert reduced.outcome is multibody.outcome is gm.Outcome.LEFT_RANGE
    sentence, time = zip(*(run.detail.split(", at t = ") for run in (reduced, multibody)), strict=True)
    assert sentence[0] == sentence[1]
    found, expected = (float(one.split(" s")[0]) for one in time)
    # The table ends at most 1e-9 rad before its bound.
    assert found == pytest.approx((math.pi / 2 - 0.5) / 4.0, abs=1e-8)
    assert found == pytest.approx(expected, abs=1e-8)
    np.testing.assert_array_equal(reduced.times, multibody.times)


def test_the_limit_of_another_reading_ends_the_range():
    scene = governor_scene(CROSSED, speed=13.0, angle=0.6, duration=5.0)
    reduced, multibody = both(scene, 1e-9)
    assert reduced.outcome is multibody.outcome is gm.Outcome.LEFT_RANGE
    sentences = [run.detail.split(", at ")[0] for run in (reduced, multibody)]
    assert sentences[0] == sentences[1]
    assert "the balls meet on the spindle axis" in sentences[0]
    np.testing.assert_array_equal(reduced.times, multibody.times)


def test_a_turning_point_of_the_coordinate_ends_the_run():
    # With the piston position as coordinate the run ends at the end of the stroke; with the crank angle it continues.
    scene = crank(coordinate="x", duration=1.0)
    run, true = ReducedEngine().run(scene, accuracy=1e-7), MultibodyEngine().run(scene, accuracy=1e-9)
    assert true.outcome is gm.Outcome.DONE
    assert run.outcome is gm.Outcome.DEAD_CENTRE
    assert "'x' is at a turning point" in run.message
    many = len(run.times)
    centre = np.interp(math.pi, true.readings["crank"], true.times)
    assert run.times[-1] < centre < run.times[-1] + 2 * scene.run.output_interval
    assert many > 10
    np.testing.assert_allclose(run.readings["crank"], true.readings["crank"][:many], atol=1e-6)  # ten times the requested accuracy


@pytest.mark.long
def test_a_change_point_ends_the_run_and_auto_continues():
    scene = gm.load("four_bar_chain")
    run, true = both(scene, 1e-9)  # multibody misses 1e-10 after ten change points
    assert run.outcome is gm.Outcome.DEAD_CENTRE
    assert "the joints at a change point, and does not determine the poses at" in run.message
    many = len(run.times)
    passed = next(event.time for event in true.events if event.kind == EventKind.CHANGE_POINT)
    assert run.times[-1] < passed < run.times[-1] + 2 * scene.run.output_interval
    for name in run.readings:
        assert np.max(np.abs(run.readings[name] - true.readings[name][:many])) < AGREEMENT_TOLERANCE * run.scales[name], name
    by_auto = gm.run(scene, accuracy=1e-8)
    assert by_auto.outcome is gm.Outcome.DONE
    assert by_auto.cost.engine == "multibody"
    assert len(by_auto.events) == len(true.events)


def test_a_start_at_a_turning_point_is_refused():
    # A lamp on a cord hangs straight down: its height does not determine its position.
    scene = make_scene(
        bodies=[point_mass("lamp", 2.0)],
        joints=[Distance(name="cord", first=body_point("lamp"), second=ground_point(0.0, 1.0), length=0.6)],
        readings=[y_reading("lamp"), x_reading("lamp")],
        sketch=[(0.0, 0.4, 0.0)],
    )
    with pytest.raises(gm.MechanismError, match=r"'reduced' cannot start: 'y' is at a turning point.*'multibody'"):
        ReducedEngine().run(scene)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("quick_return", "drives move this mechanism; choose.*multibody"),
        ("porter_clearance", r"engine 'reduced' cannot model \['Clearance'\]"),
    ],
)
def test_an_unsupported_scene_is_refused(name, sentence):
    with pytest.raises(gm.UnsupportedEffect, match=sentence):
        gm.run(name, engine="reduced")


def test_two_degrees_of_freedom_are_refused():
    scene = make_scene(
        bodies=[rod_body("one", 1.0, 1.0), rod_body("two", 1.0, 1.0)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("one", -0.5)),
            Pin(name="knee", first=body_point("one", 0.5), second=body_point("two", -0.5)),
        ],
        readings=[body_angle("one"), body_angle("two")],
        sketch=[(0.5, 0.0, 0.0), (1.5, 0.0, 0.0)],
    )
    with pytest.raises(gm.UnsupportedEffect, match=r"mobility.*2.*choose.*multibody"):
        ReducedEngine().run(scene)


# --- settings ---------------------------------------------------------------------------------------------------------


def test_a_run_without_certificate_has_the_same_motion():
    scene = governor_scene(PORTER, speed=12.2, angle=0.6)
    certified, plain = (ReducedEngine(tolerance=1e-10).run(scene, certify=certify) for certify in (True, False))
    assert plain.outcome is gm.Outcome.NOT_CERTIFIED
    assert plain.error_estimate is None
    assert (certified.cost.runs, plain.cost.runs) == (2, 1)
    np.testing.assert_array_equal(plain.poses, certified.poses)


@pytest.mark.parametrize("times", [[0.0], [2.0], [0.5, 0.7, 1.9], [1e-12]], ids=["start", "end", "later", "at once"])
def test_any_times_may_be_requested(times):
    scene = governor_scene(PORTER, speed=Spindle(times=(0.0, 1.0, 1.0), speeds=(12.2, 12.4, 12.6)), angle=0.6)
    reduced, multibody = both(scene, times=times)
    agree(reduced, multibody)


# --- second derivatives ----------------------------------------------------------------------------------------------


def test_gamma_of_a_line_angle_agrees_with_second_differences():
    """Compare J a - gamma of the angle of a line with second differences along a motion of both bodies."""
    scene = crank()
    mechanism = scene.part.mechanism
    line = LineAngle(name="line", quantity="angle", start=body_point("crank", 0.07, -0.03), end=body_point("rod", 0.11, 0.05))
    output_rows = make_output_rows(replace(mechanism, readings=(*mechanism.readings, line)), ["line"], {})
    random = np.random.default_rng(5)
    poses, velocities, accelerations = (random.normal(size=(3, 3)) for _ in range(3))
    poses[1, :2] = poses[0, :2] + [0.6, 0.4]
    step = 1e-3

    def angle(time):
        at = poses + velocities * time + 0.5 * accelerations * time**2
        ends = []
        for point in (line.start, line.end):
            x, y, turned = at[mechanism.body_index(point.body)]
            ends.append(complex(x, y) + complex(point.x, point.y) * np.exp(1j * turned))
        return np.angle((ends[1] - ends[0]) * np.exp(-1j * reference))

    reference = 0.0
    reference = angle(0.0)
    f = [angle(k * step) for k in range(-2, 3)]
    second = (16 * (f[3] + f[1]) - (f[4] + f[0]) - 30 * f[2]) / (12 * step**2)
    row = RowEvaluation(output_rows, poses, velocities)
    gamma, gradient = row.gamma[0], row.jacobian[0]
    # Differences of fourth order: 1e-12 times derivatives of several thousand, and rounding of 1e-16 / step^2.
    assert np.sum(gradient * accelerations) - gamma == pytest.approx(second, abs=1e-6)
    assert abs(gamma) > 0.1


def test_quintic_hermite_interpolation_reproduces_quintics():
    """A polynomial of degree five and its rate are reproduced to rounding."""
    motion, h = np.polynomial.Polynomial([0.4, -1.1, 0.7, 2.3, -1.9, 0.8]), 0.3
    rate, acceleration = motion.deriv(), motion.deriv(2)
    for fraction in (0.1, 0.5, 0.9):
        value, speed = quintic_hermite(motion(0.0), rate(0.0), acceleration(0.0), motion(h), rate(h), acceleration(h), h, fraction)
        assert value == pytest.approx(motion(fraction * h), abs=1e-14)
        assert speed == pytest.approx(rate(fraction * h), abs=1e-13)


def test_a_certificate_compares_with_a_run_along_a_table_of_its_own_with_narrower_pieces():
    engine, request = ReducedEngine(), RunRequest(times=np.array([0.0, 1.0]), accuracy=1e-8, certify=True, reason="")
    runner = ReducedRunner(engine, gm.load("porter"), request)
    runner.run()
    ratio = engine.settings.comparison_width_ratio
    own, other = (runner.get_reduced_run(one) for one in (1.0, ratio))
    assert own is not other
    assert ratio < 0.9
    first_widths = [float(np.ptp(one.motion_table.table.intervals[0, :2])) for one in (own, other)]
    assert first_widths[1] == pytest.approx(ratio * first_widths[0], rel=1e-12)
    assert all(one.counts[0] > 0 for one in (own, other))  # each counts its own steps


@pytest.mark.parametrize("side", [0, 1], ids=["below", "above"])
def test_poses_beyond_either_end_of_a_table_are_solved_and_not_extrapolated(side):
    scene = governor_scene(PORTER, speed=6.0, angle=0.6)
    poses, _ = initial_state(scene)
    table = MotionTable(scene, 0.6, poses)
    beyond = np.array([table.edge(side) + (0.1 if side else -0.1)])
    (found,), _ = table.evaluate_poses(beyond)
    assert np.abs(constraint_equations_of(scene.mechanism).residuals(found)).max() < 1e-14
