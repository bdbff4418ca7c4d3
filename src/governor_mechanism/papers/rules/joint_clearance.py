"""Zehnder's remark that clearance in the joints keeps small irregularities of the engine away from the sleeve."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.effects.clearance import CLEARANCE_READING
from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rules.engines import (
    INERTIA,
    CyclicEngine,
    build_cyclic_engine,
    dashpot_on_sleeve,
    find_coordinate_at,
    find_steady_engine,
    friction_on_sleeve,
    gear_to_speed,
)
from governor_mechanism.papers.rules.rule import RuleCheck, Verdict
from governor_mechanism.papers.rules.shaking import SHAKING_RATIO
from governor_mechanism.types import FloatArray

CLEARANCES = (0.0, 1e-3, 1e-2, 4e-2)
"""Clearances between links and sleeve, m."""

LIGHT_SLEEVE = {"part.governor.dimensions.sleeve_mass": 0.2, **dashpot_on_sleeve(100.0)}
"""A governor whose sleeve is so light (kg) that friction carries it, with a dashpot (N s/m) for it."""

LIGHT_SLEEVE_RATIO = 0.8
"""Insensitivity over fluctuation of speed of the light governor, about: it shakes without clearance, too."""

LIGHT_SLEEVE_FRICTION = 4.0
"""Friction on the light sleeve, N: twice its weight."""

N_TURNS, N_MEASURED_TURNS = 30, 10
"""Turns of a run, and last turns whose largest motion counts: impacts in the clearance are irregular."""

QUIET_RATIO = 0.5
"""Motion over that without clearance below which a clearance is a remedy."""

CHANGE_TOLERANCE = 0.03
"""Relative change of the motion that counts as none: what is left of the start after the turns of a run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceCheck(RuleCheck):
    """Motion of the sleeve in a turn against the clearance between links and sleeve, of two governors.

    Attributes
    ----------
    clearances
        Clearances, m; shape (n,), the first 0.
    amplitudes
        Largest motion of the sleeve in one of the last turns, m, by the name of the governor; shape (n,) each.
    """

    title: ClassVar[str] = "clearance against shaking"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = "Some clearance in the joints keeps the small irregularities of the engine away from the governor."

    clearances: FloatArray
    amplitudes: Mapping[str, FloatArray]

    def relative_motion(self, name: str) -> FloatArray:
        """Return the motion over that without clearance; shape (n,)."""
        amplitudes = self.amplitudes[name]
        return np.asarray(amplitudes / amplitudes[0])

    @property
    def verdict(self) -> Verdict:
        """Holds if each clearance quiets both governors; with a condition if some does; else it does not hold."""
        is_quiet = [self.relative_motion(name)[1:] < QUIET_RATIO for name in self.amplitudes]
        if np.all(is_quiet):
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if np.any(is_quiet) else Verdict.FAILS

    @property
    def finding(self) -> str:
        """What the clearances do to each governor."""
        return "; ".join(f"{name}: {self._describe(self.relative_motion(name))}" for name in self.amplitudes)

    def _describe(self, motion: FloatArray) -> str:
        if np.all(np.abs(motion[1:] - 1) < CHANGE_TOLERANCE):
            return f"changes nothing up to {1e3 * self.clearances[-1]:g} mm (within {CHANGE_TOLERANCE:.0%})"
        worst = int(np.argmax(motion))
        quiet = motion < QUIET_RATIO
        first_quiet = next((k for k in range(1, len(quiet)) if quiet[k:].all()), None)
        is_worse = motion[worst] > 1 + CHANGE_TOLERANCE
        worse = [f"{1e3 * self.clearances[worst]:g} mm multiplies the motion by {motion[worst]:.1f}"] if is_worse else []
        if first_quiet is None:
            return ", ".join([*worse, f"and none up to {1e3 * self.clearances[-1]:g} mm halves it"])
        return ", ".join([*worse, f"from {1e3 * self.clearances[first_quiet]:g} mm on it is {motion[first_quiet]:.2g} times as large"])

    def numbers(self) -> dict[str, Any]:
        """Return clearances and amplitudes."""
        amplitudes = [{"governor": name, "amplitudes": values.tolist()} for name, values in self.amplitudes.items()]
        return {"clearances": self.clearances.tolist(), "governors": amplitudes}


def check_clearance(
    engine: Scene,  # scene of a governed engine whose gas acts at every instant
    mean_engine: Scene,
    cyclic_engine: CyclicEngine,
) -> ClearanceCheck:
    """Run the governed engine with clearance between links and sleeve: under its Porter governor, and under one with a light sleeve."""
    light = _build_light_engine(engine, mean_engine, cyclic_engine)
    friction = cyclic_engine.find_friction(SHAKING_RATIO)
    return ClearanceCheck(
        clearances=np.array(CLEARANCES),
        amplitudes={
            # The loaded sleeve hangs on its links, the light one starts in the middle of its clearance.
            "loaded sleeve": np.array([_measure_motion(cyclic_engine, friction, width, -0.5 * width) for width in CLEARANCES]),
            "light sleeve": np.array([_measure_motion(light, LIGHT_SLEEVE_FRICTION, width, 0.0) for width in CLEARANCES]),
        },
    )


def _build_light_engine(engine: Scene, mean_engine: Scene, cyclic_engine: CyclicEngine) -> CyclicEngine:
    """Return the engine under the governor with a light sleeve, with a flywheel that makes it shake."""
    porter = cyclic_engine.point
    first = find_steady_engine(mean_engine, LIGHT_SLEEVE, sleeve_lift=porter.sleeve_lift)
    relative_friction = LIGHT_SLEEVE_FRICTION * first.relative_friction_of_newton
    insensitivity = math.sqrt(1 + relative_friction) - math.sqrt(1 - relative_friction)
    # The fluctuation of speed is inversely proportional to the moment of inertia, nearly.
    inertia = (
        float(porter.scene.part_of("engine")[0].dimensions["inertia"]) * cyclic_engine.fluctuation * LIGHT_SLEEVE_RATIO / insensitivity
    )
    values = {**LIGHT_SLEEVE, **gear_to_speed(first, porter.engine_speed), INERTIA: inertia}
    return build_cyclic_engine(engine, find_steady_engine(mean_engine, values, sleeve_lift=porter.sleeve_lift), values)


def _measure_motion(engine: CyclicEngine, friction: float, width: float, start: float) -> float:
    """Return the largest motion of the sleeve in one of the last turns, m, with a clearance, m, and its value at the start."""
    values = friction_on_sleeve(friction)
    if width:
        lift_of_links = engine.point.sleeve_lift - start
        start_values = {"arm_angle": find_coordinate_at(engine.scene, lift_of_links), CLEARANCE_READING: start}
        values |= {"part.governor.effects.clearance": width, "part.governor.start": start_values}
    return float(engine.amplitudes_per_turn(N_TURNS, values)[-N_MEASURED_TURNS:].max())
