"""Implicit steps in independent coordinates, for stiff scenes: few numbers, and no joint in the way of the solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import Radau
from scipy.linalg import qr

from governor_mechanism.integrators.projected_dop853 import DONE, EXHAUSTED, STALLED
from governor_mechanism.mechanics.dynamics.equations_of_motion import EXTRA, project, slope_of
from governor_mechanism.mechanics.dynamics.lowering import System, Workspace
from governor_mechanism.mechanics.kinematics.constraint_kernels import gradients_of
from governor_mechanism.numerics.least_squares import INDEPENDENT
from governor_mechanism.types import FloatArray, IntArray

DIFFERENCE = 1e-7
"""Of a coordinate or its scale: the step of differences, between rounding and curvature."""

POOR = 1e-3
"""Where the dependent coordinates would move more than 1/POOR times as fast as the chosen ones, others are chosen."""


@dataclass
class _Chart:
    """Which coordinates stand for all of them, and the poses from which the others are found."""

    system: System
    chosen: IntArray
    poses: FloatArray


class Implicit:
    """Steps one system by Radau IIA of order 5 with error control; `scale` as in `dop853.integrate`."""

    def __init__(self, system: System, room: Workspace, scale: FloatArray, closed: float) -> None:
        self._system, self._room, self._scale, self._closed = system, room, scale, closed
        self._count = len(system.bodies)
        self.evaluations = self.steps = 0

    def integrate(
        self,
        cubics: FloatArray,
        span: tuple[float, float],
        since: float,
        times: FloatArray,
        state: FloatArray,
        tolerance: float,
        most: int,
        found: FloatArray,
    ) -> tuple[int, float, int]:
        """As `dop853.integrate`; the cubics count from `since` (s). How it ended, last step, times reached."""
        now, end = span
        step, reached = (end - now) * 1e-3, 0
        while now < end:
            chart = self._chart(state)
            solver = Radau(
                lambda time, z, chart=chart: self._slope(chart, cubics, time - since, z),
                now,
                self._reduced(chart, state),
                end,
                jac=lambda time, z, chart=chart: self._jacobian(chart, cubics, time - since, z),
                first_step=min(step, end - now),
                rtol=max(tolerance, 2.3e-14),
                atol=tolerance * self._reduced(chart, self._scale),
            )
            while solver.status == "running":
                if self.steps >= most:
                    return EXHAUSTED, step, reached
                solver.step()
                if solver.status == "failed":
                    return STALLED, step, reached
                self.steps += 1
                dense = solver.dense_output()
                while reached < times.size and times[reached] <= solver.t:
                    found[reached] = self._whole(chart, cubics, times[reached] - since, dense(times[reached]))
                    reached += 1
                now, step = solver.t, solver.step_size or step
                state[:] = self._whole(chart, cubics, now - since, solver.y)
                chart.poses = state[: 3 * self._count].reshape(-1, 3).copy()
                if self._poor(chart):
                    break
        return DONE, step, reached

    def _chart(self, state: FloatArray) -> _Chart:
        """The coordinates along which the mechanism moves most freely: those the joints' equations pivot last."""
        poses = state[: 3 * self._count].reshape(-1, 3).copy()
        free, rows = self._free(), self._weighted(poses)
        chosen = free
        if len(rows):
            _, triangle, order = qr(rows, mode="economic", pivoting=True)
            diagonal = np.abs(np.diag(triangle))
            chosen = np.sort(free[order[np.sum(diagonal > INDEPENDENT * diagonal[0]) :]])
        held = self._system.inverse_mass.copy()
        held.ravel()[chosen] = 0.0  # a projection leaves these as they are
        return _Chart(self._system._replace(inverse_mass=held), chosen, poses)

    def _free(self) -> IntArray:
        """Coordinates that can change, among all (3 bodies)."""
        return np.flatnonzero(self._system.inverse_mass.ravel() > 0.0)

    def _weighted(self, poses: FloatArray) -> FloatArray:
        """Joint equations by the free coordinates, each in units of its scale."""
        rows, free = gradients_of(self._system.rows, poses[np.newaxis])[0], self._free()
        weighted: FloatArray = rows.reshape(len(rows), poses.size)[:, free] * self._scale[free]
        return weighted

    def _poor(self, chart: _Chart) -> bool:
        dependent = self._weighted(chart.poses)[:, ~np.isin(self._free(), chart.chosen)]
        values = np.linalg.svd(dependent, compute_uv=False)
        return bool(values.size and values[-1] < POOR * values[0])

    def _reduced(self, chart: _Chart, state: FloatArray) -> FloatArray:
        whole = 3 * self._count
        return np.concatenate([state[chart.chosen], state[whole + chart.chosen], state[-EXTRA:]])

    def _whole(self, chart: _Chart, cubics: FloatArray, since: float, z: FloatArray) -> FloatArray:
        """The state of all bodies, joints closed, that the chosen coordinates and their speeds stand for."""
        whole, many = 3 * self._count, len(chart.chosen)
        poses, velocities = chart.poses.copy(), np.zeros_like(chart.poses)
        poses.ravel()[chart.chosen], velocities.ravel()[chart.chosen] = z[:many], z[many : 2 * many]
        project(chart.system, self._room, cubics, since, poses, velocities, self._closed)
        state = np.empty(2 * whole + EXTRA)
        state[:whole], state[whole : 2 * whole], state[-EXTRA:] = poses.ravel(), velocities.ravel(), z[-EXTRA:]
        return state

    def _jacobian(self, chart: _Chart, cubics: FloatArray, since: float, z: FloatArray) -> FloatArray:
        """Derivatives of the slope by differences; work and the spindle's angle act on nothing."""
        here = self._slope(chart, cubics, since, z)
        result = np.zeros((z.size, z.size))
        steps = DIFFERENCE * np.maximum(np.abs(z), self._reduced(chart, self._scale))
        for k in (*range(z.size - EXTRA), z.size - 1):
            beside = z.copy()
            beside[k] += steps[k]
            result[:, k] = (self._slope(chart, cubics, since, beside) - here) / (beside[k] - z[k])
        return result

    def _slope(self, chart: _Chart, cubics: FloatArray, since: float, z: FloatArray) -> FloatArray:
        state = self._whole(chart, cubics, since, z)
        self.evaluations += 1
        return self._reduced(chart, slope_of(self._system, self._room, cubics, since, state))
