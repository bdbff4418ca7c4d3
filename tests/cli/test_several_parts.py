"""Commands on a scene of several parts: an engine and its governor."""

import csv
import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.io import netcdf_file

import governor_mechanism as gm
from command_line import json_of, succeed
from coupled_scenes import coupled_scene, discs_part, engine_part, porter_part
from governor_mechanism.effects.body_forces import Centrifugal
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.model.coupling.couplings import ControlCoupling, GearCoupling
from governor_mechanism.model.time_functions import InputFunction, LinearFunction
from refusing import refuses

READINGS = [
    "engine.crank_angle",
    "governor.arm_angle",
    "governor.ball_radius",
    "governor.sleeve_lift",
    "governor.spindle_speed",
    "governor.spindle_angle",
]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """The shipped Watt governor on an engine, a second and a half long."""
    shipped = Path(__file__).parents[2] / "models" / "watt_engine_stable.toml"
    text = shipped.read_text(encoding="utf-8").replace('duration = "20 s"', 'duration = "1.5 s"').replace("1e-8", "1e-5")
    text = text.replace('output_interval = "20 ms"', 'output_interval = "100 ms"')
    path = tmp_path_factory.mktemp("scene") / "engine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.long
def test_run_writes_readings_of_all_parts(scene, tmp_path):
    assert "at 1.5 s: engine.crank_angle " in succeed("run", scene, "--verbose", "--out", str(tmp_path)).stdout
    with (tmp_path / "engine.csv").open(encoding="utf-8") as stream:
        units, header = itertools.islice(csv.reader(stream), 2)
    assert units[0].startswith("# units: time s; engine.crank_angle rad; ")
    assert header == ["time", *READINGS]
    assert list(json.loads((tmp_path / "engine.json").read_text(encoding="utf-8"))["final"]) == READINGS
    with netcdf_file(tmp_path / "engine.nc", mmap=False) as dataset:
        assert set(READINGS) < {getattr(variable, "long_name", b"").decode() for variable in dataset.variables.values()}
        assert dataset.dimensions["body"] == len(gm.load(scene).mechanism.bodies)
        speed, rate = (dataset.variables[name][:] for name in ("reading_governor_spindle_speed", "rate_engine_crank_angle"))
    np.testing.assert_allclose(speed, 2.0 * rate, rtol=1e-12)  # the ratio of the belt, to rounding
    with Image.open(tmp_path / "engine.gif") as film:
        assert film.size == (766, 480)  # a panel of 286 pixels for the engine beside the frame of the governor
    with Image.open(tmp_path / "engine.png") as figure:
        assert figure.size[0] > 0


def test_run_as_json_has_the_final_readings_of_all_parts(scene, tmp_path):
    assert list(json_of("run", scene, "--no-film", "--out", tmp_path)["final"]) == READINGS
    assert not (tmp_path / "engine.gif").exists()


@pytest.mark.long
def test_equilibria_are_those_of_the_rotating_part(scene, tmp_path):
    """At the speed of the shipped steady state the arms hang at an angle with the cosine 0.6, as g = 0.3 m x 0.6 x speed^2."""
    speed = math.sqrt(9.81 / (0.3 * 0.6))
    (point,) = (point for point in gm.equilibria(scene, speed) if point.stable)
    assert point.coordinate == pytest.approx(math.acos(0.6), rel=1e-12)
    words = ("--speed", f"{speed} rad/s", "--resistance", "1 N", "--against", "sleeve_lift", "--out", tmp_path)
    result = succeed("equilibria", scene, *words)
    assert "(part 'governor' alone, started at 6.53086 rad/s)" in result.stdout
    assert "53.1301 deg: stable" in result.stdout
    assert "insensitivity" in result.stdout
    assert [path.name for path in tmp_path.iterdir() if "characteristic" in path.name] == ["engine_characteristic.png"]


def test_a_part_on_a_free_spindle_has_its_equilibrium_at_the_speed_of_the_start():
    assert gm.equilibria("haug_governor")[0].coordinate == pytest.approx(0.05, rel=1e-9)  # the given height of the collar


def test_the_rotating_part_is_checked_against_closed_forms(scene):
    result = succeed("crosscheck", scene)
    assert "all 6 agree" in result.stdout
    assert "part 'governor' alone" in result.stdout  # the loop with the engine is not checked


