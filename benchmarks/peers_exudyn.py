"""Cases of `peers.py` for Exudyn: points, one-coordinate masses, and distance constraints for arms and links.

With arms as one-coordinate rotors, so that only the links are distances, errors are the same and a step costs a tenth more.
The centrifugal force is a spring of negative stiffness between the balls in the rotating plane. If the speed changes, the stiffness
is set before every step, which costs less than a force function in Python; no compiled element does it.

A new Jacobian at every step is faster than one kept as long as it converges, and than one at every iteration. The dense solver is
faster than the sparse one. Looser Newton tolerances are visible in the errors. The explicit integrators accept no distance
constraints. Friction is modelled by bristles or by a smooth law; neither holds a sleeve exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import exudyn
import exudyn.itemInterface
import numpy as np

from governor_mechanism.types import FloatArray
from peers_cases import GRAVITY, INTERVALS, Case, Governor, Method, SliderCrank

ExudynModel = tuple[int, Callable[[FloatArray], FloatArray], Callable[[], None]]
"""Sensor, function from its coordinates to the angle, and function to call before a run."""

item = exudyn.itemInterface
exudyn.SetWriteToConsole(False)

VERSION = f"Exudyn {exudyn.GetVersionString().split()[0]}"
LADDER = tuple(2**k for k in range(13))

BRISTLE_STIFFNESS, BRISTLE_DAMPING = 1e8, 4e4
"""Stiffness (N/m) and damping (N s/m) of the bristles: among the best of 1e5 to 1e9 N/m and 0 to critical damping."""

SMOOTHING_ACCELERATION = 0.1
"""Acceleration (m/s2); friction is proportional to speeds below the step times this value. At a tenth of it Newton fails."""

QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Rotation of the line of a one-coordinate mass from x to y."""


def methods(case: Case) -> tuple[Method, ...]:
    """Return both implicit integrators."""
    solvers = {
        "generalised alpha, index 3": exudyn.DynamicSolverType.GeneralizedAlpha,
        "trapezoidal, index 2": exudyn.DynamicSolverType.TrapezoidalIndex2,
    }
    rubs = isinstance(case.model, Governor) and case.model.friction > 0
    held = {"; bristles": False, "; smooth friction": True} if rubs else {"": False}
    return tuple(
        Method(name=f"Exudyn, {name}{how}", prepare=partial(prepare_run, case, solver, smooth), ladder=LADDER)
        for how, smooth in held.items()
        for name, solver in solvers.items()
    )


def prepare_run(case: Case, solver: Any, smooth: bool, steps: int) -> Callable[[], FloatArray]:
    """Return the assembled system and its solver call."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    if isinstance(case.model, SliderCrank):
        made = build_slider_crank(system, case.model)
    else:
        made = build_governor(system, case.model, SMOOTHING_ACCELERATION * case.interval / steps if smooth else 0.0)
    sensor, read, begin = made
    system.Assemble()
    settings = solver_settings(case, steps)

    def run() -> FloatArray:
        """Run once and return the angles."""
        begin()
        try:
            done = system.SolveDynamic(settings, solverType=solver, updateInitialValues=False, storeSolver=False, showHints=False)
        except Exception as error:
            # Its exception type is not public in every version.
            raise ArithmeticError(str(error)) from error
        samples = system.GetSensorStoredData(sensor)
        if not done or len(samples) != INTERVALS + 1:
            raise ArithmeticError("Newton's iterations failed")
        return read(samples[:, 1:])

    # The container owns the system and must outlive it.
    run.container = container  # type: ignore[attr-defined]
    return run


def solver_settings(case: Case, steps: int) -> Any:
    """Return fixed-step settings without output to files or console."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = case.interval
    settings.linearSolver.solverType = exudyn.LinearSolverType.EXUdense
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = INTERVALS * steps, case.scene.run.duration
    integration.verboseMode, integration.adaptiveStep = 0, False
    integration.newton.useModifiedNewton = True
    integration.newton.modifiedNewtonJacUpdatePerStep = True
    return settings


