"""Hartung's governor against Dubois' formulas: spring force, speed of rest, sleeve force, swing, motion, energy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram
from governor_mechanism.mechanics.reduction.lagrangian import Reduction
from governor_mechanism.model.effect import OnReading
from governor_mechanism.model.scene import FreeSpindle, Scene, Spindle
from governor_mechanism.observables.static_forces import static_force
from governor_mechanism.statics.speed_curve import equilibrium_speed
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.hartung.motion import LEVER, in_motion, spring_force
from governor_mechanism.verification.oscillation import rpm, run_of, settled_row, swing_row
from governor_mechanism.verification.report import Row

PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Of the way between the ends of the stroke."""

BESIDE = 0.05
"""rad: so far to each side of its rest the simulation is let go to settle; less where it might settle elsewhere."""


def findings(scene: Scene) -> Iterator[Row | str]:
    """Every comparison that applies to the scene: over the stroke, at rest at its first and last speed, in motion.

    What is at rest is checked without the effects that act along readings, and motion until something strikes.
    """
    if not (scene.gravity and scene.centrifugal):
        raise MechanismError("the closed forms of a Hartung governor need both effects, gravity and centrifugal")
    cranks = any(isinstance(effect, BellCranks) for effect in scene.effects)
    if cranks:
        yield "the closed forms have weights as points on massless bell cranks: only the energy is checked"
    else:
        governor = closed_governor(scene)
        plain = replace(scene, effects=tuple(one for one in scene.effects if not isinstance(one, OnReading)))
        yield from _over_the_stroke(plain, governor, _stroke(scene))
        yield from _at_rests(plain, governor, _stroke(scene))
    run = run_of(scene)
    if not cranks:
        yield from in_motion(scene, governor, run)
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1]:.4g} of {scene.run.duration:.4g} s: {run.message}"
    yield Row(
        quantity="Jacobi integral, largest change",
        simulated=run.energy.drift,
        expected=0.0,
        allowed=scene.run.accuracy,
        unit="1",
        reason="relative to mass x size^2 / time scale^2, like the accuracy",
    )


def closed_governor(scene: Scene) -> closed.HartungGovernor:
    """The closed form's governor of a scene."""
    sizes = scene.part.dimensions
    names = ("weight_arm", "sleeve_arm", "fulcrum_radius", "weight_mass", "sleeve_mass", "hanger")
    return closed.HartungGovernor(
        **{name: sizes[name] for name in names},
        angle=sizes["bell_crank_angle"],
        lug_radius=sizes["lug_offset"],
        gravity=scene.gravity,
    )


def _stroke(scene: Scene) -> tuple[float, float]:
    """Between the stops of the lever; without them, the middle half of the travel."""
    stops = next((one for one in scene.effects if isinstance(one, Stops) and one.reading == LEVER), None)
    low, high = _travel(scene)
    inner, outer = 0.75 * high + 0.25 * low, 0.25 * high + 0.75 * low
    if stops is None:
        return outer, inner
    return stops.low if math.isfinite(stops.low) else outer, stops.high if math.isfinite(stops.high) else inner


def _travel(scene: Scene) -> tuple[float, float]:
    limit = next(limit for limit in scene.part.mechanism.limits if limit.reading == LEVER)
    return limit.low, limit.high


def _over_the_stroke(scene: Scene, governor: closed.HartungGovernor, stroke: tuple[float, float]) -> Iterator[Row]:
    outer, inner = stroke
    levers = np.array([inner + part * (outer - inner) for part in PLACES])
    along = Reduction(scene).at(levers)
    static = static_force(scene, "sleeve_lift", along.poses)
    for k, lever in enumerate(levers.tolist()):
        at, force = f"at {math.degrees(lever):.4g} deg", spring_force(scene, lever)
        algebra = "both are algebra; rounding and the closing of the joints leave about 1e-12"
        speed = float(closed.equilibrium_speed(governor, lever_angle=lever, spring_force=force))
        found = float(equilibrium_speed(scene, np.array([lever]))[0])
        yield Row(
            quantity=f"speed of rest {at}",
            simulated=found,
            expected=speed,
            allowed=1e-10 * speed,
            unit="rad/s",
            reason=algebra,
        )
        held = float(closed.static_sleeve_force(governor, lever_angle=lever, spring_force=force))
        yield Row(
            quantity=f"static sleeve force {at}",
            simulated=float(static[k]),
            expected=held,
            allowed=1e-10 * abs(held),
            unit="N",
            reason=algebra,
        )
    yield from _astatic(scene, governor, levers)


