"""Contact modes: what ends them, which segments of tables hold, and values at which outputs are held."""

import numpy as np
import pytest

from coupled_scenes import coupled_scene, discs_part, engine_part, porter_part
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.contact.scene_contacts import InputModes, SceneContacts
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, make_system_workspace
from governor_mechanism.mechanics.dynamics.constrained_solution import project_state
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.event_functions import EventFunctionKind, evaluate_event_functions
from governor_mechanism.mechanics.dynamics.lowering import make_system, with_held_values
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.coupling.couplings import GearCoupling
from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, TableFunction
from scene_parts import make_mechanism, scene_of

ANGLE = "wheel_angle"
KINKS = (-0.5, 0.2, 1.1)


def disc(*effects) -> Scene:
    return coupled_scene(discs_part("disc", {"wheel": 0.5})).with_changes(effects=effects)


HELD_READINGS = (
    BodyAngle(name="held", quantity="angle", body="ball"),
    PointDistance(name="held", quantity="length", first=Point(body=GROUND), second=Point(body="ball", x=0.1)),
    PointCoordinate(name="held", quantity="length", point=Point(body="ball"), direction_x=0.6, direction_y=0.8, zero=-0.2),
    LineAngle(name="held", quantity="angle", start=Point(body=GROUND), end=Point(body="ball")),
)
FRICTION = DryFriction(reading=ANGLE, force=InputFunction(values=(0.7,)))
STOPS = Stops(reading=ANGLE, low=-0.4, high=0.9)


@pytest.mark.parametrize(
    ("effects", "held", "signs"),
    [
        ((FRICTION,), 0.1, [-1.0, 1.0]),  # slips either way
        ((STOPS,), -0.4, [-1.0]),  # a stop pushes without limit; the contact ends when it would have to pull
        ((STOPS,), 0.9, [1.0]),
        ((FRICTION, STOPS), -0.4, [-1.0]),
        ((FRICTION, STOPS), 0.2, [-1.0, 1.0]),
    ],
)
def test_what_is_held_is_released_by_forces_that_exceed_the_limit(effects, held, signs):
    functions = make_system(disc(*effects), ContactMode((held,), (0,)))[0].event_functions
    assert np.all(functions["kind"] == EventFunctionKind.FORCE)
    assert sorted(functions["sign"]) == signs
    assert np.all((functions["input_index"] >= 0) == (FRICTION in effects))


def test_what_slides_ends_at_rest_or_at_a_stop():
    functions = make_system(disc(FRICTION, STOPS), ContactMode((None,), (-1,)))[0].event_functions
    assert [(row["kind"], row["sign"], row["threshold"]) for row in functions] == [
        (EventFunctionKind.RATE, 1.0, 0.0),
        (EventFunctionKind.VALUE, 1.0, 0.9),
        (EventFunctionKind.VALUE, -1.0, 0.4),
    ]
    assert not len(make_system(disc(FRICTION, STOPS), ContactMode((None,), (-1,), is_locked=True))[0].event_functions)


def event_values(scene: Scene, mode: ContactMode, angle: float, rate: float) -> list[float]:
    """Return the values of the event functions at an angle and a rate of the disc."""
    system, functions = make_system(scene, mode)
    others = np.zeros((len(scene.mechanism.bodies) - 1, 3))
    state = np.concatenate([[0.0, 0.0, angle], others.ravel(), [0.0, 0.0, rate], others.ravel(), np.zeros(N_ENERGY_STATES)])
    workspace = make_system_workspace(system)
    evaluate_state_derivative(system, workspace, stack_local_cubics(functions, np.zeros(1))[0], 0.0, state, np.empty_like(state))
    values = np.empty(len(system.event_functions))
    evaluate_event_functions(system, workspace, state, values, 0)
    return values.tolist()


@pytest.mark.long  # in the daily tests runs have their events at these thresholds, tests/engines/test_effects.py
@pytest.mark.parametrize("discs", [{"wheel": 0.5}, {"wheel": 0.5, "idler": 0.3}], ids=["one disc", "two discs"])
def test_event_functions_are_what_is_beyond_their_thresholds(discs):
    torque = Torque(name="load", second="wheel", moment=InputFunction(values=(2.0,)))
    scene = coupled_scene(discs_part("disc", discs, torque)).with_changes(effects=(FRICTION, STOPS))
    assert event_values(scene, ContactMode((None,), (-1,)), 0.3, -1.2) == pytest.approx([-1.2, 0.3 - 0.9, -0.3 - 0.4])
    # The torque is held against a friction of 0.7 N m: it would have to push by 2 N m backwards.
    assert sorted(event_values(scene, ContactMode((0.3,), (0,)), 0.3, 0.0)) == pytest.approx([-2.0 - 0.7, 2.0 - 0.7])


@pytest.mark.parametrize(("held", "inward"), [(-0.4, -1.0), (0.9, 1.0)])
@pytest.mark.parametrize("moment", [2.0, -2.0])
def test_a_stop_lets_go_when_it_would_have_to_pull(held, inward, moment):
    torque = Torque(name="load", second="wheel", moment=InputFunction(values=(moment,)))
    scene = coupled_scene(discs_part("disc", {"wheel": 0.5}, torque)).with_changes(effects=(STOPS,))
    assert event_values(scene, ContactMode((held,), (0,)), held, 0.0) == pytest.approx([-inward * moment])


@pytest.mark.parametrize("is_taut", [False, True])
def test_a_one_sided_spring_changes_where_it_is_slack(is_taut):
    spring = OutputSpring(reading=ANGLE, rate=3.0, zero=0.3, one_sided=True)
    (function,) = make_system(disc(spring), ContactMode(taut=(is_taut,)))[0].event_functions
    for angle in (0.2, 0.4):
        has_changed = is_taut == (angle < 0.3)
        assert (function["sign"] * angle > function["threshold"]) == has_changed


