"""The astatic governor against Zehnder's isochronous parabola: equilibrium speed, neutral equilibrium, transit time."""

import math

import numpy as np

from governor_mechanism.closed_form import parabolic as closed
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.units.constants import RPM
from governor_mechanism.verification.machines.comparisons import Checks, compare_algebraic, require_gravity_and_centrifugal, run_scene
from governor_mechanism.verification.report import ComparisonRow

GUIDE_FRACTIONS = (0.1, 0.5, 0.9)
"""Checked positions as fractions of the guide's length."""

NEUTRAL_RUN_DURATION = 10.0
"""Duration of the run that checks the neutral equilibrium (s)."""


def check_parabolic_governor(scene: Scene) -> Checks:
    """Yield every comparison that applies to the scene."""
    require_gravity_and_centrifugal(scene)
    dimensions = scene.part.dimensions
    mass_ratio = dimensions["sleeve_mass"] / dimensions["ball_mass"]
    double_parameter = dimensions["double_parameter"]
    neutral_speed = math.sqrt(2 * scene.gravity * (1 + mass_ratio) / double_parameter)
    for fraction in GUIDE_FRACTIONS:
        radius = (1 - fraction) * dimensions["inner_radius"] + fraction * dimensions["outer_radius"]
        speed = equilibrium_speed_at(scene, np.array([radius]))[0]
        yield compare_algebraic(f"equilibrium speed at {radius * 1e3:.4g} mm", speed, neutral_speed, "rad/s")
        yield _check_neutral_equilibrium(scene, radius, neutral_speed)
    yield from _check_transit_time(scene, neutral_speed, mass_ratio, double_parameter)


def _check_neutral_equilibrium(scene: Scene, radius: float, neutral_speed: float) -> ComparisonRow:
    """Return the drift from an equilibrium at a radius (m), which must vanish."""
    neutral_scene = scene.with_changes(
        spindle=Spindle(speeds=(neutral_speed,)),
        start=Start(values={"ball_radius": radius}),
        run=RunSettings(duration=NEUTRAL_RUN_DURATION, output_interval=0.5, accuracy=1e-10),
    )
    drift = float(np.max(np.abs(run_scene(neutral_scene).readings["ball_radius"] - radius)))
    quantity = f"drift from equilibrium at {radius * 1e3:.4g} mm, maximum in {NEUTRAL_RUN_DURATION:g} s"
    return ComparisonRow(quantity, drift, 0.0, 1e-10, "m", "in neutral equilibrium the forces are zero up to rounding")


def _check_transit_time(scene: Scene, neutral_speed: float, mass_ratio: float, double_parameter: float) -> Checks:
    """Yield the time in which the balls drift along the guide at the neutral speed."""
    speeds = scene.spindle.speeds if isinstance(scene.spindle, Spindle) else ()
    if any(not math.isclose(speed, neutral_speed, rel_tol=1e-9) for speed in speeds) or not speeds:
        yield f"the spindle does not keep the neutral speed, {neutral_speed / RPM:.6g} rpm: the transit time is not checked"
        return
    run = run_scene(scene)
    radius, rate = run.readings["ball_radius"], float(run.rates["ball_radius"][0])
    if rate == 0.0:
        yield "the initial velocity is zero: the transit time is not checked"
        return
    transit_time = closed.guide_transit_time(
        start=radius[0], end=radius[-1], start_rate=rate, double_parameter=double_parameter, mass_ratio=mass_ratio
    )
    quantity = f"time from {radius[0] * 1e3:.4g} to {radius[-1] * 1e3:.4g} mm"
    simulated_time = float(run.times[-1])
    reason = "the requested accuracy, at a nearly constant drift speed"
    yield ComparisonRow(quantity, simulated_time, float(transit_time), scene.run.accuracy * simulated_time, "s", reason)
