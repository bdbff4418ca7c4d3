"""Effects that give parts mass: what they refuse, what they take, and the values they have if nothing is given."""

import math
from dataclasses import astuple

import pytest

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.crank_masses import MIN_MASS_RATIO, CrankMasses
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.errors import MechanismError


def test_what_is_not_given_is_massless():
    assert astuple(CrankMasses(crank=2.0)) == (2.0, 0.0, 0.0, None, None, 0.0)
    assert astuple(BellCrankMasses(mass=2.0)) == (2.0, 0.0, 0.0, 0.0)
    assert astuple(RodMasses(arm_mass=2.0)) == (2.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("masses", "sentence"),
    [
        ({"crank": 0.0}, "masses.crank must be positive; got 0 kg"),
        ({"crank": 1.0, "rod": -1.0}, "masses.rod must not be negative; got -1 kg"),
        ({"crank": 1.0, "crosshead": -1.0}, "masses.crosshead must not be negative; got -1 kg"),
        ({"crank": 1.0, "crank_centre": math.nan}, "masses.crank_centre must be a finite number"),
        ({"crank": 1.0, "rod": 1.0, "rod_centre": -0.1}, "masses.rod_centre must not be negative; got -0.1 m"),
        ({"crank": 1.0, "rod": 1.0, "rod_inertia": 0.0}, "masses.rod_inertia must be positive; got 0 kg m2"),
        ({"crank": 1.0, "rod_centre": 0.1}, "need a rod with mass"),
        ({"crank": 1.0, "rod_inertia": 0.1}, "need a rod with mass"),
        ({"crank": 0.99e-4, "rod": 1.0}, r"masses.crank \(9.9e-05 kg\) is negligible .* give it 0.0001 kg at least$"),
        ({"crank": 1.0, "rod": 0.99e-4}, "masses.rod .* masses.crank .* give it 0.0001 kg at least, or leave it out$"),
        ({"crank": 1.0, "crosshead": 0.99e-4}, "masses.crosshead .* give it 0.0001 kg at least, or leave it out$"),
        ({"crank": 1.0, "rod": 2e-4, "crosshead": 3.0}, r"masses.rod .* masses.crosshead \(3 kg\); give it 0.0003 kg at least"),
    ],
)
def test_masses_of_a_slider_crank_that_mean_nothing_are_refused(masses, sentence):
    with pytest.raises(MechanismError, match=sentence):
        CrankMasses(**masses)


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


SIZES = ("mass", "weight_width", "weight_height", "weight_depth")


@pytest.mark.parametrize("name", SIZES)
def test_a_negative_size_of_a_bell_crank_is_refused_by_name(name):
    unit = "kg" if name == "mass" else "m"
    with pytest.raises(MechanismError, match=f"bell_cranks.{name} must not be negative; got -0.1 {unit}"):
        BellCrankMasses(**{"mass": 1.0, name: -0.1})


@pytest.mark.parametrize("name", SIZES[:3])
def test_one_size_of_a_bell_crank_is_enough_and_a_depth_is_taken_with_it(name):
    assert getattr(BellCrankMasses(**{name: 0.1}), name) == 0.1
    assert BellCrankMasses(**{name: 0.1}, weight_depth=0.2).weight_depth == 0.2


def test_bell_cranks_without_moment_of_inertia_in_the_plane_are_refused():
    with pytest.raises(MechanismError, match="bell_cranks need mass, weight_width, weight_height or weight_depth"):
        BellCrankMasses()
    with pytest.raises(MechanismError, match=r"bell_cranks.weight_depth alone"):
        BellCrankMasses(weight_depth=0.1)


@pytest.mark.parametrize(("name", "unit"), [("arm_mass", "kg"), ("link_mass", "kg"), ("ball_radius", "m")])
def test_one_property_of_rods_is_enough_and_none_is_negative(name, unit):
    assert getattr(RodMasses(**{name: 0.1}), name) == 0.1
    with pytest.raises(MechanismError, match=f"rods.{name} must not be negative; got -0.1 {unit}"):
        RodMasses(**{name: -0.1})
