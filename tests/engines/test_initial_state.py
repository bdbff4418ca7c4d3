"""How scenes start: guesses are closed, values and rates met, and what cannot start is refused in a sentence."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.scenes.parser import parse_scene_document

FOUR_BAR = """
machine = "custom"
[ground]
A = [0, 0]
D = ["400 mm", 0]
[[body]]
name = "crank"
mass = "1 kg"
rod = { length = "100 mm" }
angle = "60 deg"
[[body]]
name = "coupler"
mass = "1 kg"
rod = { length = "350 mm" }
at = ["50 mm", "87 mm"]
angle = "20 deg"
[[body]]
name = "rocker"
mass = "1 kg"
rod = { length = "250 mm" }
at = ["400 mm", 0]
angle = "95 deg"
[[joint]]
type = "pin"
name = "A"
first = "ground.A"
second = "crank.start"
[[joint]]
type = "pin"
name = "B"
first = "crank.end"
second = "coupler.start"
[[joint]]
type = "pin"
name = "C"
first = "coupler.end"
second = "rocker.end"
[[joint]]
type = "pin"
name = "D"
first = "ground.D"
second = "rocker.start"
[effects]
gravity = true
[run]
duration = "0.2 s"
[readings]
crank_angle = { angle = "crank" }
rocker_angle = { angle = "rocker" }
"""

DRIVE = """
[[joint]]
type = "driven_turn"
name = "{name}"
first = "ground"
second = "{body}"
rate = "{rate}"
"""


def scene(*more, text=FOUR_BAR):
    return parse_scene_document(tomllib.loads(text + "".join(more)), "linkage.toml")


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_a_guess_is_closed_and_the_run_says_by_how_much_it_was_open(engine):
    made = scene()
    run = gm.run(made, engine=engine)
    assert run.outcome.ok
    assert run.mobility == 1
    assert len(run.notes) == 1
    assert "was a guess: joint 'C' was open by" in run.notes[0]
    assert run.joint_gap[0] < 1e-14
    assert np.all(run.rates["crank_angle"][:1] == 0.0)


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_start_values_and_rates_are_met(engine):
    made = scene('[start]\ncrank_angle = "75 deg"\ncrank_rate = "3 rad/s"\n')
    run = gm.run(made, engine=engine)
    assert run.readings["crank_angle"][0] == pytest.approx(math.radians(75), abs=1e-13)
    assert run.rates["crank_angle"][0] == pytest.approx(3.0, abs=1e-12)
    assert run.notes == ()  # what was asked for is no guess


@pytest.mark.parametrize(
    ("more", "text", "sentence"),
    [
        (['[start]\ncrank_angle = "75 deg"\nrocker_angle = "80 deg"\n'], FOUR_BAR, "joint .* stays open by"),
        (
            ['[start]\ncrank_angle = "75 deg"\ncrank_rate = 1\nrocker_rate = 1\n'],
            FOUR_BAR,
            "contradict each other there|contradicts joints",
        ),
        ([], FOUR_BAR.replace('"350 mm"', '"40 mm"'), "cannot be assembled: joint '[ABCD]' stays open by 0.0"),
        (
            [DRIVE.format(name=name, body=name, rate="60 rpm") for name in ("crank", "rocker")],
            FOUR_BAR,
            r"drivers \['crank', 'rocker'\] contradict .* the joints leave mobility 1, and of 2 drivers only 1 are",
        ),
        (['[[link]]\nfirst = "ground.D"\nsecond = "crank.end"\n'], FOUR_BAR, "joints leave 0 degrees of freedom; without any one of"),
        ([DRIVE.format(name="motor", body="crank", rate="60 rpm"), "[start]\ncrank_rate = 1\n"], FOUR_BAR, "contradict"),
    ],
    ids=["two values", "two rates", "too short", "two drives", "rigid", "rate against drive"],
)
def test_what_cannot_start_is_refused(more, text, sentence, tmp_path):
    path = tmp_path / "linkage.toml"
    path.write_text(text + "".join(more), encoding="utf-8")
    with pytest.raises(gm.MechanismError, match=sentence) as refusal:
        gm.load(path)
    assert all(problem.startswith(str(path)) for problem in refusal.value.problems)


def test_the_same_linkage_in_millimetres_starts_the_same():
    metres, _ = initial_state(scene('[start]\ncrank_angle = "75 deg"\n'))
    larger = FOUR_BAR.replace(" mm", " m")
    millimetres, _ = initial_state(scene('[start]\ncrank_angle = "75 deg"\n', text=larger))
    np.testing.assert_allclose(millimetres / [1e3, 1e3, 1.0], metres, atol=1e-13)


@pytest.mark.parametrize("engine", ["multibody", "reduced", "impulse"])
def test_a_linkage_starts_at_rest_at_the_bottom_of_its_travel(engine):
    made = scene('[start]\ncrank_angle = "equilibrium"\n')
    poses, velocities = initial_state(made)
    (stable,) = [rest for rest in gm.equilibria(made) if rest.stable]
    np.testing.assert_array_equal(poses, stable.poses)
    assert not velocities.any()
    run = gm.run(made, engine=engine, times=[1.0], accuracy=1e-8)
    np.testing.assert_allclose(run.poses[-1], poses, atol=1e-7)  # where it was let go, it stays


SLOT = """
machine = "custom"
[ground]
O = [0, 0]
[[body]]
name = "bead"
mass = 1
point = true
at = [{x}, {y}]
[[joint]]
type = "curve"
name = "slot"
first = "ground.O"
second = "bead.centre"
curve = {{ points = [[-0.2, 0.1], [-0.1, 0.02], [0, 0], [0.1, 0.02], [0.2, 0.1]] }}
[effects]
gravity = true
[run]
duration = "1 s"
"""


def test_a_start_off_the_table_of_a_slot_is_refused():
    with pytest.raises(gm.MechanismError, match=r"outside the travel of .* leaves the table"):
        initial_state(scene(text=SLOT.format(x=0.3, y=0.2)))
    initial_state(scene(text=SLOT.format(x=0.1, y=0.0)))


@pytest.mark.long
def test_a_drive_that_locks_the_mechanism_ends_the_run_by_name():
    motor = DRIVE.format(name="motor", body="rocker", rate="60 rpm") + 'start = "100 deg"\n'
    locking = FOUR_BAR.replace('"0.2 s"', '"2 s"') + motor
    run = gm.run(scene(text=locking), engine="multibody", accuracy=1e-6)
    assert run.outcome.name == "STALLED"
    assert "as where a driver locks" in run.message
    assert 0 < run.times[-1] < 1.0
    assert np.all(np.isfinite(run.readings["crank_angle"]))


def test_values_many_turns_away_are_refused():
    made = scene('[start]\ncrank_angle = "100000 deg"\n')
    with pytest.raises(gm.MechanismError, match="leave out whole turns"):
        initial_state(made)


def test_start_values_against_a_drive_name_both():
    made = scene(DRIVE.format(name="motor", body="crank", rate="60 rpm"), '[start]\ncrank_angle = "10 deg"\n')
    with pytest.raises(gm.MechanismError, match=r"'crank_angle': .* and drivers \['motor'\] contradict each other"):
        initial_state(made)
