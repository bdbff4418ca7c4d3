"""Registry of all joints; each has a file."""

from governor_mechanism.model.joints.arc_slot import ArcSlot
from governor_mechanism.model.joints.base import GROUND, Glyph, Joint, Point
from governor_mechanism.model.joints.curve_slot import CurveSlot
from governor_mechanism.model.joints.distance import Distance
from governor_mechanism.model.joints.drivers import Driver, RotationalDriver, TranslationalDriver
from governor_mechanism.model.joints.gear import Gear
from governor_mechanism.model.joints.pin import Pin
from governor_mechanism.model.joints.prismatic import Prismatic
from governor_mechanism.model.joints.proportional_displacement import ProportionalDisplacement
from governor_mechanism.model.joints.rack import RackAndPinion
from governor_mechanism.model.joints.slider import Slider
from governor_mechanism.model.joints.weld import Weld

__all__ = [
    "GROUND", "JOINTS", "JOINT_TYPES", "ArcSlot", "CurveSlot", "Distance", "Driver", "Gear", "Glyph", "Joint", "Pin", "Point", "Prismatic",
    "ProportionalDisplacement", "RackAndPinion", "RotationalDriver", "Slider", "TranslationalDriver", "Weld",
]  # fmt: skip

JOINTS: tuple[type[Joint], ...] = (
    Pin,
    Weld,
    Prismatic,
    Slider,
    ArcSlot,
    CurveSlot,
    Gear,
    RackAndPinion,
    RotationalDriver,
    TranslationalDriver,
    Distance,
    ProportionalDisplacement,
)
"""All joints, those of [[joint]] in a scene file first."""

JOINT_TYPES = frozenset(JOINTS)
"""All joints."""
