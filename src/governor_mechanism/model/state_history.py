"""What an engine finds: a motion at some times."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.types import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class StateHistory:
    """What an engine found at n times: poses and velocities (n, bodies, 3), work (n,) J, spindle (n, 2).

    work is what changes of a given spindle speed have put in, less what drives, loads and torque have; lost (n,) J is
    what brakes, friction and stops have taken, and is part of it; spindle holds the angle (rad) and speed (rad/s) of
    the spindle.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    work: FloatArray
    dissipated_energy: FloatArray
    spindle_state: FloatArray

    def at(self, indices: slice | IntArray) -> StateHistory:
        """The state at some of the times."""
        arrays = (self.times, self.poses, self.velocities, self.work, self.dissipated_energy, self.spindle_state)
        times, poses, velocities, work, dissipated_energy, spindle_state = (array[indices] for array in arrays)
        return StateHistory(
            times=times, poses=poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, spindle_state=spindle_state
        )

    def first(self, count: int) -> StateHistory:
        """The state at the first so many times."""
        return self.at(slice(count))
