"""Scenes built in Python for the tests, without going through a file."""

from typing import Any

import numpy as np

from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import FreeSpindle, Part, Spindle, Start
from governor_mechanism.model.scene import RunSettings, Scene
from reference import zehnder

PORTER = {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0}
WATT = {"arm": 0.4, "offset": 0.05, "ball_mass": 2.0}
CROSSED = {"arm": 0.4, "offset": -0.06, "ball_mass": 2.0, "sleeve_mass": 8.0}
EXTENDED = {"arm": 0.4, "arm_joint": 0.25, "offset": 0.03, "ball_mass": 2.5, "sleeve_mass": 7.5}
UNCROSSED_LINKS = {"arm": 0.4, "arm_joint": 0.25, "offset": -0.04, "lug_offset": 0.03, "link": 0.2, "ball_mass": 2.0, "sleeve_mass": 8.0}


def governor_scene(
    dimensions: dict[str, float],
    *,
    speed: float | Spindle,
    angle: float | str,
    rate: float = 0.0,
    duration: float = 2.0,
    output_interval: float = 0.01,
    accuracy: float = 1e-6,
) -> Scene:
    """A pendulum governor with gravity and centrifugal load."""
    machine = MACHINES["pendulum_governor"](**dimensions)
    spindle = speed if isinstance(speed, Spindle) else Spindle(speeds=(speed,))
    start = Start(values={"arm_angle": angle}, rates={"arm_angle": rate})
    run = RunSettings(duration=duration, output_interval=output_interval, accuracy=accuracy)
    return machine_scene(machine, (Gravity(), Centrifugal()), spindle, start, run)


def machine_scene(machine: Any, effects: tuple[Effect, ...], spindle: Spindle | FreeSpindle, start: Start, run: RunSettings) -> Scene:
    """A scene of one machine that turns with its spindle."""
    mechanism, of_machine = machine.mechanism_with_effects(effects), {"machine": machine.name, "dimensions": machine.dimensions()}
    part = Part(name="governor", **of_machine, mechanism=mechanism, effects=effects, spindle=spindle, start=start)
    return Scene(title="test", parts=(part,), run=run)


def porter_open(**options) -> Scene:
    """The governor of the reference motion from its start, at constant speed."""
    start = zehnder.PORTER_OPEN_MOTION
    return governor_scene(PORTER, speed=start["spindle_speed"], angle=start["arm_angle"], rate=start["arm_rate"], **options)


def random_governor(random: np.random.Generator) -> tuple[dict[str, float], float]:
    """Dimensions of some governor, and an arm angle (rad) well inside its travel."""
    arm = random.uniform(0.15, 0.6)
    dimensions = {"arm": arm, "offset": arm * random.uniform(-0.15, 0.3), "ball_mass": random.uniform(0.5, 10.0)}
    kind = random.integers(4)
    if kind > 0:
        dimensions["sleeve_mass"] = dimensions["ball_mass"] * 10 ** random.uniform(-0.5, 1.5)
    if kind > 1:
        dimensions["arm_joint"] = arm * random.uniform(0.5, 0.95)
    if kind > 2:
        dimensions["link"] = dimensions["arm_joint"] * random.uniform(0.9, 1.3)
    return dimensions, random.uniform(0.45, 0.95)
