"""Equations of one coordinate and one shaft, against those of all bodies with the forces in their joints."""

from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, from_mass_centres, make_system_workspace
from governor_mechanism.mechanics.dynamics.body_forces import inertia_of_plane
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics, evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.inputs import initial_lags
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.mechanics.reduction.equation_of_motion import evaluate_state_rates
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.reduced_model import find_shaft_train, parts_with_coordinate
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_scenes import PORTER, governor_scene
from shaft_scenes import LOADS, changed

TABLE_ERROR = 1e-11
"""Truncation of 1e-13 of a scale in the columns of a table, and the rounding of joint forces."""


def compare_formulations(scene: Scene, *, time: float = 0.0, sliding_sign: int = 1, is_taut: bool = True) -> dict[str, float]:
    """Compare accelerations and power at the start of a scene, and return them."""
    mechanism, (prefix, part), train = scene.mechanism, parts_with_coordinate(scene)[0], find_shaft_train(scene)
    (poses, velocities), first = initial_state(scene), mechanism.body_index(prefix + part.mechanism.bodies[0].name)
    coordinate = evaluate_output(mechanism, prefix + part.mechanism.coordinate, poses, velocities)
    contacts, springs = contacts_of(scene), one_sided_forces_of(scene)
    signs = tuple(sliding_sign if contact.friction is not None else 0 for contact in contacts)

    table = MotionTable(scene, float(coordinate.value), poses[first : first + len(part.mechanism.bodies)])
    mode = np.array([0, *signs, *(is_taut for _ in springs)])
    model = table.model.on_table(table.table, stack_local_cubics(table.time_functions, np.array([time]))[0], mode)
    shaft = next((mechanism.body_index(name) for name in train.motion), 0)
    rate = float(np.sum(coordinate.gradient * velocities))
    state = rate, float(poses[shaft, 2]), float(velocities[shaft, 2])
    acceleration, shaft_acceleration, work_rate, dissipated_power = evaluate_state_rates(model, 0, -1.0, *state, 0.0, True)

    arrays = np.array([time]), poses[np.newaxis], velocities[np.newaxis], np.zeros((1, 0))
    contact_mode = ContactMode((None,) * len(signs), signs, (is_taut,) * len(springs))
    bodies = compute_inverse_dynamics(scene, *arrays, (contact_mode,))
    expected = float(np.sum(coordinate.gradient * bodies.accelerations[0]) + coordinate.quadratic_velocity_term)
    assert acceleration == pytest.approx(expected, rel=TABLE_ERROR)
    without_friction = evaluate_state_rates(model, 0, -1.0, *state, 0.0, False).acceleration
    assert (without_friction != acceleration) == any(signs)
    if train.motion:
        assert shaft_acceleration == pytest.approx(bodies.accelerations[0, shaft, 2], rel=TABLE_ERROR, abs=TABLE_ERROR)
    # What a given speed, or one that is followed, puts into the turning bodies is no power of a force.
    turning_power = 0.0
    if scene.system.planes and not train.has_reaction:
        speed, speed_rate = train.spindle_ratio * np.array([state[2], shaft_acceleration]) if train.motion else given_motion(scene, time)
        turning_power = turning_inertia(scene, poses) * speed * speed_rate
    assert work_rate == pytest.approx(turning_power - bodies.power[0], rel=TABLE_ERROR, abs=TABLE_ERROR)
    rates_of_bodies = energy_rates(scene, contact_mode, time, poses, velocities)
    assert rates_of_bodies == pytest.approx((work_rate, dissipated_power), rel=TABLE_ERROR, abs=TABLE_ERROR)
    return {"acceleration": acceleration, "shaft": shaft_acceleration, "work": work_rate, "dissipation": dissipated_power}


def energy_rates(scene: Scene, mode: ContactMode, time: float, poses: np.ndarray, velocities: np.ndarray) -> tuple[float, float]:
    """Return the rates of work and of dissipated energy by the equations of all bodies."""
    system, functions = make_system(scene, mode)
    layout = system.state_layout
    lags = initial_lags(scene, poses, velocities)
    motion = np.concatenate([part.ravel() for part in from_mass_centres(system, poses, velocities)])
    state = np.concatenate([motion, np.zeros(N_ENERGY_STATES), lags])
    derivative, cubics = np.empty_like(state), stack_local_cubics(functions, np.array([time]))[0]
    evaluate_state_derivative(system, make_system_workspace(system), cubics, 0.0, state, derivative)
    return derivative[layout.work], derivative[layout.dissipated_energy]


