"""What the full kinematics of a valve gear costs: positions, rates and accelerations of all readings at 3,600 crank angles.

Usage: python benchmarks/kinematics.py
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from scipy.optimize import fsolve

import governor_mechanism as gm
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.types import FloatArray

MODELS = ("slide_valve_30", "stephenson_arc_middle", "gooch", "joy")
N_ANGLES, N_REPEATS = 3600, 15
R, ROD, ADVANCE, RADIUS, HALF_LINK, HANGER = 0.06, 1.2, math.radians(30), 1.2, 0.15, 0.5
"""Dimensions of stephenson_arc_middle, m and rad."""


def best_time(calculate: Callable[[], object], repeats: int = N_REPEATS) -> float:
    """Return the shortest time of several calls, ms."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        calculate()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def solve_link_by_fsolve(angles: FloatArray) -> None:
    """Solve for the position of Stephenson's link in full forward gear at each angle (rad) by scipy's fsolve: positions alone."""
    pin = math.sqrt(RADIUS**2 - HALF_LINK**2) - RADIUS
    top = 1.2, HANGER - RADIUS * math.asin(HALF_LINK / RADIUS)
    position = np.array([1.2, -0.15, 0.0])

    def errors(position: FloatArray, angle: float) -> list[float]:
        x, y, turn = position
        cosine, sine = math.cos(turn), math.sin(turn)
        forward = R * math.sin(angle + ADVANCE), R * math.cos(angle + ADVANCE)
        backward = -R * math.sin(angle - ADVANCE), -R * math.cos(angle - ADVANCE)
        rods = ((pin, HALF_LINK, forward, ROD), (pin, -HALF_LINK, backward, ROD), (0.0, 0.0, top, HANGER))
        return [math.hypot(x + cosine * a - sine * b - end[0], y + sine * a + cosine * b - end[1]) - length for a, b, end, length in rods]

    for angle in angles.tolist():
        position = fsolve(errors, position, args=(angle,))


def main() -> None:
    """Print the times and the ratio to fsolve."""
    angles = np.linspace(0.0, math.tau, N_ANGLES)
    fsolve_time = best_time(lambda: solve_link_by_fsolve(angles), 3)
    print(f"| {N_ANGLES} crank angles, warm | gm.kinematics, ms | turn of the valve, ms | fsolve / gm.kinematics |\n|---|---|---|---|")
    for name in MODELS:
        scene = gm.load(name)
        motion = valve_motion_of(scene)
        studies = (lambda s=scene: gm.kinematics(s, "crank_angle", angles), lambda m=motion: m.evaluate(angles))
        whole, turn = (best_time(study) for study in studies)
        ratio = f"{fsolve_time / whole:.0f}" if name.startswith("stephenson") else ""
        print(f"| {name} | {whole:.1f} | {turn:.1f} | {ratio} |", flush=True)
    print(f"\n`fsolve`, positions of Stephenson's link alone, one angle after the other: {fsolve_time:.0f} ms.")


if __name__ == "__main__":
    main()
