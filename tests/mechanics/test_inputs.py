"""Loads that depend on readings, against their formulas: torques on a disc, which turns as they say."""

import math
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part
from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, from_mass_centres, make_system_workspace
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics, evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.event_functions import EventFunctionKind
from governor_mechanism.mechanics.dynamics.inputs import NOT_HELD, initial_lags, make_table_segments
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import Pin, Point, RotationalDriver
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import (
    AngleHarmonic,
    Harmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    PrescribedMotion,
    StrokeHold,
    TableFunction,
)
from scene_parts import body_angle, body_point, ground_point, make_mechanism, rotating_body, scene_of

ANGLE, INERTIA = "wheel_angle", 0.5
LINEAR = LinearFunction(reading=ANGLE, gain=-3.0, about=0.4)
WAVES = HarmonicFunction(
    reading=ANGLE,
    harmonics=tuple(
        AngleHarmonic(order=order, amplitude=math.hypot(cosine, sine), phase=math.atan2(cosine, sine))
        for order, cosine, sine in ((2.0, 0.9, -0.4), (3.0, 0.1, 0.7))
    ),
)
TABLE = TableFunction(reading=ANGLE, positions=(-0.5, 0.2, 1.1), values=(2.0, -1.0, 4.0))


def disc(*torques: InputFunction, name: str = "wheel") -> Scene:
    """Return a disc with torques; the speed of one with the name "spindle" is a reading."""
    loads = (Torque(name=f"load {k}", second=name, moment=torque) for k, torque in enumerate(torques))
    return coupled_scene(discs_part("disc", {name: INERTIA}, *loads))


def torque_on(
    scene: Scene, angle: float, rate: float = 0.0, lags: tuple[float, ...] = (), mode: ContactMode | None = None, time: float = 0.0
) -> float:
    """Return the torque on the disc at an angle and a rate."""
    motion = np.array([time]), np.array([[[0.0, 0.0, angle]]]), np.array([[[0.0, 0.0, rate]]])
    modes = () if mode is None else (mode,)
    return INERTIA * float(compute_inverse_dynamics(scene, *motion, np.array([lags]), modes).accelerations[0, 0, 2])


def linear(angle: float) -> float:
    return -3.0 * (angle - 0.4)


def waves(angle: float) -> float:
    return 0.9 * math.cos(2 * angle) - 0.4 * math.sin(2 * angle) + 0.1 * math.cos(3 * angle) + 0.7 * math.sin(3 * angle)


@pytest.mark.parametrize("angle", [-1.3, 0.4, 2.2])
def test_functions_are_added_and_factors_multiply_the_sum(angle):
    load = InputFunction(values=(5.0,), functions=(LINEAR, WAVES), factors=(WAVES, LINEAR))
    expected = (5.0 + linear(angle) + waves(angle)) * waves(angle) * linear(angle)
    constant = InputFunction(values=(0.3,), functions=(LINEAR,))  # another load behind it has inputs of its own
    assert torque_on(disc(load, constant), angle) == pytest.approx(expected + 0.3 + linear(angle), rel=1e-14)


@pytest.mark.parametrize(("angle", "segment"), [(-0.9, 0), (-0.2, 1), (0.7, 2), (1.9, 3)])
def test_a_table_is_linear_between_its_points_and_constant_beyond(angle, segment):
    scene = disc(InputFunction(values=(1.0,), functions=(TABLE,)), InputFunction(functions=(LINEAR,), factors=(TABLE,)))
    mode = ContactMode(segments=(segment, segment))
    value = float(np.interp(angle, TABLE.positions, TABLE.values))
    assert torque_on(scene, angle, mode=mode) == pytest.approx(1.0 + value + value * linear(angle), rel=1e-14)
    # Its event functions are negative on the segment and vanish at its ends.
    functions = make_system(scene, mode)[0].event_functions
    assert np.all(functions["kind"] == EventFunctionKind.VALUE)
    assert np.all(functions["sign"] * angle < functions["threshold"])
    ends = [-math.inf, *TABLE.positions, math.inf][segment : segment + 2]
    assert sorted(functions["sign"] * functions["threshold"]) == sorted(2 * [end for end in ends if math.isfinite(end)])
    assert sorted(set(functions["contact_index"])) == [0, 1]


