"""Cases of `peers.py`, described once for every code, and the recorded results of a run."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import governor_mechanism as gm
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

INTERVALS = 200
GRAVITY = 9.81


@dataclass(frozen=True, kw_only=True)
class Governor:
    """Two balls on arms, a sleeve on links as long as the arms; SI. Speeds are pairs (time, rad/s) with linear ramps between them."""

    arm: float
    offset: float
    ball_mass: float
    sleeve_mass: float
    friction: float
    speeds: tuple[tuple[float, float], ...]
    angle: float


@dataclass(frozen=True, kw_only=True)
class SliderCrank:
    """An unbalanced flywheel with a crank pin, a massless rod, and a slider under a constant force; SI."""

    crank: float
    rod: float
    flywheel_mass: float
    flywheel_inertia: float
    centre: float
    slider_mass: float
    force: float
    angle: float
    rate: float

    @property
    def slider(self) -> float:
        """Position of the slider at the start (m)."""
        return self.crank * math.cos(self.angle) + math.sqrt(self.rod**2 - (self.crank * math.sin(self.angle)) ** 2)

    @property
    def slider_rate(self) -> float:
        """Velocity of the slider at the start (m/s)."""
        height = self.crank * math.sin(self.angle)
        along = self.crank * math.cos(self.angle)
        return -height * self.rate * (1 + along / math.sqrt(self.rod**2 - height**2))


@dataclass(frozen=True, kw_only=True)
class Case:
    """A scene of this package, the same data for the peers, and the compared angle (rad)."""

    title: str
    scene: Scene
    reading: str
    model: Governor | SliderCrank

    @property
    def times(self) -> FloatArray:
        """Reported times of every code (s)."""
        return np.linspace(0.0, self.scene.run.duration, INTERVALS + 1)

    @property
    def interval(self) -> float:
        """Interval between reported times (s)."""
        return self.scene.run.duration / INTERVALS


@dataclass(frozen=True, kw_only=True)
class Method:
    """A method of a code.

    `prepare` takes a number of steps between reported times, or for codes with error control the exponent of a tolerance. It returns
    the timed function, which returns the angle at every reported time.
    """

    name: str
    prepare: Callable[[int], Callable[[], FloatArray]]
    ladder: tuple[int, ...]
    stepped: bool = True


@dataclass(frozen=True)
class SettingResult:
    """A setting of a ladder: the largest error (rad), the shortest time (s), and the angles."""

    setting: int
    error: float
    seconds: float
    angles: FloatArray


SLIDER_CRANK = SliderCrank(
    crank=0.1, rod=0.3, flywheel_mass=20.0, flywheel_inertia=0.4, centre=0.02, slider_mass=2.0, force=50.0,
    angle=math.radians(30.0), rate=10.0,
)  # fmt: skip

SLIDER_CRANK_FILE = """\
title = "Slider crank with flywheel"
machine = "custom"
ground = {{ O = [0, 0] }}

[[body]]
name = "flywheel"
mass = {flywheel_mass}
inertia = {flywheel_inertia}
centre = [{centre}, 0]
points = {{ pin = [{crank}, 0] }}

[[body]]
name = "slider"
mass = {slider_mass}
turns = false
at = [{slider}, 0]

[[joint]]
type = "pin"
first = "ground.O"
second = "flywheel.origin"

[[joint]]
type = "slider"
first = "ground.O"
second = "slider.centre"
angle = 0

[[link]]
first = "flywheel.pin"
second = "slider.centre"
length = {rod}

[[force]]
type = "force"
point = "slider.centre"
x = {force}
y = 0

[readings]
crank_angle = {{ angle = "flywheel" }}

[start]
crank_angle = {angle}
crank_rate = {rate}

[effects]
gravity = true

[run]
duration = 5
"""


def cases() -> tuple[Case, ...]:
    """Return the four cases."""
    porter = gm.load("porter")
    # Equilibrium speed at the same angle with a sleeve 400 times as heavy as a ball.
    speed = porter.spindle.speeds[0] * math.sqrt((1 + 400) / (1 + 4))
    heavy = gm.load(edit_scene_file("porter", ('sleeve_mass = "20 kg"', 'sleeve_mass = "2000 kg"'), ('"120 rpm"', f'"{speed!r} rad/s"')))
    rubbing = gm.load("porter_dry_friction")
    # The turning point of the speed is then a reported time.
    rubbing = replace(rubbing, run=replace(rubbing.run, duration=40.0))
    turning = gm.load(write_scene_file(SLIDER_CRANK_FILE.format(**{**vars(SLIDER_CRANK), "slider": SLIDER_CRANK.slider}), "slider_crank"))
    return (
        governor_case("Porter governor, 10 s", porter),
        governor_case("sleeve 400 times as heavy as a ball, 10 s", heavy),
        governor_case("dry friction, speed up and down, 40 s", rubbing),
        Case(title="slider crank with flywheel, 5 s", scene=turning, reading="crank_angle", model=SLIDER_CRANK),
    )


def governor_case(title: str, scene: Scene) -> Case:
    """Return the case of a governor scene, with its numbers defined once."""
    dimensions, spindle = scene.part.dimensions, scene.spindle
    friction = next((effect.force for effect in scene.output_effects if isinstance(effect, DryFriction)), None)
    speeds = tuple(zip(spindle.times, spindle.speeds, strict=True))
    model = Governor(
        arm=dimensions["arm"],
        offset=dimensions["offset"],
        ball_mass=dimensions["ball_mass"],
        sleeve_mass=dimensions["sleeve_mass"],
        friction=0.0 if friction is None else float(friction.values[0]),
        speeds=tuple((float(time), float(speed)) for time, speed in speeds),
        angle=float(scene.start.values["arm_angle"]),
    )
    return Case(title=title, scene=scene, reading="arm_angle", model=model)


def edit_scene_file(name: str, *changes: tuple[str, str]) -> Path:
    """Return the file of a shipped scene with other numbers."""
    text = (Path(__file__).parents[1] / "models" / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return write_scene_file(text, name)


def write_scene_file(text: str, name: str) -> Path:
    """Write a scene file."""
    path = Path(tempfile.mkdtemp()) / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path
