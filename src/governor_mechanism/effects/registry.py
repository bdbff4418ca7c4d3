"""Registry of all effects."""

from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.gas_pressure import GasPressure
from governor_mechanism.effects.holding import Clearance, DryFriction, Stops
from governor_mechanism.effects.masses import BellCrankMasses, CrankMasses, LinkMasses, PistonMasses, RodMasses
from governor_mechanism.effects.spring import OutputSpring
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
