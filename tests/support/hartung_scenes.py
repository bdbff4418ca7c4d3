"""Hartung governors built in Python for the tests, and their closed forms."""

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.machines.hartung import HartungGovernor
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import FreeSpindle, Spindle, Start
from governor_mechanism.model.scene import RunSettings, Scene
from governor_scenes import machine_scene
from reference import hartung

PAPER_DIMENSIONS = {
    **{name: value for name, value in hartung.GOVERNOR.items() if name != "angle"},
    "bell_crank_angle": hartung.GOVERNOR["angle"],
    "spring_rate": hartung.SPRING_RATE,
    "spring_preload": hartung.PRELOAD,
    "preload_radius": hartung.PRELOAD_RADIUS,
}


def hartung_scene(
    dimensions: dict[str, Any],
    *,
    speed: float | Spindle | FreeSpindle = 21.9,
    angle: float = 0.0,
    rate: float = 0.0,
    more_effects: tuple[Effect, ...] = (),
    duration: float = 2.0,
    output_interval: float = 0.01,
    accuracy: float = 1e-6,
) -> Scene:
    """A Hartung governor with gravity, centrifugal load, and more effects."""
    machine, effects = HartungGovernor(**dimensions), (Gravity(), Centrifugal(), *more_effects)
    spindle = Spindle(speeds=(speed,)) if isinstance(speed, float) else speed
    start = Start(values={"lever_angle": angle}, rates={"lever_angle": rate})
    run = RunSettings(duration=duration, output_interval=output_interval, accuracy=accuracy)
    return machine_scene(machine, effects, spindle, start, run)


def build_closed_form_governor(dimensions: dict[str, Any]) -> closed.HartungGovernor:
    """The closed form's governor of these dimensions."""
    names = ("weight_arm", "sleeve_arm", "fulcrum_radius", "weight_mass", "sleeve_mass")
    return closed.HartungGovernor(
        **{name: dimensions[name] for name in names},
        angle=dimensions["bell_crank_angle"],
        hanger=dimensions.get("hanger") or math.inf,
        lug_radius=dimensions.get("lug_offset", 0.0),
    )


def sleeve_height_at(governor: closed.HartungGovernor, lever_angle: Any) -> Any:
    """Height (m) of the sleeve lugs above the fulcrum: that of the hangers' upper ends, less the vertical extent of a hanger."""
    x = governor.fulcrum_radius - governor.sleeve_arm * np.sin(governor.angle + lever_angle)
    drop = np.sqrt(governor.hanger**2 - (x - governor.lug_radius) ** 2) if math.isfinite(governor.hanger) else 0.0
    return governor.sleeve_arm * np.cos(governor.angle + lever_angle) - drop


def spring_force_at(dimensions: dict[str, Any], lever_angle: float) -> float:
    """Force (N) of each spring at a lever angle (rad)."""
    x = float(closed.weight_radius(build_closed_form_governor(dimensions), lever_angle=lever_angle))
    return float(dimensions["spring_preload"] + dimensions["spring_rate"] * (x - dimensions["preload_radius"]))


def equilibrium_angle_at(dimensions: dict[str, Any], speed: float, low: float = -0.4, high: float = 0.4) -> float:
    """Lever angle (rad) of rest at a spindle speed (rad/s), by the closed form."""
    governor = build_closed_form_governor(dimensions)

    def excess(lever: float) -> float:
        force = spring_force_at(dimensions, lever)
        return float(closed.equilibrium_speed(governor, lever_angle=lever, spring_force=force)) - speed

    return float(brentq(excess, low, high, xtol=1e-15, rtol=1e-14))
