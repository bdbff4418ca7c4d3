"""Hartung's governor in motion: rest, swings and energy against the closed forms, for every engine."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
import hartung_scenes as scenes
from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.engines import ENGINES, ImpulseEngine
from governor_mechanism.machines.hartung import SLEEVE
from governor_mechanism.model.joints import GROUND, Point, TranslationalDriver
from governor_mechanism.model.part import FreeSpindle, Spindle, Start
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.observables.derived_readings import evaluate_static_forces
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.verification.machines.comparisons import measure_period, relax_to_equilibrium
from reference import hartung

NAMES = ["impulse", "multibody", "reduced"]
RPM = math.pi / 30
HUNG = {**scenes.PAPER_DIMENSIONS, "hanger": hartung.HANGER_LENGTH, "lug_offset": 0.01}
BRAKE = Dashpot(reading="sleeve_lift", linear=800.0)


def motion(dimensions: dict[str, Any], scene: Any, times: np.ndarray) -> np.ndarray:
    """Lever angles (n,) by the one-coordinate equation, from the scene's start at its first speed."""
    brake = sum(effect.linear for effect in scene.effects if isinstance(effect, Dashpot))
    start = scene.start.values["lever_angle"], scene.start.rates["lever_angle"]
    return integrate_lever_motion(tuple(dimensions.items()), scene.spindle.speeds[0], brake, start, tuple(times.tolist()))


@cache
def integrate_lever_motion(
    dimension_items: tuple[tuple[str, Any], ...], speed: float, brake: float, start: tuple[float, float], times: tuple[float, ...]
) -> np.ndarray:
    """Lever angles (n,), once for all engines."""
    dimensions = dict(dimension_items)
    governor = scenes.build_closed_form_governor(dimensions)

    def slope(_: float, state: np.ndarray) -> list[float]:
        state_of_lever = {"lever_angle": state[0], "lever_rate": state[1], "spring_force": scenes.spring_force_at(dimensions, state[0])}
        bend = closed.lever_acceleration(governor, **state_of_lever, spindle_speed=speed, damping=brake)
        return [state[1], float(bend)]

    found = solve_ivp(slope, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-13, atol=1e-14)
    angles: np.ndarray = found.y[0]
    return angles


@pytest.mark.parametrize("rpm", [204.0, 208.0, 212.0])
def test_it_settles_where_the_closed_form_rests(rpm: float) -> None:
    expected = scenes.equilibrium_angle_at(scenes.PAPER_DIMENSIONS, rpm * RPM)
    braked = scenes.hartung_scene(scenes.PAPER_DIMENSIONS, speed=rpm * RPM, angle=expected + 0.05, more_effects=(BRAKE,))
    assert relax_to_equilibrium(braked, expected + 0.05) == pytest.approx(expected, abs=1e-8)  # asked
    # The brake takes 2.6 e-folds a second or more, so that 10 s leave 5e-12 of the way.
    run = gm.run(braked, engine="multibody", accuracy=1e-11, times=[0.0, 10.0])
    assert run.outcome is Outcome.DONE
    assert run.readings["lever_angle"][-1] == pytest.approx(expected, abs=1e-10)  # asked


@pytest.mark.long
@pytest.mark.parametrize("engine", NAMES)
@pytest.mark.parametrize("dimensions", [scenes.PAPER_DIMENSIONS, HUNG], ids=["vertical", "hung"])
def test_small_swings_take_the_closed_forms_time(engine: str, dimensions: dict[str, Any]) -> None:
    speed = 208 * RPM
    rest = scenes.equilibrium_angle_at(dimensions, speed)
    sprung = {"spring_force": scenes.spring_force_at(dimensions, rest), "spring_rate": hartung.SPRING_RATE}
    square = closed.squared_natural_frequency(scenes.build_closed_form_governor(dimensions), lever_angle=rest, **sprung)
    period = 2 * math.pi / math.sqrt(float(square))
    found = []
    for swing in (4e-4, -4e-4):  # to both sides; what is left is of the swing's square, 1e-7
        scene = scenes.hartung_scene(dimensions, speed=speed, angle=rest + swing)
        run = gm.run(scene, engine=engine, accuracy=1e-9, times=np.linspace(0.0, 2.2 * period, 120))
        found.append(measure_period(run, "lever_angle", rest))
    assert np.mean(found) == pytest.approx(period, rel=1e-6)  # asked


