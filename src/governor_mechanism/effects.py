"""The physical effects a scene may ask for. One frozen description each; the laws are in `equations/forces.py`.

Those that act on a reading pull along it: a force (N) on a length, a moment (N m) on an angle, positive toward larger
values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.programs import Program

STANDARD_GRAVITY = 9.81
"""m/s2: what `gravity = true` means."""

PLAY = "sleeve_play"
"""The reading that tells where in its play a sleeve is."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Something the engines add to the bare linkage."""


@dataclass(frozen=True, kw_only=True)
class Gravity(Effect):
    """A uniform pull along -y, in m/s2."""

    acceleration: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        require_positive(self.acceleration, "m/s2", "gravity")


@dataclass(frozen=True, kw_only=True)
class Centrifugal(Effect):
    """The centrifugal load on bodies whose plane turns with the spindle."""


@dataclass(frozen=True, kw_only=True)
class Rods(Effect):
    """Arms and links as slender uniform rods of these masses (kg, each), balls as solid spheres of this radius (m).

    The machine builds its bodies from them; what is nought is left as it was.
    """

    arm_mass: float = 0.0
    link_mass: float = 0.0
    ball_radius: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("arm_mass", "kg"), ("link_mass", "kg"), ("ball_radius", "m")):
            _require_not_negative(getattr(self, name), unit, f"rods.{name}")
        if self.arm_mass == self.link_mass == self.ball_radius == 0.0:
            raise MechanismError("rods need arm_mass, link_mass or ball_radius; leave the effect out if there are none")


@dataclass(frozen=True, kw_only=True)
class OnReading(Effect):
    """An effect that acts along one reading."""

    reading: str


@dataclass(frozen=True, kw_only=True)
class SpringOn(OnReading):
    """A spring along a reading: it pulls by -(preload + rate (value - zero)).

    rate in N/m or N m/rad, preload in N or N m, zero in m or rad. one_sided: it only ever pulls one way, and is slack
    where it would push (where that sum is below nought).
    """

    rate: float
    preload: float = 0.0
    zero: float = 0.0
    one_sided: bool = False

    def __post_init__(self) -> None:
        require_positive(self.rate, "N/m", f"rate of the spring on {self.reading!r}")
        for name in ("preload", "zero"):
            require_finite(getattr(self, name), "", f"{name} of the spring on {self.reading!r}")

    @property
    def free(self) -> float:
        """The value of the reading at which it pulls nothing."""
        return self.zero - self.preload / self.rate


def wire_spring_rate(*, wire: float, coil: float, turns: float, modulus: float) -> float:
    """Rate (N/m) of a helical spring: G d^4 / (8 D^3 n).

    wire d and coil D are diameters (m, of the coil's middle line), turns n those that work, modulus G (Pa) of shear.
    Raises MechanismError for what is not positive, and for a coil that is not wider than its wire.
    """
    for value, unit, name in (
        (wire, "m", "wire"),
        (coil, "m", "coil"),
        (turns, "", "turns"),
        (modulus, "Pa", "modulus"),
    ):
        require_positive(value, unit, f"{name} of the spring")
    if coil <= wire:
        raise MechanismError(f"coil of the spring ({coil:g} m) must be wider than its wire ({wire:g} m)")
    return modulus * wire**4 / (8 * coil**3 * turns)


@dataclass(frozen=True, kw_only=True)
class DryFriction(OnReading):
    """Dry friction along a reading: it holds against any force up to `force` (N, or N m), and opposes motion with it.

    force is a program of time, so that friction may be relieved now and then.
    """

    force: Program = field(default_factory=Program)

    def __post_init__(self) -> None:
        if min(self.force.values) < 0:
            raise MechanismError(
                f"dry friction on {self.reading!r} must not be negative; got {min(self.force.values):g}"
            )


@dataclass(frozen=True, kw_only=True)
class OilBrake(OnReading):
    """An oil brake along a reading: it pulls by -(linear rate + quadratic |rate| rate).

    linear in N s/m or N m s/rad; quadratic in N s2/m2 or N m s2/rad2, as of oil forced through an orifice.
    """

    linear: float = 0.0
    quadratic: float = 0.0

    def __post_init__(self) -> None:
        for name in ("linear", "quadratic"):
            _require_not_negative(getattr(self, name), "", f"{name} of the oil brake on {self.reading!r}")
        if self.linear == self.quadratic == 0.0:
            raise MechanismError(f"the oil brake on {self.reading!r} needs a linear or a quadratic part")


DISCHARGE = 0.62
"""Coefficient of discharge of a sharp-edged orifice."""


def orifice_coefficient(*, piston: float, hole: float, screw: float = 1.0, density: float = 900.0) -> float:
    """Quadratic coefficient (N s2/m2) of a piston that forces oil through an orifice: rho A^3 / (2 (0.62 a)^2).

    piston A and hole a are areas (m2), screw is the part of the hole that an adjusting screw leaves open (above 0, to
    1), density rho (kg/m3). Raises MechanismError outside that, and for a hole not smaller than the piston.
    """
    for value, unit, name in ((piston, "m2", "piston"), (hole, "m2", "hole"), (density, "kg/m3", "oil")):
        require_positive(value, unit, f"{name} of the oil brake")
    if not 0 < screw <= 1:
        raise MechanismError(f"screw of the oil brake must lie above 0 (shut) and at most at 1 (open); got {screw:g}")
    if hole >= piston:
        raise MechanismError(f"hole of the oil brake ({hole:g} m2) must be smaller than its piston ({piston:g} m2)")
    return density * piston**3 / (2 * (DISCHARGE * screw * hole) ** 2)


