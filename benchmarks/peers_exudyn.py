"""The cases of `peers.py` for Exudyn: points, masses of one coordinate, and distances for arms and links.

Arms as rotors of one coordinate, so that only the links are distances, give the same errors at a tenth more a step.
The centrifugal pull is a spring of negative stiffness between the balls in the plane that turns; where the speed
changes its stiffness is set before every step, which costs less than a force function in Python, and no compiled
element does it.

A new Jacobian at every step is quicker than one kept as long as it converges, and than one at every iteration; the
dense solver is quicker than the sparse one; looser Newton tolerances than these show in the errors. The explicit
integrators take no distances. What rubs has bristles, or friction made smooth: neither holds a sleeve exactly.
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

from peers_cases import GRAVITY, INTERVALS, Case, FloatArray, Governor, SliderCrank, Way

Made = tuple[int, Callable[[FloatArray], FloatArray], Callable[[], None]]
"""The sensor, what turns its coordinates into the angle, and what is to be set before a run."""

item = exudyn.itemInterface
exudyn.SetWriteToConsole(False)

VERSION = f"Exudyn {exudyn.GetVersionString().split()[0]}"
LADDER = tuple(2**k for k in range(13))

BRISTLES, BRISTLES_DAMPING = 1e8, 4e4
"""Stiffness (N/m) and damping (N s/m) of what holds a sleeve: among the best of 1e5 to 1e9 N/m, 0 to critical."""

ZONE = 0.1
"""Smooth friction is in proportion to speeds below the step times this (m/s2); with a tenth of it Newton fails."""

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Turns the line of a mass of one coordinate from x to y."""


def ways(case: Case) -> tuple[Way, ...]:
    """Both implicit integrators."""
    solvers = {
        "generalised alpha, index 3": exudyn.DynamicSolverType.GeneralizedAlpha,
        "trapezoidal, index 2": exudyn.DynamicSolverType.TrapezoidalIndex2,
    }
    rubs = isinstance(case.model, Governor) and case.model.friction > 0
    held = {"; bristles": False, "; smooth friction": True} if rubs else {"": False}
    return tuple(
        Way(name=f"Exudyn, {name}{how}", prepare=partial(prepared, case, solver, smooth), ladder=LADDER)
        for how, smooth in held.items()
        for name, solver in solvers.items()
    )


def prepared(case: Case, solver: Any, smooth: bool, steps: int) -> Callable[[], FloatArray]:
    """The system assembled, and what solves it."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    if isinstance(case.model, SliderCrank):
        made = slider_crank(system, case.model)
    else:
        made = governor(system, case.model, ZONE * case.interval / steps if smooth else 0.0)
    sensor, read, begin = made
    system.Assemble()
    settings = settings_of(case, steps)

    def run() -> FloatArray:
        begin()
        try:
            done = system.SolveDynamic(settings, solverType=solver, updateInitialValues=False, storeSolver=False, showHints=False)
        except Exception as error:
            # Its own kind of error is no public name in every version.
            raise ArithmeticError(str(error)) from error
        told = system.GetSensorStoredData(sensor)
        if not done or len(told) != INTERVALS + 1:
            raise ArithmeticError("Newton's iterations failed")
        return read(told[:, 1:])

    # The system lives in its container.
    run.container = container  # type: ignore[attr-defined]
    return run


def settings_of(case: Case, steps: int) -> Any:
    """Fixed steps, nothing written to files or to the console."""
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


def governor(system: Any, shape: Governor, zone: float) -> Made:
    """Four distances, a mass on the axis, two points."""
    across, down = shape.arm * math.sin(shape.angle), -shape.arm * math.cos(shape.angle)
    ground = system.AddObject(item.ObjectGround())
    sleeve_node = system.AddNode(item.Node1D(referenceCoordinates=[0.0]))
    sleeve = system.AddObject(
        item.ObjectMass1D(
            mass=shape.sleeve_mass, nodeNumber=sleeve_node, referencePosition=[0, 2 * down, 0],
            referenceRotation=QUARTER,
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
        # A body of one coordinate along y has its own x there.
        for body, place in ((ground, [side * shape.offset, 0, 0]), (sleeve, [0, -side * shape.offset, 0])):
            end = system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=place))
            system.AddObject(item.DistanceConstraint(markerNumbers=[end, centre], distance=shape.arm))
    apart = 2 * (shape.offset + across)
    pull = system.AddObject(item.CoordinateSpringDamper(markerNumbers=outward[::-1], stiffness=stiffness_at(shape, 0.0), offset=-apart))
    if len(shape.speeds) > 1:

        def turn(system: Any, time: float) -> bool:
            # The time is that of the step's end, where an implicit step asks for the forces.
            system.SetObjectParameter(pull, "stiffness", stiffness_at(shape, time))
            return True

        system.SetPreStepUserFunction(turn)
    if shape.friction:
        rub(system, lift, shape.friction, zone)
    sensor = system.AddSensor(
        item.SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=exudyn.OutputVariableType.Coordinates)
    )

    def begin() -> None:
        # A run leaves the stiffness of its end behind.
        system.SetObjectParameter(pull, "stiffness", stiffness_at(shape, 0.0))

    return sensor, lambda told: np.arctan2(across + told[:, 0], -down - told[:, 1]), begin


def stiffness_at(shape: Governor, time: float) -> float:
    """Of the spring between the balls (N/m)."""
    speed = shape.speeds[0][1]
    for (begin, low), (end, high) in pairwise(shape.speeds):
        if begin < end and time > begin:
            speed = low + (high - low) * min((time - begin) / (end - begin), 1.0)
    return -0.5 * shape.ball_mass * speed**2


def rub(system: Any, marker: int, force: float, zone: float) -> None:
    """Bristles that hold up to a force, or, with a zone (m/s), friction in proportion to slower speeds."""
    still = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))
    keys: dict[str, Any] = {"frictionProportionalZone": zone}
    if not zone:
        memory = system.AddNode(item.NodeGenericData(initialCoordinates=[0, 0, 0], numberOfDataCoordinates=3))
        keys = {"nodeNumber": memory, "stickingStiffness": BRISTLES, "stickingDamping": BRISTLES_DAMPING}
    system.AddObject(item.CoordinateSpringDamperExt(markerNumbers=[still, marker], dynamicFrictionForce=force, **keys))


def slider_crank(system: Any, shape: SliderCrank) -> Made:
    """A rotor, a mass on a line, a distance between them."""
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
    sensor = told_by(system, turn)
    return sensor, lambda told: shape.angle + told[:, 0], lambda: None


def told_by(system: Any, node: int) -> int:
    """A sensor that keeps a node's coordinates in memory."""
    kind = exudyn.OutputVariableType.Coordinates
    sensor: int = system.AddSensor(item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))
    return sensor
