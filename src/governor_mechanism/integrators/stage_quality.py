"""Quality of the stages of a step: 1, less near a singular state, and negative outside the domain of an equation; compiled."""

from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.numerics.jit import jit_in_place

NEAR_SINGULAR_QUALITY, MIN_STAGE_QUALITY = 1e-3, 1e-6
"""Quality of a stage below which it is near a singular state, and below which a step is retried.

At an angle e from a change point, a constraint violation d causes an acceleration error of order d / e^3. The step is
therefore placed so that the change point falls into the widest gap between stages. A step with a stage too close to
the change point is repeated with another length, unless it starts so close that no step does better.
"""

CROSSING_QUALITY_RATIO = 0.04
"""Quality of the stages nearest to a change point relative to that of the start, in a step that has the change point in its widest gap.

The gap reaches from 0.333 to 0.6 of the step. With the change point in its middle, the nearest stages are 0.134 / 0.466 of the angle of
the start away, and the quality is the square of an angle: 0.08. Half of it is required, because the angle is extrapolated.
"""

BELOW_DOMAIN, ABOVE_DOMAIN, FAR_OUTSIDE_DOMAIN, OUT_OF_RANGE, TURNED_BACK, LEFT_LIMITS = -1.0, -2.0, -3.0, -4.0, -5.0, -6.0
"""Qualities of a stage that leaves the domain of the equation, of one so far outside that a shorter step may stay inside, and of ends of
a step at which the integration ends.
"""

STAGE_GAP_FRACTION = 0.466
"""Middle of the widest gap between the stage nodes, as a fraction of the step."""

STEERING_QUALITY = 0.1
"""Quality below which step sizes are steered so that the change point falls into the gap between stages."""

MAX_SINGULAR_RETRIES = 60
"""Largest number of other step lengths tried at one change point."""


@jit_in_place
def domain_status(quality: float) -> IntegrationStatus:
    """Return how an integration ends at a stage outside the domain."""
    if quality == OUT_OF_RANGE:
        return IntegrationStatus.OUT_OF_RANGE
    if quality == LEFT_LIMITS:
        return IntegrationStatus.LEFT_LIMITS
    if quality == TURNED_BACK:
        return IntegrationStatus.TURNED_BACK
    return IntegrationStatus.BELOW_TABLE if quality == BELOW_DOMAIN else IntegrationStatus.ABOVE_TABLE


@jit_in_place
def steer_step_over_singularity(angle: float, previous_angle: float, h: float, step: float) -> float:
    """Return the next step size that places the change point in the gap between stages, from its angles one step h apart."""
    time_to_singularity = angle * h / (previous_angle - angle)
    time_to_step_start = time_to_singularity - STAGE_GAP_FRACTION * step
    if time_to_step_start > step:  # at least two steps away
        return step
    if time_to_step_start > 0.0:  # end this step where the next one has the singularity in its gap
        return max(time_to_step_start, 0.02 * step)
    return time_to_singularity / STAGE_GAP_FRACTION if time_to_singularity > 0.1 * step else step
