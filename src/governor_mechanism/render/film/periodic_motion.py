"""When a motion comes back: the last whole period, or turn, on which a film closes so that it repeats without a jump."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import find_parts, integrate_speed
from governor_mechanism.render.part_run import PartRun
from governor_mechanism.types import FloatArray

MIN_FRAMES_PER_TURN = 20
"""Number of frames of a turn below which a crank jumps, or seems to turn backward: a wheel with five spokes looks the same after 14."""
MIN_FRAMES_PER_SPINDLE_TURN = 10
"""Number of frames of a turn of a spindle seen from outside below which it is slowed: two balls look the same after half a turn, and seem
to turn backward from a quarter of a turn between frames on."""
RETURN_TOLERANCE = 0.01
"""Largest difference of two like poses, relative to the range of the motion: less than a pixel in a motion of 100."""
EXCURSION = 0.25
"""Difference, relative to the range of the motion, beyond which a machine has left its first position."""
MAX_REST_RATIO = 1.25
"""Longest rest of a run after its last whole period, in periods: a longer one is no part of the same periodic motion."""
CLOSING_TOLERANCE = 0.02
"""Largest difference of two poses, relative to the range of the motion, if that lets the spindle close too: a pixel in a motion of 50."""
SPINDLE_CLOSING_TOLERANCE = 0.02
"""Largest difference of the spindle's angle from whole turns, in turns: a quarter of a step of the film at 2 turns/s."""
N_CLOSING_TIMES = 401
"""Number of times within half a turn of the spindle at which both differences are compared: the angle then fits to 1/400 of a turn."""


