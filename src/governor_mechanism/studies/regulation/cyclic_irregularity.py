"""Cyclic sleeve motion under a fluctuating spindle speed, against speed fluctuation and clearance."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance, DryFriction
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.plain_runs import SLEEVE_READING, FittedParameter, fit_slope, run_uncertified
from governor_mechanism.types import FloatArray

FLUCTUATION_RATIOS = np.concatenate([np.linspace(0.0, 0.95, 12), 1 + np.geomspace(1e-4, 1.0, 29)])
"""Speed fluctuations over the insensitivity band, for a curve of cyclic motion."""

CLEARANCES = np.geomspace(1e-5, 4e-2, 33)
"""Clearances, m, for a curve of the clearance study."""

SAMPLES_PER_TURN = 200
"""Reported times per turn of the spindle."""

STANDSTILL_TOLERANCE = 1e-13
"""Amplitude below which the sleeve is at rest, m; rounding is smaller."""

THRESHOLD_TOLERANCE = 1e-6
"""Tolerance of the threshold of cyclic motion, relative to the insensitivity band."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicMotionStudy(Result):
    """Amplitude of the sleeve per turn, after a number of turns, against the speed fluctuation."""

    title: str  # title of the scene
    fluctuation_ratios: FloatArray  # speed fluctuation over insensitivity band at the start; shape (n,)
    amplitudes: FloatArray  # sleeve motion from lowest to highest point, m; shape (n,)
    insensitivity_band: float  # relative width of the insensitivity band, (w' - w'') / mean speed
    threshold: float  # fluctuation ratio at which the sleeve first moves
    n_turns: int  # turns before the one that is measured

    figure = "render.figures.regulation.cyclic_figure"

    @property
    def onset_exponent(self) -> FittedParameter:
        """Exponent of the amplitude in (ratio - threshold), fitted where this is below 0.01."""
        excess = self.fluctuation_ratios - self.threshold
        is_near_threshold = (excess > 10 * THRESHOLD_TOLERANCE) & (excess < 0.01) & (self.amplitudes > 0)
        return fit_slope(np.log(excess[is_near_threshold]), np.log(self.amplitudes[is_near_threshold]))

    @property
    def conclusion(self) -> str:
        """One sentence on when the sleeve moves."""
        threshold = f"cyclic sleeve motion from a speed fluctuation of {self.threshold:.6g} insensitivity bands"
        return f"{threshold}; the band is {self.insensitivity_band:.6g}"


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceStudy(Result):
    """Amplitudes of sleeve and arms per turn, after a number of turns, against the clearance."""

    title: str  # title of the scene
    clearances: FloatArray  # clearance between links and sleeve, m; shape (n,)
    amplitudes: FloatArray  # sleeve motion from lowest to highest point, m; shape (n,)
    arm_amplitudes: FloatArray  # the same of the links, as the lift of a sleeve without clearance, m; shape (n,)
    amplitude_without_clearance: float  # sleeve amplitude without clearance, m
    # whether the friction exceeds the weight of the sleeve, so that it can stay at rest without its links
    friction_carries_sleeve: bool
    fluctuation_ratio: float  # speed fluctuation over insensitivity band
    n_turns: int  # turns before the one that is measured

    figure = "render.figures.regulation.clearance_figure"

    def plot(self, *others: "ClearanceStudy") -> Figure:
        """Draw the sleeve amplitude over that without clearance, against clearance, with a line for each of other studies.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If a scene has no cyclic sleeve motion without clearance.
        """
        return self._draw(*others)

    @property
    def worst(self) -> tuple[float, float]:
        """Clearance with the largest sleeve amplitude, and that amplitude, m."""
        index = int(np.argmax(self.amplitudes))
        return float(self.clearances[index]), float(self.amplitudes[index])

    @property
    def standstill_clearance(self) -> float:
        """Least clearance from which the sleeve is at rest for all larger ones, m; infinite if there is none."""
        order = np.argsort(self.clearances)
        moving_indices = np.flatnonzero(self.amplitudes[order] > 0)
        first_index = int(moving_indices[-1]) + 1 if moving_indices.size else 0
        return float(self.clearances[order][first_index]) if first_index < len(order) else math.inf

    @property
    def conclusion(self) -> str:
        """The title, and one sentence on whether clearance reduces the cyclic motion."""
        return f"{self.title}: {self._describe_effect()}"

    def _describe_effect(self) -> str:
        clearance, amplitude = self.worst
        base_amplitude = self.amplitude_without_clearance
        clearance_text = f"a clearance of {clearance * 1e3:.3g} mm"
        if base_amplitude == 0:
            return f"{clearance_text} causes cyclic motion" if amplitude > 0 else "the sleeve is at rest with and without clearance"
        if np.all(np.abs(self.amplitudes - base_amplitude) < 1e-3 * base_amplitude):
            reason = "" if self.friction_carries_sleeve else ": the weight of the sleeve keeps the clearance closed"
            return f"clearance changes nothing{reason}"
        standstill = self.standstill_clearance
        standstill_text = f"; from {standstill * 1e3:.3g} mm the sleeve is at rest" if standstill < math.inf else ""
        if amplitude / base_amplitude > 1.001:
            return f"{clearance_text} multiplies the amplitude by {amplitude / base_amplitude:.3g}{standstill_text}"
        return f"clearance reduces the amplitude{standstill_text}"


