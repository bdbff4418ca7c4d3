"""Misprints and wrong statements of Zehnder's paper that touch the procedure, each with its proof in the numbers of a design.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.closed_form import parabolic
from governor_mechanism.studies.pendulum.inputs import RPM
from governor_mechanism.studies.pendulum.results import PendulumDesign

PROBE_ANGLE = math.radians(2)
"""Change of the arm angle at which the wrong statements are tested, rad."""


@dataclass(frozen=True, kw_only=True)
class Misprint:
    """A misprint: where it stands, what is printed, what is right, and the proof."""

    place: str
    printed: str
    correct: str
    proof: str

    def __str__(self) -> str:
        """Return the misprint in one line."""
        return f"MISPRINT {self.place}: {self.printed}; correct: {self.correct}; {self.proof}"


def find_misprints(design: PendulumDesign) -> tuple[Misprint, ...]:
    """Return the misprints that touch the procedure.

    Parameters
    ----------
    design
        A design, in whose numbers they are proved.

    Returns
    -------
    tuple[Misprint, ...]
        The misprints in the order of the steps; last a wrong statement.
    """
    return tuple(_misprints(design))


def _misprints(design: PendulumDesign) -> Iterator[Misprint]:
    start, inputs = design.start, design.inputs
    c, y = (100 * length for length in (start.double_parameter, start.ordinate))
    square = (c + 4 * y) ** 3 / (4 * c)
    yield Misprint(
        place="step V",
        printed="rho_2 = (c1 + 4 y1)^3 / 4 c1",
        correct="rho^2 = (c1 + 4 y1)^3 / (4 c1), as where it is derived",
        proof=f"the right side is {square:.8g} cm^2, its root {math.sqrt(square):.6g} cm is (c^2 + 4 x^2)^(3/2) / (2 c^2)",
    )
    yield Misprint(
        place="step VI",
        printed="the formula is missing",
        correct="w2 = sqrt(g (1 + m) tan a2 / x2), from (3)",
        proof=f"it gives the chosen {design.requirement.lowest_speed / RPM:.6g} rpm in the lowest position",
    )
    half = (inputs.insensitivity - inputs.speed_fluctuation) / 2
    if half > 0:
        low, wrong = (design.requirement.lowest_speed * (1 + sign * half) / RPM for sign in (-1, 1))
        yield Misprint(
            place="before step VII",
            printed="w1'' = w1 (1 + (delta - epsilon) / 2)",
            correct="w1 (1 - (delta - epsilon) / 2), as in (VII)",
            proof=f"the lowest speed allowed is {low:.6g} rpm, not {wrong:.6g} rpm above that of rest",
        )
    yield Misprint(
        place="start radius",
        printed="x = (g (l + m)) / w_2",
        correct="x = g (1 + m) / w^2",
        proof=f"the limit of g (1 + m) / (w1 w2), here {50 * start.double_parameter:.6g} cm",
    )
    yield _wrong_statement(design)


def _wrong_statement(design: PendulumDesign) -> Misprint:
    """Return the statement on arms of other lengths, which compares heights on the parabolas and not slopes."""
    start = design.start
    changes = []
    for ratio, side in ((1.3, 1), (0.7, -1)):
        point = {"start_angle": start.arm_angle, "start_abscissa": start.abscissa, "arm": ratio * start.radius_of_curvature}
        changes.append(100 * float(parabolic.equilibrium_speed_change(**point, angle_change=side * PROBE_ANGLE)))
    return Misprint(
        place="choice of l",
        printed="an arm above rho is usable downward only, one below rho upward only",
        correct="above rho it is unstable in the lowest position, below rho stable both ways",
        proof=f"the speed changes by {changes[0]:+.4g} % 2 deg above it with l = 1.3 rho, by {changes[1]:+.4g} % 2 deg below it with "
        "l = 0.7 rho; the advice l <= rho is right",
    )