@pytest.mark.parametrize("effects", [(FRICTION,), (STOPS,)])
def test_other_held_values_are_those_of_a_new_system(effects):
    scene, modes = disc(*effects), [ContactMode((held,), (0,)) for held in (-0.4, 0.9)]
    system = make_system(scene, modes[0])[0]
    moved = with_held_values(system, [0], modes[1])
    np.testing.assert_array_equal(moved.constraint_rows.table, make_system(scene, modes[1])[0].constraint_rows.table)
    assert np.any(moved.constraint_rows.table != system.constraint_rows.table)


@pytest.mark.parametrize("reading", HELD_READINGS, ids=lambda one: type(one).__name__)
def test_an_output_is_held_at_its_value(reading):
    """The nearest poses at which the holding row is satisfied have that value."""
    ball = Body(name="ball", mass=1.0, second_moments=SecondMoments(xx=0.5))
    mechanism = make_mechanism([ball], [], [reading], [(0.3, -0.4, 0.1)])
    scene = scene_of(mechanism, DryFriction(reading="held", force=InputFunction(values=(1.0,))))
    for held in (0.45, 0.6):
        system, functions = make_system(scene, ContactMode((held,), (0,)))
        poses, cubics = np.array([[0.3, -0.4, 0.1]]), stack_local_cubics(functions, np.zeros(1))[0]
        project_state(system, make_system_workspace(system), cubics, 0.0, poses, np.zeros((1, 3)), 1e-15)
        assert float(evaluate_output_value(mechanism, "held", poses)) == pytest.approx(held, abs=1e-14)
        assert np.any(poses != [[0.3, -0.4, 0.1]])


def segment_of_table(scene: Scene, current: int, value: float, rate: float, *, is_triggered: bool = False) -> int:
    """Return the segment of the only table of a scene at a value and a rate of its output, after another segment."""
    modes = InputModes(scene, 1.0, 3)
    assert not modes.is_fixed
    return modes.update(ContactMode(segments=(current,)), 0.0, [value], [rate], {3} if is_triggered else set()).segments[0]


def test_the_segment_of_a_table_is_that_of_the_value_and_at_a_kink_that_of_the_motion():
    table = TableFunction(reading=ANGLE, positions=KINKS, values=(2.0, -1.0, 4.0))
    torque = Torque(name="load", second="wheel", moment=InputFunction(functions=(table,)))
    scene = coupled_scene(discs_part("disc", {"wheel": 0.5}, torque))
    for value in (-1.0, -0.4, 0.7, 3.0):
        assert segment_of_table(scene, 0, value, 1.0) == np.searchsorted(KINKS, value)
    for k, kink in enumerate(KINKS):
        for value in (kink, kink + 1e-15, kink - 1e-15):
            assert segment_of_table(scene, 0, value, 0.3) == k + 1
            assert segment_of_table(scene, 0, value, -0.3) == k
            # The event of the kink itself changes the segment, whatever rounding says of the rate.
            assert segment_of_table(scene, k, value, -0.3, is_triggered=True) == k + 1
            assert segment_of_table(scene, k + 1, value, 0.3, is_triggered=True) == k


def test_the_segment_of_a_table_of_a_speed_stays_at_a_kink():
    """The sign of its change is not known there: the event decides."""
    table = TableFunction(reading="governor.spindle_speed", positions=KINKS, values=(2.0, -1.0, 4.0))
    engine = engine_part(torque=InputFunction(functions=(table,)))
    belt = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", ratio=2.0)
    scene = coupled_scene(engine, porter_part(), couplings=(belt,))
    for rate in (-1.0, -0.4, 0.7, 3.0):
        assert segment_of_table(scene, 0, 0.2, rate) == np.searchsorted(KINKS, rate)
    for k, kink in enumerate(KINKS):
        assert [segment_of_table(scene, current, 9.0, kink) for current in range(4)] == [
            current if current in (k, k + 1) else k for current in range(4)
        ]
        assert segment_of_table(scene, k, 9.0, kink, is_triggered=True) == k + 1
        assert segment_of_table(scene, k + 1, 9.0, kink, is_triggered=True) == k


def test_gears_break_at_their_time():
    belt = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle", until=1.5)
    modes = InputModes(coupled_scene(engine_part(), porter_part(), couplings=(belt,)), 1.0, 0)
    assert [modes.update(ContactMode(), time, [], [], ()).broken for time in (0.0, 1.4, 1.5, 2.0)] == [(), (), ("belt",), ("belt",)]
    assert InputModes(coupled_scene(engine_part()), 1.0, 0).is_fixed


@pytest.mark.parametrize(
    ("angle", "torque", "held"), [(0.9, 2.0, 0.9), (0.9, -2.0, None), (0.3, 2.0, None), (-0.4, -2.0, -0.4), (-0.4, 2.0, None)]
)
def test_what_is_pressed_against_a_stop_rests_there_and_nothing_else_does(angle, torque, held):
    load = Torque(name="load", second="wheel", moment=InputFunction(values=(torque,)))
    scene = coupled_scene(discs_part("disc", {"wheel": 0.5}, load)).with_changes(effects=(STOPS,))
    contacts = SceneContacts(scene, 1.0, 1e-9)
    state = np.array([0.0, 0.0, angle, 0.0, 0.0, 0.0, *(0.0,) * N_ENERGY_STATES])
    contacts.start(state, stack_local_cubics(contacts.input_functions, np.zeros(1))[0])
    assert contacts.mode.held_values == (held,)
