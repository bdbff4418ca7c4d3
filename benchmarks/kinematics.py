"""What the full kinematics of a valve gear and of a ten-bar linkage costs: positions, rates and accelerations of all readings.

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


N_TEN_BAR_ANGLES, N_DYADS = 360, 4
PIVOT_DISTANCE, CRANK, TEN_BAR_ROD, ROCKER = 0.4, 0.1, 0.38, 0.3
"""Dimensions of the ten-bar, m: each rocker drives the next one by a rod."""


def make_ten_bar() -> gm.Scene:
    """Return a crank that drives four rockers, one behind the other: ten links with the ground, thirteen pins."""
    bodies = [{"name": "crank", "mass": 1.0, "rod": {"length": CRANK}, "angle": "60 deg"}]
    joints = [{"type": "pin", "first": "ground.O", "second": "crank.start"}]
    ground, end, driver = {"O": [0.0, 0.0]}, CRANK * np.exp(1j * math.pi / 3), "crank"
    for number in range(1, N_DYADS + 1):
        pivot = number * PIVOT_DISTANCE
        line = pivot - end
        along = (abs(line) ** 2 + TEN_BAR_ROD**2 - ROCKER**2) / (2 * abs(line))
        knee = end + line / abs(line) * (along + 1j * math.sqrt(TEN_BAR_ROD**2 - along**2))
        rod, rocker = f"rod {number}", f"rocker {number}"
        for name, length, at in ((rod, TEN_BAR_ROD, end), (rocker, ROCKER, complex(pivot))):
            angle = float(np.angle(knee - at))
            bodies.append({"name": name, "mass": 1.0, "rod": {"length": length}, "at": [at.real, at.imag], "angle": angle})
        pins = ((f"{driver}.end", f"{rod}.start"), (f"{rod}.end", f"{rocker}.end"), (f"ground.P{number}", f"{rocker}.start"))
        joints += [{"type": "pin", "first": first, "second": second} for first, second in pins]
        ground[f"P{number}"] = [pivot, 0.0]
        end, driver = knee, rocker
    joints.append({"type": "driven_turn", "first": "ground", "second": "crank", "rate": 1.0})
    readings = {"crank_angle": {"angle": "crank"}, "last_angle": {"angle": driver}}
    tables = {"ground": ground, "body": bodies, "joint": joints, "readings": readings}
    return gm.Scene.from_dict({"title": "Ten-bar linkage", "machine": "custom", **tables})


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
    ten_bar, turn = make_ten_bar(), np.linspace(0.0, math.tau, N_TEN_BAR_ANGLES)
    time_of_turn = best_time(lambda: gm.kinematics(ten_bar, "crank_angle", turn), 10 * N_REPEATS)
    print(f"\nA ten-bar linkage at {N_TEN_BAR_ANGLES} crank angles: {time_of_turn:.1f} ms (target 10 ms for the positions).")


if __name__ == "__main__":
    main()
