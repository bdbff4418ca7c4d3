"""The state of a motion at one time, from which another run starts. Frozen values."""

from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.units.text_table import short_repr

Row = tuple[float, float, float]
"""Pose of a body, m and rad, or its rate."""


@dataclass(frozen=True, kw_only=True)
class MotionState:
    """State of a motion at one time, as `Trajectory.state` returns it; `gm.run(scene, start=state)` goes on from it.

    Which contacts hold or slide, and which springs are taut, follows from poses, velocities and loads.

    Attributes
    ----------
    time
        Time on the clock of the scene, s: what the scene prescribes over time goes on from there.
    bodies
        Names of the bodies.
    poses
        Position (m) of the mass centre and angle (rad) of each body.
    velocities
        Their rates, m/s and rad/s.
    lags
        States of first-order lags and of held inputs.
    """

    time: float
    bodies: tuple[str, ...]
    poses: tuple[Row, ...]
    velocities: tuple[Row, ...]
    lags: tuple[float, ...] = ()

    __repr__ = short_repr

    def __post_init__(self) -> None:
        require_finite(self.time, "s", "time of a state")
        for what, rows in (("poses", self.poses), ("velocities", self.velocities)):
            if len(rows) != len(self.bodies) or any(len(row) != 3 for row in rows):
                raise MechanismError(f"{what} of a state are three numbers for each of its {len(self.bodies)} bodies")
            for number in (number for row in rows for number in row):
                require_finite(number, "", f"number in the {what} of a state")

    def motion_of(self, names: Sequence[str]) -> tuple[list[Row], list[Row]]:
        """Return poses and velocities of bodies in a given order.

        Parameters
        ----------
        names
            Names of the bodies.

        Returns
        -------
        poses : list[Row]
            Poses, m and rad.
        velocities : list[Row]
            Their rates.

        Raises
        ------
        MechanismError
            If the state has other bodies.
        """
        missing = [name for name in names if name not in self.bodies]
        if missing or len(names) != len(self.bodies):
            raise MechanismError(
                f"the state to start from is one of the bodies {list(self.bodies)}, and the scene has {list(names)}; "
                "take a state of a run of this scene, or of one that differs in its numbers alone"
            )
        indices = [self.bodies.index(name) for name in names]
        return [self.poses[k] for k in indices], [self.velocities[k] for k in indices]
