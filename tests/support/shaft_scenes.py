"""Engines with a shaft and a governor: shipped scenes with other couplings and loads."""

import math
from collections.abc import Mapping

import governor_mechanism as gm
from governor_mechanism.model.scene import Scene


def changed(name: str, changes: Mapping[str, object], duration: str = "3 s") -> Scene:
    """Return a shipped scene with entries of its document replaced, each given by its path; None removes the entry."""
    start = {"run.duration": duration, "part.engine.start.crank_rate": 3.27, "part.governor.start.arm_angle": "56 deg"}
    return gm.load(name).replace({**start, **changes})


GEAR = {"coupling.belt.type": "gear", "part.governor.spindle": {"inertia": "0.3 kg m^2"}}
STEAM = {"type": "torque", "name": "steam", "body": "flywheel"}
STEADY = {**STEAM, "moment": "100 N m"}
DAMPER = {"type": "torsion_damper", "name": "brake", "second": "flywheel", "damping": "5 N m s/rad"}
SPRING = {"type": "torsion_spring", "name": "coil", "second": "flywheel", "stiffness": "5 N m/rad"}
LIFT = {"reading": "governor.sleeve_lift", "gain": -2000, "about": "540 mm"}
LIFT_TABLE = {"reading": "governor.sleeve_lift", "table": [[0.45, 200], [0.5, 60], [0.55, -100]]}
DOUBLE_SINE = {"order": 2, "amplitude": math.hypot(90, 40), "phase": math.atan2(90, 40)}  # 90 cosine and 40 sine
SPEED_TABLE = {"reading": "governor.spindle_speed", "table": [[6.4, 20], [6.6, -20]]}
SPEED = {"reading": "governor.spindle_speed", "gain": -30, "about": "7 rad/s"}
LOADS = {
    "gear": GEAR,
    "gear against the sense of the engine": {**GEAR, "coupling.belt.ratio": -2},
    "torsion damper": {**GEAR, "part.engine.force": [STEADY, DAMPER]},
    "torque of the crank angle": {
        "part.engine.force": [{**STEAM, "moment": [{"reading": "engine.crank_angle", "harmonics": [DOUBLE_SINE]}, LIFT]}]
    },
    "torque of the speed": {**GEAR, "part.engine.force": [{**STEAM, "moment": [SPEED]}]},
    "factor": {
        "part.engine.force": [STEADY],
        "coupling.valve": {"type": "control", "reading": "governor.sleeve_lift", "scales": "engine.steam", "gain": -5},
    },
    "friction": {**GEAR, "part.governor.effects.dry_friction": {"sleeve_lift": "15 N"}},
    "friction of the crank angle": {
        "part.governor.effects.dry_friction": {"sleeve_lift": "15 N"},
        "coupling.wear": {"type": "control", "reading": "engine.crank_angle", "sets": "governor.dry_friction.sleeve_lift", "gain": 0.5},
    },
    "stops": {**GEAR, "part.governor.effects.stops": {"arm_angle": ["50 deg", "60 deg"], "restitution": 0.4}},
}
"""Changes of the scene watt_engine_hunting."""

TABLES = {"tables of the lift and of the speed": {**GEAR, "part.engine.force": [{**STEAM, "moment": [LIFT_TABLE, SPEED_TABLE, -50]}]}}
"""Changes of the same scene, with kinks that the motion crosses."""
