"""An engine under Watt's governor, in Pontryagin's form of Vyshnegradskii's problem: stability limit and onset of hunting.

The balls hang on massless arms on the spindle axis, the sleeve on links as long as the arms. The spindle follows the engine at a
fixed ratio and returns no torque. The torque of the engine falls linearly with the lift of the sleeve. With the length of the arm l and
the time sqrt(l / g) as units, x the arm angle and z the spindle speed:

    x'' = z^2 sin x cos x - sin x - epsilon x'        z' = alpha (cos x - beta)

References
----------
L. S. Pontryagin, Ordinary Differential Equations (1962), section 27: equations and stability limit. J. Sotomayor, L. F. Mello,
D. de Carvalho Braga, Bifurcation analysis of the Watt governor system, arXiv:math/0606230 (2006):
onset of hunting, with the coefficient of Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, section 5.4.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class WattEngine:
    """The scaled problem.

    Attributes
    ----------
    control
        Strength of the control alpha, above 0.
    cosine
        Cosine beta of the arm angle in equilibrium, between 0 and 1.
    damping
        Damping of the arms epsilon, at least 0.
    """

    control: float
    cosine: float
    damping: float


def scale_engine(
    *,
    arm: float,
    ball_mass: float,
    arm_damping: float,
    engine_inertia: float,
    torque_gain: float,
    equilibrium_lift: float,
    ratio: float = 1.0,
    gravity: float = 9.81,
) -> WattEngine:
    """Return the scaled problem: epsilon = b sqrt(l / g) / (2 m l^2), alpha = 2 r G l^2 / (g J), beta = 1 - s / 2l.

    Parameters
    ----------
    arm
        Length l of arms and links, m.
    ball_mass
        Mass m of one of the two balls, kg.
    arm_damping
        Damping b along the arm angle, both arms together, N m s/rad.
    engine_inertia
        Moment of inertia J of the engine, kg m2.
    torque_gain
        Fall G of the engine's torque with the lift of the sleeve, N.
    equilibrium_lift
        Lift s of the sleeve, from hanging arms, at which torque and load are equal, m; between 0 and 2 l.
    ratio
        Spindle speed relative to engine speed r.
    gravity
        Acceleration of gravity g, m/s2.

    Returns
    -------
    WattEngine
        The scaled problem. Its unit of time is scaled_time_unit, its unit of the spindle speed the inverse.
    """
    unit_of_time = scaled_time_unit(arm=arm, gravity=gravity)
    return WattEngine(
        control=2 * ratio * torque_gain * arm**2 / (gravity * engine_inertia),
        cosine=1 - equilibrium_lift / (2 * arm),
        damping=arm_damping * unit_of_time / (2 * ball_mass * arm**2),
    )


def scaled_time_unit(*, arm: float, gravity: float = 9.81) -> float:
    """Return the unit of the scaled time, sqrt(arm / gravity), in s; the arm in m, gravity in m/s2."""
    return math.sqrt(arm / gravity)


def equilibrium(engine: WattEngine) -> tuple[float, float]:
    """Return the arm angle arccos(beta) (rad) and the scaled spindle speed 1 / sqrt(beta) of the equilibrium."""
    return math.acos(engine.cosine), 1 / math.sqrt(engine.cosine)


def damping_limit(engine: WattEngine) -> float:
    """Return the damping below which the engine hunts, 2 alpha beta^(3/2)."""
    return 2 * engine.control * math.pow(engine.cosine, 1.5)


def first_lyapunov_coefficient(engine: WattEngine) -> float:
    """Return the first Lyapunov coefficient at the stability limit; its sign tells how hunting sets in.

    Negative: soft, a small stable oscillation arises beyond the limit. Positive: hard, an unstable oscillation before the limit bounds the
    disturbances that die out, and beyond it the engine leaves the neighbourhood of the equilibrium. The eigenvector q of the formula has
    the component 1 along the arm angle; the coefficient is Re(c1) / w0 with the frequency w0 = sqrt((1 - beta^2) / beta).

        Re(c1) = -alpha beta^(3/2) (1 - beta^2) (3 + (alpha^2 - 5) beta^2 + alpha^4 beta^6) / (2 (S + 4 B) (S + B))

    with S = 1 - beta^2 and B = alpha^2 beta^4.

    Parameters
    ----------
    engine
        The scaled problem; its damping does not matter.

    Returns
    -------
    float
        The coefficient.

    References
    ----------
    Sotomayor, Mello and Braga (2006) for the sign; the factor by Kuznetsov's formula.
    """
    control, cosine = engine.control, engine.cosine
    squared_sine, feedback = 1 - cosine**2, control**2 * cosine**4
    sign = 3 + (control**2 - 5) * cosine**2 + control**4 * cosine**6
    cubic = -control * math.pow(cosine, 1.5) * squared_sine * sign / (2 * (squared_sine + 4 * feedback) * (squared_sine + feedback))
    return cubic / math.sqrt(squared_sine / cosine)