@pytest.mark.parametrize("engine", NAMES)
def test_small_swings_on_a_free_spindle_take_the_closed_forms_time(engine: str) -> None:
    angle = math.radians(5)
    row = next(row for row in hartung.VERTICAL_HANGER if row[0] == 5)
    own = hartung.SPINDLE_INERTIA
    found = []
    for swing in (4e-4, -4e-4):
        # The angular momentum of rest, or the swing would be about another place.
        inertia = [own + 90 * (0.122 - 0.115 * math.sin(lever)) ** 2 for lever in (angle, angle + swing)]
        spindle = FreeSpindle(inertia=own, start_speed=row[3] * inertia[0] / inertia[1])
        scene = scenes.hartung_scene(scenes.PAPER_DIMENSIONS, speed=spindle, angle=angle + swing)
        run = gm.run(scene, engine=engine, accuracy=1e-9, times=np.linspace(0.0, 2.2 * 2 * math.pi / math.sqrt(row[8]), 120))
        found.append(measure_period(run, "lever_angle", angle))
    assert np.mean(found) == pytest.approx(2 * math.pi / math.sqrt(row[8]), rel=1e-6)


@pytest.mark.parametrize("engine", NAMES)
@pytest.mark.parametrize(
    ("dimensions", "more"),
    [(scenes.PAPER_DIMENSIONS, (Dashpot(reading="sleeve_lift", linear=300.0),)), (HUNG, ())],
    ids=["vertical, braked", "hung, bare"],
)
def test_a_wide_swing_follows_the_equation_of_motion(engine: str, dimensions: dict[str, Any], more: Any) -> None:
    scene = scenes.hartung_scene(dimensions, speed=208 * RPM, angle=0.15, rate=-0.4, more_effects=more)
    times = np.linspace(0.0, 2.0, 41)
    run = gm.run(scene, engine=engine, accuracy=1e-7, times=times)
    assert run.outcome is Outcome.DONE
    assert np.max(np.abs(run.readings["lever_angle"] - motion(dimensions, scene, times))) < 1e-7  # asked
    assert run.joint_gap.max() < 1e-7 * run.scene.part.mechanism.length_scale


@pytest.mark.parametrize("dimensions", [scenes.PAPER_DIMENSIONS, HUNG], ids=["vertical", "hung"])
def test_impulse_is_of_second_order_and_keeps_the_joints_closed(dimensions: dict[str, Any]) -> None:
    scene = scenes.hartung_scene(dimensions, speed=208 * RPM, angle=0.15, rate=-0.4)
    times = np.linspace(0.1, 1.1, 11)  # the largest error of many times has no lucky zero
    expected = motion(dimensions, scene, np.concatenate([[0.0], times]))[1:]
    steps, errors = 0.1 / (16 * 2 ** np.arange(4)), []
    for step in steps:
        run = ImpulseEngine(step=float(step), iterations=160, runs=1).run(scene, times=times, certify=False)
        errors.append(np.max(np.abs(run.readings["lever_angle"] - expected)))
        # v^2 h^2 / 2 L for the fastest joint, which goes with v, on the shortest arm.
        fastest = 0.17 * np.max(np.abs(run.rates["lever_angle"]))
        assert np.max(run.joint_gap) < (fastest * step) ** 2 / (2 * 0.115)
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("dimensions", [scenes.PAPER_DIMENSIONS, HUNG], ids=["vertical", "hung"])
def test_the_energy_ledger_holds_the_springs(dimensions: dict[str, Any]) -> None:
    brake = Dashpot(reading="sleeve_lift", linear=100.0)
    scene = scenes.hartung_scene(dimensions, speed=208 * RPM, angle=0.2, rate=-0.6, more_effects=(brake,))
    run = gm.run(scene, engine="multibody", accuracy=1e-10)
    assert run.energy.drift < 1e-9  # asked
    # The springs' part of it, by their forces: k y^2 / 2 each.
    pulls = np.array([scenes.spring_force_at(dimensions, float(lever)) for lever in run.readings["lever_angle"]])
    sprung = pulls**2 / hartung.SPRING_RATE
    weights = 9.81 * (run.poses[:, :, 1] @ [45.0, 45.0, 15.0])
    np.testing.assert_allclose(run.energy.potential, sprung + weights, rtol=1e-12)  # sums of a few terms


@pytest.mark.parametrize("dimensions", [scenes.PAPER_DIMENSIONS, HUNG], ids=["vertical", "hung"])
@pytest.mark.parametrize("degrees", [15.0, 0.0, -15.0])
def test_a_sleeve_locked_at_standstill_is_held_with_the_static_force(dimensions: dict[str, Any], degrees: float) -> None:
    angle = math.radians(degrees)
    scene = scenes.hartung_scene(dimensions, speed=0.0, angle=angle)
    height = float(scenes.sleeve_height_at(scenes.build_closed_form_governor(dimensions), angle)) - 0.115
    height -= 1.5 * 0.115 if dimensions is scenes.PAPER_DIMENSIONS else 0.0  # as far below vertical hangers it is drawn
    ends, still = {"first": Point(body=GROUND), "second": Point(body=SLEEVE)}, PrescribedMotion.constant_rate(height, 0.0)
    lock = TranslationalDriver(name="lock", **ends, angle=math.pi / 2, motion=still)
    held = replace(scene.mechanism, joints=(*scene.mechanism.joints, lock))
    locked = scene.with_changes(mechanism=held, start=Start())
    run = gm.run(locked, engine="multibody", accuracy=1e-11, times=[0.0, 0.1])
    governor, force = scenes.build_closed_form_governor(dimensions), scenes.spring_force_at(dimensions, angle)
    static = closed.static_sleeve_force(governor, lever_angle=angle, spring_force=force)
    assert run.readings["lever_angle"][-1] == pytest.approx(angle, abs=1e-12)
    np.testing.assert_allclose(run.reactions["lock"].force[:, 1], float(static), rtol=1e-9)  # asked
    # What statics tell of the same poses, from virtual work and no reaction.
    np.testing.assert_allclose(evaluate_static_forces(locked, run.poses)["static_sleeve_force"], float(static), rtol=1e-9)


