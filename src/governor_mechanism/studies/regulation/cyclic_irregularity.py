"""Twitching: how far the sleeve goes in a turn of an uneven spindle, against unevenness and against play."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.engines.initial_state import starting_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import Scene, Spindle, Start
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.speed_curve import standing_band
from governor_mechanism.studies.regression import SLEEVE, Fitted, slope, uncertified
from governor_mechanism.types import FloatArray

SAMPLES = 200
"""In a turn of the spindle."""

ROUNDING = 1e-13
"""m: what goes no farther stands still."""

NEAREST = 1e-6
"""Of the band: so near the threshold of twitching is found."""


@dataclass(frozen=True, kw_only=True)
class Twitch:
    """How far the sleeve goes in a turn, after a number of turns, against the unevenness of the spindle.

    shares (n,): unevenness over the standing band at the start; amplitudes (n,) m, from lowest to highest; band, the
    relative width of the standing band, (w' - w'') / mean speed; threshold, the share at which the sleeve first moves.
    """

    title: str
    shares: FloatArray
    amplitudes: FloatArray
    band: float
    threshold: float
    turns: int

    @property
    def onset(self) -> Fitted:
        """The exponent with which the amplitude grows with share - threshold, fitted where that is below 0.01."""
        excess = self.shares - self.threshold
        near = (excess > 10 * NEAREST) & (excess < 0.01) & (self.amplitudes > 0)
        return slope(np.log(excess[near]), np.log(self.amplitudes[near]))


@dataclass(frozen=True, kw_only=True)
class PlayAndTwitch:
    """How far sleeve and arms go in a turn, after a number of turns, against play.

    plays (n,) m; amplitudes (n,) m of the sleeve, without_play (m) the one without any; arm_amplitudes (n,) m those of
    the links, as the lift that they would give a sleeve hanging on them; carried: whether friction bears the sleeve's
    weight, so that it can stand without its links; share: unevenness over the standing band.
    """

    title: str
    plays: FloatArray
    amplitudes: FloatArray
    arm_amplitudes: FloatArray
    without_play: float
    carried: bool
    share: float
    turns: int

    @property
    def worst(self) -> tuple[float, float]:
        """The play (m) with the largest amplitude, and that amplitude (m)."""
        index = int(np.argmax(self.amplitudes))
        return float(self.plays[index]), float(self.amplitudes[index])

    @property
    def still_from(self) -> float:
        """The play (m) from which on the sleeve stands still with all that are wider; infinite where it never does."""
        order = np.argsort(self.plays)
        moving = np.flatnonzero(self.amplitudes[order] > 0)
        first = int(moving[-1]) + 1 if moving.size else 0
        return float(self.plays[order][first]) if first < len(order) else math.inf

    @property
    def finding(self) -> str:
        """Whether play is a remedy here, in one sentence."""
        play, amplitude = self.worst
        if self.without_play == 0:
            return f"play of {play * 1e3:.3g} mm makes it twitch" if amplitude > 0 else "it stands still, play or not"
        if np.all(np.abs(self.amplitudes - self.without_play) < 1e-3 * self.without_play):
            return "play changes nothing" + ("" if self.carried else ": the weight of the sleeve keeps it closed")
        until = (
            f"; from {self.still_from * 1e3:.3g} mm on the sleeve stands still" if self.still_from < math.inf else ""
        )
        times = amplitude / self.without_play
        if times > 1.001:
            return f"play of {play * 1e3:.3g} mm makes it {times:.3g} times worse{until}"
        return f"play helps{until}"


def twitch(scene: Scene, shares: Sequence[float] | FloatArray, turns: int = 10) -> Twitch:
    """Run a scene with unevennesses of these shares (n,) of its standing band; the last of turns + 1 turns counts.

    The scene needs dry friction on the sleeve and a constant mean speed. The threshold is found by halving between
    shares 0 and 2; it is 1 where the mean speed lies in the middle of the band. Raises MechanismError otherwise.
    """
    asked = np.asarray(shares, dtype=np.float64)
    mean, band = _mean_and_band(scene)

    def moves(share: float) -> bool:
        turned = _uneven(scene, share * band, mean, 2)
        return bool(uncertified(turned).events)

    low, high = 0.0, 2.0
    if not moves(high):
        raise MechanismError("the sleeve does not move with an unevenness of twice the standing band; is it held?")
    while high - low > NEAREST:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if moves(middle) else (middle, high)
    amplitudes = [
        _amplitude(uncertified(_uneven(scene, share * band, mean, turns + 1)), SLEEVE) for share in asked.tolist()
    ]
    return Twitch(
        title=scene.title,
        shares=asked,
        amplitudes=np.array(amplitudes),
        band=band,
        threshold=0.5 * (low + high),
        turns=turns,
    )


def play_and_twitch(scene: Scene, plays: Sequence[float] | FloatArray, turns: int = 20) -> PlayAndTwitch:
    """Run a twitching scene with these plays (n,) m between links and sleeve; the last of turns + 1 turns counts.

    It starts where in its play the scene starts; a scene without play starts with the sleeve hanging on its links.
    Raises MechanismError as `twitch` does.
    """
    asked = np.asarray(plays, dtype=np.float64)
    bare = _with_play(scene, 0.0)
    mean, band = _mean_and_band(bare)
    unevenness = scene.spindle.unevenness if isinstance(scene.spindle, Spindle) else 0.0
    runs = [uncertified(_uneven(_with_play(scene, play), unevenness, mean, turns + 1)) for play in asked.tolist()]
    weight = scene.part.dimensions["sleeve_mass"] * scene.gravity
    return PlayAndTwitch(
        title=scene.title,
        plays=asked,
        amplitudes=np.array([_amplitude(run, SLEEVE) for run in runs]),
        arm_amplitudes=np.array([_last_turn(run.readings[SLEEVE] - run.readings.get(PLAY, 0.0)) for run in runs]),
        without_play=_amplitude(uncertified(_uneven(bare, unevenness, mean, turns + 1)), SLEEVE),
        carried=_friction(scene) > weight,
        share=unevenness / band,
        turns=turns,
    )


def _friction(scene: Scene) -> float:
    """The dry friction (N) on the sleeve, at the start."""
    for effect in scene.effects:
        if isinstance(effect, DryFriction) and effect.reading == SLEEVE:
            return effect.force.values[0]
    raise MechanismError("a sleeve twitches against dry friction; list effects.dry_friction = { sleeve = ... }")


def _mean_and_band(scene: Scene) -> tuple[float, float]:
    """The mean speed (rad/s), and the relative width of the standing band where the scene starts."""
    spindle = scene.spindle
    if not isinstance(spindle, Spindle) or not spindle.program.constant:
        raise MechanismError("twitching is studied about one mean speed; give spindle.speed as a number")
    mean, coordinate = spindle.speeds[0], scene.part.mechanism.coordinate
    start = float(reading_value(scene.part.mechanism, coordinate, starting_state(scene)[0]))
    band = standing_band(scene, [start], _friction(scene), SLEEVE)
    return mean, float((band.rising_speed - band.falling_speed)[0]) / mean


def _uneven(scene: Scene, unevenness: float, mean: float, turns: int) -> Scene:
    """The scene for so many turns of an uneven spindle."""
    spindle = scene.spindle
    waves = spindle.waves if isinstance(spindle, Spindle) else 1.0
    turn = 2 * math.pi / mean
    return replace(
        scene,
        spindle=Spindle(speeds=(mean,), unevenness=unevenness, waves=waves),
        run=replace(scene.run, duration=turns * turn, every=turn / SAMPLES),
    )


def _last_turn(values: FloatArray) -> float:
    way = float(np.ptp(values[-SAMPLES - 1 :]))
    return way if way > ROUNDING else 0.0


def _amplitude(run: Trajectory, reading: str) -> float:
    return _last_turn(run.readings[reading])


def _with_play(scene: Scene, width: float) -> Scene:
    """The scene with another play, or with none, starting at the same part of it."""
    before = next((effect.width for effect in scene.effects if isinstance(effect, Play)), 0.0)
    effects: list[Effect] = [effect for effect in scene.effects if not isinstance(effect, Play)]
    values = {name: value for name, value in scene.start.values.items() if name != PLAY}
    if width:
        given = scene.start.values.get(PLAY)
        part = float(given) / before if before and given is not None else -0.5
        effects.append(Play(width=width))
        values[PLAY] = part * width
    machine = MACHINES[scene.part.machine](**scene.part.dimensions)
    part_of = replace(scene.part, mechanism=machine.mechanism_with(effects))
    rates = {name: rate for name, rate in scene.start.rates.items() if name != PLAY}
    return replace(scene, parts=(part_of,), effects=tuple(effects), start=Start(values=values, rates=rates))