def given_motion(scene: Scene, time: float) -> tuple[float, float]:
    """Return the speed of a spindle, a ramp with a fluctuation, and its rate."""
    spindle = scene.spindle
    rate = (spindle.speeds[-1] - spindle.speeds[0]) / spindle.times[-1]
    speed, angle = spindle.speeds[0] + rate * time, spindle.speeds[0] * time + 0.5 * rate * time**2
    amplitude, phase = 0.5 * spindle.speed_fluctuation, spindle.cycles_per_turn * angle
    ratio = 1.0 + amplitude * np.sin(phase)
    return speed * ratio, rate * ratio + amplitude * spindle.cycles_per_turn * speed**2 * np.cos(phase)


def rate_at_start(scene: Scene, name: str) -> float:
    """Return the rate of a reading at the start of a scene."""
    poses, velocities = initial_state(scene)
    return float(evaluate_output(scene.mechanism, name, poses).rate(velocities))


def turning_inertia(scene: Scene, poses: np.ndarray) -> float:
    """Return the moment of inertia of all bodies in the turning plane about the spindle."""
    total = 0.0
    for plane in scene.system.planes:
        for index in plane.bodies:
            mass, moments = scene.mechanism.bodies[index].mass, scene.mechanism.bodies[index].second_moments
            total += force_laws.spindle_inertia(mass, moments.xx, moments.yy, moments.xy, moments.zz, poses[index, 0], poses[index, 2])
    return total


@pytest.mark.parametrize("changes", LOADS.values(), ids=LOADS.keys())
@pytest.mark.parametrize("sign", [1, -1])
def test_shafts_and_their_loads(changes, sign):
    start = {"part.governor.start.arm_rate": 0.3 * sign, "part.engine.start.crank_angle": 0.7}
    found = compare_formulations(changed("watt_engine_hunting", {**changes, **start}), sliding_sign=sign)
    assert found["acceleration"] != 0.0
    assert found["dissipation"] > 0.0


@pytest.mark.parametrize("name", ["porter_dashpot", "porter_dry_friction", "porter_heavy_rods", "hartung_corrected", "slider_crank_torque"])
def test_loads_of_shipped_scenes(name):
    scene = gm.load(name)
    if not scene.system.planes:
        compare_formulations(scene)
        return
    speed = scene.spindle.speeds[0]
    ramp = Spindle(times=(0.0, 2.0), speeds=(speed, 1.1 * speed), speed_fluctuation=0.1, cycles_per_turn=3.0)
    compare_formulations(scene.with_changes(spindle=ramp, start=replace(scene.start, rates={scene.mechanism.coordinate: -0.3})), time=0.5)


def test_loads_and_effects_of_one_part():
    scene = gm.load("slider_crank_torque")
    effects = (
        Dashpot(reading="slider_x", linear=3.0),
        DryFriction(reading="crank_angle", force=InputFunction(values=(0.2,))),
        OutputSpring(reading="slider_x", rate=40.0, zero=0.3, one_sided=True),
    )
    turning = replace(scene.start, rates={"crank_angle": 4.0})
    loaded = compare_formulations(scene.with_changes(effects=(*scene.effects, *effects), start=turning))
    plain = compare_formulations(scene.with_changes(start=turning))
    assert loaded["dissipation"] == pytest.approx(3.0 * rate_at_start(scene.with_changes(start=turning), "slider_x") ** 2 + 0.2 * 4.0)
    assert loaded["acceleration"] != plain["acceleration"]


