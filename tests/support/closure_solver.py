"""Poses of a custom mechanism by root finding on the equations of its scene file: it shares no code with the package."""

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import root

LENGTHS, ANGLES = {"m": 1.0, "mm": 1e-3}, {"rad": 1.0, "deg": math.pi / 180}


def si(value: float | str) -> float:
    """A number, or text with a unit, in SI."""
    if not isinstance(value, str):
        return float(value)
    number, unit = value.split()
    return float(number) * (LENGTHS | ANGLES)[unit]


class ClosureEquations:
    """Joints and links of a scene file with pins, straight and circular slots and drivers; body axes as in the file."""

    def __init__(self, path: Path) -> None:
        self.document: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        self.bodies = {body["name"]: body for body in self.document["body"]}
        self.unknowns = [(name, k) for name, body in self.bodies.items() for k in range(3) if k < 2 or body.get("turns", True)]

    def guess(self) -> np.ndarray:
        starts = {name: [*map(si, body.get("at", (0, 0))), si(body.get("angle", 0))] for name, body in self.bodies.items()}
        return np.array([starts[name][k] for name, k in self.unknowns])

    def poses(self, values: np.ndarray) -> dict[str, list[float]]:
        found = {"ground": [0.0, 0.0, 0.0]} | {name: [0.0, 0.0, 0.0] for name in self.bodies}
        for (name, k), value in zip(self.unknowns, values, strict=True):
            found[name][k] = value
        return found

    def place(self, poses: dict[str, list[float]], point: str) -> complex:
        """The position of "body.point" in the plane."""
        name, _, own = point.partition(".")
        body = self.document if name == "ground" else self.bodies[name]
        points = body["ground"] if name == "ground" else body.get("points", {}) | {"origin": (0, 0), "centre": (0, 0), "start": (0, 0)}
        if "rod" in body:
            points = points | {"end": (body["rod"]["length"], 0)}
        x, y, angle = poses[name]
        return complex(x, y) + complex(*map(si, points[own])) * np.exp(1j * angle)

    def residuals(self, values: np.ndarray, driven: dict[str, float]) -> list[float]:
        """What every joint misses; `driven` are the angles (rad) of the drivers."""
        poses, missed = self.poses(values), []
        for joint in self.document["joint"]:
            if joint["type"] == "driven_turn":
                missed.append(poses[joint["second"]][2] - driven[joint["name"]])
                continue
            gap = self.place(poses, joint["second"]) - self.place(poses, joint["first"])
            if joint["type"] == "pin":
                missed += [gap.real, gap.imag]
            elif joint["type"] == "arc":
                missed.append(abs(gap) - si(joint["radius"]))
            else:
                turn = poses[joint["first"].partition(".")[0]][2] + si(joint["angle"])
                missed.append((gap * np.exp(-1j * turn)).imag)
        ends = ((self.place(poses, link["second"]) - self.place(poses, link["first"]), link) for link in self.document["link"])
        return missed + [abs(gap) - si(link["length"]) for gap, link in ends]

    def turn(self, crank: str, angles: np.ndarray, driven: dict[str, float]) -> list[dict[str, list[float]]]:
        """The poses at ascending angles (rad) of a driver, each found from those before it."""
        values, found = self.guess(), []
        for angle in angles:
            solution = root(self.residuals, values, args=({**driven, crank: angle},), tol=1e-14)
            assert max(map(abs, self.residuals(solution.x, {**driven, crank: angle}))) < 1e-12
            values = solution.x
            found.append(self.poses(values))
        return found
