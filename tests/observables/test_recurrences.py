"""How named crossings recur: interval, advances and energies of a damped oscillator and of a clock, against closed forms."""

import math
from itertools import pairwise

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import invoke
from governor_mechanism.errors import UnknownName

MASS, DAMPING, STIFFNESS, FORCE = 2.0, 0.4, 50.0, 3.0
DECAY = DAMPING / (2 * MASS)
FREQUENCY = math.sqrt(STIFFNESS / MASS - DECAY**2)
MIDDLE, AMPLITUDE = FORCE / STIFFNESS, 0.1


def oscillator(**changes):
    """A mass with a spring, a damper and a constant force; it starts at rest, off its position of equilibrium."""
    ends = {"first": "ground.origin", "second": "mass.origin"}
    document = {
        "machine": "custom",
        "ground": {"wall": [-1, 0]},
        "body": [{"name": "mass", "mass": MASS, "at": [MIDDLE + AMPLITUDE, 0], "turns": False}],
        "joint": [{"type": "slider", **ends, "angle": 0}],
        "force": [
            {"type": "spring", "name": "spring", **ends, "first": "ground.wall", "stiffness": STIFFNESS, "free_length": 1.0},
            {"type": "damper", "name": "damper", **ends, "first": "ground.wall", "damping": DAMPING},
            {"type": "force", "name": "pull", "point": "mass.origin", "x": FORCE},
        ],
        "readings": {"x": {"x": "mass.origin"}},
        "start": {"x": MIDDLE + AMPLITUDE, "x_rate": 0},
        "run": {"duration": 6.0, "output_interval": 0.3},
        "events": {"beat": {"reading": "x", "value": MIDDLE}},
    }
    return document | changes


def exact_state(time):
    """Return deviation from the middle and velocity of the oscillator."""
    decayed, phase = AMPLITUDE * math.exp(-DECAY * time), FREQUENCY * time
    return decayed * (math.cos(phase) + DECAY / FREQUENCY * math.sin(phase)), -decayed * STIFFNESS / MASS / FREQUENCY * math.sin(phase)


def exact_means(direction):
    """Return the mean work and the mean loss from one crossing to the next, by the states in the middle between two."""
    half, first = math.pi / FREQUENCY, (math.pi - math.atan(FREQUENCY / DECAY)) / FREQUENCY
    times = [first + k * half for k in range(20) if first + k * half < 6.0]
    times = times if direction == "both" else times[1::2]  # it falls through the middle first
    middles = [(start + end) / 2 for start, end in pairwise(times)]
    if direction == "both":
        middles = middles[(len(middles) - 1) % 2 :]
    n, ((x0, v0), (x1, v1)) = len(middles) - 1, (exact_state(middles[k]) for k in (0, -1))
    energies = [MASS * v**2 / 2 + STIFFNESS * (x + MIDDLE) ** 2 / 2 for x, v in ((x0, v0), (x1, v1))]
    work = FORCE * (x1 - x0)
    return len(times), work / n, (work + energies[0] - energies[1]) / n


@pytest.mark.parametrize(("direction", "halves"), [("both", 1), ("up", 2)])
def test_a_damped_oscillator_recurs_as_its_closed_form(direction, halves):
    document = oscillator()
    document["events"]["beat"]["direction"] = direction
    beat = gm.run(gm.Scene.from_dict(document), accuracy=1e-9).recurrences["beat"]
    count, supplied, lost = exact_means(direction)
    assert beat.count == count
    assert abs(beat.interval - halves * math.pi / FREQUENCY) <= beat.interval_error < 1e-9
    assert beat.frequency == pytest.approx(FREQUENCY / math.pi / halves, rel=1e-8)
    assert beat.advances == {}
    assert beat.supplied == pytest.approx(supplied, rel=1e-7)
    assert beat.lost == pytest.approx(lost, rel=1e-7)