@pytest.mark.parametrize("engine", [pytest.param(name, marks=pytest.mark.long) if name == "impulse" else name for name in NAMES])
def test_what_runs_outward_meets_its_stop(engine: str) -> None:
    """Let go 0.1 rad inside its rest it swings 0.1 rad beyond, and meets a stop half way there."""
    rest = scenes.equilibrium_angle_at(scenes.PAPER_DIMENSIONS, 208 * RPM)
    stops = Stops(reading="lever_angle", low=rest - 0.05, high=0.5, restitution=0.4)
    scene = scenes.hartung_scene(scenes.PAPER_DIMENSIONS, speed=208 * RPM, angle=rest + 0.1, more_effects=(stops,), duration=1.0)
    run = gm.run(scene, engine=engine, accuracy=1e-6)
    assert run.outcome is Outcome.DONE
    struck = [event for event in run.events if event.kind == "strikes its stop"]
    assert struck[0].subject == "lever_angle"
    assert run.readings["lever_angle"].min() > rest - 0.05 - 1e-6
    free = scenes.hartung_scene(scenes.PAPER_DIMENSIONS, speed=208 * RPM, angle=rest + 0.1)
    times = np.linspace(0.0, 1.0, 4001)
    crossing = times[np.argmax(motion(scenes.PAPER_DIMENSIONS, free, times) < rest - 0.05)]
    assert struck[0].time == pytest.approx(crossing, abs=3e-4)  # the witness is looked at every 0.25 ms


@pytest.mark.long
@pytest.mark.parametrize("engine", [name for name in NAMES if BellCrankMasses in ENGINES[name].effects])
def test_heavy_bell_cranks_swing_as_statics_say(engine: str) -> None:
    cranks = BellCrankMasses(mass=8.0, weight_width=0.154, weight_height=0.2, weight_depth=0.1)
    sprung = {**HUNG, "spring_rate": 35e3}  # the paper's springs are too weak for so much more mass: unstable
    speed = float(equilibrium_speed_at(scenes.hartung_scene(sprung, more_effects=(cranks,)), [0.0])[0])
    light = float(equilibrium_speed_at(scenes.hartung_scene(sprung), [0.0])[0])
    assert abs(speed / light - 1) > 1e-3  # what they change is not lost in the comparison
    scene = scenes.hartung_scene(sprung, speed=speed, more_effects=(cranks,))
    rest = min(gm.equilibria(scene), key=lambda one: abs(one.coordinate))
    period = 2 * math.pi / rest.frequency
    found = []
    for swing in (4e-4, -4e-4):
        swung = scene.with_changes(start=replace(scene.start, values={"lever_angle": swing}))
        run = gm.run(swung, engine=engine, accuracy=1e-9, times=np.linspace(0.0, 2.2 * period, 120))
        found.append(measure_period(run, "lever_angle", rest.coordinate))
    assert np.mean(found) == pytest.approx(period, rel=1e-6)


def test_both_sides_move_alike_and_the_engines_agree() -> None:
    program = Spindle(times=(0.0, 0.5, 1.5), speeds=(204 * RPM, 204 * RPM, 212 * RPM))
    scene = scenes.hartung_scene(HUNG, speed=program, angle=scenes.equilibrium_angle_at(HUNG, 204 * RPM), more_effects=(BRAKE,))
    runs = [gm.run(scene, engine=name, accuracy=1e-7) for name in NAMES]
    for run in runs:
        right, left = run.poses[:, 0], run.poses[:, 1]
        np.testing.assert_allclose(right * [-1.0, 1.0, -1.0], left, atol=1e-7)  # asked
    torques = [run.readings["spindle_torque"] / run.scales["spindle_torque"] for run in runs]
    assert np.max(np.abs(runs[0].readings["lever_angle"] - runs[1].readings["lever_angle"])) < 2e-7
    assert np.max(np.abs(torques[0] - torques[1])) < 2e-7
    assert set(NAMES) <= set(ENGINES)
