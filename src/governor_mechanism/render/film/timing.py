"""Which part of a run a film shows, and how fast: true time, slowed for fast cranks, and closed on whole periods where there are any."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.results.pictures import FilmOptionError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.numerics.interpolation import integrate_samples, interpolate_samples
from governor_mechanism.render.frame_data import find_parts
from governor_mechanism.render.geometry.primitives import Vec2, round_step
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
        self._turns = integrate_samples(run.times, speed) / (2 * math.pi) if shows_rotation and spindle is not None else None
        self.times, self.poses, self._velocities = run.times, part_run.poses, part_run.select_bodies(run.velocities)
        self._length_scale = part_run.part.mechanism.length_scale

    def turn_time(self, begin: float, end: float) -> float:
        """Return the shortest duration (s) of a whole turn between times (s), that of a spindle counts as longer; infinite without one."""
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
        if len(self.times) < 2:
            return np.zeros(len(times))
        # Clipped: a run may end before the others.
        at = np.clip(np.concatenate([[begin], times]), self.times[0], self.times[-1])
        poses = interpolate_samples(self.times, self.poses, self._velocities, at)
        columns = self._columns(poses, np.interp(at, self.times, self._speed))
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
        self._motions = motions
        self._begin = begin
        self._end = end
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
        returns = [self._begin]
        is_away = False
        values = self._difference(times)
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


MIN_TRUE_TIME_DURATION, MAX_TRUE_TIME_DURATION = 1.0, 60.0
"""Range of run durations (s) that are shown in true time by default."""
MIN_FILM_DURATION, MAX_FILM_DURATION = 4.0, 20.0
"""Range of film durations (s) for all other runs."""
MAX_SLOWED_FILM_DURATION = 3600.0
"""Longest film (s) with a requested slow-down."""
MIN_SPED_FILM_DURATION = 0.1
"""Shortest film (s) of a run that is sped up on request: two or three frames."""
ENGINE_ROOM_FILM_DURATION = 10.0
"""Longest default duration (s) of the film of an engine room, for a file of less than 700 kB."""
MIN_SHARE_OF_FRAMES = 0.5
"""Share of these frames that a GIF keeps which would otherwise be too large: the turns are coarser then, but their direction is seen."""
MAX_TURNING_FILM_DURATION = 12.0
"""Longest film (s) of a crank that is slowed, for a file of less than 700 kB."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Start and end of the shown part (s), seconds of film per second of it, and its fastest whole turn (s; infinite without one)."""

    time_span: Vec2
    slow_down: float
    turn_time: float = math.inf

    @property
    def has_whole_turns(self) -> bool:
        """Whether a crank, or a spindle whose rotation is shown, makes whole turns."""
        return math.isfinite(self.turn_time)

    @property
    def lowest_frame_rate(self) -> float:
        """Lowest frame rate (1/s of film) of a GIF that would otherwise be too large."""
        return MIN_SHARE_OF_FRAMES * MIN_FRAMES_PER_TURN / (self.turn_time * self.slow_down)


def choose_slow_down(duration: float) -> float:
    """Return the factor, 1, 2 or 5 x 10^n or its inverse, for a duration (s): 1 from 1 to 60 s, else for a film of 4 to 20 s."""
    if MIN_TRUE_TIME_DURATION <= duration <= MAX_TRUE_TIME_DURATION or duration <= 0.0:
        return 1.0
    if duration < MIN_TRUE_TIME_DURATION:
        return round_step(MIN_FILM_DURATION / duration, 1)
    return 1.0 / round_step(duration / MAX_FILM_DURATION, 1)


def select_timing(
    runs: Sequence[Trajectory],
    part: str | None,
    start: float | None,
    stop: float | None,
    slow_down: float | None,
    frame_rate: float,
    *,
    shows_rotation: bool = False,
) -> Timing:
    """Return what a film of machines shows, with the given values where there are any; `frame_rate` in 1/s.

    Cranks are slowed to at least MIN_FRAMES_PER_TURN frames a turn, and spindles whose rotation is shown to MIN_FRAMES_PER_SPINDLE_TURN.
    The film of one run ends on a whole turn or period, if it can of the spindles too whose rotation is shown.
    """
    limits = min(float(one.times[0]) for one in runs), max(float(one.times[-1]) for one in runs)
    begin, end = select_time_span(limits, start, stop)
    factor = select_slow_down(limits, (begin, end), slow_down)
    motions = motions_of(runs, part, shows_rotation=shows_rotation)
    if slow_down is None:
        factor, end = _slow_cranks(motions, (begin, end), factor, frame_rate, may_shorten=stop is None)
    if stop is None and len(runs) == 1:
        whole_end = last_whole_period(motions, begin, end)
        end = end if whole_end is None else whole_end
    turn_time = min((motion.turn_time(begin, end) for motion in motions), default=math.inf)
    return Timing(time_span=(begin, end), slow_down=factor, turn_time=turn_time)


