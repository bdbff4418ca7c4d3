"""The cross-check of Hartung's governor: planted errors are found, what has no closed form is noted."""

import math
from dataclasses import replace
from typing import Any

import pytest

import governor_mechanism as gm
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.verification.machines import hartung
from hartung_scenes import PAPER_DIMENSIONS, hartung_scene
from refusing import refuses


def quantities(scene: Any) -> dict[str, bool]:
    """What is checked, and whether it agrees."""
    return {row.quantity: row.passed for row in gm.crosscheck(scene).rows}


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"angle": math.radians(132.001)}, "static sleeve force at"),
        ({"weight_mass": 45.001}, "equilibrium speed at"),
        ({"sleeve_mass": 15.01}, "spring force that balances"),
        ({"weight_arm": 0.11501}, "lever angle in motion"),
        ({"sleeve_arm": 0.1701}, "small-oscillation period"),
    ],
)
def test_a_planted_error_is_found(monkeypatch: pytest.MonkeyPatch, change: dict[str, float], found: str) -> None:
    right = hartung.build_hartung_closed_form
    monkeypatch.setattr(hartung, "build_hartung_closed_form", lambda scene: replace(right(scene), **change))
    scene = gm.load("hartung_dubois")
    wrong = quantities(replace(scene, run=replace(scene.run, duration=0.6)))
    assert any(name.startswith(found) and not passed for name, passed in wrong.items())


def test_a_free_spindle_is_followed_with_its_speed() -> None:
    program = InputFunction(times=(0.0, 0.5, 1.0), values=(0.0, 6.0, 0.0))
    spindle = FreeSpindle(inertia=0.8, start_speed=21.8, torque=program)
    scene = hartung_scene({**PAPER_DIMENSIONS, "hanger": 0.3}, speed=spindle, angle=0.02, duration=1.5)
    report = gm.crosscheck(scene)
    assert report.passed, str(report)
    assert any(row.quantity.startswith("spindle speed in motion") for row in report.rows)
    assert "the spindle is free: equilibria at a given speed are not checked" in report.notes


def test_a_speed_without_rest_within_the_stroke_is_noted() -> None:
    scene = hartung_scene(PAPER_DIMENSIONS, speed=Spindle(speeds=(24.0,)), angle=0.1, duration=0.1)
    report = gm.crosscheck(scene)
    assert report.passed, str(report)
    assert any("no equilibrium within the stroke" in note for note in report.notes)


@pytest.mark.parametrize(
    ("more", "note"),
    [
        (BellCrankMasses(mass=1.0), "only the energy is checked"),
        (DryFriction(reading="sleeve_lift", force=InputFunction(values=(20.0,))), "the closed form does not include dry friction"),
    ],
)
def test_what_has_no_closed_form_is_noted(more: Any, note: str) -> None:
    scene = hartung_scene({**PAPER_DIMENSIONS, "spring_rate": 35e3}, angle=0.05, more_effects=(more,), duration=0.2)
    report = gm.crosscheck(replace(scene, run=replace(scene.run, engine="multibody")))
    assert report.passed, str(report)
    assert any(note in one for one in report.notes)


def test_without_gravity_it_is_refused() -> None:
    scene = hartung_scene(PAPER_DIMENSIONS)
    refuses("need the effects gravity and centrifugal", gm.crosscheck, scene.with_changes(effects=scene.effects[1:]))
