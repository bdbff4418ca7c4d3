"""Which part of a run a film shows, and how fast: true time, slowed for fast cranks, and closed on whole periods where there are any."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.model.results.film_options import FilmOptionError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.periodic_motion import MIN_FRAMES_PER_TURN, Motion, last_whole_period, motions_of
from governor_mechanism.render.geometry.primitives import Vec2, round_step

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
    """Return the slow-down factor for a duration (s): 1 from 1 to 60 s, else a factor that gives a film of 4 to 20 s.

    The factor or its reciprocal is 1, 2 or 5 x 10^n.
    """
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
    begin, end = (first if start is None else start), (last if stop is None else stop)
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
    """Return the slow-down at which the fastest turn takes enough frames, and the end of the shown part (s).

    A crank that gets faster needs less slowing if fewer of its turns are shown. A part that may not be shortened is slowed to a film of at
    most MAX_FILM_DURATION.
    """
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