@pytest.mark.parametrize("time", [0.0, 0.1])
def test_a_torque_swings_in_time_by_its_harmonics(time):
    harmonics = (Harmonic(amplitude=0.3, frequency=2.0, phase=0.5), Harmonic(amplitude=-0.7, frequency=3.0, phase=0.2))
    swing = sum(one.amplitude * math.sin(math.tau * one.frequency * time + one.phase) for one in harmonics)
    assert torque_on(disc(InputFunction(values=(2.0,), harmonics=harmonics)), 0.4, time=time) == pytest.approx(2.0 + swing, rel=1e-14)


def test_a_lag_takes_the_place_of_its_function_and_follows_it():
    lagged = (
        LinearFunction(reading=ANGLE, gain=-3.0, about=0.4, lag=0.2),
        HarmonicFunction(reading=ANGLE, harmonics=WAVES.harmonics, lag=0.5),
    )
    scene = disc(InputFunction(values=(5.0,), functions=lagged[:1], factors=lagged[1:]), InputFunction(functions=(LINEAR,)))
    angle, states = 0.9, (0.7, -1.6)
    assert torque_on(scene, angle, lags=states) == pytest.approx((5.0 + 0.7) * -1.6 + linear(angle), rel=1e-14)
    system, functions = make_system(scene)
    state = np.concatenate([[0.0, 0.0, angle, 0.0, 0.0, 2.0], np.zeros(N_ENERGY_STATES), states])
    derivative, cubics = np.empty_like(state), stack_local_cubics(functions, np.zeros(1))[0]
    evaluate_state_derivative(system, make_system_workspace(system), cubics, 0.0, state, derivative)
    expected = [(linear(angle) - 0.7) / 0.2, (waves(angle) + 1.6) / 0.5]
    np.testing.assert_allclose(derivative[-2:], expected, rtol=1e-14)
    np.testing.assert_allclose(initial_lags(scene, state[None, :3], state[None, 3:6]), [linear(angle), waves(angle)], rtol=1e-14)


def test_a_lag_behind_a_rate_begins_at_the_value_of_the_rate():
    lagged = LinearFunction(reading="spindle_speed", gain=-3.0, about=0.4, lag=0.2)
    scene = disc(InputFunction(functions=(lagged,)), name="spindle")
    motion = np.array([[0.0, 0.0, 0.9]]), np.array([[0.0, 0.0, 2.5]])
    np.testing.assert_allclose(initial_lags(scene, *motion), [linear(2.5)], rtol=1e-14)


def test_the_rounding_of_a_rate_is_one_in_its_unit():
    """A point of a table over a rate is passed within a rounding of the rate, not of the angle."""
    tolerances = []
    for reading in ("spindle_angle", "spindle_speed"):
        scene = disc(InputFunction(values=(50.0,), functions=(replace(TABLE, reading=reading),)), name="spindle")
        functions = make_system(scene, ContactMode(segments=(1,)))[0].event_functions
        tolerances.append(set(functions["tolerance"].tolist()))
    (of_angle,), (of_rate,) = tolerances
    assert time_scale(scene) < 0.5
    assert of_rate == pytest.approx(of_angle / time_scale(scene), rel=1e-12)
    loads = [InputFunction(functions=(replace(TABLE, source="angle", is_rate=is_rate),)) for is_rate in (False, True)]
    segments = make_table_segments(["angle"], [1.5], 0.1, loads)
    n = len(TABLE.positions) + 1
    np.testing.assert_allclose(segments["tolerance"][n:], segments["tolerance"][:n] / 0.1, rtol=1e-12)


def accelerations_of(scene: Scene, poses: list[list[float]], velocities: list[list[float]], time: float = 0.0) -> np.ndarray:
    """Return the accelerations of the bodies at poses and velocities of their mass centres, by the derivative of the state."""
    system, functions = make_system(scene)
    motion = [part.ravel() for part in from_mass_centres(system, np.array(poses), np.array(velocities))]
    state = np.concatenate([*motion, np.zeros(N_ENERGY_STATES)])
    derivative, cubics = np.empty_like(state), stack_local_cubics(functions, np.array([time]))[0]
    evaluate_state_derivative(system, make_system_workspace(system), cubics, 0.0, state, derivative)
    return derivative[3 * len(poses) : 6 * len(poses)].reshape(-1, 3)


