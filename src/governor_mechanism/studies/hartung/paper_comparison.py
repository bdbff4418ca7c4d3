"""What Dubois prints of his Hartung governor beside what his own formulas give, and where the print is wrong.

Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620. Each number is recomputed from what the paper
states just before it, so that a slip shows where it was made and not in all that follows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from governor_mechanism.closed_form.hartung import design as formulas
from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.studies.hartung.design import AT, KGF

SPEEDS = (21.363, 22.201)
"""rad/s, as the paper rounds 204 and 212 rpm."""

SLIDE_RULE = 1.0
"""kgf: a force of the table farther from its formula is no slip of a slide rule; the others are within 0.66."""

FORCES = (
    (92.0, 173.8, 199.8),
    (100.0, 193.4, 210.4),
    (106.0, 208.5, 226.5),
    (114.0, 227.2, 247.2),
    (122.0, 246.8, 267.8),
    (130.0, 266.3, 288.3),
    (138.0, 286.0, 309.0),
    (144.0, 301.2, 325.2),
    (152.0, 319.8, 345.8),
)
"""Table 2: radius in mm, and the astatic spring force in kgf at each of the two speeds."""

COUNTER_EXAMPLE = (189.0, 262.0, 335.0)
"""kgf: the static sleeve force of Pohlhausen's no. 97, a Hartung governor with right angles, low, middle and high."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One number of the paper, in `unit`: as printed, and recomputed; misprint says what is wrong with it, if it is."""

    quantity: str
    unit: str
    printed: float
    recomputed: float
    misprint: str = ""


@dataclass(frozen=True, kw_only=True)
class Dubois:
    """The paper's numbers one by one, its table of spring forces, and the governor it warns of (forces in kgf)."""

    steps: tuple[Step, ...]
    table: tuple[Step, ...]
    counter_example: tuple[Step, ...]

    @property
    def misprints(self) -> tuple[Step, ...]:
        """The numbers that are printed wrong, in the paper's order."""
        return tuple(step for step in (*self.steps, *self.table, *self.counter_example) if step.misprint)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self) | {"misprints": [step.quantity for step in self.misprints]}

    def __str__(self) -> str:
        rows = [(step.quantity, step.unit, step.printed, step.recomputed, step.misprint) for step in self.steps]
        wrong = [step for step in self.table if step.misprint]
        rows += [(step.quantity, step.unit, step.printed, step.recomputed, step.misprint) for step in wrong]
        rows += [(one.quantity, one.unit, one.printed, one.recomputed, one.misprint) for one in self.counter_example]
        widths = [max(len(row[0]) for row in rows), 8, 10, 14]
        lines = [f"{'quantity':<{widths[0]}}  {'unit':<{widths[1]}}{'printed':>{widths[2]}}{'recomputed':>{widths[3]}}"]
        for quantity, unit, printed, recomputed, misprint in rows:
            line = f"{quantity:<{widths[0]}}  {unit:<{widths[1]}}{printed:>{widths[2]}.6g}{recomputed:>{widths[3]}.7g}"
            lines.append(line + (f"  MISPRINT: {misprint}" if misprint else ""))
        right = len(self.table) - len(wrong)
        lines.append(f"table 2: {right} of {len(self.table)} spring forces agree with their formula")
        return "\n".join(lines)


def dubois() -> Dubois:
    """The paper, recomputed."""
    return Dubois(
        steps=(*_weights(), *_forces(), *_spring(), *_sleeve()),
        table=tuple(_table()),
        counter_example=tuple(_counter_example()),
    )


def governor() -> closed.HartungGovernor:
    """The governor that the paper reckons with, at 132 deg."""
    return closed.HartungGovernor(
        weight_arm=0.115,
        sleeve_arm=0.170,
        angle=math.radians(132),
        fulcrum_radius=0.122,
        weight_mass=45.0,
        sleeve_mass=15.0,
        gravity=KGF,
    )


def _weights() -> Iterator[Step]:
    x = [1e3 * float(closed.weight_radius(governor(), lever_angle=math.radians(side))) for side in (15, -15)]
    wrong = "the next lines go on with 92"
    yield Step(quantity="radius of a weight at rest", unit="mm", printed=95, recomputed=15 + 77, misprint=wrong)
    yield Step(quantity="radius of the fulcrum", unit="mm", printed=122, recomputed=92 + 30)
    yield Step(quantity="sagitta", unit="mm", printed=4, recomputed=115 * (1 - math.cos(math.radians(15))))
    wrong = "a figure too many; the table says 92"
    yield Step(quantity="radius innermost", unit="mm", printed=192, recomputed=x[0], misprint=wrong)
    yield Step(quantity="radius outermost", unit="mm", printed=152, recomputed=x[1])
    squares = [speed**2 for speed in SPEEDS]
    yield Step(quantity="slow speed squared", unit="1/s^2", printed=456.4, recomputed=squares[0])
    yield Step(quantity="fast speed squared", unit="1/s^2", printed=492.9, recomputed=squares[1])
    wrong = "two lines above it is 492.9"
    yield Step(quantity="the same, in C2", unit="1/s^2", printed=492.2, recomputed=squares[1], misprint=wrong)


