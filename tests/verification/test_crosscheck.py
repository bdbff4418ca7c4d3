"""Cross-checks: shipped scenes agree, planted errors are found, a caller's function is fed by name."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.model.part import Spindle
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.verification.machines import pendulum
from governor_mechanism.verification.machines.registry import CHECKS
from governor_mechanism.verification.report import CheckReport, ComparisonRow
from governor_scenes import CROSSED, PORTER, WATT, governor_scene
from refusing import refuses

ANGLES = np.radians([15.0, 25.0, 35.0, 45.0])


def zehnder(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    """Equation (3), written by a caller."""
    load = 1 + sleeve_mass / ball_mass
    return math.sqrt(gravity * load * math.tan(arm_angle) / (offset + arm * math.sin(arm_angle)))


def shortened(name):
    """Return a shipped scene, of which 4 s are compared: a few oscillations, or two turns."""
    scene = gm.load(name)
    return replace(scene, run=replace(scene.run, duration=min(scene.run.duration, 4.0)))


# The files are read, as loading all scenes would cost every worker a second before its first test; one of several parts has no machine.
CHECKED = [name for name, path in shipped_scenes().items() if tomllib.loads(path.read_text("utf-8")).get("machine") in CHECKS]

# Free spindles have no equilibrium speed; with clearance, friction or stops motion has no closed form, and with a program of
# speeds the torque is left out.
FEWER = {
    "air_engine_finite_rods": 1,  # no closed form but the energy balance
    "air_engine_heavy_pistons": 1,
    "parabolic": 7,
    "porter_dry_friction": 6,
    "porter_free_spindle": 3,
    "porter_load_step": 3,
    "porter_clearance": 1,
    "porter_ramp": 7,
    "porter_cyclic": 6,
    "porter_cyclic_damped": 6,
    "watt_improved": 7,
    "watt_clearance": 1,
}


@pytest.mark.parametrize("name", CHECKED)
def test_every_shipped_scene_agrees_with_its_closed_form(name):
    report = gm.crosscheck(shortened(name))
    assert report.passed, str(report)
    assert len(report.rows) >= FEWER.get(name, 8)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("watt_improved", ["checked without dashpot and stops", "does not include dashpot and stops"]),
        ("porter_clearance", ["with clearance the sleeve is not fixed to the links"]),
        ("porter_cyclic", ["checked without dry friction", "does not include dry friction"]),
    ],
)
def test_what_has_no_closed_form_is_noted(name, words):
    scene = gm.load(name)
    short = replace(scene, run=replace(scene.run, duration=0.1))
    notes = "\n".join(gm.crosscheck(short).notes)
    for part in words:
        assert part in notes


def test_a_wrong_inertia_of_the_rods_is_found(monkeypatch):
    right = pendulum.build_pendulum_closed_form
    monkeypatch.setattr(pendulum, "build_pendulum_closed_form", lambda scene: replace(right(scene), link_mass=0.49))
    scene = gm.load("porter_heavy_rods")
    report = gm.crosscheck(replace(scene, run=replace(scene.run, duration=1.0)))
    assert sum(not row.passed for row in report.rows) >= 5


def test_a_linear_brake_on_the_sleeve_is_part_of_the_closed_motion(monkeypatch):
    scene = gm.load("porter_dashpot")
    assert any("in motion" in row.quantity for row in gm.crosscheck(scene).rows)
    right = pendulum.closed.arm_acceleration
    monkeypatch.setattr(pendulum.closed, "arm_acceleration", lambda *a, **k: right(*a, **{**k, "damping": 40.1}))
    assert not gm.crosscheck(scene).passed


def test_a_custom_mechanism_has_no_closed_form():
    refuses("there is no closed form for machine 'custom'", gm.crosscheck, "pendulum_iftomm")


def test_a_wrong_closed_form_is_found(monkeypatch):
    right = pendulum.closed.squared_oscillation_frequency
    monkeypatch.setattr(pendulum.closed, "squared_oscillation_frequency", lambda *a, **k: 1.0001 * right(*a, **k))
    report = gm.crosscheck(governor_scene(PORTER, speed=13.0, angle=0.7))
    assert [row.quantity.split()[0] for row in report.rows if not row.passed] == ["small-oscillation"]
    assert "1 of 8 do not agree" in str(report)


def test_a_wrong_equation_of_motion_is_found(monkeypatch):
    right = pendulum.closed.arm_acceleration
    monkeypatch.setattr(pendulum.closed, "arm_acceleration", lambda *a, **k: right(*a, **k) - 1e-4)
    report = gm.crosscheck(governor_scene(PORTER, speed=13.0, angle=0.7))
    assert any("in motion" in row.quantity and not row.passed for row in report.rows)


def test_a_scene_without_rest_is_checked_in_motion_alone():
    # Below its lowest speed the crossed governor has no equilibrium at all.
    report = gm.crosscheck(governor_scene(CROSSED, speed=14.0, angle=0.7, duration=0.4))
    assert [row.quantity.split(",")[0].split(" (")[0] for row in report.rows] == [
        "arm angle in motion",
        "spindle torque in motion",
        "Jacobi integral",
    ]
    assert report.passed, str(report)
    assert any("no equilibrium within the travel" in note for note in report.notes)


def test_a_run_that_ends_early_is_noted_and_compared_as_far_as_it_went():
    report = gm.crosscheck(governor_scene(CROSSED, speed=13.0, angle=0.6, duration=5.0))
    assert any("the balls meet" in note and "of 5 s" in note for note in report.notes)
    assert report.passed, str(report)


def test_a_run_worse_than_asked_does_not_widen_its_own_tolerance(monkeypatch):
    scene = governor_scene(PORTER, speed=13.0, angle=0.9)
    coarse = ImpulseEngine(step=2e-2, plain=True)
    monkeypatch.setattr(pendulum.comparisons, "run_scene", lambda scene: coarse.run(scene))
    report = gm.crosscheck(scene)
    assert not next(row for row in report.rows if row.quantity.startswith("arm angle in motion")).passed


def test_turning_backwards_changes_nothing_but_the_sign():
    report = gm.crosscheck(governor_scene(PORTER, speed=-13.0, angle=0.7))
    assert report.passed, str(report)
    assert len(report.rows) == 8


@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_a_spindle_too_slow_to_lift_the_arms_is_noted(speed):
    assert gm.crosscheck(governor_scene({**PORTER, "offset": 0.0}, speed=speed, angle=0.3, duration=0.2)).notes


def test_a_scene_without_gravity_has_no_closed_form():
    scene = governor_scene(PORTER, speed=13.0, angle=0.7).with_changes(effects=())
    refuses("need the effects gravity and centrifugal", gm.crosscheck, scene)


def test_a_speed_program_is_checked_too():
    spindle = Spindle(times=(0.0, 0.5, 0.5, 1.0), speeds=(12.5, 12.9, 13.2, 12.8))
    report = gm.crosscheck(governor_scene(PORTER, speed=spindle, angle=0.6))
    assert report.passed, str(report)


def test_a_right_kernel_passes():
    report = gm.crosscheck(governor_scene(PORTER, speed=13.0, angle=0.7), kernel=zehnder, over={"arm_angle": ANGLES})
    assert report.passed
    assert len(report.rows) == len(ANGLES)
    assert max(abs(row.difference) for row in report.rows) < 1e-10


def test_a_kernel_one_per_cent_off_is_found():
    def off(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
        return 1.01 * zehnder(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity)

    report = gm.crosscheck(governor_scene(PORTER, speed=13.0, angle=0.7), kernel=off, over={"arm_angle": ANGLES})
    assert not report.passed
    assert not any(row.passed for row in report.rows)


def test_a_kernel_may_take_readings_and_leave_defaults_alone():
    scene = governor_scene(WATT, speed=5.0, angle=0.7)

    def by_radius(ball_radius, arm_angle, gravity=9.81, unused="left alone"):
        return math.sqrt(gravity * math.tan(arm_angle) / ball_radius)

    assert gm.crosscheck(scene, kernel=by_radius, over={"arm_angle": ANGLES}).passed


def test_a_kernel_of_a_position_is_compared_with_that_reading():
    scene = governor_scene(PORTER, speed=13.0, angle=0.7)
    lift = lambda arm_angle, arm: 2 * arm * (1 - math.cos(arm_angle))  # noqa: E731
    assert gm.crosscheck(scene, kernel=lift, quantity="sleeve_lift", over={"arm_angle": ANGLES}).passed


def test_a_kernel_that_gives_no_number_fails_its_row_only():
    scene = governor_scene(PORTER, speed=13.0, angle=0.7)

    def sometimes(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
        good = zehnder(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity)
        return good if arm_angle < 0.7 else math.nan

    report = gm.crosscheck(scene, kernel=sometimes, over={"arm_angle": ANGLES})
    assert [row.passed for row in report.rows] == [True, True, True, False]


@pytest.mark.parametrize(
    ("kernel", "options", "sentence"),
    [
        (lambda arm_angel: 1.0, {}, r"unknown parameter 'arm_angel'.*Did you mean 'arm_angle'"),
        (lambda arm_angel, gravitas: 1.0, {}, r"(?s)'arm_angel'.*'gravitas'.*Did you mean 'gravity'"),
        (lambda *values: 1.0, {}, "cannot be matched by name"),
        (lambda arm_angle: "fast", {}, "must return one real number"),
    ],
)
def test_a_kernel_that_cannot_be_used_is_refused_in_a_sentence(kernel, options, sentence):
    scene = governor_scene(PORTER, speed=13.0, angle=0.7)
    refuses(sentence, gm.crosscheck, scene, kernel=kernel, **{"over": {"arm_angle": ANGLES}, **options})


def test_a_machine_without_closed_form_is_refused():
    scene = governor_scene(PORTER, speed=13.0, angle=0.7)
    scene = scene.with_changes(machine="steam_hammer")
    refuses("there is no closed form for machine 'steam_hammer'", gm.crosscheck, scene)


def test_a_report_without_rows_has_not_passed_and_nan_never_passes():
    assert not CheckReport(title="", against="", rows=()).passed
    row = ComparisonRow(quantity="q", simulated=math.nan, expected=1.0, allowed=1.0, unit="1", reason="")
    assert not row.passed