def _astatic(scene: Scene, governor: closed.HartungGovernor, levers: FloatArray) -> Iterator[Row]:
    """The spring force that would hold the weights at one speed, from a governor without its springs."""
    part = scene.part
    bare = replace(scene, parts=(replace(part, mechanism=replace(part.mechanism, loads=(), outputs=())),))
    reduction = Reduction(bare)
    along = reduction.at(levers)
    speed = SpeedProgram(scene.spindle).start_speed
    # The work of two springs on a small way balances that of weights and turning.
    pulls = (0.5 * along.spindle_slope * speed**2 - along.potential_slope) / (
        2 * reduction.slopes(along, "weight_radius")
    )
    for lever, pull in zip(levers.tolist(), pulls.tolist(), strict=True):
        expected = float(closed.astatic_spring_force(governor, lever_angle=lever, spindle_speed=speed))
        yield Row(
            quantity=f"spring force that holds {math.degrees(lever):.4g} deg at {rpm(speed)}",
            simulated=pull,
            expected=expected,
            allowed=1e-10 * max(abs(expected), governor.weight_mass * scene.gravity),
            unit="N",
            reason="both are algebra; rounding and the closing of the joints leave about 1e-12",
        )


def _at_rests(scene: Scene, governor: closed.HartungGovernor, stroke: tuple[float, float]) -> Iterator[Row | str]:
    if isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: rest at a given speed is not checked"
        return
    speeds = list(dict.fromkeys((scene.spindle.speeds[0], scene.spindle.speeds[-1])))
    for speed in speeds:
        every = _rests(scene, governor, abs(speed))
        angles = [angle for angle in every if stroke[0] <= angle <= stroke[1]]
        if not angles:
            yield f"at {rpm(speed)} this governor rests nowhere within its stroke: rest is not checked"
        for angle in angles:
            beside = min([BESIDE, *(0.3 * abs(angle - other) for other in every if other != angle)])
            yield from _at_rest(replace(scene, spindle=Spindle(speeds=(speed,))), governor, angle, beside)


def _rests(scene: Scene, governor: closed.HartungGovernor, speed: float) -> list[float]:
    """Lever angles (rad) at which the springs' force is what the speed asks for."""
    low, high = _travel(scene)
    edge = 1e-3 * (high - low)

    def excess(lever: float) -> float:
        asked = closed.astatic_spring_force(governor, lever_angle=lever, spindle_speed=speed)
        return spring_force(scene, lever) - float(asked)

    grid = np.linspace(low + edge, high - edge, 400)
    values = [excess(float(lever)) for lever in grid]
    return [
        float(brentq(excess, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-14))
        for k in range(len(grid) - 1)
        if values[k] * values[k + 1] < 0
    ]


def _at_rest(scene: Scene, governor: closed.HartungGovernor, angle: float, beside: float) -> Iterator[Row | str]:
    speed, sizes = SpeedProgram(scene.spindle).start_speed, scene.part.dimensions
    at = f"{math.degrees(angle):.4g} deg, {rpm(speed)}"
    force, rate = spring_force(scene, angle), sizes["spring_rate"]
    squared = float(closed.squared_frequency(governor, lever_angle=angle, spring_force=force, spring_rate=rate))
    if squared <= 0:
        yield f"the equilibrium at {at} is unstable: nothing settles into it or swings about it"
        return
    for side in (-beside, beside):
        yield settled_row(
            scene,
            f"settled from {math.degrees(angle + side):.4g} deg at {rpm(speed)}",
            start=angle + side,
            expected=angle,
        )
    period = 2 * math.pi / math.sqrt(squared)
    yield swing_row(scene, LEVER, angle=angle, period=period, at=at)
