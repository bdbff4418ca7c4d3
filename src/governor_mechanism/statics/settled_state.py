"""The steady state of a scene near given poses."""

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.scene_dynamics import SceneDynamics
from governor_mechanism.statics.steady_state import SteadyState, find_steady_state
from governor_mechanism.types import FloatArray

MAX_RESTARTS = 12
"""Largest number of restarts of Newton's method, each with other independent coordinates and slack springs."""

RELAXATION_STEP = 0.1
"""Displacement along the accelerations, in scales, before a restart: where Newton's method stalls, the forces lead to an equilibrium."""

NO_STEADY_STATE = (
    "no steady state was found near the start: accelerations remain; start nearer to an equilibrium or a steady rotation. "
    "If a torque depends on the angle of a turning shaft, its steady state is periodic: use the mean torque"
)


def settle(
    scene: Scene,
    poses: FloatArray,  # assembled poses near the steady state; shape (bodies, 3)
    # their time derivatives, of which those of steadily turning shafts matter; shape (bodies, 3)
    velocities: FloatArray,
    time: float | None = None,  # time at which inputs are taken, s; that of their last change if None
) -> tuple[SceneDynamics, SteadyState]:
    """Find the steady state near given poses; raise MechanismError if there is no steady state near the start, or it is periodic."""
    for _ in range(MAX_RESTARTS):
        dynamics = SceneDynamics(scene, poses, velocities, time)
        dynamics.require_no_uneven_turning()
        dynamics.set_contact_mode(dynamics.start, dynamics.start_rates)
        state = find_steady_state(dynamics.accelerations, dynamics.start, dynamics.start_rates, dynamics.scales, dynamics.time_scale)
        # Coordinates that describe the start well may not do so at the steady state, and springs may have become slack.
        if state.is_steady and dynamics.is_well_conditioned(state.z) and not dynamics.set_contact_mode(state.z, state.rates):
            return dynamics, state
        relaxed = state.z if state.is_steady else state.z + RELAXATION_STEP * state.direction_of_acceleration
        motions = [dynamics.mass_centre_motion(z, state.rates) for z in (relaxed, state.z)]
        poses, velocities = next(motion for motion in motions if np.all(np.isfinite(motion[0])))
    raise MechanismError(NO_STEADY_STATE)