BELT = GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle")
RUBBING = ControlCoupling(
    name="rubbing", target="governor.dry_friction.sleeve_lift", function=LinearFunction(reading="engine.crank_angle", gain=1.0)
)
SLEEVE_FRICTION = DryFriction(reading="sleeve_lift", force=InputFunction(values=(10.0,)))


def governor_with_friction(reading):
    """Return a governor with a friction along the sleeve that depends on a reading."""
    force = InputFunction(values=(10.0,), functions=(LinearFunction(reading=reading, gain=1.0),))
    return replace(porter_part(), effects=(*porter_part().effects, DryFriction(reading="sleeve_lift", force=force)))


@pytest.mark.parametrize("reading", ["sleeve_lift", "governor.sleeve_lift"])
def test_a_load_may_name_a_reading_of_its_own_part_with_or_without_the_part(reading):
    without, with_friction = (
        gm.equilibria(coupled_scene(engine_part(), governor, couplings=(BELT,)))
        for governor in (porter_part(), governor_with_friction(reading))
    )
    assert [point.coordinate for point in without] == [point.coordinate for point in with_friction]  # equilibria leave friction out


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (coupled_scene(engine_part(), discs_part("pump", {"rotor": 1.0})), "in this scene these parts turn: none"),
        (
            coupled_scene(engine_part(), porter_part(), replace(porter_part(), name="second"), couplings=(BELT,)),
            "in this scene these parts turn: 'governor', 'second'",
        ),
        (
            coupled_scene(engine_part(), porter_part(effects=(Centrifugal(), SLEEVE_FRICTION)), couplings=(BELT, RUBBING)),
            "depends on other parts through coupling 'rubbing'",
        ),
        (
            coupled_scene(engine_part(), governor_with_friction("engine.crank_angle"), couplings=(BELT,)),
            "part 'governor' has no equilibria of its own: a load depends on 'engine.crank_angle', which is no reading",
        ),
    ],
)
def test_parts_without_equilibria_of_their_own_are_refused(scene, message):
    refuses(message, gm.equilibria, scene)


@pytest.mark.parametrize(
    "call_function", [gm.valve_timing, lambda scene: gm.kinematics(scene, "engine.crank_angle", [0.1])], ids=["valve timing", "kinematics"]
)
def test_functions_for_one_part_refuse_several(scene, call_function):
    refuses(r"parts|degrees of freedom", call_function, gm.load(scene))


def test_a_sweep_varies_couplings_and_dimensions_of_parts(scene, tmp_path):
    keys = {"coupling.belt.ratio": "2,2.01", "part.governor.dimensions.arm": "299mm,300mm"}
    vary = [word for key, values in keys.items() for word in ("--vary", f"{key}={values}")]
    quantities = ["--quantity", "final governor.spindle_speed", "--quantity", "final rate of engine.crank_angle"]
    succeed("sweep", scene, *vary, *quantities, "--json", "--out", tmp_path)
    with (tmp_path / "engine_sweep.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 4
    for row in rows:
        numbers = {key.split(" [")[0]: value for key, value in row.items()}
        ratio = float(numbers["final governor.spindle_speed"]) / float(numbers["final rate of engine.crank_angle"])
        assert ratio == pytest.approx(float(numbers["coupling.belt.ratio"]), rel=1e-12)


def test_effects_are_switched_part_by_part(scene, tmp_path):
    answer = json_of("effects", scene, "--out", str(tmp_path))
    rows = {row["effect"]: row for row in answer["effects"]}
    assert list(rows) == ["engine.gravity", "governor.gravity", "governor.centrifugal", "governor.dashpot"]
    assert rows["engine.gravity"]["relative_change"] == 0.0  # the flywheel turns about its mass centre
    assert rows["governor.dashpot"]["relative_change"] > 1e-3
    assert "governor.rods" in answer["untried"]
    assert "engine.rods" not in answer["untried"]
    assert "engine.centrifugal" not in answer["untried"]


@pytest.mark.long
def test_accuracy_measures_the_engine_that_can_run_it(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("governor_mechanism.studies.work_precision.MIN_REPEATS", 1)
    monkeypatch.setattr("governor_mechanism.studies.work_precision.MIN_TIMING_DURATION", 0.0)
    variants = {row["name"]: row for row in json_of("accuracy", scene, "--longest", "0.3", "--out", tmp_path)["variants"]}
    assert variants["multibody"]["points"]  # how many depends on the speed of the machine
    assert variants["reduced"]["points"]
    assert "choose engine multibody" in variants["impulse extrapolated"]["refusal"]