def build_governor(system: Any, shape: Governor, zone: float) -> ExudynModel:
    """Build four distances, a mass on the axis, two points."""
    across, down = shape.arm * math.sin(shape.angle), -shape.arm * math.cos(shape.angle)
    ground = system.AddObject(item.ObjectGround())
    sleeve_node = system.AddNode(item.Node1D(referenceCoordinates=[0.0]))
    sleeve = system.AddObject(
        item.ObjectMass1D(
            mass=shape.sleeve_mass, nodeNumber=sleeve_node, referencePosition=[0, 2 * down, 0],
            referenceRotation=QUARTER_TURN,
        )
    )  # fmt: skip
    lift = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=sleeve_node, coordinate=0))
    system.AddLoad(item.LoadCoordinate(markerNumber=lift, load=-shape.sleeve_mass * GRAVITY))
    outward, nodes = [], []
    for side in (1, -1):
        node = system.AddNode(item.NodePoint2D(referenceCoordinates=[side * (shape.offset + across), down]))
        nodes.append(node)
        ball = system.AddObject(item.ObjectMassPoint2D(mass=shape.ball_mass, nodeNumber=node))
        centre = system.AddMarker(item.MarkerBodyPosition(bodyNumber=ball))
        height = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
        system.AddLoad(item.LoadCoordinate(markerNumber=height, load=-shape.ball_mass * GRAVITY))
        outward.append(system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=0)))
        # The local x axis of a one-coordinate body along y is y.
        for body, place in ((ground, [side * shape.offset, 0, 0]), (sleeve, [0, -side * shape.offset, 0])):
            end = system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=place))
            system.AddObject(item.DistanceConstraint(markerNumbers=[end, centre], distance=shape.arm))
    apart = 2 * (shape.offset + across)
    pull = system.AddObject(
        item.CoordinateSpringDamper(markerNumbers=outward[::-1], stiffness=centrifugal_stiffness(shape, 0.0), offset=-apart)
    )
    if len(shape.speeds) > 1:

        def turn(system: Any, time: float) -> bool:
            # An implicit step evaluates the forces at its end.
            system.SetObjectParameter(pull, "stiffness", centrifugal_stiffness(shape, time))
            return True

        system.SetPreStepUserFunction(turn)
    if shape.friction:
        add_friction(system, lift, shape.friction, zone)
    sensor = system.AddSensor(
        item.SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=exudyn.OutputVariableType.Coordinates)
    )

    def begin() -> None:
        # Reset the stiffness, which has the value of the end of the last run.
        """Set the initial values."""
        system.SetObjectParameter(pull, "stiffness", centrifugal_stiffness(shape, 0.0))

    return sensor, lambda samples: np.arctan2(across + samples[:, 0], -down - samples[:, 1]), begin


def centrifugal_stiffness(shape: Governor, time: float) -> float:
    """Return the stiffness of the spring between the balls (N/m)."""
    speed = shape.speeds[0][1]
    for (begin, low), (end, high) in pairwise(shape.speeds):
        if begin < end and time > begin:
            speed = low + (high - low) * min((time - begin) / (end - begin), 1.0)
    return -0.5 * shape.ball_mass * speed**2


def add_friction(system: Any, marker: int, force: float, zone: float) -> None:
    """Add bristles that hold up to a force, or, with a zone (m/s), friction proportional to lower speeds."""
    still = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))
    keys: dict[str, Any] = {"frictionProportionalZone": zone}
    if not zone:
        memory = system.AddNode(item.NodeGenericData(initialCoordinates=[0, 0, 0], numberOfDataCoordinates=3))
        keys = {"nodeNumber": memory, "stickingStiffness": BRISTLE_STIFFNESS, "stickingDamping": BRISTLE_DAMPING}
    system.AddObject(item.CoordinateSpringDamperExt(markerNumbers=[still, marker], dynamicFrictionForce=force, **keys))


def build_slider_crank(system: Any, shape: SliderCrank) -> ExudynModel:
    """Build a rotor, a mass on a line, and a distance between them."""
    cosine, sine = math.cos(shape.angle), math.sin(shape.angle)
    start = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    turn = system.AddNode(item.Node1D(referenceCoordinates=[0.0], initialCoordinates=[0.0], initialVelocities=[shape.rate]))
    flywheel = system.AddObject(
        item.ObjectRotationalMass1D(
            inertia=shape.flywheel_inertia + shape.flywheel_mass * shape.centre**2, nodeNumber=turn,
            referenceRotation=start,
        )
    )  # fmt: skip
    centre = system.AddMarker(item.MarkerBodyPosition(bodyNumber=flywheel, localPosition=[shape.centre, 0, 0]))
    system.AddLoad(item.Force(markerNumber=centre, loadVector=[0, -shape.flywheel_mass * GRAVITY, 0]))
    slide = system.AddNode(item.Node1D(referenceCoordinates=[0.0], initialCoordinates=[0.0], initialVelocities=[shape.slider_rate]))
    slider = system.AddObject(item.ObjectMass1D(mass=shape.slider_mass, nodeNumber=slide, referencePosition=[shape.slider, 0, 0]))
    push = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=slide, coordinate=0))
    system.AddLoad(item.LoadCoordinate(markerNumber=push, load=shape.force))
    ends = [
        system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=place))
        for body, place in ((flywheel, [shape.crank, 0, 0]), (slider, [0, 0, 0]))
    ]
    system.AddObject(item.DistanceConstraint(markerNumbers=ends, distance=shape.rod))
    sensor = add_sensor(system, turn)
    return sensor, lambda samples: shape.angle + samples[:, 0], lambda: None


def add_sensor(system: Any, node: int) -> int:
    """Add a sensor that stores the coordinates of a node."""
    kind = exudyn.OutputVariableType.Coordinates
    sensor: int = system.AddSensor(item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))
    return sensor
