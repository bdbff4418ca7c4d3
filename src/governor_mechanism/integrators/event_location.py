"""Whether something that is watched rises above nought within a step, compiled."""

from __future__ import annotations

from governor_mechanism.mechanics.dynamics.equations_of_motion import slope
from governor_mechanism.mechanics.dynamics.lowering import System, Workspace
from governor_mechanism.mechanics.dynamics.output_forces import FORCE, PARTS, between, observe
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, IntArray

UNTOLD = 0.05
"""Of the spread of three values: by so much a summit between them may be higher than their parabola's."""


@kernel
def observed(
    system: System, room: Workspace, cubics: FloatArray, since: float, state: FloatArray, marks: FloatArray
) -> None:
    """What is watched, at a state whose slope was the last to be evaluated."""
    count = system.bodies.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    observe(system.gauges, system.watch, poses, velocities, cubics, since, room.vector, room.seen, room.leaning, marks)


@kernel
def crossing(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    since: float,
    h: float,
    state: FloatArray,
    slopes: FloatArray,
    ahead: FloatArray,
    slopes_ahead: FloatArray,
    trial: FloatArray,
    spare: FloatArray,
    marks: FloatArray,
    counts: IntArray,
) -> tuple[float, float]:
    """Between which parts of a step the first mark rises above nought; (2, 2) where none does.

    marks (PARTS, watches) are known at both ends. Something that begins at nought, as a body that has just left a
    stop, must have been below it first, unless it rises at once.
    """
    watch, last, count = system.watch, PARTS.size - 1, 3 * system.bodies.size
    forces = False
    for i in range(watch.size):
        forces = forces or watch[i].kind == FORCE
    for j in range(1, last):
        between(state, slopes, ahead, slopes_ahead, count, h, PARTS[j], trial)
        if forces:
            slope(system, room, cubics, since + PARTS[j] * h, trial, spare)
            counts[2] += 1
        observed(system, room, cubics, since + PARTS[j] * h, trial, marks[j])
    low = high = 2.0
    for i in range(watch.size):
        tiny = watch[i].tiny
        armed = marks[0, i] < -tiny
        for j in range(1, last + 1):
            if marks[j, i] > (0.0 if armed else tiny):
                if PARTS[j] < high:
                    low, high = PARTS[j - 1], PARTS[j]
                break
            armed = armed or marks[j, i] < -tiny
            if j == last or not armed:
                continue
            part, height = summit(PARTS[j], PARTS[1], marks[j - 1, i], marks[j, i], marks[j + 1, i])
            below_first = part > PARTS[j] or marks[j - 1, i] < -tiny
            if height > 0.0 and part < high and below_first and _rises(
                system, room, cubics, since, h, state, slopes, ahead, slopes_ahead, trial, spare, marks[last], i, part,
                forces, counts,
            ):  # fmt: skip
                low, high = (PARTS[j - 1] if part <= PARTS[j] else PARTS[j]), part
                break
    return low, high


@kernel
def summit(middle: float, apart: float, before: float, here: float, after: float) -> tuple[float, float]:
    """Where the parabola through three equally spaced values is highest between them, and how high it may be there.

    A little is added for what a parabola does not tell; no height where it has no summit there.
    """
    bend, slope = before - 2.0 * here + after, 0.5 * (after - before)
    if not bend < 0.0 or abs(slope) > -bend:
        return middle, -1.0
    spread = max(before, here, after) - min(before, here, after)
    return middle - apart * slope / bend, here - 0.5 * slope * slope / bend + UNTOLD * spread


@kernel
def _rises(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    since: float,
    h: float,
    state: FloatArray,
    slopes: FloatArray,
    ahead: FloatArray,
    slopes_ahead: FloatArray,
    trial: FloatArray,
    spare: FloatArray,
    ends: FloatArray,
    which: int,
    part: float,
    forces: bool,
    counts: IntArray,
) -> bool:
    """Whether a mark is above nought at a part of the step."""
    between(state, slopes, ahead, slopes_ahead, 3 * system.bodies.size, h, part, trial)
    if forces:
        slope(system, room, cubics, since + part * h, trial, spare)
        counts[2] += 1
    kept = ends.copy()
    observed(system, room, cubics, since + part * h, trial, kept)
    return bool(kept[which] > 0.0)
