"""The characteristic polynomial of a governed engine by hand, from the dimensions of its scene, for comparison with the simulation."""

from governor_mechanism.closed_form.governed_engine import CharacteristicCoefficients, pendulum_coefficients
from governor_mechanism.closed_form.pendulum.kinematics import PendulumGovernor
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.stops import Stops
from governor_mechanism.machines.pendulum import machine as pendulum
from governor_mechanism.model.coupling.couplings import FollowCoupling
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.studies.regression import SLEEVE_READING
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine, OperatingPoint


def characteristic_coefficients_of(governed: GovernedEngine, point: OperatingPoint) -> CharacteristicCoefficients | None:
    """Return the polynomial of the loop with mean torque, by Vyshnegradskii's theory with the reaction of the governor.

    Result: coefficients; None unless a pendulum governor without further effects than a linear dashpot on its
    sleeve, and stops, regulates the engine.
    """
    part = next(one for one in governed.scene.parts if one.name == governed.governor)
    dashpots = [one for one in part.effects if isinstance(one, Dashpot)]
    others = [one for one in part.effects if not isinstance(one, Dashpot | Gravity | Centrifugal | Stops)]
    if part.machine != pendulum.PendulumGovernor.name or others:
        return None
    if any(one.reading != SLEEVE_READING or one.quadratic for one in dashpots):
        return None
    is_follower = any(isinstance(one, FollowCoupling) for one in governed.scene.couplings)
    return pendulum_coefficients(
        PendulumGovernor(**part.dimensions, gravity=part.gravity),
        arm_angle=point.coordinate,
        flywheel_inertia=governed.shaft_inertia,
        torque_slope=governed.torque_slope(point),
        sleeve_damping=sum(one.linear for one in dashpots),
        gear_ratio=abs(governed.ratio),
        spindle_inertia=part.spindle.inertia if isinstance(part.spindle, FreeSpindle) else 0.0,
        reacts=not is_follower,
    )