def find_loop_end(run: Trajectory, time_span: Vec2, *, shows_rotation: bool = False) -> float | None:
    """Return the last time (s) in a time span (s) at which all parts of a run move as at its start; None for one that is not periodic.

    If the rotation of spindles is shown, they have made whole turns then where a number of periods allows it.
    """
    limits = float(run.times[0]), float(run.times[-1])
    return last_whole_period(motions_of((run,), None, shows_rotation=shows_rotation), *select_time_span(limits, *time_span))


def select_time_span(limits: Vec2, start: float | None, stop: float | None) -> Vec2:
    """Return the validated start and end (s) of the shown part within the times of the runs (s)."""
    first, last = limits
    begin = first if start is None else start
    end = last if stop is None else stop
    if begin == end and first < last:
        raise FilmOptionError(
            "{start} and {stop} are both {found:g} s; a film shows what happens between two times within {first:g}..{last:g} s",
            found=begin,
            first=first,
            last=last,
        )
    if not first <= begin <= end <= last:
        raise FilmOptionError(
            "{start} and {stop} must lie within the run, {first:g}..{last:g} s, in this order; got {begin:g} and {end:g} s",
            first=first,
            last=last,
            begin=begin,
            end=end,
        )
    return begin, end


def select_slow_down(limits: Vec2, time_span: Vec2, requested: float | None, longest_true_time: float = MAX_TRUE_TIME_DURATION) -> float:
    """Return the validated slow-down factor, as requested or chosen from the duration.

    `limits` are the times of the runs (s); runs of up to `longest_true_time` (s) are shown in true time.
    """
    begin, end = time_span
    if requested is None:
        # If the whole run is shown in true time, so is any part of it, however short.
        return 1.0 if MIN_TRUE_TIME_DURATION <= limits[1] - limits[0] <= longest_true_time else choose_slow_down(end - begin)
    if (end - begin) * requested > MAX_SLOWED_FILM_DURATION:
        raise FilmOptionError(
            "{slow_down} {found:g} makes a film of {length:g} s; at most {most:g} s: show less by {start} and {stop}, or slow it less",
            found=requested,
            length=(end - begin) * requested,
            most=MAX_SLOWED_FILM_DURATION,
        )
    is_sped_up = begin < end and requested < 1.0
    if is_sped_up and (end - begin) * requested < MIN_SPED_FILM_DURATION:
        raise FilmOptionError(
            "{slow_down} {found:g} makes a film of {length:.3g} s; at least {least:g} s: take {slow_down} {factor:.3g} or more",
            found=requested,
            length=(end - begin) * requested,
            least=MIN_SPED_FILM_DURATION,
            factor=min(1.0, MIN_SPED_FILM_DURATION / (end - begin)),
        )
    return requested


def _slow_cranks(motions: Sequence[Motion], time_span: Vec2, factor: float, frame_rate: float, *, may_shorten: bool) -> Vec2:
    """Return the slow-down at which the fastest turn takes enough frames, and the end of the shown part (s)."""
    # A crank that gets faster needs less slowing if fewer of its turns are shown.
    # A part that may not be shortened is slowed to a film of at most MAX_FILM_DURATION.
    begin, end = time_span
    limit = math.inf
    while True:
        shown_end = min(end, begin + limit) if may_shorten else end
        turn_time = min((motion.turn_time(begin, shown_end) for motion in motions), default=math.inf)
        if turn_time * frame_rate * factor >= MIN_FRAMES_PER_TURN:
            return factor, shown_end
        slower = round_step(1.01 * factor, 1)
        if not may_shorten and (end - begin) * slower > MAX_FILM_DURATION:
            return factor, end
        factor = slower
        limit = MAX_TURNING_FILM_DURATION / factor


def select_room_timing(run: Trajectory, start: float | None, stop: float | None, slow_down: float | None) -> Timing:
    """Return what the film of an engine room shows: by default in at most 10 s, sped up by a whole number."""
    limits = float(run.times[0]), float(run.times[-1])
    begin, end = time_span = select_time_span(limits, start, stop)
    if slow_down is None and end - begin > ENGINE_ROOM_FILM_DURATION:
        return Timing(time_span=time_span, slow_down=1.0 / math.ceil((end - begin) / ENGINE_ROOM_FILM_DURATION))
    return Timing(time_span=time_span, slow_down=select_slow_down(limits, time_span, slow_down))