@dataclass(frozen=True, kw_only=True)
class Stops(OnReading):
    """Hard stops at the low and the high end of a reading (m or rad; infinite where there is none).

    restitution is the part of the speed with which it bounces back, 0 to 1.
    """

    low: float = -math.inf
    high: float = math.inf
    restitution: float = 0.0

    def __post_init__(self) -> None:
        if math.isnan(self.low) or math.isnan(self.high) or not self.low < self.high:
            raise MechanismError(
                f"stops of {self.reading!r}: the low one ({self.low:g}) must lie below the high one ({self.high:g})"
            )
        if math.isinf(self.low) and math.isinf(self.high):
            raise MechanismError(f"stops of {self.reading!r} need a low or a high end")
        if not 0 <= self.restitution <= 1:
            raise MechanismError(f"restitution of the stops must lie between 0 and 1; got {self.restitution:g}")


@dataclass(frozen=True, kw_only=True)
class Play(Effect):
    """Play (m) between links and sleeve: the sleeve may move so far before the links take it along.

    restitution as of Stops. The machine adds the reading `sleeve_play`, from -width / 2 to width / 2.
    """

    width: float
    restitution: float = 0.0

    def __post_init__(self) -> None:
        require_positive(self.width, "m", "play")
        if not 0 <= self.restitution <= 1:
            raise MechanismError(f"restitution of the play must lie between 0 and 1; got {self.restitution:g}")

    @property
    def stops(self) -> Stops:
        """The play as stops of its reading."""
        return Stops(reading=PLAY, low=-self.width / 2, high=self.width / 2, restitution=self.restitution)


@dataclass(frozen=True, kw_only=True)
class Masses(Effect):
    """Masses (kg) of the parts of a slider crank: the crank, and rod and crosshead where they have some.

    crank_centre (m) is where the crank's mass lies, from the shaft toward the crank pin, negative for a counterweight.
    The rod's lies rod_centre (m) from the crank pin, in the middle if left out, and has rod_inertia (kg m2) about that
    centre, that of a slender uniform rod if left out. The machine builds its bodies from them.
    """

    crank: float
    crank_centre: float = 0.0
    rod: float = 0.0
    rod_centre: float | None = None
    rod_inertia: float | None = None
    crosshead: float = 0.0

    def __post_init__(self) -> None:
        require_positive(self.crank, "kg", "masses.crank")
        for name in ("rod", "crosshead"):
            _require_not_negative(getattr(self, name), "kg", f"masses.{name}")
        require_finite(self.crank_centre, "m", "masses.crank_centre")
        if self.rod_centre is not None:
            _require_not_negative(self.rod_centre, "m", "masses.rod_centre")
        if self.rod_inertia is not None:
            require_positive(self.rod_inertia, "kg m2", "masses.rod_inertia")
        if self.rod == 0.0 and (self.rod_centre is not None or self.rod_inertia is not None):
            raise MechanismError("masses.rod_centre and rod_inertia are of a rod with mass; give masses.rod as well")
        _refuse_unlike({"crank": self.crank, "rod": self.rod, "crosshead": self.crosshead})


UNLIKE = 1e-4
"""A part so much lighter than another is as good as massless, and rigid bodies so unlike are not solved well."""


def _refuse_unlike(masses: dict[str, float]) -> None:
    heaviest = max(masses, key=lambda name: masses[name])
    for name, mass in masses.items():
        if 0.0 < mass < UNLIKE * masses[heaviest]:
            cure = "" if name == "crank" else ", or leave it out"
            raise MechanismError(
                f"masses.{name} ({mass:g} kg) is nothing beside masses.{heaviest} ({masses[heaviest]:g} kg); "
                f"give it {UNLIKE * masses[heaviest]:g} kg at least{cure}"
            )


@dataclass(frozen=True, kw_only=True)
class BellCranks(Effect):
    """Bell cranks with mass (kg, each): two slender arms of one section, and on them weights that have a size.

    A weight is a block fixed to its arm: width (m) across the arm, height along it, depth out of the plane. The machine
    builds its bodies from them; what is nought is left as it was.
    """

    mass: float = 0.0
    weight_width: float = 0.0
    weight_height: float = 0.0
    weight_depth: float = 0.0

    def __post_init__(self) -> None:
        sizes = ("weight_width", "weight_height", "weight_depth")
        for name, unit in (("mass", "kg"), *((size, "m") for size in sizes)):
            _require_not_negative(getattr(self, name), unit, f"bell_cranks.{name}")
        if self.mass == self.weight_width == self.weight_height == self.weight_depth == 0.0:
            raise MechanismError(
                f"bell_cranks need mass, {', '.join(sizes[:2])} or {sizes[2]}; leave the effect out if there are none"
            )
        if self.weight_depth > 0.0 and self.mass == self.weight_width == self.weight_height == 0.0:
            raise MechanismError(
                "bell_cranks.weight_depth alone leaves a weight that has no inertia to turn with in the plane; "
                "give weight_width or weight_height as well"
            )


def _require_not_negative(value: float, unit: str, what: str) -> None:
    require_finite(value, unit, what)
    if value < 0:
        raise MechanismError(f"{what} must not be negative; got {value:g} {unit}".rstrip())


ALL_EFFECTS: frozenset[type[Effect]] = frozenset(
    (Gravity, Centrifugal, Rods, SpringOn, DryFriction, OilBrake, Stops, Play, Masses, BellCranks)
)
