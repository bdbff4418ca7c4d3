"""What a pendulum governor moves: the throttle gear at its sleeve."""

from governor_mechanism.machines.pendulum.machine import SLEEVE
from governor_mechanism.render.machines.governor_parts import throttle_pivot_distance
from governor_mechanism.render.machines.pendulum.effects import spindle_foot_height
from governor_mechanism.render.machines.pendulum.proportions import GROOVE_RATIO, PendulumProportions
from governor_mechanism.render.machines.throttle_gear import ThrottleGear

# Lengths as fractions of the arm.
_COLLAR_GROOVE_DEPTH, _DRUM_FORK_RATIO = 0.148, 0.60
"""Depth of the groove of a light collar below the lugs, and that of the strap on a drum, relative to the depth of its foot."""
_PIVOT_DISTANCE, _PIVOT_GAP, _VALVE_DEPTH = 0.40, 0.14, 0.10


def fork_depth(governor: PendulumProportions) -> float:
    """Return the depth of the fork's pin below the lugs (m): in the groove of a light collar, or at the strap around a drum."""
    is_loaded = SLEEVE in governor.body_names
    return _DRUM_FORK_RATIO * governor.sleeve_size[1] if is_loaded else _COLLAR_GROOVE_DEPTH * governor.arm


def make_throttle_gear(governor: PendulumProportions) -> ThrottleGear:
    """Return the throttle gear of a governor, beyond its sleeve and its dashpot."""
    u, half_width, (low, high), depth = governor.arm, governor.sleeve_size[0], governor.lug_height_range, fork_depth(governor)
    return ThrottleGear(
        unit=u,
        side=-1.0,
        pin_range=(low - depth, high - depth),
        strap_half_width=1.03 * half_width if SLEEVE in governor.body_names else (GROOVE_RATIO + 0.04) * half_width,
        pivot_distance=throttle_pivot_distance(governor, max(_PIVOT_DISTANCE * u, half_width + _PIVOT_GAP * u), _PIVOT_GAP * u),
        valve_height=spindle_foot_height(governor) - _VALVE_DEPTH * u,
    )
