"""The engine of the rules in the steady state at part load: shipped scenes with other values, and the governor alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.linearisation import Linearisation, linearise_from_start
from governor_mechanism.statics.speed_curve import InsensitivityBand, compute_insensitivity_band, compute_speed_curve
from governor_mechanism.studies.plain_runs import SLEEVE_READING

Values = Mapping[str, Any]
"""Values of a scene file by their keys."""

NO_VALUES: Values = MappingProxyType({})
"""No other values."""

SLEEVE = f"governor.{SLEEVE_READING}"
GOVERNOR_SPEED = "governor.spindle_speed"
ENGINE_SPEED = "engine.shaft_speed"
"""Readings of a governed engine."""

DASHPOT = "part.governor.effects.dashpot"
FRICTION = "part.governor.effects.dry_friction"
GEAR_RATIO = "coupling.gear.ratio"
INERTIA = "part.engine.dimensions.inertia"
START_SPEED = "part.engine.start.crank_rate"
LOAD = "load.fraction"
DURATION = "run.duration"
INTERVAL = "run.output_interval"
ACCURACY = "run.accuracy"
"""Keys of a governed engine."""

HALF_LOAD = 0.5
"""Load of the operating point, over the rated torque."""


def with_values(scene: Scene, values: Values) -> Scene:
    """Return a scene with other values in its file."""
    return parse_scene_with(scene.document, values.items())


def dashpot_on_sleeve(damping: float) -> dict[str, Any]:
    """Return the values of a dashpot on the sleeve, N s/m; 0 is none."""
    return {DASHPOT: {"sleeve": damping} if damping else False}


def friction_on_sleeve(force: float) -> dict[str, Any]:
    """Return the values of dry friction on the sleeve, N; 0 is none."""
    return {FRICTION: {"sleeve": force} if force else False}


def load_step(before: float, after: float, time: float) -> dict[str, Any]:
    """Return the values of a load that jumps at a time, s, from one fraction of the rated torque to another."""
    return {LOAD: [[0.0, before], [time, before], [time, after]]}


def linearise_scene_from_start(scene: Scene) -> Linearisation:
    """Return the linearised equations about the steady state nearest to the start of a scene."""
    return linearise_from_start(scene, *initial_state(scene))


@dataclass(frozen=True, kw_only=True)
class SteadyEngine:
    """A governed engine with the mean torque of its gas, in its steady state."""

    scene: Scene  # the scene, started in that state
    coordinate: float  # leading coordinate of the governor, rad
    sleeve_lift: float  # lift of the sleeve, m
    engine_speed: float  # speed of the engine, rad/s
    governor_speed: float  # speed of the governor, rad/s

    @property
    def start(self) -> dict[str, Any]:
        """Values that start a scene at this point."""
        return start_at_rest(self.scene, self.coordinate) | {START_SPEED: self.engine_speed}

    @cached_property
    def governor(self) -> Scene:
        """The governor alone at its speed, without friction and dashpot."""
        return governor_alone(self.scene, self.governor_speed)

    def find_insensitivity_band(self, friction: float) -> InsensitivityBand:
        """Return the insensitivity band of the governor here under friction on the sleeve, N."""
        return compute_insensitivity_band(self.governor, [self.coordinate], friction, SLEEVE_READING)

    @property
    def relative_friction_of_newton(self) -> float:
        """Change of the squared equilibrium speed that 1 N on the sleeve holds, over that square, 1/N."""
        band = self.find_insensitivity_band(1.0)
        return float((band.rising_speed**2 - band.falling_speed**2)[0]) / (2 * self.governor_speed**2)

    def droop_over(self, travel: float) -> float:
        """Return the relative change of speed over a travel of the sleeve, m, at the slope of the speed curve here."""
        reduction = SingleDofReduction(self.governor)
        coefficients = reduction.evaluate([self.coordinate])
        stiffness = float(coefficients.stiffness_terms(self.governor_speed**2).sum())
        # K = J' d(w^2)/dq / 2, so that dw/dq / w = K / (J' w^2).
        slope = stiffness / (float(coefficients.spindle_inertia_derivative[0]) * self.governor_speed**2)
        return travel * slope / float(reduction.output_derivative(coefficients, SLEEVE_READING)[0])


def find_steady_engine(
    mean_engine: Scene,  # scene of a governed engine with the mean torque of its gas
    values: Values = NO_VALUES,
    *,
    # lift of the sleeve near the steady state, m; if None, the governor starts as in the scene
    sleeve_lift: float | None = None,
) -> SteadyEngine:
    """Return the steady state of an engine with mean torque at half load; raise MechanismError if there is none."""
    scene = with_values(mean_engine, {LOAD: HALF_LOAD, **values})
    if sleeve_lift is not None:
        scene = with_values(scene, start_at_rest(scene, find_coordinate_at(scene, sleeve_lift)))
    linearisation = linearise_scene_from_start(scene)
    coordinate = linearisation.readings[f"governor.{_coordinate_name(scene)}"]
    engine_speed = linearisation.rates["engine.crank_angle"]
    return SteadyEngine(
        scene=with_values(scene, start_at_rest(scene, coordinate) | {START_SPEED: engine_speed}),
        coordinate=coordinate,
        sleeve_lift=linearisation.readings[SLEEVE],
        engine_speed=engine_speed,
        governor_speed=linearisation.rates[GOVERNOR_SPEED],
    )


def find_coordinate_at(scene: Scene, sleeve_lift: float) -> float:
    """Return the coordinate of the governor at a lift of its sleeve, m, from its speed curve (about 1e-4 rad)."""
    curve = compute_speed_curve(governor_alone(scene, 1.0))
    lifts = curve.readings[SLEEVE_READING]
    order = np.argsort(lifts)
    return float(np.interp(sleeve_lift, lifts[order], curve.coordinate[order]))


def governor_alone(scene: Scene, speed: float) -> Scene:
    """Return the governor of a governed engine alone at a speed of its spindle, rad/s, under gravity and centrifugal force."""
    part = scene.document["part"]["governor"]
    document = {
        "title": f"{scene.title}: the governor",
        "machine": part["machine"],
        "dimensions": part["dimensions"],
        "effects": {"gravity": True, "centrifugal": True},
        "spindle": {"speed": speed},
        "run": {"duration": 1.0, "output_interval": 0.1, "accuracy": 1e-6},
    }
    return parse_scene_document(document)


def _coordinate_name(scene: Scene) -> str:
    return scene.part_of("governor")[0].mechanism.coordinate


def start_at_rest(scene: Scene, coordinate: float) -> dict[str, Any]:
    """Return the values that start the governor at rest at a coordinate, SI; the whole table, so that no rate is left in it."""
    return {"part.governor.start": {scene.part_of("governor")[0].mechanism.coordinate: coordinate}}