def _forces() -> Iterator[Step]:
    mass = 45 / KGF
    yield Step(
        quantity="mass of a weight",
        unit="kgf s2/m",
        printed=4.58,
        recomputed=mass,
        misprint="cut off, not rounded: 4.59",
    )
    forces = [mass * speed**2 * x for speed, x in zip(SPEEDS, (0.092, 0.152), strict=True)]
    for quantity, printed, force in zip(("C1", "C2"), (192, 344), forces, strict=True):
        yield Step(quantity=f"centrifugal force {quantity}", unit="kgf", printed=printed, recomputed=force)
    first = formulas.spring_abscissa(inner_force=192.0, outer_force=344.0, stroke=60.0)
    yield Step(quantity="abscissa y1", unit="mm", printed=76, recomputed=float(first))
    yield Step(quantity="abscissa y0", unit="mm", printed=106, recomputed=76 + 30)
    angle = float(formulas.crank_angle(weight_arm=115.0, middle_abscissa=106.0))
    yield Step(quantity="tangent of the angle", unit="1", printed=-0.92, recomputed=math.tan(angle))
    wrong = "the arc of 0.92 was added to 90 deg instead of taken from 180 deg; 132 deg is used"
    yield Step(
        quantity="angle of the bell crank", unit="deg", printed=133, recomputed=math.degrees(angle), misprint=wrong
    )
    swing = math.radians(15)
    arm = formulas.even_sleeve_arm(fulcrum_radius=122.0, angle=math.radians(132), swing=swing)
    yield Step(quantity="sleeve's arm b, at 132 deg", unit="mm", printed=170, recomputed=float(arm))


def _spring() -> Iterator[Step]:
    rise, wire, coil, shear = 345.8 - 173.8, 0.012, 0.08, 750_000 * AT
    rate = rise * KGF / 0.06
    yield Step(quantity="rise of the spring force", unit="kgf", printed=172, recomputed=rise)
    moment = 1e8 * float(formulas.polar_moment(wire=wire))
    wrong = "its formula lacks the fourth power of 1.2; the number is right"
    yield Step(quantity="polar moment of the wire", unit="cm^4", printed=0.2036, recomputed=moment, misprint=wrong)
    length = 100 * float(formulas.wire_length(wire=wire, coil=coil, rate=rate, modulus=shear))
    wrong = "should be 333; and its formula has cm^4 and cm^2 where there are none"
    yield Step(quantity="length of the wire", unit="cm", printed=332, recomputed=length, misprint=wrong)
    turns = float(formulas.coil_turns(wire=wire, coil=coil, rate=rate, modulus=shear))
    yield Step(quantity="turns", unit="1", printed=13, recomputed=turns)
    section = 1e6 * float(formulas.section_modulus(wire=wire))
    wrong = "its formula lacks the cube of 1.2; should be 0.339"
    yield Step(quantity="section modulus of the wire", unit="cm^3", printed=0.338, recomputed=section, misprint=wrong)
    stress = float(formulas.coil_stress(wire=wire, coil=coil, force=346 * KGF)) / AT
    yield Step(quantity="stress under 346 kgf", unit="kgf/cm^2", printed=4100, recomputed=stress)


def _sleeve() -> Iterator[Step]:
    statics, held = [], []
    for side, force in ((15, 173.8), (-15, 345.8)):
        found = closed.static_sleeve_force(governor(), lever_angle=math.radians(side), spring_force=force * KGF)
        statics.append(float(found) / KGF)
        held.append(float(formulas.regulating_force(static_force=statics[-1])))
    wrong = "on the way - 0.677 for x 0.677, and 85.8 for 185.8; the number is right"
    yield Step(quantity="static force S, inner", unit="kgf", printed=460, recomputed=statics[0], misprint=wrong)
    wrong = "on the way + 5 for + 15; the number is right"
    yield Step(quantity="static force S, outer", unit="kgf", printed=503, recomputed=statics[1], misprint=wrong)
    yield Step(quantity="regulating force K, inner", unit="kgf", printed=18.4, recomputed=held[0])
    wrong = "the next line has 20.2"
    yield Step(quantity="regulating force K, outer", unit="kgf", printed=26.2, recomputed=held[1], misprint=wrong)
    part = 100 * (held[1] - held[0]) / (0.5 * (held[0] + held[1]))
    wrong = "2 / 10 is not 10 %; 2 / 20 was meant"
    yield Step(quantity="its change over the stroke", unit="%", printed=10, recomputed=part, misprint=wrong)


def _table() -> Iterator[Step]:
    for radius, *printed in FORCES:
        lever = math.asin((122 - radius) / 115)
        for rpm, speed, force in zip((204, 212), SPEEDS, printed, strict=True):
            balance = closed.astatic_spring_force(governor(), lever_angle=lever, spindle_speed=speed)
            found = float(balance) / KGF
            far = abs(force - found) > SLIDE_RULE
            yield Step(
                quantity=f"spring force at {radius:g} mm, {rpm} rpm",
                unit="kgf",
                printed=force,
                recomputed=found,
                misprint="breaks the even slope of its neighbours; one figure off, 189.8" if far else "",
            )


def _counter_example() -> Iterator[Step]:
    forces = [float(formulas.regulating_force(static_force=force)) for force in COUNTER_EXAMPLE]
    for place, printed, force in zip(("low", "middle", "high"), (7.5, 10.5, 13.4), forces, strict=True):
        yield Step(quantity=f"Pohlhausen's no. 97, K {place}", unit="kgf", printed=printed, recomputed=force)
    change = 100 * (13.4 - 7.5) / 10.5
    yield Step(quantity="Pohlhausen's no. 97, change of K", unit="%", printed=56, recomputed=change)
