"""Drawing and plate of the engine with a flywheel: the indicator points run along their loops, over the pistons."""

import math
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from crank_scenes import air_engine_document, air_engine_scene
from decoding import words_of
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.closed_form import flywheel_engine as closed
from governor_mechanism.render.figures.plates.engines import draw_engine_plate, engine_plate_refusal
from governor_mechanism.render.geometry.primitives import Circle
from governor_mechanism.scenes.parser import parse_scene_document
from reference import flywheel

RODS = {"connecting_rod": 1.6, "pump_connecting_rod": 1.3}
NO_PUMP = dict.fromkeys(("pump_area", "pump_stroke", "pump_clearance"))


@pytest.fixture(scope="module")
def drawn():
    return Drawn(gm.run(air_engine_scene(accuracy=1e-6), engine="reduced"))


def marks(drawn, k: int) -> list[Circle]:
    """Indicator points at a reported time: those of the faces of both pistons, first toward the shaft."""
    return [shape for shape in drawn.at(k) if isinstance(shape, Circle) and shape.role.endswith(" mark")]


@pytest.mark.parametrize("k", [3, 20, 40, 62, 83, 120])
def test_the_indicator_points_show_the_pressures_of_the_closed_form(drawn, k):
    engine = closed.AirEngine(**(flywheel.ENGINE | {"load_pressure": 4e4}))
    angle = float(drawn.run.readings["crank_angle"][k])
    laws = closed.expansion_pressure, closed.suction_pressure, closed.delivery_pressure
    driving, behind, before = (float(law(engine, crank_angle=angle)) for law in laws)
    is_return = math.floor(angle / math.pi) % 2 == 1
    expected = [driving, 1.5e5, behind, before] if not is_return else [1.5e5, driving, before, behind]
    heights = np.array([mark.y for mark in marks(drawn, k)])
    zeros = np.array([drawn.drawing._cylinders[i].diagram_base for i in (0, 0, 1, 1)])
    scale = 0.36 * flywheel.ENGINE["stroke"] / 4e5  # metres of the picture for a pascal
    assert heights == pytest.approx(zeros + scale * np.array(expected), abs=1e-6 * 0.65)  # errors of the run
    assert [mark.x for mark in marks(drawn, k)] == pytest.approx([drawn.run.readings["piston_travel"][k]] * 4, abs=1e-6)


MOVING = {"throttle": [[0.0, 1.0], [2.0, 0.5]], "cut_off": [[0.0, 0.15], [2.0, 0.6]], "load_torque": 200.0}


def test_the_indicator_points_and_the_diagram_follow_throttle_and_cut_off():
    drawn = Drawn(gm.run(air_engine_scene(MOVING, accuracy=1e-6)))
    readings = drawn.run.readings
    scale, zero = 0.36 * flywheel.ENGINE["stroke"] / 4e5, drawn.drawing._cylinders[0].diagram_base
    highest = []
    for k in range(3, len(drawn.run.times), 20):
        is_return = math.floor(readings["crank_angle"][k] / math.pi) % 2 == 1
        driving = marks(drawn, k)[1 if is_return else 0]
        pressure = float(readings["expansion_pressure"][k])
        assert driving.y == pytest.approx(zero + scale * pressure, abs=1e-6 * 0.65)  # errors of the run
        loop = of_role(drawn.at(k), "head end curve")[0]
        highest.append((max(y for _, y in loop.lines[0]) - zero) / scale)
    openings = readings["throttle_opening"][3::20]
    assert highest == pytest.approx(1.5e5 + openings * 2.5e5, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "effects"), [({}, {}), (MOVING, {}), (RODS, {}), (RODS, {"piston_masses": {"piston": 250.0}}), (NO_PUMP, {})]
)
def test_every_pose_gives_the_same_shapes_within_the_bounds(changes, effects):
    result = gm.run(parse_scene_document(air_engine_document(changes, effects, duration=1.1, accuracy=1e-6)))
    drawn = Drawn(result)
    assert_shapes_keep(drawn)
    left, right, bottom, top = drawn.drawing.bounds
    assert 0.5 < (right - left) / (top - bottom) < 1.8


def test_the_plate_marks_the_angles_of_extreme_speed(drawn, tmp_path: Path):
    plate = draw_engine_plate(drawn.run)
    texts = words_of(plate)
    found = {letter: next(float(text.split(" = ")[1][:-1]) for text in texts if letter in text) for letter in ("alpha", "beta")}
    _, _, alpha, beta, _, _ = flywheel.CASES["closed by the load"]
    assert found["alpha"] % 180 == pytest.approx(alpha, abs=0.06)  # digits of the plate; either stroke has it
    assert found["beta"] % 180 == pytest.approx(beta, abs=0.06)
    assert plate.save(tmp_path / "plate.png").read_bytes()[:4] == b"\x89PNG"
    short = gm.run(air_engine_scene(duration=0.5, accuracy=1e-6), engine="reduced")
    assert engine_plate_refusal(short) == "the shaft makes no complete turn"