def test_what_goes_on_is_told_from_what_swings():
    """A wheel that turns at a constant speed beside the oscillator advances; its torque in a varying direction has no given work."""
    document = oscillator()
    document["body"].append({"name": "wheel", "mass": 1.0, "inertia": 0.1})
    document["joint"].append({"type": "pin", "first": "ground.origin", "second": "wheel.origin"})
    document["readings"]["turn"] = {"angle": "wheel"}
    document["start"]["turn_rate"] = -7.0
    beat = gm.run(gm.Scene.from_dict(document)).recurrences["beat"]
    assert beat.advances == {"turn": pytest.approx(-7 * math.pi / FREQUENCY, rel=1e-6)}
    assert beat.units == {"turn": "rad"}
    document["force"].append({"type": "torque", "name": "load", "body": "wheel", "moment": [[0, 0], [3, 1e-3]]})
    assert gm.run(gm.Scene.from_dict(document)).recurrences["beat"].supplied is None


def test_a_driver_does_work_that_positions_do_not_give():
    beats = gm.run(gm.load("slide_valve_30").replace({"run.duration": "8 s"})).recurrences
    assert set(beats) >= {"admission", "cut_off", "release"}
    assert beats["cut_off"].interval == pytest.approx(2.0, abs=1e-9)  # 30 rpm
    assert beats["cut_off"].supplied is None


def test_what_happens_seldom_or_at_unequal_intervals_does_not_recur():
    document = oscillator(run={"duration": 1.5, "output_interval": 0.3})
    assert len(gm.run(gm.Scene.from_dict(document)).events) < 4
    assert gm.run(gm.Scene.from_dict(document)).recurrences == {}
    off_middle = oscillator(events={"beat": {"reading": "x", "value": MIDDLE + 0.06, "direction": "up"}})
    assert set(gm.run(gm.Scene.from_dict(off_middle)).recurrences) == {"beat"}
    with pytest.raises(UnknownName, match="no recurring event 'tick'"):
        gm.run(gm.Scene.from_dict(document)).recurrences["tick"]
    # A weight that bounces passes a height at ever shorter intervals.
    ball = {"name": "ball", "mass": 1.0, "at": [0, 1], "turns": False}
    slider = {"type": "slider", "first": "ground.origin", "second": "ball.origin", "angle": "90 deg"}
    bouncing = oscillator(
        body=[ball],
        joint=[slider],
        force=[],
        readings={"height": {"y": "ball.origin"}},
        effects={"gravity": True, "stops": {"height": [0, "none"], "restitution": 0.7}},
        start={"height": 1},
        events={"pass": {"reading": "height", "value": 0.05}},
    )
    run = gm.run(gm.Scene.from_dict(bouncing))
    assert sum(event.subject == "pass" for event in run.events) > 6
    assert run.recurrences == {}


def test_the_command_prints_what_recurs_and_the_saved_run_has_it(tmp_path):
    result = invoke("run", "slide_valve_30", "--seconds", "8 s", "--no-film", "--no-figure", "--out", tmp_path)
    assert "cut_off: 4 times, every 2 s, accurate to " in result.stdout
    assert gm.open_run(tmp_path / "slide_valve_30.nc").recurrences["cut_off"].count == 4
    run = gm.run(gm.Scene.from_dict(oscillator()))
    assert ["work of the forces" in str(run.recurrences["beat"]), "losses" in str(run.recurrences["beat"])] == [True, True]


@pytest.mark.long
def test_a_beat_of_the_clock_turns_its_wheel_by_half_a_tooth_at_a_certified_rate():
    times = np.linspace(0.0, 3.0, 31)
    beat, finer = (gm.run("graham_escapement", times=times, accuracy=accuracy).recurrences["beat"] for accuracy in (1e-6, 1e-9))
    assert beat.advances == {"wheel_angle": pytest.approx(-math.radians(6), rel=1e-9)}
    assert beat.supplied == pytest.approx(1.2e-3 * math.radians(6), rel=1e-9)
    assert abs(beat.interval - finer.interval) <= beat.interval_error < 1e-8
    assert beat.lost == pytest.approx(finer.lost, rel=1e-6)
