"""How scenes start: guesses are closed, values and rates met, and what cannot start is refused in a sentence."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import between, custom_document, pin, rod


def four_bar(*joints, coupler=350, unit="mm", duration="0.2 s", **tables):
    """A four-bar linkage whose start is a guess, with further joints."""
    return custom_document(
        ground={"A": [0, 0], "D": [f"400 {unit}", 0]},
        body=[
            rod("crank", f"100 {unit}", "1 kg", angle="60 deg"),
            rod("coupler", f"{coupler} {unit}", "1 kg", at=[f"50 {unit}", f"87 {unit}"], angle="20 deg"),
            rod("rocker", f"250 {unit}", "1 kg", at=[f"400 {unit}", 0], angle="95 deg"),
        ],
        joint=[
            pin("ground.A", "crank.start", name="A"),
            pin("crank.end", "coupler.start", name="B"),
            pin("coupler.end", "rocker.end", name="C"),
            pin("ground.D", "rocker.start", name="D"),
            *joints,
        ],
        effects={"gravity": True},
        readings={"crank_angle": {"angle": "crank"}, "rocker_angle": {"angle": "rocker"}},
        run={"duration": duration},
        **tables,
    )


def drive(body, name="motor", **keys):
    return between("driven_turn", "ground", body, name=name, rate="60 rpm", **keys)


def scene(*joints, **tables):
    return parse_scene_document(four_bar(*joints, **tables), "linkage.toml")


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
    made = scene(start={"crank_angle": "75 deg", "crank_rate": "3 rad/s"})
    run = gm.run(made, engine=engine)
    assert run.readings["crank_angle"][0] == pytest.approx(math.radians(75), abs=1e-13)
    assert run.rates["crank_angle"][0] == pytest.approx(3.0, abs=1e-12)
    assert run.notes == ()  # what was asked for is no guess


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        (four_bar(start={"crank_angle": "75 deg", "rocker_angle": "80 deg"}), "joint .* stays open by"),
        (four_bar(start={"crank_angle": "75 deg", "crank_rate": 1, "rocker_rate": 1}), "contradict each other there|contradicts joints"),
        (four_bar(coupler=40), "cannot be assembled: joint '[ABCD]' stays open by 0.0"),
        (
            four_bar(drive("crank", "crank"), drive("rocker", "rocker")),
            r"drivers \['crank', 'rocker'\] contradict .* the joints leave mobility 1, and of 2 drivers only 1 are",
        ),
        (four_bar(link=[{"first": "ground.D", "second": "crank.end"}]), "joints leave 0 degrees of freedom; without any one of"),
        (four_bar(drive("crank"), start={"crank_rate": 1}), "contradict"),
    ],
    ids=["two values", "two rates", "too short", "two drives", "rigid", "rate against drive"],
)
def test_what_cannot_start_is_refused(document, sentence, tmp_path):
    path = tmp_path / "linkage.toml"
    path.write_text(parse_scene_document(document).to_toml(), encoding="utf-8")
    with pytest.raises(gm.MechanismError, match=sentence) as refusal:
        gm.load(path)
    assert all(problem.startswith(str(path)) for problem in refusal.value.problems)


def test_the_same_linkage_in_millimetres_starts_the_same():
    metres, millimetres = (initial_state(scene(unit=unit, start={"crank_angle": "75 deg"}))[0] for unit in ("mm", "m"))
    np.testing.assert_allclose(millimetres / [1e3, 1e3, 1.0], metres, atol=1e-13)


@pytest.mark.parametrize("engine", ["multibody", "reduced", "impulse"])
def test_a_linkage_starts_at_rest_at_the_bottom_of_its_travel(engine):
    made = scene(start={"crank_angle": "equilibrium"})
    poses, velocities = initial_state(made)
    (stable,) = [rest for rest in gm.equilibria(made) if rest.stable]
    np.testing.assert_array_equal(poses, stable.poses)
    assert not velocities.any()
    run = gm.run(made, engine=engine, times=[1.0], accuracy=1e-8)
    np.testing.assert_allclose(run.poses[-1], poses, atol=1e-7)  # where it was let go, it stays


def bead_on_a_slot(x, y):
    slot = {"points": [[-0.2, 0.1], [-0.1, 0.02], [0, 0], [0.1, 0.02], [0.2, 0.1]]}
    document = custom_document(
        body=[{"name": "bead", "mass": 1, "point": True, "at": [x, y]}],
        joint=[between("curve", "ground.A", "bead.centre", name="slot", curve=slot)],
        readings={},
        effects={"gravity": True},
    )
    return parse_scene_document(document)


def test_a_start_off_the_table_of_a_slot_is_refused():
    with pytest.raises(gm.MechanismError, match=r"outside the travel of .* leaves the table"):
        initial_state(bead_on_a_slot(0.3, 0.2))
    initial_state(bead_on_a_slot(0.1, 0.0))


@pytest.mark.long
def test_a_drive_that_locks_the_mechanism_ends_the_run_by_name():
    locking = scene(drive("rocker", start="100 deg"), duration="2 s")
    run = gm.run(locking, engine="multibody", accuracy=1e-6)
    assert run.outcome.name == "STALLED"
    assert "as where a driver locks" in run.message
    assert 0 < run.times[-1] < 1.0
    assert np.all(np.isfinite(run.readings["crank_angle"]))


def test_values_many_turns_away_are_refused():
    made = scene(start={"crank_angle": "100000 deg"})
    with pytest.raises(gm.MechanismError, match="leave out whole turns"):
        initial_state(made)


def test_start_values_against_a_drive_name_both():
    made = scene(drive("crank"), start={"crank_angle": "10 deg"})
    with pytest.raises(gm.MechanismError, match=r"'crank_angle': .* and drivers \['motor'\] contradict each other"):
        initial_state(made)
