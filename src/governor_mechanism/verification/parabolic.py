"""The astatic governor against Zehnder's isochronous parabola: one speed of rest, neutral rest, time of a drift."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from governor_mechanism.closed_form.parabolic import isochronous_curve as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import RunSettings, Scene, Spindle, Start
from governor_mechanism.statics.speed_curve import equilibrium_speed
from governor_mechanism.verification.oscillation import run_of
from governor_mechanism.verification.report import Row

PLACES = (0.1, 0.5, 0.9)
"""Of the way between the ends of the guide."""

STILL = 10.0
"""s: so long a governor at rest is watched."""


def findings(scene: Scene) -> Iterator[Row | str]:
    """Every comparison that applies to the scene."""
    if not (scene.gravity and scene.centrifugal):
        raise MechanismError("the isochronous parabola needs both effects, gravity and centrifugal")
    sizes = scene.part.dimensions
    ratio, parameter = sizes["sleeve_mass"] / sizes["ball_mass"], sizes["double_parameter"]
    neutral = math.sqrt(2 * scene.gravity * (1 + ratio) / parameter)
    for part in PLACES:
        radius = (1 - part) * sizes["inner_radius"] + part * sizes["outer_radius"]
        yield Row(
            quantity=f"speed of rest at {radius * 1e3:.4g} mm",
            simulated=float(equilibrium_speed(scene, np.array([radius]))[0]),
            expected=neutral,
            allowed=1e-10 * neutral,
            unit="rad/s",
            reason="both are algebra; the closing of the joints leaves about 1e-13",
        )
        yield _left_alone(scene, radius, neutral)
    yield from _drifting(scene, neutral, ratio, parameter)


def _left_alone(scene: Scene, radius: float, speed: float) -> Row:
    still = replace(
        scene,
        spindle=Spindle(speeds=(speed,)),
        start=Start(values={"ball_radius": radius}),
        run=RunSettings(duration=STILL, every=0.5, accuracy=1e-10),
    )
    return Row(
        quantity=f"left alone at {radius * 1e3:.4g} mm, farthest in {STILL:g} s",
        simulated=float(np.max(np.abs(run_of(still).readings["ball_radius"] - radius))),
        expected=0.0,
        allowed=1e-10,
        unit="m",
        reason="neutral rest keeps what the start leaves: forces are zero but for rounding",
    )


def _drifting(scene: Scene, neutral: float, ratio: float, parameter: float) -> Iterator[Row | str]:
    speeds = scene.spindle.speeds if isinstance(scene.spindle, Spindle) else ()
    if any(not math.isclose(speed, neutral, rel_tol=1e-9) for speed in speeds) or not speeds:
        yield f"the spindle does not keep the neutral speed, {neutral * 30 / math.pi:.6g} rpm: the drift is not checked"
        return
    run = run_of(scene)
    radius, rate = run.readings["ball_radius"], float(run.rates["ball_radius"][0])
    if rate == 0.0:
        yield "the balls start at rest: there is no drift to check"
        return
    time = closed.guide_transit_time(
        start=radius[0], end=radius[-1], start_rate=rate, double_parameter=parameter, mass_ratio=ratio
    )
    yield Row(
        quantity=f"time from {radius[0] * 1e3:.4g} to {radius[-1] * 1e3:.4g} mm",
        simulated=float(run.times[-1]),
        expected=float(time),
        allowed=scene.run.accuracy * run.times[-1],
        unit="s",
        reason="the accuracy asked of the run, on a drift at nearly one speed",
    )
