"""Effects of masses of the parts of a machine, which builds its bodies from them."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class BellCrankMasses(Effect):
    """Bell cranks with mass and weights of finite size. The machine builds its bodies from them; zero leaves a body unchanged.

    A bell crank is two slender arms of equal section. A weight is a block fixed to its arm.

    Attributes
    ----------
    mass
        Mass of each bell crank, kg.
    weight_width
        Size of a weight across its arm, m.
    weight_height
        Size of a weight along its arm, m.
    weight_depth
        Size of a weight normal to the plane, m.
    """

    key = "bell_cranks"
    changes_bodies_of = "a Hartung governor"

    mass: float = optional_size("mass", examples="6 kg", meaning="mass of each bell crank")
    weight_width: float = optional_size("length", examples="150 mm", meaning="size of a weight across its arm")
    weight_height: float = optional_size("length", examples="200 mm", meaning="size of a weight along its arm")
    weight_depth: float = optional_size("length", meaning="size of a weight normal to the plane")

    def __post_init__(self) -> None:
        sizes = ("weight_width", "weight_height", "weight_depth")
        require_valid_fields(self, "bell_cranks.")
        if self.mass == self.weight_width == self.weight_height == self.weight_depth == 0.0:
            raise MechanismError(f"bell_cranks need mass, {', '.join(sizes[:2])} or {sizes[2]}; leave the effect out if there are none")
        if self.weight_depth > 0.0 and self.mass == self.weight_width == self.weight_height == 0.0:
            raise MechanismError(
                "bell_cranks.weight_depth alone leaves a weight without moment of inertia in the plane; "
                "give weight_width or weight_height as well"
            )


@dataclass(frozen=True, kw_only=True)
class CrankMasses(Effect):
    """Masses of the parts of a slider crank. The machine builds its bodies from them.

    Attributes
    ----------
    crank
        Mass of the crank, kg; positive.
    crank_centre
        Position of the crank's mass centre from the shaft toward the crank pin, m; negative for a counterweight.
    rod
        Mass of the connecting rod, kg; 0 for a massless rod.
    rod_centre
        Distance of the rod's mass centre from the crank pin, m; the middle of the rod if None.
    rod_inertia
        Moment of inertia of the rod about its mass centre, kg m2; that of a slender uniform rod if None.
    crosshead
        Mass of the crosshead, kg; 0 for none.
    """

    key = "masses"
    changes_bodies_of = "a slider crank"

    crank: float = quantity("mass", built=True, examples="80 kg", meaning="the mass of the crank (rod and crosshead may have none)")
    crank_centre: float = quantity(
        "length",
        sign="any",
        built=True,
        default=0.0,
        meaning="mass centre of the crank from the shaft toward the crank pin; negative for a counterweight",
    )
    rod: float = optional_size("mass", examples="70 kg", meaning="mass of the connecting rod")
    rod_centre: float | None = quantity(
        "length", sign="not negative", built=True, default=None, meaning="mass centre of the rod from the crank pin; its middle if left out"
    )
    rod_inertia: float | None = quantity(
        "moment_of_inertia",
        built=True,
        default=None,
        meaning="moment of inertia of the rod about its mass centre; that of a slender rod if left out",
    )
    crosshead: float = optional_size("mass", examples="110 kg", meaning="mass of the crosshead")

    def __post_init__(self) -> None:
        require_valid_fields(self, "masses.")
        if self.rod == 0.0 and (self.rod_centre is not None or self.rod_inertia is not None):
            raise MechanismError("masses.rod_centre and rod_inertia need a rod with mass; give masses.rod as well")
        _require_comparable_masses({"crank": self.crank, "rod": self.rod, "crosshead": self.crosshead})


MIN_MASS_RATIO = 1e-4
"""Smallest ratio of two masses: a lighter part is practically massless and makes the equations ill-conditioned."""


def _require_comparable_masses(masses: dict[str, float]) -> None:
    heaviest = max(masses, key=lambda name: masses[name])
    for name, mass in masses.items():
        if 0.0 < mass < MIN_MASS_RATIO * masses[heaviest]:
            hint = "" if name == "crank" else ", or leave it out"
            raise MechanismError(
                f"masses.{name} ({mass:g} kg) is negligible compared to masses.{heaviest} ({masses[heaviest]:g} kg); "
                f"give it {MIN_MASS_RATIO * masses[heaviest]:g} kg at least{hint}"
            )


@dataclass(frozen=True, kw_only=True)
class RodMasses(Effect):
    """Arms and links as slender uniform rods, balls as solid spheres. The machine builds its bodies from them.

    A value of zero leaves the part unchanged.

    Attributes
    ----------
    arm_mass
        Mass of each arm, kg.
    link_mass
        Mass of each link, kg.
    ball_radius
        Radius of each ball, m.
    """

    key = "rods"
    changes_bodies_of = "a governor with arms and links"

    arm_mass: float = optional_size("mass", examples="0.6 kg", meaning="mass of each arm")
    link_mass: float = optional_size("mass", examples="0.5 kg", meaning="mass of each link")
    ball_radius: float = optional_size("length", meaning="radius of each ball")

    def __post_init__(self) -> None:
        require_valid_fields(self, "rods.")
        if self.arm_mass == self.link_mass == self.ball_radius == 0.0:
            raise MechanismError("rods need arm_mass, link_mass or ball_radius; leave the effect out if there are none")


@dataclass(frozen=True, kw_only=True)
class LinkMasses(Effect):
    """Masses of link, eccentric rods and valve. The machine builds its bodies from them; a value of zero leaves a part massless.

    Attributes
    ----------
    link
        Mass of the link, kg; a thin uniform arc between the rod pins.
    eccentric_rod
        Mass of each eccentric rod, kg; a slender uniform rod.
    valve
        Mass of the valve with its spindle and the die block, kg.
    shaft_inertia
        Moment of inertia of the shaft with crank and eccentrics, kg m2; None for a massless shaft.
    """

    key = "link_masses"
    changes_bodies_of = "a gear with a link"

    link: float = optional_size("mass", examples="25 kg", meaning="mass of the link, a thin arc between the rod pins")
    eccentric_rod: float = optional_size("mass", examples="15 kg", meaning="mass of each eccentric rod")
    valve: float = optional_size("mass", examples="60 kg", meaning="mass of the valve with its spindle and the die block")
    shaft_inertia: float | None = quantity(
        "moment_of_inertia",
        built=True,
        default=None,
        meaning="moment of inertia of the shaft with crank and eccentrics; massless if left out",
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, "link_masses.")
        if self.link == self.eccentric_rod == self.valve == 0.0 and self.shaft_inertia is None:
            raise MechanismError("link_masses need link, eccentric_rod, valve or shaft_inertia; leave the effect out if there are none")


@dataclass(frozen=True, kw_only=True)
class PistonMasses(Effect):
    """Masses of the pistons and connecting rods of an engine. The machine builds bodies of those that are not zero.

    Attributes
    ----------
    piston
        Mass of the piston with piston rod and crosshead, kg; with an infinite connecting rod, that of the yoke too.
    connecting_rod
        Mass of the connecting rod, kg; a slender uniform rod.
    pump_piston
        Mass of the pump piston with its rod and crosshead, kg.
    pump_connecting_rod
        Mass of the connecting rod of the pump, kg; a slender uniform rod.
    """

    key = "piston_masses"
    changes_bodies_of = "an engine with a flywheel"

    piston: float = optional_size("mass", examples="120 kg", meaning="mass of the piston with piston rod and crosshead")
    connecting_rod: float = optional_size("mass", examples="60 kg", meaning="mass of the connecting rod")
    pump_piston: float = optional_size("mass", examples="120 kg", meaning="mass of the pump piston with its rod and crosshead")
    pump_connecting_rod: float = optional_size("mass", examples="60 kg", meaning="mass of the connecting rod of the pump")

    def __post_init__(self) -> None:
        require_valid_fields(self, "piston_masses.")
        if not (self.piston or self.pump_piston):
            raise MechanismError("piston_masses need piston or pump_piston; leave the effect out if there are none")
        for rod, piston in (("connecting_rod", "piston"), ("pump_connecting_rod", "pump_piston")):
            if getattr(self, rod) and not getattr(self, piston):
                raise MechanismError(f"piston_masses.{rod} has a mass and its piston has none; give piston_masses.{piston} as well")