def study_cyclic_motion(
    scene: Scene,  # scene with dry friction on the sleeve and a constant mean speed
    fluctuation_ratios: Sequence[float] | FloatArray,  # speed fluctuation over insensitivity band; shape (n,)
    n_turns: int = 10,
) -> CyclicMotionStudy:
    """Run a scene at several speed fluctuations and measure the last turn.

    The threshold is found by bisection between the ratios 0 and 2; it is 1 if the mean speed is in the middle of the band.

    Result: amplitudes and threshold. Raises MechanismError if the scene has no such friction or speed, or if
    the sleeve does not move at a ratio of 2.
    """
    requested_ratios = np.asarray(fluctuation_ratios, dtype=np.float64)
    spindle, insensitivity_band = _find_spindle_and_band(scene)

    def does_sleeve_move(fluctuation_ratio: float) -> bool:
        run = _run_fluctuating(scene, replace(spindle, speed_fluctuation=fluctuation_ratio * insensitivity_band), 2)
        return any(event.kind is not EventKind.CROSSING for event in run.events)

    low, high = 0.0, 2.0
    if not does_sleeve_move(high):
        raise MechanismError(
            "the sleeve does not move at a speed fluctuation of twice the insensitivity band; is it held by something else?"
        )
    while high - low > THRESHOLD_TOLERANCE:
        midpoint = 0.5 * (low + high)
        low, high = (low, midpoint) if does_sleeve_move(midpoint) else (midpoint, high)
    spindles = (replace(spindle, speed_fluctuation=ratio * insensitivity_band) for ratio in requested_ratios.tolist())
    runs = (_run_fluctuating(scene, one, n_turns + 1) for one in spindles)
    return CyclicMotionStudy(
        title=scene.title,
        fluctuation_ratios=requested_ratios,
        amplitudes=np.array([_compute_last_turn_amplitude(run.readings[SLEEVE_READING]) for run in runs]),
        insensitivity_band=insensitivity_band,
        threshold=0.5 * (low + high),
        n_turns=n_turns,
    )