def test_effects_along_a_reading_of_a_governor():
    """A slack spring does not act; friction and dashpots oppose the motion."""
    chain = OutputSpring(reading="sleeve_lift", rate=300.0, zero=0.02, one_sided=True)
    effects = (
        Dashpot(reading="sleeve_lift", linear=120.0, quadratic=900.0),
        DryFriction(reading="sleeve_lift", force=InputFunction(values=(25.0,))),
        OutputSpring(reading="arm_angle", rate=7.0, zero=0.3),
    )
    accelerations = {}
    for sign, is_taut, with_chain in ((1, True, True), (1, False, True), (1, False, False), (-1, True, True)):
        scene = governor_scene(PORTER, speed=Spindle(times=(0.0, 2.0), speeds=(12.0, 14.0)), angle=0.7, rate=0.4 * sign)
        scene = scene.with_changes(effects=(*scene.effects, *effects, *(chain,) * with_chain))
        found = compare_formulations(scene, time=0.5, sliding_sign=sign, is_taut=is_taut)
        rate = abs(rate_at_start(scene, "sleeve_lift"))
        assert found["dissipation"] == pytest.approx(120.0 * rate**2 + 900.0 * rate**3 + 25.0 * rate, rel=TABLE_ERROR)
        accelerations[sign, is_taut, with_chain] = found["acceleration"]
    assert accelerations[1, False, True] == accelerations[1, False, False] > accelerations[1, True, True]


@pytest.mark.parametrize(("name", "across"), [("porter_extended_arms", "x"), ("hartnell", "y")])
def test_the_inertia_of_a_turning_plane_follows_from_the_places_of_the_masses(name, across):
    """The pose of a ball on an arm or a bell crank is that of its pin; the rate is the change by a small step."""
    scene = gm.load(name).replace({"start.arm_angle": "25 deg", "start.arm_rate": "0.4 rad/s"})
    system, _ = make_system(scene)
    (poses, velocities), step = initial_state(scene), 1e-6
    inertia, rate = inertia_of_plane(system.bodies, 0, *from_mass_centres(system, poses, velocities))
    assert any(system.bodies[across])
    assert inertia == pytest.approx(turning_inertia(scene, poses), rel=1e-14)
    sides = [turning_inertia(scene, poses + sign * step * velocities) for sign in (1, -1)]
    assert rate == pytest.approx((sides[0] - sides[1]) / (2 * step), rel=1e-8)


def test_a_governor_of_heavier_parts_moves_in_the_same_way():
    """All forces grow with the masses: in units of a power of two not a bit differs, also where arms without mass have stand-ins."""
    found, dimensions = [], ("ball_mass", "sleeve_mass")
    for ratio in (1.0, 2.0**20):
        keys = {f"dimensions.{name}": f"{ratio * mass} kg" for name, mass in zip(dimensions, (5.0, 40.0), strict=True)}
        scene = gm.load("proell").replace({**keys, "effects.dashpot.sleeve": f"{300.0 * ratio} N s/m", "start.arm_rate": "0.4 rad/s"})
        poses, velocities = initial_state(scene)
        assert make_system(scene)[0].has_stand_in_inertia
        found.append(compute_inverse_dynamics(scene, np.zeros(1), poses[None], velocities[None], np.zeros((1, 0))).accelerations)
    np.testing.assert_array_equal(*found)


def test_inputs_go_on_in_local_time():
    """The cubics of the inputs at a time, a little later, are those at the later time."""
    table = {"times": (0.0, 0.7, 1.5, 2.0), "values": (25.0, 31.0, 28.0, 40.0)}
    speed = Spindle(times=table["times"], speeds=(12.0, 12.5, 12.4, 14.0), speed_fluctuation=0.1, cycles_per_turn=3.0)
    scene = governor_scene(PORTER, speed=speed, angle=0.7, rate=0.4)
    scene = scene.with_changes(effects=(*scene.effects, DryFriction(reading="sleeve_lift", force=InputFunction(**table))))
    motion = MotionTable(scene, 0.7, initial_state(scene)[0])
    found = []
    for time, local_time in ((0.8, 0.5), (1.3, 0.0)):
        cubics = stack_local_cubics(motion.time_functions, np.array([time]))[0]
        model = motion.model.on_table(motion.table, cubics, np.array([0, 1]))
        found.append(evaluate_state_rates(model, 0, -1.0, 0.4, 0.0, 0.0, local_time, True))
    np.testing.assert_allclose(*found, rtol=1e-12)
