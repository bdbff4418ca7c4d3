"""Runs that several tests save, each simulated once: friction and events, several parts, a driven mechanism, unusual names."""

from functools import cache
from pathlib import Path

import governor_mechanism as gm

UNUSUAL_NAMES = str(Path(__file__).with_name("unusual_names.toml"))
SCENES = ("porter_dry_friction", "governed_engine_mean_torque", "slide_valve_30", UNUSUAL_NAMES)


@cache
def saved_run(scene: str) -> gm.Trajectory:
    return gm.run(scene)
