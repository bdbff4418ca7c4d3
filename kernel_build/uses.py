"""Short calculations that together call every kernel that Python calls, with the types with which it always does."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

import governor_mechanism as gm
from governor_mechanism.engines import select_engine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.engine import MultibodyEngine, MultibodyRunner
from governor_mechanism.engines.multibody.implicit import RadauLimits
from governor_mechanism.mechanics.curves.outline_kernels import least_depth
from governor_mechanism.mechanics.curves.segments import evaluate_curve, evaluate_polar_curve, make_curve_segments
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, from_mass_centres, make_system_workspace
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.event_functions import evaluate_event_functions
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.mechanics.reduction.equation_of_motion import evaluate_state_rates
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.model.joints import CurveSlot
from governor_mechanism.numerics.hermite_curve import HermiteCurve
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.scene_dynamics import SceneDynamics

SHORT, STRIKING = (0.0, 0.01), (0.0, 0.05)
"""Reported times of a run without contacts, and of one that strikes a stop, s."""

STRIKING_GOVERNOR = {
    "machine": "pendulum_governor",
    "dimensions": {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0},
    "effects": {
        "gravity": True,
        "centrifugal": True,
        "dashpot": {"arm_angle": 0.5},
        "dry_friction": {"sleeve": 10.0},
        "stops": {"arm_angle": [0.5, 0.8], "restitution": 0.0},
    },
    "spindle": {"speed": 6.0},
    "start": {"arm_angle": 0.505},
    "run": {"duration": 0.05, "accuracy": 1e-4},
}
"""A governor that strikes its stop and rests on it: its contacts need all rules."""


def run(engine: str, model: str, times: tuple[float, ...] = SHORT, accuracy: float | None = None) -> tuple[object, ...]:
    """Run a shipped scene, and return what is computed after a run only when it is read."""
    return read_results(gm.run(model, engine=engine, times=times, accuracy=accuracy))


def strike_stop(engine: str, accuracy: float) -> tuple[object, ...]:
    """Run a governor that falls on its stop."""
    scene = parse_scene_document(STRIKING_GOVERNOR)
    return read_results(select_engine(engine, scene, None)[0].run(scene, times=STRIKING, accuracy=accuracy))


def read_results(trajectory: gm.Trajectory) -> tuple[object, ...]:
    """Return what is computed only when it is read."""
    return trajectory.events, trajectory.reactions, trajectory.energy


RESTING_BALL = {
    "machine": "custom",
    "size": 0.1,
    "body": [
        {"name": "floor", "mass": 1.0, "inertia": 1.0, "outline": [[-1, -0.5], [1, -0.5], [1, 0], [-1, 0]]},
        {"name": "ball", "mass": 1.0, "point": True, "at": [0, 0.02]},
    ],
    "joint": [{"type": "weld", "first": "ground.origin", "second": "floor.origin"}],
    "contact": [{"name": "ball", "first": "ball.origin", "radius": 0.02, "second": "floor"}],
    "readings": {"y": {"y": "ball.origin"}},
    "effects": {"gravity": True},
    "start": {"ball_gap": 0, "ball_rate": 0},
    "run": {"duration": 0.01},
}
"""A ball that rests on a floor: engine `impulse` looks whether it comes to another edge."""


def rest_on_outline() -> tuple[object, ...]:
    """Run a ball that rests on an outline."""
    scene = parse_scene_document(RESTING_BALL)
    return read_results(select_engine("impulse", scene, None)[0].run(scene, times=SHORT, accuracy=1e-1))


def integrate_implicitly() -> None:
    """Take a step with the method for stiff motion."""
    scene = gm.load("stiff_flyball")
    request = RunRequest(times=np.array(SHORT), accuracy=1e-3, certify=False, reason="asked for")
    integrator = MultibodyRunner(MultibodyEngine(), scene, request).integrator
    state, cubics = integrator.initial_state, integrator.input_cubics(0.0)
    outputs = np.empty((0, state.size))
    implicit = integrator.make_implicit_integrator()
    implicit.integrate(cubics, (0.0, 1e-9), outputs[:, 0], state, RadauLimits(1.0, 1e-9, 1), outputs)


def start_with_friction() -> None:
    """Choose which parts rub at the start of a run, and check the forces between them."""
    scene = gm.load("graham_escapement")
    request = RunRequest(times=np.array(SHORT), accuracy=1e-3, certify=False, reason="asked for")
    integrator = MultibodyRunner(MultibodyEngine(), scene, request).integrator
    if integrator.scene_contacts is not None:
        integrator.scene_contacts.start(integrator.initial_state.copy(), integrator.input_cubics(0.0))


def accelerate_coordinates() -> None:
    """Evaluate the accelerations of independent coordinates, as the search for an equilibrium of several does."""
    scene = gm.load("porter")
    dynamics = SceneDynamics(scene, *initial_state(scene))
    dynamics.accelerations(dynamics.start[np.newaxis], dynamics.start_rates[np.newaxis])
    dynamics.poses(dynamics.start)


def accelerate_coordinate() -> None:
    """Evaluate the acceleration of one coordinate on its motion table, as the tests of the equations of motion do."""
    scene = gm.load("porter")
    angle = float(scene.start.values["arm_angle"])
    motion = MotionTable(scene, angle, initial_state(scene)[0])
    cubics = stack_local_cubics(motion.time_functions, np.array([0.0]))[0]
    evaluate_state_rates(motion.model.on_table(motion.table, cubics, np.array([0])), 0, -1.0, 0.0, 0.0, 0.0, 0.0, True)


def accelerate_bodies() -> None:
    """Evaluate the derivative of the state of all bodies and its event functions, as the tests of the equations of motion do."""
    scene = gm.load("porter_dry_friction")
    system, functions = make_system(scene, ContactMode((None,), (1,)))
    motion = [part.ravel() for part in from_mass_centres(system, *initial_state(scene))]
    state, workspace = np.concatenate([*motion, np.zeros(N_ENERGY_STATES)]), make_system_workspace(system)
    cubics = stack_local_cubics(functions, np.array([0.0]))[0]
    evaluate_state_derivative(system, workspace, cubics, 0.0, state, np.empty_like(state))
    evaluate_event_functions(system, workspace, state, np.empty(len(system.event_functions)), 0)


def follow_curve() -> None:
    """Locate a point on a curve, as the joint of a point on a curve does at every step."""
    (curve, *_) = (joint.curve for joint in gm.load("parabolic").mechanism.joints if isinstance(joint, CurveSlot))
    segments = make_curve_segments(curve)
    evaluate_curve(segments, 0, len(segments), 0.1)
    evaluate_polar_curve(segments, 0, len(segments), 0.1)


def look_behind_outline() -> None:
    """Look how deep the inside of an outline is, as every lowering of a contact with hollow corners does."""
    least_depth(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0]]), np.array([[0.5, 0.5]]))


def find_roots_between_samples() -> None:
    """Find a root of a curve through samples, as the search for events does."""
    places = np.array([0.0, 1.0, 2.0])
    curve = HermiteCurve(places, places - 0.5, np.ones(3), np.zeros(3))
    root = curve.find_crossings(0.0, np.array([0]), 2, places[:1], places[1:2], 1e-9)
    curve.evaluate(np.array([0]), 2, root)


USES: Mapping[str, Callable[[], object]] = {
    "reduced": partial(run, "reduced", "porter"),
    "reduced, contacts": partial(strike_stop, "reduced", 1e-3),
    "reduced, gas in cylinders": partial(run, "reduced", "air_engine"),
    "multibody": partial(run, "multibody", "porter"),
    "multibody, contacts": partial(strike_stop, "multibody", 1e-1),
    "multibody, friction of contacts": start_with_friction,
    "multibody, gas in cylinders": partial(run, "multibody", "air_engine"),
    "multibody, stiff": integrate_implicitly,
    "impulse, contacts": partial(run, "impulse", "porter_cyclic", (0.0, 0.15), 1e-1),
    "impulse, outlines": rest_on_outline,
    "impulse, point on a curve": follow_curve,
    "inside of outlines": look_behind_outline,
    "equilibria": partial(gm.equilibria, "porter"),
    "equilibria with several coordinates": accelerate_coordinates,
    "equation of motion of one coordinate": accelerate_coordinate,
    "equations of motion of all bodies": accelerate_bodies,
    "events between samples": find_roots_between_samples,
    "kinematics": partial(gm.kinematics, "porter", "arm_angle", [0.5, 0.6]),
}