def test_a_drive_gives_its_acceleration():
    oscillation = Harmonic(amplitude=0.3, frequency=1.5, phase=0.4)
    motion = PrescribedMotion(times=(0.0, 1.0), values=(0.2, 0.7), harmonics=(oscillation,))
    joints = [
        Pin(name="bearing", first=ground_point(), second=body_point("wheel")),
        RotationalDriver(name="drive", first=ground_point(), second=body_point("wheel"), motion=motion),
    ]
    scene = scene_of(make_mechanism([rotating_body("wheel", 1.0, 0.5)], joints, [body_angle("wheel", "turn")], [(0.0, 0.0, 0.2)]))
    speed = math.tau * oscillation.frequency
    for time in (0.0, 0.37):
        swing = oscillation.amplitude * math.sin(speed * time + oscillation.phase)
        angle = 0.2 + 0.5 * time + swing
        rate = 0.5 + oscillation.amplitude * speed * math.cos(speed * time + oscillation.phase)
        found = accelerations_of(scene, [[0.0, 0.0, angle]], [[0.0, 0.0, rate]], time)
        np.testing.assert_allclose(found, [[0.0, 0.0, -(speed**2) * swing]], atol=1e-11)


@pytest.mark.parametrize(("x", "y"), [(-0.3, 0.2), (0.0, 0.4), (0.25, 0.0)])
def test_a_pendulum_is_turned_by_the_moment_of_its_weight(x, y):
    """A point mass on an arm from a pin at (x, y) in its axes."""
    pin = Pin(name="pivot", first=ground_point(), second=Point(body="bob", x=x, y=y))
    scene = scene_of(make_mechanism([Body(name="bob", mass=2.0)], [pin], [body_angle("bob", "swing")], [(-x, -y, 0.0)]), Gravity())
    angle, rate = 0.6, 1.7
    arm = -complex(x, y) * np.exp(1j * angle)
    found = accelerations_of(scene, [[arm.real, arm.imag, angle]], [[-arm.imag * rate, arm.real * rate, rate]])
    assert found[0, 2] == pytest.approx(-9.81 * arm.real / abs(arm) ** 2, rel=1e-13, abs=1e-13)


def test_every_input_has_one_function():
    for loads in ((), (InputFunction(values=(5.0,), functions=(LINEAR,)), InputFunction(values=(1.0,)))):
        system, functions = make_system(disc(*loads))
        assert len(functions) == system.n_inputs == len(make_system_workspace(system).inputs)


def test_a_held_load_begins_as_its_functions_say():
    held = InputFunction(values=(5.0,), functions=(LINEAR,), factors=(WAVES, LINEAR), hold=StrokeHold.FROM_DEAD_CENTRE)
    angle = np.array([[0.0, 0.0, 0.9]])
    expected = (5.0 + linear(0.9)) * waves(0.9) * linear(0.9)
    np.testing.assert_allclose(initial_lags(disc(held), angle, 0.0 * angle), [expected], rtol=1e-14)


@pytest.mark.parametrize("stroke", ["400 mm", "2.5 m"])
def test_a_cut_off_is_held_from_where_the_piston_has_come_to_it(stroke):
    """The rods are endless: the travel is (1 - cos) / 2 of the stroke, whose cut-off is about the half."""
    changes = {"cut_off_read": "within stroke", "stroke": stroke}
    engine = gm.load("governed_engine_cut_off").replace({f"part.engine.dimensions.{key}": value for key, value in changes.items()})
    for angle, is_held in (("80 deg", False), ("100 deg", True), ("260 deg", False), ("280 deg", True)):
        scene = engine.replace({"part.engine.start.crank_angle": angle})
        (held,) = initial_lags(scene, *initial_state(scene))
        assert (held == pytest.approx(0.5, abs=0.1)) if is_held else (held == NOT_HELD)


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_opposes_the_motion_and_is_never_negative(sign):
    scene = disc(InputFunction(values=(2.0,)))
    friction = DryFriction(reading=ANGLE, force=InputFunction(values=(0.5,), functions=(LINEAR,)))
    scene, mode = scene.with_changes(effects=(friction,)), ContactMode((None,), (sign,))
    for angle in (0.1, 0.5, 0.7):  # 1.4, 0.2 and, without the bound, -0.4 N m
        assert torque_on(scene, angle, rate=sign, mode=mode) == pytest.approx(2.0 - sign * max(0.5 + linear(angle), 0.0), rel=1e-14)
