"""The engine whose gas turns the crank unevenly, with a governor whose insensitivity band lies about its range of speed."""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rules.steady_engine import (
    ACCURACY,
    DURATION,
    ENGINE_SPEED,
    GEAR_RATIO,
    INTERVAL,
    LOAD,
    SLEEVE,
    START_SPEED,
    SteadyEngine,
    Values,
    friction_on_sleeve,
    with_values,
)
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.types import FloatArray

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
