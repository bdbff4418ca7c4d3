"""Registry of all joints."""

from governor_mechanism.model.joints.base import GROUND, Glyph, Joint, Point
from governor_mechanism.model.joints.drivers import Driver, RotationalDriver, TranslationalDriver
from governor_mechanism.model.joints.gears import Gear, ProportionalDisplacement, RackAndPinion
from governor_mechanism.model.joints.pairs import ArcSlot, CurveSlot, Distance, Pin, Prismatic, Slider, Weld

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
