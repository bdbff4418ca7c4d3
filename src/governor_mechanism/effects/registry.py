"""All effects."""

from __future__ import annotations

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Play
from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect

ALL_EFFECTS: frozenset[type[Effect]] = frozenset(
    (Gravity, Centrifugal, Rods, SpringOn, DryFriction, OilBrake, Stops, Play, Masses, BellCranks)
)