def study_clearance(
    scene: Scene,  # scene with dry friction on the sleeve and a constant mean speed
    clearances: Sequence[float] | FloatArray,  # clearance between links and sleeve, m; shape (n,)
    n_turns: int = 20,
) -> ClearanceStudy:
    """Run a scene with cyclic sleeve motion at several clearances and measure the last turn.

    Each run starts at the same relative position in the clearance as the scene; a scene without clearance starts with the
    sleeve hanging on its links. Raises MechanismError if the scene has no such friction or speed.

    Result: amplitudes of sleeve and arms.
    """
    _find_sleeve_friction(scene)  # raises if there is none, before anything else of the scene is judged
    requested_clearances = np.asarray(clearances, dtype=np.float64)
    scenes = (_make_scene_with_clearance(scene, clearance) for clearance in (0.0, *requested_clearances.tolist()))
    spindle, insensitivity_band = _find_spindle_and_band(_make_scene_with_clearance(scene, 0.0))
    runs = [_run_fluctuating(one, spindle, n_turns + 1) for one in scenes]
    sleeve_motions = [run.readings[SLEEVE_READING] for run in runs]
    arm_motions = [run.readings[SLEEVE_READING] - run.readings.get(CLEARANCE_READING, 0.0) for run in runs[1:]]
    amplitude_without_clearance, *amplitudes = map(_compute_last_turn_amplitude, sleeve_motions)
    sleeve_weight = scene.part.dimensions["sleeve_mass"] * scene.gravity
    return ClearanceStudy(
        title=scene.title,
        clearances=requested_clearances,
        amplitudes=np.array(amplitudes),
        arm_amplitudes=np.array([_compute_last_turn_amplitude(motion) for motion in arm_motions]),
        amplitude_without_clearance=amplitude_without_clearance,
        friction_carries_sleeve=_find_sleeve_friction(scene) > sleeve_weight,
        fluctuation_ratio=spindle.speed_fluctuation / insensitivity_band,
        n_turns=n_turns,
    )


def _find_sleeve_friction(scene: Scene) -> float:
    """Return the dry friction on the sleeve at the start, N."""
    for effect in scene.effects:
        if isinstance(effect, DryFriction) and effect.reading == SLEEVE_READING:
            return effect.force.values[0]
    raise MechanismError("cyclic sleeve motion needs dry friction on the sleeve; add effects.dry_friction = { sleeve = ... }")


def _find_spindle_and_band(scene: Scene) -> tuple[Spindle, float]:
    """Return the spindle with its mean speed, and the relative width of the insensitivity band at the start."""
    spindle = scene.spindle
    if not isinstance(spindle, Spindle) or not spindle.speed_function.is_constant:
        raise MechanismError("cyclic sleeve motion needs a constant mean speed; give spindle.speed as a number")
    mechanism = scene.part.mechanism
    start_value = float(evaluate_output_value(mechanism, mechanism.coordinate, initial_state(scene)[0]))
    band = compute_insensitivity_band(scene, [start_value], _find_sleeve_friction(scene), SLEEVE_READING)
    return replace(spindle, times=(0.0,), speeds=spindle.speeds[:1]), float((band.rising_speed - band.falling_speed)[0]) / spindle.speeds[0]


def _run_fluctuating(scene: Scene, spindle: Spindle, n_turns: int) -> Trajectory:
    """Run the scene for some turns of a spindle."""
    turn_period = 2 * math.pi / spindle.speeds[0]
    settings = replace(scene.run, duration=n_turns * turn_period, output_interval=turn_period / SAMPLES_PER_TURN)
    return run_uncertified(scene.with_changes(spindle=spindle, run=settings))


def _compute_last_turn_amplitude(values: FloatArray) -> float:
    """Return the peak-to-peak value over the last turn; 0 below STANDSTILL_TOLERANCE."""
    amplitude = float(np.ptp(values[-SAMPLES_PER_TURN - 1 :]))
    return amplitude if amplitude > STANDSTILL_TOLERANCE else 0.0


def _make_scene_with_clearance(scene: Scene, clearance: float) -> Scene:
    """Return the scene with another clearance, m, or none, at the same relative start position."""
    previous_clearance = next((effect.width for effect in scene.effects if isinstance(effect, Clearance)), 0.0)
    effects: list[Effect] = [effect for effect in scene.effects if not isinstance(effect, Clearance)]
    values = {name: value for name, value in scene.part.start.values.items() if name != CLEARANCE_READING}
    if clearance:
        given_start = scene.part.start.values.get(CLEARANCE_READING)
        start_ratio = float(given_start) / previous_clearance if previous_clearance and given_start is not None else -0.5
        effects.append(Clearance(width=clearance))
        values[CLEARANCE_READING] = start_ratio * clearance
    mechanism = MACHINES[scene.part.machine](**scene.part.dimensions).mechanism_with_effects(effects)
    rates = {name: rate for name, rate in scene.part.start.rates.items() if name != CLEARANCE_READING}
    return scene.with_changes(mechanism=mechanism, effects=tuple(effects), start=Start(values=values, rates=rates))