class Motion:
    """Motion of one part, as columns: positions (m) of its bodies in its plane, cosine and sine of their angles, and the spindle speed.

    Without the speed (rad/s), a governor that friction holds would have come back at any time.
    """

    def __init__(self, part_run: PartRun, *, shows_rotation: bool = False) -> None:
        run = part_run.run
        spindle = part_run.select_entries(run.readings).get("spindle_speed") if part_run.part.turns else None
        speed = np.zeros(len(run.times)) if spindle is None else spindle
        self._shown_speed = np.abs(speed) if shows_rotation else np.zeros(len(run.times))
        self._speed = speed
        self._turns = integrate_speed(run.times, speed) / (2 * math.pi) if shows_rotation and spindle is not None else None
        self.times, self.poses, self._velocities = run.times, part_run.poses, part_run.select_bodies(run.velocities)
        self._length_scale = part_run.part.mechanism.length_scale
        self._spline = CubicHermiteSpline(run.times, self.poses, self._velocities) if len(run.times) > 1 else None

    def turn_time(self, begin: float, end: float) -> float:
        """Return the shortest duration (s) of a turn between two times (s) of a body that makes whole turns; infinite without one.

        That of a spindle counts as longer, as it needs fewer frames.
        """
        inside = (self.times >= begin) & (self.times <= end)
        if not inside.any() or not self.poses.shape[1]:
            return math.inf
        spindle_rate = float(self._shown_speed[inside].max()) * MIN_FRAMES_PER_SPINDLE_TURN / MIN_FRAMES_PER_TURN
        is_turning = np.ptp(self.poses[inside, :, 2], axis=0) >= (1.0 - 1e-6) * 2 * math.pi  # a film of one turn has rounded ends
        rates = np.abs(self._velocities[inside, :, 2][:, is_turning])
        fastest = max(spindle_rate, float(rates.max(initial=0.0)))
        return 2 * math.pi / fastest if fastest > 0.0 else math.inf

    @property
    def has_shown_spindle(self) -> bool:
        """Whether the rotation of a spindle is shown."""
        return self._turns is not None

    def spindle_turns(self, times: FloatArray, begin: float) -> FloatArray:
        """Return the turns (n,) of a shown spindle from the begin to times (n,) s."""
        turns = np.zeros(len(self.times)) if self._turns is None else self._turns
        counted: FloatArray = np.interp(times, self.times, turns) - np.interp(begin, self.times, turns)
        return counted

    def difference(self, times: FloatArray, begin: float, scales: FloatArray) -> FloatArray:
        """Return the largest difference (n,) of the columns at times (n,) s from those at the begin (s), relative to their scales."""
        if self._spline is None:
            return np.zeros(len(times))
        # Clipped: a run may end before the others.
        at = np.clip(np.concatenate([[begin], times]), self.times[0], self.times[-1])
        columns = self._columns(np.asarray(self._spline(at)), np.interp(at, self.times, self._speed))
        largest: FloatArray = np.abs((columns[1:] - columns[0]) / scales).max(axis=1, initial=0.0)
        return largest

    def scales(self, begin: float, end: float) -> FloatArray:
        """Return the range of each column between two times (s); infinite for one that practically does not move."""
        inside = (self.times >= begin) & (self.times <= end)
        ranges = np.ptp(self._columns(self.poses[inside], self._speed[inside]), axis=0)
        smallest_speed = 1e-6 * float(np.abs(self._speed).max(initial=0.0))
        smallest = np.append(np.tile([1e-6 * self._length_scale] * 2 + [1e-6] * 2, self.poses.shape[1]), smallest_speed)
        return np.where(ranges > smallest, ranges, np.inf)

    def goes_the_same_way(self, begin: float, time: float) -> bool:
        """Return whether the bodies move at a time (s) as they did at the begin (s), or hardly moved then."""
        rates_at_both = [
            np.array([np.interp(at, self.times, column) for column in self._velocities.reshape(len(self.times), -1).T])
            for at in (begin, time)
        ]
        scale = np.abs(self._velocities).max(axis=0).ravel()
        first, second = (rates / np.where(scale > 0.0, scale, 1.0) for rates in rates_at_both)
        return float(np.abs(first).max(initial=0.0)) < 0.1 or float(first @ second) > 0.0

    @staticmethod
    def _columns(poses: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return the columns (n, 4 bodies + 1) of poses (n, bodies, 3) and spindle speeds (n,) rad/s."""
        x, y, angle = np.moveaxis(poses, -1, 0)
        of_bodies = np.stack([x, y, np.cos(angle), np.sin(angle)], axis=-1).reshape(len(poses), -1)
        return np.column_stack([of_bodies, speeds])


def motions_of(runs: Sequence[Trajectory], part: str | None, *, shows_rotation: bool = False) -> list[Motion]:
    """Return the motions of the shown parts of all runs."""
    return [Motion(PartRun(run=one, part=shown), shows_rotation=shows_rotation) for one in runs for shown in find_parts(one, part)]


def last_whole_period(motions: Sequence[Motion], begin: float, end: float) -> float | None:
    """Return the last time (s) up to the end at which all parts move as at the begin, or None if the motion is not periodic.

    A motion that comes back only at first, or that stops, is not periodic. Of spindles whose rotation is shown, the time is preferred at
    which they have made whole turns; if only they move, it is the last such time.
    """
    comparison = _Comparison(motions, begin, end)
    returns = comparison.find_returns()
    spindles = [motion for motion in motions if motion.has_shown_spindle]
    if not returns:
        return comparison.last_whole_turn(spindles) if spindles and comparison.is_at_rest else None
    if spindles:
        for time in reversed(returns):
            closing = comparison.closing_time(time, spindles)
            if closing is not None:
                return closing
    return returns[-1]


class _Comparison:
    """Comparison of motions between two times (s) with that at the first."""

    def __init__(self, motions: Sequence[Motion], begin: float, end: float) -> None:
        self._motions, self._begin, self._end = motions, begin, end
        times = motions[0].times
        self._times = np.unique(np.concatenate([[begin], times[(times > begin) & (times < end)], [end]]))
        self._scales = [motion.scales(begin, end) for motion in motions]

    @property
    def is_at_rest(self) -> bool:
        """Whether nothing moves in its plane."""
        return bool(self._difference(self._times).max() == 0.0)

    def _difference(self, at: FloatArray) -> FloatArray:
        """Return the largest difference (n,) at times (n,) s, relative to the range of the motion."""
        compared = zip(self._motions, self._scales, strict=True)
        largest: FloatArray = np.max([motion.difference(at, self._begin, scale) for motion, scale in compared], axis=0)
        return largest

    def find_returns(self) -> list[float]:
        """Return the times (s) at which all parts move as at the begin; none if the motion is not periodic."""
        times = self._times
        if len(times) < 5:
            return []
        returns, is_away, values = [self._begin], False, self._difference(times)
        for k in range(1, len(times)):
            is_away |= bool(values[k] > EXCURSION)
            following = values[k + 1] if k + 1 < len(times) else math.inf
            # The next sample may be nearer; far from the first position no search is needed.
            if not is_away or values[k] > EXCURSION or not values[k - 1] >= values[k] <= following:
                continue
            near = np.linspace(times[k - 1], times[min(k + 1, len(times) - 1)], 201)
            differences = self._difference(near)
            nearest = int(differences.argmin())
            time = float(near[nearest])
            if differences[nearest] < RETURN_TOLERANCE and all(one.goes_the_same_way(self._begin, time) for one in self._motions):
                returns.append(time)
                is_away = False
        if len(returns) == 1 or self._end - returns[-1] > MAX_REST_RATIO * float(np.diff(returns).max()):
            return []
        return returns[1:]

    def closing_time(self, time: float, spindles: Sequence[Motion]) -> float | None:
        """Return the time (s) near a return at which spindles have made whole turns within the tolerances; None if there is none."""
        fastest = max(float(np.ptp(one.spindle_turns(np.array([self._begin, time]), self._begin))) for one in spindles)
        if fastest == 0.0:
            return time
        half_turn = 0.5 * (time - self._begin) / fastest
        near = np.linspace(max(time - half_turn, self._begin), min(time + half_turn, self._end), N_CLOSING_TIMES)
        off = self._turns_off(near, spindles)
        is_closed = (self._difference(near) < CLOSING_TOLERANCE) & (off < SPINDLE_CLOSING_TOLERANCE)
        if not is_closed.any():
            return None
        return float(near[np.where(is_closed, off, np.inf).argmin()])

    def last_whole_turn(self, spindles: Sequence[Motion]) -> float | None:
        """Return the last time (s) at which all spindles have made whole turns; None if there is none."""
        total = max(float(np.abs(one.spindle_turns(np.array([self._end]), self._begin))[0]) for one in spindles)
        for turns in range(math.floor(total + SPINDLE_CLOSING_TOLERANCE), 0, -1):
            closing = self.closing_time(self._begin + (self._end - self._begin) * min(turns / total, 1.0), spindles)
            if closing is not None:
                return closing
        return None

    def _turns_off(self, times: FloatArray, spindles: Sequence[Motion]) -> FloatArray:
        """Return the largest difference (n,) of spindles from whole turns at times (n,) s."""
        turns = np.array([one.spindle_turns(times, self._begin) for one in spindles])
        largest: FloatArray = np.abs(turns - np.round(turns)).max(axis=0)
        return largest
