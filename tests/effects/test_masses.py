"""Effects that give parts mass: what they refuse, what they take, and the values they have if nothing is given."""

import math
from dataclasses import astuple

import pytest

from governor_mechanism.effects.masses import MIN_MASS_RATIO, BellCrankMasses, CrankMasses, LinkMasses, PistonMasses, RodMasses
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError
from governor_mechanism.scenes.quantities import read_declared_quantity
from governor_mechanism.units.fields import fields_of


def test_what_is_not_given_is_massless():
    assert astuple(CrankMasses(crank=2.0)) == (2.0, 0.0, 0.0, None, None, 0.0)
    assert astuple(BellCrankMasses(mass=2.0)) == (2.0, 0.0, 0.0, 0.0)
    assert astuple(RodMasses(arm_mass=2.0)) == (2.0, 0.0, 0.0)
    assert astuple(LinkMasses(link=2.0)) == (2.0, 0.0, 0.0, None)
    assert astuple(PistonMasses(piston=2.0)) == (2.0, 0.0, 0.0, 0.0)


NOT_BUILT = {("gravity", "acceleration"), ("stops", "low"), ("stops", "high")}
"""What may be as small as one likes: an acceleration, and places on the scale of a reading, which may lie beside its zero."""

SIZES_OF_EFFECTS = [
    pytest.param(effect, name, declared.along(quantity), id=f"{effect.key} {name} {quantity}")
    for effect in EFFECTS
    for name, declared in fields_of(effect).items()
    for quantity in ("length", "angle")
    if declared.form == "quantity"
]


@pytest.mark.parametrize(("effect", "name", "declared"), SIZES_OF_EFFECTS)
def test_nothing_that_is_built_is_smaller_than_a_part_of_a_watch(effect, name, declared):
    for number in (1e-40, -1e-40):
        if number < 0 and declared.sign != "any":
            with pytest.raises(MechanismError, match="must"):
                read_declared_quantity(declared, number)
        elif (effect.key, name) in NOT_BUILT:
            assert read_declared_quantity(declared, number) == number
        else:
            with pytest.raises(MechanismError, match="must lie between"):
                read_declared_quantity(declared, number)


WHOLE = {
    RodMasses: {"arm_mass": 0.6, "link_mass": 0.5, "ball_radius": 0.05},
    CrankMasses: {"crank": 80.0, "crank_centre": 0.1, "rod": 70.0, "rod_centre": 0.5, "rod_inertia": 9.0, "crosshead": 110.0},
    BellCrankMasses: {"mass": 6.0, "weight_width": 0.15, "weight_height": 0.2, "weight_depth": 0.3},
    LinkMasses: {"link": 25.0, "eccentric_rod": 15.0, "valve": 60.0, "shaft_inertia": 8.0},
    PistonMasses: {"piston": 120.0, "connecting_rod": 60.0, "pump_piston": 120.0, "pump_connecting_rod": 60.0},
}
PARTS = [pytest.param(effect, name, id=f"{effect.key}.{name}") for effect, values in WHOLE.items() for name in values]
SIGNED, POSITIVE = {"crank_centre"}, {"crank", "rod_inertia", "shaft_inertia"}


def test_every_effect_that_gives_parts_mass_has_an_example_with_all_its_parts():
    assert {effect for effect in EFFECTS if effect.changes_bodies_of and effect.key != "clearance"} == set(WHOLE)
    for effect, values in WHOLE.items():
        assert set(values) == set(fields_of(effect))
        assert {name: getattr(effect(**values), name) for name in values} == values


@pytest.mark.parametrize(("effect", "name"), PARTS)
def test_a_part_that_cannot_be_is_refused_by_its_name(effect, name):
    wrong = [(math.nan, "must be"), (math.inf, "must be")] + [(-0.1, "must"), (-1e-30, "must")] * (name not in SIGNED)
    for number, sentence in wrong + [(0.0, "must be positive")] * (name in POSITIVE):
        with pytest.raises(MechanismError, match=f"{effect.key}.{name} {sentence}"):
            effect(**WHOLE[effect] | {name: number})


@pytest.mark.parametrize("effect", [RodMasses, BellCrankMasses, LinkMasses, PistonMasses], ids=lambda effect: effect.key)
def test_masses_of_no_part_are_refused_and_of_one_part_are_taken(effect):
    needs_another = {"weight_depth", "connecting_rod", "pump_connecting_rod"}
    with pytest.raises(MechanismError, match=f"{effect.key} need .* leave the effect out"):
        effect(**{name: 0.0 for name in WHOLE[effect] if name not in POSITIVE})
    for name, value in WHOLE[effect].items():
        if name in needs_another:
            with pytest.raises(MechanismError):
                effect(**{name: value})
        else:
            assert getattr(effect(**{name: value}), name) == value


@pytest.mark.parametrize("side", ["", "pump_"])
def test_a_connecting_rod_has_its_own_piston(side):
    other = "" if side else "pump_"
    assert PistonMasses(**{f"{side}piston": 2.0, f"{side}connecting_rod": 1.0}) != PistonMasses(**{f"{side}piston": 2.0})
    with pytest.raises(MechanismError, match=rf"piston_masses.{side}connecting_rod has a mass .* give piston_masses.{side}piston as well"):
        PistonMasses(**{f"{other}piston": 2.0, f"{side}connecting_rod": 1.0})


@pytest.mark.parametrize(
    "masses",
    [
        {"crank": 1.0, "crank_centre": -0.1},
        {"crank": 1.0, "rod": 1.0},
        {"crank": 1.0, "rod": 1.0, "rod_centre": 0.0, "rod_inertia": 1e-3},
        {"crank": MIN_MASS_RATIO * 2.0, "rod": 2.0},
        {"crank": 1.0, "rod": 0.5, "crosshead": 0.0},
    ],
)
def test_masses_of_a_slider_crank_up_to_the_limits_are_taken(masses):
    assert CrankMasses(**masses) == CrankMasses(**masses)


@pytest.mark.parametrize("name", ["mass", "weight_width", "weight_height"])
def test_a_depth_of_a_weight_is_taken_with_another_size(name):
    assert BellCrankMasses(**{name: 0.1}, weight_depth=0.2).weight_depth == 0.2


def test_bell_cranks_without_moment_of_inertia_in_the_plane_are_refused():
    with pytest.raises(MechanismError, match=r"bell_cranks.weight_depth alone"):
        BellCrankMasses(weight_depth=0.1)
