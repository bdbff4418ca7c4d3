"""A rule of a paper, what the simulation shows of it, and the verdict; and the engines, steady or turned unevenly, for trying rules."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.linearisation import Linearisation, linearise_from_start
from governor_mechanism.statics.speed_curve import InsensitivityBand, compute_insensitivity_band, compute_speed_curve
from governor_mechanism.studies.plain_runs import SLEEVE_READING, run_uncertified
from governor_mechanism.types import FloatArray


class Verdict(Enum):
    """What a simulation says about a rule. Each value is a phrase for the user."""

    HOLDS = "holds"
    CONDITIONAL = "holds with a condition"
    FAILS = "does not hold"


class RuleCheck(ABC):
    """A rule and the simulations that test it; the verdict and the finding follow from the numbers."""

    title: ClassVar[str]
    """Short name of the rule."""

    source: ClassVar[str]
    """Who states it, and where."""

    statement: ClassVar[str]
    """What the paper says, as one sentence."""

    @property
    @abstractmethod
    def verdict(self) -> Verdict:
        """Whether the rule holds in the simulation."""

    @property
    @abstractmethod
    def finding(self) -> str:
        """What the simulation shows, with its numbers."""

    @property
    def condition(self) -> str:
        """The condition in a few words, if the rule holds with one; else empty."""
        return ""

    @property
    def verdict_text(self) -> str:
        """The verdict with its condition."""
        return f"{self.verdict.value}: {self.condition}" if self.verdict is Verdict.CONDITIONAL and self.condition else self.verdict.value

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return the measured values as plain values in SI, by names with their units."""


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


SAMPLES_PER_TURN = 400
"""Reported times per turn: the extreme of a speed with two waves per turn is missed by at most 1e-4 of its amplitude."""

HOLDING_FRICTION = 1e3
"""Friction that holds the sleeve whatever the speed, N: some times the weight of a governor here."""

RUN_ACCURACY = 1e-6
"""Accuracy of the runs: the sleeve moves by 0.1 of its length scale at most, and motions of 1 µm are distinguished."""

TURNS_TO_MOVE = 1.25
"""Turns after which a sleeve that cannot rest has moved: every speed occurs once a turn."""

THRESHOLD_STEP = 1e-3
"""Width of the last interval of a bisection for the threshold, as a ratio of the band."""


@dataclass(frozen=True, kw_only=True)
class CyclicEngine:
    """An engine at constant load whose lowest and highest speed lie symmetrically in the insensitivity band of its governor."""

    # the scene without friction, started so that a held sleeve leaves the speed in the middle of the band
    scene: Scene
    point: SteadyEngine  # steady state with mean torque
    # coefficient of fluctuation of speed, (highest - lowest) / equilibrium speed, while the sleeve rests
    fluctuation: float

    @property
    def turn_period(self) -> float:
        """Time of a turn of the crank, s."""
        return math.tau / self.point.engine_speed

    def find_friction(self, ratio: float) -> float:
        """Return the friction on the sleeve, N, whose insensitivity is a multiple of the coefficient of fluctuation of speed."""
        # sqrt(1 + d) - sqrt(1 - d) = insensitivity
        insensitivity = ratio * self.fluctuation
        relative_friction = insensitivity * math.sqrt(1 - insensitivity**2 / 4)
        return relative_friction / self.point.relative_friction_of_newton

    def run(self, n_turns: float, values: Values) -> Trajectory:
        """Run the engine for some turns with other values."""
        interval = self.turn_period / SAMPLES_PER_TURN
        times = {DURATION: n_turns * self.turn_period, INTERVAL: interval, ACCURACY: RUN_ACCURACY}
        return run_uncertified(with_values(self.scene, {**times, **values}))

    def amplitudes_per_turn(self, n_turns: int, values: Values) -> FloatArray:
        """Return the motion of the sleeve from lowest to highest point in each turn, m; shape (n_turns,)."""
        lift = self.run(n_turns, values).readings[SLEEVE]
        starts = range(0, n_turns * SAMPLES_PER_TURN, SAMPLES_PER_TURN)
        return np.array([np.ptp(lift[start : start + SAMPLES_PER_TURN + 1]) for start in starts])

    def does_sleeve_move(self, ratio: float, values: Values) -> bool:
        """Return whether the sleeve slips within a turn under the friction of a ratio of insensitivity to fluctuation."""
        run = self.run(TURNS_TO_MOVE, {**friction_on_sleeve(self.find_friction(ratio)), **values})
        return any(event.kind is EventKind.SLIP and event.subject == SLEEVE for event in run.events)

    def find_threshold(self, values: Values) -> float:
        """Return the ratio of insensitivity to fluctuation from which on the sleeve rests; nan if it is not between 0.9 and 1.1."""
        low = 0.9
        high = 1.1
        if not self.does_sleeve_move(low, values) or self.does_sleeve_move(high, values):
            return math.nan
        while high - low > THRESHOLD_STEP:
            midpoint = 0.5 * (low + high)
            low, high = (midpoint, high) if self.does_sleeve_move(midpoint, values) else (low, midpoint)
        return 0.5 * (low + high)


def build_cyclic_engine(
    engine: Scene,  # scene of a governed engine whose gas acts at every instant
    point: SteadyEngine,
    values: Values,
) -> CyclicEngine:
    """Return the engine with other values, at the load of an operating point of its twin with mean torque."""
    scene = with_values(engine, {**values, **point.start, LOAD: point.scene.document["load"]["fraction"]})
    trial = CyclicEngine(scene=scene, point=point, fluctuation=0.0)
    start_speed, fluctuation = point.engine_speed, 0.0
    for _ in range(3):  # the range of speed hardly depends on its middle: the second correction is below 1e-5 of the range
        speeds = trial.run(1.0, {START_SPEED: start_speed, **friction_on_sleeve(HOLDING_FRICTION)}).readings[ENGINE_SPEED]
        fluctuation = float(np.ptp(speeds)) / point.engine_speed
        # The middle of the band w sqrt(1 +- d) lies a little below w, by d^2 / 8 where the band is as wide as the fluctuation.
        middle = point.engine_speed * (1 - fluctuation**2 / 8)
        start_speed += middle - 0.5 * float(speeds.max() + speeds.min())
    return CyclicEngine(scene=with_values(scene, {START_SPEED: start_speed}), point=point, fluctuation=fluctuation)


def gear_to_speed(point: SteadyEngine, engine_speed: float) -> dict[str, float]:
    """Return the value of the gear that lets a governor at its operating point turn with an engine of a speed, rad/s."""
    return {GEAR_RATIO: point.governor_speed / engine_speed}
