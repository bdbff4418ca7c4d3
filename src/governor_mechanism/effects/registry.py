"""Registry of all effects."""

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gas_pressure import GasPressure
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.link_masses import LinkMasses
from governor_mechanism.effects.piston_masses import PistonMasses
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect, ForceLaw, OutputForce

EffectTypes = tuple[type[Effect], ...]

EFFECTS: EffectTypes = (
    Gravity,
    Centrifugal,
    RodMasses,
    OutputSpring,
    DryFriction,
    Dashpot,
    Stops,
    Clearance,
    CrankMasses,
    BellCrankMasses,
    LinkMasses,
    PistonMasses,
)
"""All effects, in the order of reports."""

EFFECT_TYPES = frozenset(EFFECTS)
"""All effects."""

FORCE_LAWS: tuple[type[ForceLaw], ...] = (*(effect for effect in EFFECTS if issubclass(effect, OutputForce)), GasPressure)
"""Force laws of effects along readings, then those of force elements alone; kernels know a law by its index."""
