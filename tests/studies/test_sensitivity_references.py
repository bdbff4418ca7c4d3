"""Derivatives of twenty motions against variational equations in extended precision.

Each motion is integrated with equations of its own in complex numbers of extended precision; a tiny imaginary part of a key carries the
variational equations along exactly, through events too. Nothing of the package but the runs themselves takes part.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as tableau

import governor_mechanism as gm

TINY = np.longdouble("1e-200")
"""Imaginary part of the key by which a motion is differentiated: its square is nothing beside 1."""

GRAVITY = 9.81
N_STEPS = 400


class Case(NamedTuple):
    """A scene, the readings that are differentiated, the keys with their values, and the readings as a function of these."""

    scene: gm.Scene
    readings: tuple[str, ...]
    keys: dict[str, float]
    reference: Callable


def integrate(rates, start, duration, n_steps=N_STEPS):
    """Return the state after a time, by the method of order 8 with fixed steps; each column belongs to a key."""
    state = np.array(start, dtype=np.clongdouble)
    h = np.longdouble(duration) / n_steps
    a = tableau.A[: tableau.N_STAGES, : tableau.N_STAGES].astype(np.longdouble)
    b = tableau.B.astype(np.longdouble)
    for _ in range(n_steps):
        stages = []
        for row in a:
            stages.append(rates(state + h * sum((row[j] * one for j, one in enumerate(stages)), 0 * state)))
        state = state + h * sum(weight * one for weight, one in zip(b, stages, strict=True))
    return state


def differentiate(case: Case):
    """Return the derivatives of the readings by the keys; shape (readings, keys)."""
    n_keys = len(case.keys)
    values = {}
    for k, (key, value) in enumerate(case.keys.items()):
        values[key] = np.full(n_keys, np.longdouble(value), dtype=np.clongdouble)
        values[key][k] += 1j * TINY
    return np.array([np.imag(one) / TINY for one in case.reference(values)], dtype=np.float64)


def governor(*, duration=1.0, damping=0.0, inertia=None, speed=12.0, **dimensions):
    """A pendulum governor of point masses, whose sleeve hangs on links as long as the arms."""
    values = {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0} | dimensions
    effects = {"gravity": True, "centrifugal": True} | ({"dashpot": {"sleeve": damping}} if damping else {})
    spindle = {"inertia": inertia, "start_speed": speed} if inertia else {"speed": speed}
    document = {
        "machine": "pendulum_governor",
        "dimensions": values,
        "effects": effects,
        "spindle": spindle,
        "start": {"arm_angle": 0.65, "arm_rate": 0.2},
        "run": {"duration": duration, "output_interval": 0.1},
    }
    speed_key = "spindle.start_speed" if inertia else "spindle.speed"
    keys = {f"dimensions.{name}": value for name, value in values.items()}
    keys |= {speed_key: speed, "start.arm_angle": 0.65, "start.arm_rate": 0.2}
    keys |= {"effects.dashpot.sleeve": damping} if damping else {}
    keys |= {"spindle.inertia": inertia} if inertia else {}

    def reference(given):
        arm, offset, ball = (given[f"dimensions.{name}"] for name in ("arm", "offset", "ball_mass"))
        load, start_speed = given["dimensions.sleeve_mass"], given[speed_key]
        radius = offset + arm * np.sin(given["start.arm_angle"])
        momentum = (given["spindle.inertia"] + 2 * ball * radius**2) * start_speed if inertia else None

        def rates(state):
            angle, rate = state
            sine, cosine = np.sin(angle), np.cos(angle)
            out = offset + arm * sine
            speed = momentum / (given["spindle.inertia"] + 2 * ball * out**2) if inertia else start_speed
            mass = 2 * ball * arm**2 + 4 * load * arm**2 * sine**2
            sleeve_rate = 2 * arm * sine * rate
            force = 2 * ball * speed**2 * out * arm * cosine - 2 * (ball + load) * GRAVITY * arm * sine
            force = force - 4 * load * arm**2 * sine * cosine * rate**2
            force = force - given.get("effects.dashpot.sleeve", 0.0) * sleeve_rate * 2 * arm * sine
            return np.array([rate, force / mass])

        return integrate(rates, [given["start.arm_angle"], given["start.arm_rate"]], duration)

    return Case(gm.Scene.from_dict(document), ("arm_angle", "rate of arm_angle"), keys, reference)


def rods(lengths, *, duration=1.0):
    """A pendulum, or a double pendulum, of uniform rods."""
    names = ["first", "second"][: len(lengths)]
    masses, angles = (2.0, 1.5), (-0.9, -0.5)
    corner = np.array([0.0, 0.0])
    bodies, joints = [], []
    for k, (name, length) in enumerate(zip(names, lengths, strict=True)):
        before = "ground.O" if k == 0 else "first.end"
        bodies.append({"name": name, "mass": masses[k], "rod": {"length": length}, "at": corner.tolist(), "angle": angles[k]})
        joints.append({"type": "pin", "first": before, "second": f"{name}.start"})
        corner = corner + length * np.array([math.cos(angles[k]), math.sin(angles[k])])
    document = {
        "machine": "custom",
        "ground": {"O": [0, 0]},
        "body": bodies,
        "joint": joints,
        "effects": {"gravity": True},
        "readings": {name: {"angle": name} for name in names},
        "start": dict(zip(names, angles, strict=False)),
        "run": {"duration": duration, "output_interval": 0.1},
    }
    keys = {f"body.{name}.mass": masses[k] for k, name in enumerate(names)}
    keys |= {f"body.{name}.rod.length": length for name, length in zip(names, lengths, strict=True)}
    keys |= {f"start.{name}": angles[k] for k, name in enumerate(names)}

    def single(given):
        length, start = given["body.first.rod.length"], given["start.first"]

        def rates(state):
            return np.array([state[1], -1.5 * GRAVITY / length * np.cos(state[0])])

        return integrate(rates, [start, 0 * start], duration)[:1]

    def double(given):
        m1, m2 = (given[f"body.{name}.mass"] for name in names)
        l1, l2 = (given[f"body.{name}.rod.length"] for name in names)

        def rates(state):
            a1, a2, w1, w2 = state
            j11, j22, coupling = (m1 / 3 + m2) * l1**2, m2 * l2**2 / 3, m2 * l1 * l2 / 2
            j12, swirl = coupling * np.cos(a1 - a2), coupling * np.sin(a1 - a2)
            f1 = -swirl * w2**2 - (m1 / 2 + m2) * GRAVITY * l1 * np.cos(a1)
            f2 = swirl * w1**2 - m2 / 2 * GRAVITY * l2 * np.cos(a2)
            determinant = j11 * j22 - j12**2
            return np.array([w1, w2, (j22 * f1 - j12 * f2) / determinant, (j11 * f2 - j12 * f1) / determinant])

        starts = [given[f"start.{name}"] for name in names]
        return integrate(rates, [*starts, 0 * starts[0], 0 * starts[0]], duration)[:2]

    return Case(gm.Scene.from_dict(document), tuple(names), keys, single if len(lengths) == 1 else double)


def oscillator(*, duration=2.0, mass=2.0, damping=3.0, stiffness=50.0, start=0.5, stop=None, restitution=0.6):
    """A block on a slide with spring and damper, and a stop in its way or none; its motion between impacts is known in closed form."""
    rest, ends = 0.4, {"first": "ground.A", "second": "block.centre"}
    document = {
        "machine": "custom",
        "ground": {"A": [0, 0]},
        "body": [{"name": "block", "mass": mass, "turns": False, "at": [rest, 0]}],
        "joint": [{"name": "slide", "type": "slider", **ends, "angle": 0.0}],
        "force": [
            {"name": "spring", "type": "spring", **ends, "stiffness": stiffness, "free_length": rest},
            {"name": "damper", "type": "damper", **ends, "damping": damping},
        ],
        "readings": {"x": {"x": "block.centre"}},
        "start": {"x": start},
        "run": {"duration": duration, "output_interval": 0.1},
    }
    keys = {"body.block.mass": mass, "force.damper.damping": damping, "force.spring.stiffness": stiffness, "start.x": start}
    if stop is not None:
        document["effects"] = {"stops": {"x": [stop, 2.0], "restitution": restitution}}
        keys |= {"effects.stops.x.1": stop, "effects.stops.restitution": restitution}

    def reference(given):
        m, c, k = (given[key] for key in ("body.block.mass", "force.damper.damping", "force.spring.stiffness"))
        decay = c / (2 * m)
        frequency = np.sqrt(k / m - decay**2)

        def flow(place, rate, time):
            sine, cosine, envelope = np.sin(frequency * time), np.cos(frequency * time), np.exp(-decay * time)
            spread = place - rest
            end = envelope * (spread * cosine + (rate + decay * spread) / frequency * sine)
            slope = envelope * (rate * cosine - (k / m * spread + decay * rate) / frequency * sine)
            return rest + end, slope

        place, rate = given["start.x"], 0 * given["start.x"]
        remaining = np.longdouble(duration) + 0 * place
        while stop is not None:
            times = np.linspace(1e-6, float(np.real(remaining[0])), 2001)
            places = np.array([float(np.real(flow(place, rate, one)[0][0])) for one in times])
            below = np.flatnonzero(places < stop)
            if not len(below):
                break
            time = times[below[0]] + 0 * place
            for _ in range(60):  # Newton's method, whose last steps carry the derivatives
                reached, slope = flow(place, rate, time)
                time = time - (reached - given["effects.stops.x.1"]) / slope
            place, rate = flow(place, rate, time)
            rate = -given["effects.stops.restitution"] * rate
            remaining = remaining - time
        return [flow(place, rate, remaining)[0]]

    return Case(gm.Scene.from_dict(document), ("x",), keys, reference)


def driven_crank(*, offset=0.0, duration=0.7):
    """A slider crank that a motor turns: the crosshead is where a circle about the crank pin meets its line."""
    crank, rod, speed = 0.1, 0.35, 5.0
    document = {
        "machine": "custom",
        "ground": {"O": [0, 0], "line": [0, offset]},
        "body": [
            {"name": "crank", "mass": 1.0, "rod": {"length": crank}, "at": [0, 0], "angle": 0.0},
            {"name": "rod", "mass": 1.0, "rod": {"length": rod}, "at": [crank, 0], "angle": 0.0},
            {"name": "crosshead", "mass": 1.0, "turns": False, "at": [crank + rod, offset]},
        ],
        "joint": [
            {"type": "pin", "first": "ground.O", "second": "crank.start"},
            {"type": "pin", "first": "crank.end", "second": "rod.start"},
            {"type": "pin", "first": "rod.end", "second": "crosshead.centre"},
            {"type": "slider", "first": "ground.line", "second": "crosshead.centre", "angle": 0.0},
            {"type": "driven_turn", "name": "motor", "first": "ground", "second": "crank", "rate": speed},
        ],
        "readings": {"x": {"x": "crosshead.centre"}},
        "run": {"duration": duration, "output_interval": 0.1},
    }
    keys = {"body.crank.rod.length": crank, "body.rod.rod.length": rod, "joint.motor.rate": speed}

    def reference(given):
        r, length, angle = given["body.crank.rod.length"], given["body.rod.rod.length"], given["joint.motor.rate"] * duration
        return [r * np.cos(angle) + np.sqrt(length**2 - (r * np.sin(angle) - offset) ** 2)]

    return Case(gm.Scene.from_dict(document), ("x",), keys, reference)


CASES = {
    "Porter": lambda: governor(),
    "Porter with a dashpot": lambda: governor(damping=40.0),
    "crossed arms": lambda: governor(offset=-0.03, speed=14.0, duration=0.3),
    "light sleeve": lambda: governor(sleeve_mass=3.0, speed=7.0),
    "heavy balls": lambda: governor(ball_mass=12.0, arm=0.25),
    "free spindle": lambda: governor(inertia=0.5),
    "free spindle, damped": lambda: governor(inertia=1.2, damping=60.0),
    "pendulum": lambda: rods([0.8]),
    "long pendulum": lambda: rods([2.5], duration=2.0),
    "double pendulum": lambda: rods([0.8, 0.6]),
    "double pendulum of unlike rods": lambda: rods([0.4, 1.1], duration=0.8),
    "oscillator": lambda: oscillator(),
    "fast oscillator": lambda: oscillator(mass=0.2, damping=0.4, duration=1.3),
    "damped oscillator": lambda: oscillator(damping=15.0),
    "one impact": lambda: oscillator(stop=0.35, duration=0.6),
    "three impacts": lambda: oscillator(stop=0.36, damping=0.5, duration=1.9),
    "hard impacts": lambda: oscillator(stop=0.38, restitution=0.9, damping=0.5, duration=1.5),
    "impact of a fast block": lambda: oscillator(mass=0.2, damping=0.4, stop=0.33, duration=0.35),
    "slider crank": lambda: driven_crank(),
    "offset slider crank": lambda: driven_crank(offset=0.05, duration=0.9),
}
EVERY_DAY = ("Porter with a dashpot", "double pendulum", "three impacts")


def errors_of(name):
    """Return the differences from the reference and the stated errors, each relative to the derivative or 1, row by row."""
    case = CASES[name]()
    found, exact = gm.sensitivities(case.scene, list(case.readings), list(case.keys)), differentiate(case)
    assert found.ok, (name, [row.refusal for row in found.rows if row.refusal])
    errors = []
    for i, reading in enumerate(case.readings):
        for k, key in enumerate(case.keys):
            row, scale = found.at(reading, key), max(1.0, abs(exact[i, k]))
            errors.append((abs(row.value - exact[i, k]) / scale, row.error / scale))
    return np.array(errors)


@pytest.mark.parametrize("name", EVERY_DAY)
def test_derivatives_are_those_of_the_variational_equations(name):
    differences, stated = errors_of(name).T
    assert np.all(differences <= 1e-7)
    assert np.all(differences <= stated)


@pytest.mark.long
def test_derivatives_of_twenty_motions_are_within_their_errors_in_99_of_100():
    differences, stated = np.concatenate([errors_of(name) for name in CASES]).T
    assert len(CASES) == 20
    assert np.all(differences <= 1e-7)
    assert np.mean(differences <= stated) >= 0.99
