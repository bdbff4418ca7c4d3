"""Errata of Zehnder's article on pendulum governors. The paper prints no example; numbers are those of the designed Porter governor.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.closed_form import parabolic
from governor_mechanism.papers.erratum import Erratum, Paper
from governor_mechanism.studies.design.pendulum import ParabolaStart, PendulumDesign, design_pendulum
from governor_mechanism.studies.design.skeleton import Cause
from governor_mechanism.units.constants import RPM

COMMAND = "governor-mechanism design pendulum"
"""Prints a design by the steps of the paper, with the right formulas."""

STATEMENT_COMMAND = "governor-mechanism errata --paper zehnder --simulate --no-figure"
"""Shows the speeds beside the osculation point by the statics of the simulated governor."""

PROBE_ANGLE_DEG = 2.0
"""Angle by which the arm leaves the osculation point."""

LONGER, SHORTER = 1.3, 0.7
"""Arms over the radius of curvature with which the statements on other arms are tested."""

_PLACE = "pp. 7-9, on leaving the point of osculation"

_formula = partial(Erratum, paper=Paper.ZEHNDER)
_statement = partial(Erratum, paper=Paper.ZEHNDER, place=_PLACE, unit="%", command=STATEMENT_COMMAND)


def list_zehnder_errata() -> Iterator[Erratum]:
    """Return the errata: the three statements of one wrong argument, then the formulas in the order of the text."""
    design = design_pendulum()
    yield from _statements(design.start)
    yield from _formulas(design)


def speed_change(
    start: ParabolaStart,  # the lowest position, on the parabola of the lowest speed
    arm_ratio: float,
    degrees: float,  # angle through which the arm has turned up, deg
) -> float:
    """Return by how much the speed of rest changes (%) when an arm leaves the point of osculation."""
    change = parabolic.equilibrium_speed_change(
        start_angle=start.arm_angle,
        start_abscissa=start.abscissa,
        arm=arm_ratio * start.radius_of_curvature,
        angle_change=math.radians(degrees),
    )
    return 100 * float(change)


def _statements(start: ParabolaStart) -> Iterator[Erratum]:
    """Yield the statements on arms that leave the point of osculation: the paper judges them by the parabola on which the ball sits."""
    slope = "A ball is at rest where the slope of its path is w^2 x / (g (1 + m)); on which parabola it sits does not matter."
    (down, up), (longer_down, longer_up), (shorter_down, shorter_up) = (
        tuple(speed_change(start, ratio, sign * PROBE_ANGLE_DEG) for sign in (-1, 1)) for ratio in (1.0, LONGER, SHORTER)
    )
    yield _statement(
        name="osculating-circle",
        cause=Cause.ERROR,
        subject="arm as long as the radius of curvature",
        printed="below the start the speeds of rest are lower",
        right=f"they are higher there too: {down:+.3f} % {PROBE_ANGLE_DEG:g} deg down, {up:+.3f} % {PROBE_ANGLE_DEG:g} deg up",
        right_value=down,
        quotation="bewegt er sich aber in Richtung der abnehmenden Abscissen, dann gelangt er umgekehrt auf flacher verlaufende Parabeln.",
        translation="but if it moves toward smaller abscissae, it comes, conversely, to flatter parabolas.",
        proof=f"{slope} On the circle of curvature the speed has a minimum at the point of osculation.",
        consequence="Below that point the governor is unstable. The advice of the paper, to make it the lowest position, is right.",
    )
    yield _statement(
        name="longer-arm",
        cause=Cause.CONSEQUENCE,
        subject="arm longer than the radius of curvature",
        printed="lower speeds both ways; usable downward",
        right=f"lower upward ({longer_up:+.2f} %), higher downward ({longer_down:+.2f} %): unstable both ways",
        right_value=longer_up,
        quotation="dann bewegen sich die Regulatorkugeln vom betreffenden Punkte aus auf- und abwärts zu "
        "geringern Tourenzahlen entsprechenden Parabeln; dieser Kreis wäre also nur vom Ausgangspunkte an "
        "abwärts brauchbar.",
        translation="then the balls move from this point, upward and downward, to parabolas of lower "
        "speeds; this circle would be of use only from the start downward.",
        proof=f"{slope} The numbers hold {PROBE_ANGLE_DEG:g} deg from the point, for an arm {LONGER:g} times as long.",
        consequence="Near the point such a governor cannot be used on either side: it jumps.",
    )
    yield _statement(
        name="shorter-arm",
        cause=Cause.CONSEQUENCE,
        subject="arm shorter than the radius of curvature",
        printed="usable upward only",
        right=f"usable both ways: {shorter_down:+.2f} % downward, {shorter_up:+.2f} % upward",
        right_value=shorter_down,
        quotation="Ist der benutzte Kreis kleiner als der Krümmungskreis, dann ist derselbe analog dem "
        "vorigen nur vom Ausgangspunkte an aufwärts brauchbar.",
        translation="If the circle is smaller than the circle of curvature, it is, like the one before, of use only from the start upward.",
        proof=f"{slope} The numbers hold {PROBE_ANGLE_DEG:g} deg from the point, for an arm {SHORTER:g} times as long.",
        consequence="The paper gives away the travel below the point; nothing that it recommends is wrong.",
    )


def _formulas(design: PendulumDesign) -> Iterator[Erratum]:
    """Yield the formulas that are wrong as they were read."""
    start, inputs = design.start, design.inputs
    yield _formula(
        name="difference-of-angles",
        place="pp. 6-7, angle between two parabolas",
        subject="sign of tan a'",
        cause=Cause.UNDECIDED,
        printed="a' = a1 - a2, with the numerator (w2^2 - w1^2) g (1 + m) x",
        right="a' = a2 - a1 with this numerator",
        proof="The tangent of a1 - a2 has w1^2 - w2^2: in one of the two the indices are exchanged. The "
        "place of the maximum does not depend on the sign.",
        command="governor-mechanism errata --paper zehnder --no-figure",
    )
    yield _formula(
        name="stray-index",
        place="p. 7, condition of the maximum",
        subject="abscissa",
        cause=Cause.UNDECIDED,
        printed="(g (1 + m))^2 - w2^2 w1^2 x_1^2 = 0",
        right="(g (1 + m))^2 - w2^2 w1^2 x^2 = 0",
        proof="x is what the condition is solved for, in the next line: x = g (1 + m) / (w1 w2). The copy may have an index too many.",
        command="governor-mechanism errata --paper zehnder --no-figure",
    )
    yield _formula(
        name="best-abscissa",
        place="p. 7, abscissa of the largest angle between neighbours",
        subject="abscissa where x = 2 y",
        cause=Cause.UNDECIDED,
        printed="x = g (1 + m) / w_2",
        right="x = g (1 + m) / w^2",
        proof="It is the limit of g (1 + m) / (w1 w2), printed two lines above; the copy may have an index "
        f"for an exponent; {50 * start.double_parameter:.3f} cm for "
        f"{design.requirement.lowest_speed / RPM:g} rpm and m = {design.requirement.mass_ratio:g}.",
        command=COMMAND,
    )
    half = (inputs.insensitivity - inputs.speed_fluctuation) / 2
    right, wrong = (design.requirement.lowest_speed * (1 + sign * half) / RPM for sign in (-1, 1))
    yield _formula(
        name="lowest-speed-sign",
        place="pp. 9-10, lowest speed allowed",
        subject="sign in w1''",
        cause=Cause.MISPRINT,
        printed="w1'' = w1 (1 + (delta - epsilon) / 2)",
        right="w1'' = w1 (1 - (delta - epsilon) / 2)",
        proof="The sentence before it subtracts, and (VII) has the minus. With the plus the lowest speed "
        f"allowed, {right:.4g} rpm in the example, would be {wrong:.4g} rpm, above the speed of rest.",
        command=COMMAND,
    )
    c, x, y = (100 * length for length in (start.double_parameter, start.abscissa, start.ordinate))
    square = (c + 4 * y) ** 3 / (4 * c)
    yield _formula(
        name="radius-squared",
        place="pp. 11-12, (V)",
        subject="radius of curvature",
        cause=Cause.UNDECIDED,
        printed="rho_2 = (c1 + 4 y1)^3 / 4 c1",
        right="rho^2 = (c1 + 4 y1)^3 / (4 c1)",
        proof="It is a square where it is derived; the copy may have an index for an exponent. In the "
        f"example the right side is {square:.1f} cm^2; its root, {math.sqrt(square):.4f} cm, is that of the "
        f"other form, (c^2 + 4 x^2)^(3/2) / (2 c^2) = {(c**2 + 4 * x**2) ** 1.5 / (2 * c**2):.4f} cm.",
        command=COMMAND,
    )
