"""Errata put to the test: what the statics, the kinematics or a run of the simulated machine find, in a sentence."""

import math
from collections.abc import Callable, Mapping

import numpy as np

from governor_mechanism.papers.errata.erratum import Paper
from governor_mechanism.papers.errata.zehnder import LONGER, PROBE_ANGLE_DEG, SHORTER
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.design.flywheel import compare_with_paper, design_flywheel
from governor_mechanism.studies.design.hartung import PAPER_INPUTS
from governor_mechanism.studies.design.pendulum import PendulumDesign, design_pendulum
from governor_mechanism.studies.design.simulated import simulate_wheels
from governor_mechanism.studies.valve_gears import tabulate_valve_timing
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

PROBE_RESISTANCE = 40.0
"""Resistance at the sleeve, N, from whose band of speed the static sleeve force follows; the result does not depend on it."""

N_STROKE_POINTS = 61
"""Positions of the lever over its stroke, both ends among them, where the static sleeve force is largest or smallest."""


def simulate_flywheels() -> str:
    """Run the engine with the wheel of the printed number, and with the one that its closed cycle needs."""
    wheels = simulate_wheels(design_flywheel(), compare_with_paper())
    light, right = wheels[0], wheels[-1]
    return (
        f"with the wheel of the printed number, {light.inertia:.0f} kg m2, the speed fluctuates by {100 * light.coefficient:.2f} %, "
        f"{light.excess:.2f} times the {100 * light.allowed:.2f} % allowed; with {right.inertia:.0f} kg m2 it fluctuates by "
        f"{100 * right.coefficient:.2f} %"
    )


def simulate_sleeve_forces() -> str:
    """Return how much the sleeve force of both governors changes over the stroke, by the band of speed of a resistance."""
    used, right = (_spread_of_sleeve_force(name) for name in ("hartung_dubois", "hartung_corrected"))
    return (
        f"the static sleeve force changes by {100 * used:.2f} % over the stroke with 132 deg and the spring of the paper, by "
        f"{100 * right:.2f} % with 137.332 deg"
    )


def _spread_of_sleeve_force(name: str) -> float:
    """Return the range of the static sleeve force S over its mean; S = 2 W w^2 / (w'^2 - w''^2) with the resistance W."""
    scene = load_scene(name)
    lever_angles = np.linspace(-PAPER_INPUTS.swing, PAPER_INPUTS.swing, N_STROKE_POINTS)
    band = compute_insensitivity_band(scene, lever_angles, PROBE_RESISTANCE)
    rising, falling = band.rising_speed**2, band.falling_speed**2
    force = PROBE_RESISTANCE * (rising + falling) / (rising - falling)
    return float(np.ptp(force) / np.mean(force))


def simulate_osculating_circle() -> str:
    """Return the speeds of rest beside the point of osculation, with an arm as long as the radius of curvature."""
    return _describe_speeds(1.0)


def simulate_longer_arm() -> str:
    """Return the speeds of rest beside the point of osculation, with a longer arm."""
    return _describe_speeds(LONGER)


def simulate_shorter_arm() -> str:
    """Return the speeds of rest beside the point of osculation, with a shorter arm."""
    return _describe_speeds(SHORTER)


def _describe_speeds(arm_ratio: float) -> str:
    down, start, up = simulated_speeds(design_pendulum(), arm_ratio, np.array([-PROBE_ANGLE_DEG, 0.0, PROBE_ANGLE_DEG])) / RPM
    return (
        f"with l = {arm_ratio:g} rho the speed of rest is {down:.3f} rpm {PROBE_ANGLE_DEG:g} deg below the point of osculation, "
        f"{start:.3f} rpm at it, and {up:.3f} rpm {PROBE_ANGLE_DEG:g} deg above it"
    )


def simulated_speeds(
    design: PendulumDesign,
    arm_ratio: float,  # arm over the radius of curvature; point and slope stay
    degrees: FloatArray,  # angles through which the arm has turned up, deg; shape (n,)
) -> FloatArray:
    """Return the speeds of rest (n,) by the statics of the simulated governor beside the point of osculation."""
    start = design.start
    arm = arm_ratio * start.radius_of_curvature
    governor = design.governor
    document = {
        "title": "Governor beside the point of osculation",
        "machine": "pendulum_governor",
        "dimensions": {
            "arm": arm,
            "offset": start.abscissa - arm * math.sin(start.arm_angle),
            "ball_mass": governor.ball_mass,
            "sleeve_mass": governor.sleeve_mass,
        },
        "effects": {"gravity": f"{governor.gravity:.15g} m/s^2", "centrifugal": True},
        "spindle": {"speed": design.requirement.lowest_speed},
        "start": {"arm_angle": start.arm_angle},
        "run": {"duration": 1.0, "output_interval": 0.1, "accuracy": 1e-6},
    }
    angles = start.arm_angle + np.radians(degrees)
    return np.asarray(compute_controlling_force(parse_scene_document(document), angles).speed)


def simulate_valve() -> str:
    """Return the delays of release and compression at both ends of the cylinder, by the simulated valve gear."""
    shifts = {row.name: math.degrees(row.shift) for row in tabulate_valve_timing(load_scene("slide_valve_marks")).rows}
    return "; ".join(
        f"{end}: release {shifts[f'{end} release']:+.2f} deg, compression {shifts[f'{end} compression']:+.2f} deg"
        for end in ("crank end", "head end")
    )


SIMULATIONS: Mapping[tuple[Paper, str], Callable[[], str]] = {
    (Paper.REDTENBACHER, "flywheel"): simulate_flywheels,
    (Paper.DUBOIS, "bell-crank-angle"): simulate_sleeve_forces,
    (Paper.ZEHNDER, "osculating-circle"): simulate_osculating_circle,
    (Paper.ZEHNDER, "longer-arm"): simulate_longer_arm,
    (Paper.ZEHNDER, "shorter-arm"): simulate_shorter_arm,
    (Paper.MARKS, "cylinder-ends"): simulate_valve,
}
"""Functions that return a sentence, by paper and name of the erratum."""
