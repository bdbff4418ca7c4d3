"""Sensitivities against derivatives of closed forms, and the places where there is none."""

import cmath
import math

import pytest

import governor_mechanism as gm
from command_line import invoke

MASS, DAMPING, STIFFNESS, START, DURATION = 2.0, 3.0, 50.0, 0.5, 2.0
REST = 0.4
KEYS = {"body.block.mass": 0, "force.damper.damping": 1, "force.spring.stiffness": 2, "start.x": 3}


def block(*, duration=DURATION, damping=True, **effects):
    """A block on a slide with a spring, and a damper or other effects."""
    force = [
        {"name": "spring", "type": "spring", "first": "ground.A", "second": "block.centre", "stiffness": STIFFNESS, "free_length": REST}
    ]
    damper = {"name": "damper", "type": "damper", "first": "ground.A", "second": "block.centre", "damping": DAMPING}
    document = {
        "machine": "custom",
        "title": "block on a slide",
        "ground": {"A": [0, 0]},
        "body": [{"name": "block", "mass": MASS, "turns": False, "at": [REST, 0]}],
        "joint": [{"name": "slide", "type": "slider", "first": "ground.A", "second": "block.centre", "angle": 0.0}],
        "force": [*force, *([damper] if damping else [])],
        "readings": {"x": {"x": "block.centre"}},
        "start": {"x": START},
        "effects": effects,
        "run": {"duration": duration, "output_interval": 0.01},
    }
    return gm.Scene.from_dict(document)


def place(mass, damping, stiffness, start, time=DURATION):
    """Return the place of the damped oscillator; all arguments may be complex."""
    decay, frequency = damping / (2 * mass), cmath.sqrt(stiffness / mass - (damping / (2 * mass)) ** 2)
    envelope = (start - REST) * cmath.exp(-decay * time)
    return REST + envelope * (cmath.cos(frequency * time) + decay / frequency * cmath.sin(frequency * time))


def exact_derivative(index):
    arguments = [complex(one) for one in (MASS, DAMPING, STIFFNESS, START)]
    arguments[index] += 1e-30j
    return place(*arguments).imag / 1e-30


@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_derivatives_of_an_oscillator_are_the_exact_ones_within_their_errors(engine):
    found = gm.sensitivities(block(), ["x", "rate of x"], list(KEYS), engine=engine)
    assert found.ok
    assert found.n_runs == 4 * len(KEYS) + 1
    for key, index in KEYS.items():
        row = found.at("x", key)
        exact = exact_derivative(index)
        assert abs(row.value - exact) <= row.error
        assert row.error < 1e-7 * max(1.0, abs(exact) * 10)
        history = found.histories["x", key]
        assert history[-1] == row.value
        assert history[0] == pytest.approx(1.0 if key == "start.x" else 0.0, abs=1e-9)


def test_derivatives_with_dry_friction_are_exact_between_changes_of_the_number_of_swings():
    """Every half swing loses 2 F / k; the block rests where the spring is weaker than the friction."""
    friction, k, x0 = 0.3, STIFFNESS, START - REST
    scene = block(duration=7.0, damping=False, dry_friction={"x": friction})
    found = gm.sensitivities(scene, ["x"], ["effects.dry_friction.x", "force.spring.stiffness"])
    n_swings = math.ceil((k * x0 / friction - 1) / 2)
    sign = (-1) ** n_swings
    for key, exact in (
        ("effects.dry_friction.x", -sign * 2 * n_swings / k),
        ("force.spring.stiffness", sign * 2 * n_swings * friction / k**2),
    ):
        row = found.at("x", key)
        assert abs(row.value - exact) <= row.error
        assert row.error < 1e-7


def test_no_derivative_where_another_swing_begins(tmp_path):
    """With a little less friction the block makes a fourth half swing: the slope of its place changes from -2 x 4 / k to 2 x 3 / k."""
    friction = STIFFNESS * (START - REST) / 7  # the spring is as strong as the friction after three half swings
    scene = block(duration=7.0, damping=False, dry_friction={"x": friction})
    found = gm.sensitivities(scene, ["x"], ["effects.dry_friction.x"])
    (row,) = found.rows
    assert row.value is None
    assert row.error is None
    assert "x has a kink there, with the slopes -0.16 and 0.12" in row.refusal
    assert not found.ok
    path = scene.save(tmp_path / "block.toml")
    told = invoke("sensitivities", path, "--of", "x", "--by", "effects.dry_friction.x", "--out", tmp_path / "out")
    assert told.exit_code == 1
    assert {one.suffix for one in (tmp_path / "out").iterdir()} == {".csv", ".json"}, "there is nothing to draw"


def test_no_derivative_where_a_stop_is_grazed():
    decay = DAMPING / (2 * MASS)
    turn = math.pi / math.sqrt(STIFFNESS / MASS - decay**2)
    lowest = place(MASS, DAMPING, STIFFNESS, START, turn).real
    (row,) = gm.sensitivities(block(stops={"x": [lowest, 1.0]}), ["x"], ["start.x"]).rows
    assert "the contacts are others: event 1 is" in row.refusal


def distance_from_middle(run):
    """Return how far the block is from its place at the end of the run of the scene itself."""
    return abs(float(run.readings["x"][-1]) - place(MASS, DAMPING, STIFFNESS, START).real)


def test_a_kink_is_named_with_both_slopes():
    found = gm.sensitivities(block(), {"distance": distance_from_middle}, ["start.x"])
    (row,) = found.rows
    assert "distance has a kink" in row.refusal
    slope = abs(exact_derivative(3))
    assert f"{-slope:.3f}"[:-1] in row.refusal
    assert f"{slope:.3f}"[:-1] in row.refusal


def test_similar_governors_have_the_same_motion():
    """Masses that change alike change nothing: the elasticities of a frequency by both cancel."""
    found = gm.sensitivities("porter", ["frequency of arm_angle"], ["dimensions.ball_mass", "dimensions.sleeve_mass"])
    first, second = found.rows
    assert first.elasticity + second.elasticity == pytest.approx(0.0, abs=1e-6)
    assert abs(first.elasticity) > 0.1


def test_extremes_are_those_of_the_times_where_the_scene_has_them():
    found = gm.sensitivities(block(), ["min x", "max x", "span x"], ["start.x"])
    low, high, span = (row.value for row in found.rows)
    assert high == pytest.approx(1.0, abs=1e-8)
    assert span == pytest.approx(high - low, abs=1e-8)
