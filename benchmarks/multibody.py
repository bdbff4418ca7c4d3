"""Cost of the multibody engine: against one coordinate, against scipy, for long chains, and of compilation.

Usage: python benchmarks/multibody.py
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.integrators.tableau import ERROR_3, ERROR_5, STAGES
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))
from chain_mechanisms import hanging_chain

END = 10.0


compiled: Any = njit
"""Decorator without types: numba states what it returns in types that have no use here."""


def main() -> None:
    """Print the tables."""
    compare_with_one_coordinate()
    compare_with_scipy()
    print_chain_costs()


def compare_with_one_coordinate() -> None:
    """Compare ten seconds of the Porter governor at 1e-8, as a multibody system and as its one-coordinate equation."""
    scene = gm.load("porter")
    scene = scene.with_changes(start=replace(scene.start, rates={"arm_angle": 0.15}))
    true = integrate_one_coordinate(1e-14)
    target = 1e-8
    hand = next(t for t in 10.0 ** -np.arange(5.0, 14.0, 0.25) if abs(integrate_one_coordinate(t)[0] - true[0]) < target)
    engines = (MultibodyEngine(tolerance=t) for t in 10.0 ** -np.arange(5.0, 14.0, 0.25))
    engine = next(e for e in engines if abs(final_arm_angle(e, scene) - true[0]) < target)
    seconds = shortest_time(lambda: integrate_one_coordinate(hand))
    whole = shortest_time(lambda: gm.run(scene, "multibody", accuracy=target, times=[END]))
    single = engine.run(scene, times=np.array([END]), certify=False)
    single_seconds = shortest_time(lambda: engine.run(scene, times=np.array([END]), certify=False))
    print("| Porter governor, 10 s, true error 1e-8 | ms | ratio |\n|---|---|---|")
    print(f"| one-coordinate equation, compiled by hand | {seconds * 1e3:.3f} | 1 |")
    stepped = min(run_cost(engine, scene, END) for _ in range(20))
    print(f"| multibody, integration only | {stepped * 1e3:.2f} | {stepped / seconds:.0f} (target 25) |")
    print(f"| the same run, with start, readings and energies | {single_seconds * 1e3:.1f} | |")
    print(f"| accuracy 1e-8, certified, whole run | {whole * 1e3:.1f} | {whole / seconds:.0f} |")
    evaluations = single.cost.evaluations["equations of motion"]
    print(f"\n{stepped / evaluations * 1e6:.2f} µs an evaluation of the equations of motion.\n")


def final_arm_angle(engine: MultibodyEngine, scene: Scene) -> float:
    """Return the arm angle at the end of one run."""
    return float(engine.run(scene, times=np.array([END]), certify=False).readings["arm_angle"][-1])


def run_cost(engine: MultibodyEngine, scene: Scene, end: float) -> float:
    """Return the time (s) of the integration alone, up to `end` (s)."""
    from governor_mechanism.engines.base import RunRequest
    from governor_mechanism.engines.certificate import StepPlan
    from governor_mechanism.engines.multibody.engine import MultibodyRunner

    task = RunRequest(times=np.array([end]), accuracy=1e-8, certify=False, reason="")
    follower = MultibodyRunner(engine, scene, task)
    started = time.perf_counter()
    follower.integrator.integrate(engine.tolerance or 1e-10, StepPlan(max_steps=follower.max_steps))
    return time.perf_counter() - started


def shortest_time(work: Callable[[], Any], repeats: int = 7) -> float:
    """Return the shortest time (s) of several runs after a warm-up run."""
    work()
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return min(times)


@compiled
def acceleration(angle: float, rate: float) -> float:
    """Return the acceleration of the scene `porter` from I a'' + I' a'^2 / 2 + V' - J' w^2 / 2 = 0."""
    arm, offset, ball, sleeve, g, w = 0.3, 0.04, 5.0, 20.0, 9.81, 4 * math.pi
    s, c = math.sin(angle), math.cos(angle)
    inertia = 2 * ball * arm**2 + 4 * sleeve * arm**2 * s * s
    growth = 8 * sleeve * arm**2 * s * c
    pull = 2 * arm * g * s * (ball + sleeve)
    out = 2 * ball * (offset + arm * s) * arm * c * w * w
    return (out - pull - 0.5 * growth * rate * rate) / inertia


@compiled
def integrate_one_coordinate(tolerance: float) -> tuple[float, float]:
    """Return angle and rate at the end, by DOP853 with error control."""
    y, t, h = np.array([math.radians(40.0), 0.15]), 0.0, 0.01
    k, trial = np.zeros((13, 2)), np.empty(2)
    k[0, 0], k[0, 1] = y[1], acceleration(y[0], y[1])
    while t < END:
        h = min(h, END - t)
        for stage in range(1, 13):
            for i in range(2):
                total = 0.0
                for m in range(stage):
                    total += STAGES[stage, m] * k[m, i]
                trial[i] = y[i] + h * total
            k[stage, 0], k[stage, 1] = trial[1], acceleration(trial[0], trial[1])
        fifth = third = 0.0
        for i in range(2):
            five = three = 0.0
            for m in range(13):
                five += ERROR_5[m] * k[m, i]
                three += ERROR_3[m] * k[m, i]
            fifth += five * five
            third += three * three
        error = 1e-30 + h * fifth / (math.sqrt((fifth + 0.01 * third) * 2) + 1e-300) / tolerance
        if error <= 1.0:
            t += h
            y[:] = trial
            k[0] = k[12]
        h *= min(6.0, max(0.2, 0.9 * error**-0.125))
    return y[0], y[1]


def compare_with_scipy() -> None:
    """Compare Andrews' squeezing mechanism at 1e-9: this engine, and scipy's DOP853 with a right-hand side in numpy."""
    scene = gm.load("andrews_squeezer")
    slope, start = make_numpy_right_hand_side(scene)

    def integrate_with_scipy(tolerance: float) -> FloatArray:
        """Integrate with scipy."""
        found = solve_ivp(slope, (0.0, 0.03), start, method="DOP853", rtol=tolerance, atol=tolerance)
        angles: FloatArray = found.y[:21, -1].reshape(7, 3)[:, 2]
        return angles

    true = gm.run(scene, "multibody", accuracy=1e-11, times=[0.03]).poses[-1, :, 2]
    tolerance = next(t for t in 10.0 ** -np.arange(7.0, 14.0) if np.max(np.abs(integrate_with_scipy(t) - true)) < 1e-9 * 15.8)
    theirs = shortest_time(lambda: integrate_with_scipy(tolerance), 2)
    engines = (MultibodyEngine(tolerance=t) for t in 10.0 ** -np.arange(6.0, 14.0, 0.5))
    times = np.array([0.03])
    engine = next(e for e in engines if np.max(np.abs(e.run(scene, times=times, certify=False).poses[-1, :, 2] - true)) < 1e-9 * 15.8)
    ours = shortest_time(lambda: engine.run(scene, times=times, certify=False))
    certified = shortest_time(lambda: gm.run(scene, "multibody", accuracy=1e-9, times=[0.03]))
    print("| Andrews' squeezing mechanism, 0.03 s, 1e-9 | ms | times faster |\n|---|---|---|")
    print(f"| scipy DOP853, right-hand side in numpy | {theirs * 1e3:.0f} | 1 |")
    stepped = min(run_cost(engine, scene, 0.03) for _ in range(20))
    print(f"| engine multibody, integration only | {stepped * 1e3:.1f} | {theirs / stepped:.0f} (target 20) |")
    print(f"| engine multibody, one run | {ours * 1e3:.1f} | {theirs / ours:.0f} |")
    print(f"| engine multibody, certified | {certified * 1e3:.1f} | {theirs / certified:.0f} |\n")


def make_numpy_right_hand_side(scene: Scene) -> tuple[Callable[[float, FloatArray], FloatArray], FloatArray]:
    """Return the state derivative of seven bodies and ten pins with Lagrange multipliers, written directly in numpy."""
    mechanism = scene.part.mechanism
    run = MultibodyEngine().run(scene, times=np.array([0.0, 1e-6]))
    mass = np.array([[b.mass, b.mass, b.second_moments.xx + b.second_moments.yy] for b in mechanism.bodies]).ravel()
    ends = [(mechanism.body_index(p.body), p.x, p.y) for j in mechanism.joints for p in (j.first, j.second)]
    body, x, y = (np.array(column) for column in zip(*ends, strict=True))
    rows = np.arange(len(ends)) // 2
    sign = np.where(np.arange(len(ends)) % 2 == 0, -1.0, 1.0)
    held = body >= 0
    spring: Any
    torque: Any
    spring, torque = mechanism.force_elements
    if not hasattr(spring, "stiffness"):
        spring, torque = torque, spring
    hook, fixed = (spring.second, spring.first) if spring.first.body == GROUND else (spring.first, spring.second)
    triangle, crank = mechanism.body_index(hook.body), mechanism.body_index(torque.second)

    def slope(_: float, state: FloatArray) -> FloatArray:
        """Return the state derivative."""
        q, v = state[:21].reshape(7, 3), state[21:].reshape(7, 3)
        c, s = np.cos(q[body, 2]), np.sin(q[body, 2])
        arm_x, arm_y = c * x - s * y, s * x + c * y
        jacobian, right = np.zeros((20, 21)), np.zeros(20)
        k = np.flatnonzero(held)
        jacobian[2 * rows[k], 3 * body[k]] += sign[k]
        jacobian[2 * rows[k] + 1, 3 * body[k] + 1] += sign[k]
        jacobian[2 * rows[k], 3 * body[k] + 2] -= sign[k] * arm_y[k]
        jacobian[2 * rows[k] + 1, 3 * body[k] + 2] += sign[k] * arm_x[k]
        turning = v[body[k], 2] ** 2
        np.add.at(right, 2 * rows[k], sign[k] * turning * arm_x[k])
        np.add.at(right, 2 * rows[k] + 1, sign[k] * turning * arm_y[k])
        load = np.zeros((7, 3))
        c, s = math.cos(q[triangle, 2]), math.sin(q[triangle, 2])
        arm = np.array([c * hook.x - s * hook.y, s * hook.x + c * hook.y])
        line = np.array([fixed.x, fixed.y]) - q[triangle, :2] - arm
        length = math.hypot(*line)
        pull = spring.stiffness * (length - spring.free_length) * line / length
        load[triangle] = pull[0], pull[1], arm[0] * pull[1] - arm[1] * pull[0]
        load[crank, 2] += torque.moment.values[0]
        system = np.block([[np.diag(mass), jacobian.T], [jacobian, np.zeros((20, 20))]])
        return np.concatenate([v.ravel(), np.linalg.solve(system, np.concatenate([load.ravel(), right]))[:21]])

    return slope, np.concatenate([run.poses[0].ravel(), run.velocities[0].ravel()])


def print_chain_costs() -> None:
    """Print the cost of an evaluation per rod, for hanging chains of increasing length."""
    print("| rods in a chain | µs an evaluation | µs a rod |\n|---|---|---|")
    for count in (5, 20, 80):
        run = MultibodyEngine(tolerance=1e-6).run(hanging_chain(count, 0.2, 0.1), certify=False)
        evaluations = run.cost.evaluations["equations of motion"]
        each = run.cost.wall_time / evaluations * 1e6
        print(f"| {count} | {each:.1f} | {each / count:.2f} |")
    print()


if __name__ == "__main__":
    main()
