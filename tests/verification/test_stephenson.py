"""Cross-checks of the link motion: every form agrees, planted errors are found."""

import pytest

import governor_mechanism as gm
from crank_scenes import link_gear_scene
from governor_mechanism.verification.machines import stephenson

FORMS = {
    "moving lever": {"reverser": [[0.1, 1.0], [0.5, -0.5]]},
    "crossed rods": {"rods": "crossed", "reverser": 0.5, "suspension": "chord middle"},
    "pins behind the arc, lower pin": {"pin_setback": 0.075, "suspension": "lower pin", "reverser": -1.0},
    "any suspension, endless rod": {"suspension": "point", "suspension_x": -0.02, "suspension_y": 0.05, "connecting_rod": None},
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("engine", ["impulse", "multibody"])
def test_every_form_agrees_in_both_engines(form, engine):
    report = gm.crosscheck(link_gear_scene(FORMS[form], engine=engine, duration=0.65))
    assert report.passed, str(report)
    gears = 2 if form == "moving lever" else 1
    assert len(report.rows) == 12 * gears + 4
    assert sum("Zeuner's first-order law gives" in note for note in report.notes) == gears


def test_a_wrong_closed_form_is_found(monkeypatch):
    right = stephenson.closed.link_position

    def wrong(*arguments, **options):
        position = right(*arguments, **options)
        return position._replace(die_offset=position.die_offset + 1e-9)

    monkeypatch.setattr(stephenson.closed, "link_position", wrong)
    report = gm.crosscheck(link_gear_scene(duration=0.05))
    assert [row.quantity.split(" (")[0] for row in report.rows if not row.passed] == ["gear 1: die slip"]


def test_a_wrong_centre_of_the_valve_is_found(monkeypatch):
    right = stephenson.closed.link_position
    monkeypatch.setattr(
        stephenson.closed, "link_position", lambda *one, **other: (found := right(*one, **other))._replace(valve=found.valve + 1e-9)
    )
    failed = [row.quantity.split(" (")[0] for row in gm.crosscheck(link_gear_scene(duration=0.05)).rows if not row.passed]
    assert {"gear 1: valve displacement", "centre of the valve's motion"} <= {*failed}
