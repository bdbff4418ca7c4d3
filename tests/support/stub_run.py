"""Runs built from geometry, so that drawings can be tested without an engine."""

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.part import Part, Spindle, Start
from governor_mechanism.model.results.records import Cost, Energy, Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import RunSettings, Scene

GOVERNOR_DIMENSIONS = {
    "porter": dict(arm=0.3, offset=0.04, ball_mass=5.0, sleeve_mass=20.0),
    "watt": dict(arm=0.4, ball_mass=1.0),
    "crossed": dict(arm=0.4, offset=-0.06, ball_mass=2.0, sleeve_mass=8.0),
    "extended": dict(arm=0.4, arm_joint=0.25, offset=0.03, ball_mass=3.0, sleeve_mass=30.0),
    "uncrossed links": dict(arm=0.4, arm_joint=0.25, offset=-0.04, lug_offset=0.03, link=0.2, ball_mass=3.0, sleeve_mass=12.0),
}
"""Dimensions in SI."""


FAKE_COST = Cost(engine="reduced", reason="", step=0.01, steps=10, runs=2, iterations=0, evaluations={}, wall_time=0.0)


def sleeve_height(governor: PendulumGovernor, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the sleeve's lugs (m) at arm angles (n,)."""
    reach = governor.offset + governor.joint_length * np.sin(angle) - governor.lug_distance
    height: NDArray[np.float64] = -governor.joint_length * np.cos(angle) - np.sqrt(governor.link_length**2 - reach**2)
    return height


def sleeve_lift(governor: PendulumGovernor, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sleeve lift (m) at arm angles (n,), from the zero of the machine."""
    lift = governor.mechanism().reading("sleeve_lift")
    return sleeve_height(governor, angle) - lift.zero


def governor_poses(governor: PendulumGovernor, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses (n, bodies, 3) at arm angles (n,)."""
    x, y = governor.offset + governor.arm * np.sin(angle), -governor.arm * np.cos(angle)
    can_rotate = governor.mechanism().bodies[0].can_rotate
    right, left = (angle - np.pi / 2, -np.pi / 2 - angle) if can_rotate else (0 * angle, 0 * angle)
    columns = [(x, y, right), (-x, y, left)]
    if governor.sleeve_mass is not None:
        columns.append((0 * angle, sleeve_height(governor, angle), 0 * angle))
    return np.stack([np.stack(column, axis=-1) for column in columns], axis=1)


def governor_scene_of(governor: PendulumGovernor, title: str, speed: float, settings: RunSettings, angle: float) -> Scene:
    """A scene of one governor that starts at an arm angle (rad) and turns at a speed (rad/s)."""
    part = Part(
        name="governor",
        machine=governor.name,
        dimensions=governor.dimensions(),
        mechanism=governor.mechanism(),
        plane=governor.plane,
        effects=(Gravity(), Centrifugal()),
        spindle=Spindle(speeds=(speed,)),
        start=Start(values={"arm_angle": angle}),
    )
    return Scene(title=title, parts=(part,), run=settings)


def fake_run(
    dimensions: dict[str, float],
    *,
    title: str = "Porter governor, Zehnder 1877, Fig. 1",
    duration: float = 10.0,
    output_interval: float = 0.01,
    mean_angle: float = 40.0,
    amplitude: float = 8.0,
    speed: float = 2 * np.pi * 2.0,
    outcome: Outcome = Outcome.DONE,
    error_estimate: float | None = 3.1e-7,
) -> Trajectory:
    """Return a run whose arms swing by `amplitude` about `mean_angle` (deg) in 1.7 s, at about `speed` (rad/s) of the spindle."""
    governor = PendulumGovernor(**dimensions)
    times = np.linspace(0.0, duration, round(duration / output_interval) + 1)
    rate = 2 * np.pi / 1.7
    angle = np.radians(mean_angle + amplitude * np.sin(rate * times))
    angle_rate = np.radians(amplitude) * rate * np.cos(rate * times)
    poses = governor_poses(governor, angle)
    small = 1e-6
    velocities = (governor_poses(governor, angle + small) - poses) / small * angle_rate[:, None, None]
    readings = {
        "arm_angle": angle,
        "ball_radius": poses[:, 0, 0],
        "sleeve_lift": sleeve_lift(governor, angle),
        "spindle_speed": speed * (1 + 0.03 * np.sin(0.5 * rate * times)),
        "spindle_torque": 3.0 * angle_rate,
    }
    scene = governor_scene_of(governor, title, speed, RunSettings(duration=duration, output_interval=output_interval), float(angle[0]))
    zero = np.zeros(len(times))
    return Trajectory(
        scene=scene,
        times=times,
        poses=poses,
        velocities=velocities,
        readings=readings,
        rates={},
        units=dict(arm_angle="rad", ball_radius="m", sleeve_lift="m", spindle_speed="rad/s", spindle_torque="N m"),
        scales={name: 1.0 for name in readings},
        joint_gap=1e-13 * (1 + np.sin(7 * times) ** 2),
        energy=Energy(
            kinetic=zero, potential=zero, rotation=zero, jacobi=50 + 1e-11 * np.sin(3 * times), dissipated_energy=zero, scale=50.0
        ),
        outcome=outcome,
        cost=FAKE_COST,
        error_estimate=error_estimate,
    )
