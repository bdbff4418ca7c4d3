"""The rotational driver."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.model.joints.base import FirstConfiguration
from governor_mechanism.model.joints.constraint_row import ConstraintRow, relative_angle_row
from governor_mechanism.model.joints.driver import Driver, motion_keys
from governor_mechanism.model.joints.impulse_parts import DrivenAngle, ImpulsePart


@dataclass(frozen=True, kw_only=True)
class RotationalDriver(Driver):
    """A rotational driver: the angle of the second body minus that of the first follows a prescribed motion.

    Attributes
    ----------
    motion
        Relative angle over time, rad.
    """

    type_name = "driven_turn"
    joins_bodies = True
    rate_example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    keys = motion_keys(
        rate=("angular_speed", "the constant speed of the second body against the first; instead of motion"),
        start=("angle", "the relative angle at the start, with a rate; by default the initial one"),
        motion=("angle motion", "the relative angle over time: a list of [time, angle], or a start and a rate with harmonics"),
    )

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the start."""
        return {"start": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [relative_angle_row(0.0, length_scale, self.motion)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (DrivenAngle(),)
