"""Registry of all effects."""

from __future__ import annotations

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect

EFFECT_TYPES: frozenset[type[Effect]] = frozenset(
    (Gravity, Centrifugal, RodMasses, OutputSpring, DryFriction, Dashpot, Stops, Clearance, CrankMasses, BellCrankMasses)
)
