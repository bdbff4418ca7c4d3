"""What an engine finds: a motion at some times."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.types import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class State:
    """What an engine found at n times: poses and velocities (n, bodies, 3), work (n,) J, spindle (n, 2).

    work is what changes of a given spindle speed have put in, less what drives, loads and torque have; lost (n,) J is
    what brakes, friction and stops have taken, and is part of it; spindle holds the angle (rad) and speed (rad/s) of
    the spindle.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    work: FloatArray
    lost: FloatArray
    spindle: FloatArray

    def at(self, which: slice | IntArray) -> State:
        """The state at some of the times."""
        parts = (self.times, self.poses, self.velocities, self.work, self.lost, self.spindle)
        times, poses, velocities, work, lost, spindle = (part[which] for part in parts)
        return State(times=times, poses=poses, velocities=velocities, work=work, lost=lost, spindle=spindle)

    def first(self, count: int) -> State:
        """The state at the first so many times."""
        return self.at(slice(count))
