"""Forces that follow from a mechanism's place: by virtual work, whatever the machine."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.output_variables import DerivedReading, SpringForce, StaticForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import compute_static_force, evaluate_derived_readings, evaluate_static_forces
from governor_mechanism.observables.run_result import StateHistory
from governor_scenes import PORTER, governor_scene
from hartung_scenes import PAPER_DIMENSIONS, hartung_scene


def telling(scene: Scene, *outputs: DerivedReading) -> Scene:
    """The scene, its mechanism with other outputs."""
    return scene.with_changes(mechanism=replace(scene.mechanism, derived_readings=outputs))


def test_a_porter_sleeve_carries_itself_and_one_ball() -> None:
    scene = governor_scene(PORTER, speed=12.0, angle=0.6)
    assembler = PositionSolver(scene.part.mechanism)
    poses = np.array([assembler.solve_at_coordinate(angle) for angle in (0.3, 0.6, 0.9)])
    # In the rhombus the sleeve moves twice as far as the two balls: (20 + 2 * 5 / 2) g; joints close to 1e-13.
    np.testing.assert_allclose(compute_static_force(scene, "sleeve_lift", poses), 25 * 9.81, rtol=1e-11)
    told = evaluate_static_forces(telling(scene, StaticForce(name="held", reading="sleeve_lift", fraction=0.02)), poses)
    np.testing.assert_allclose(told["held"], 0.02 * 25 * 9.81, rtol=1e-11)


def test_a_mechanism_without_outputs_tells_none() -> None:
    scene = governor_scene(PORTER, speed=12.0, angle=0.6)
    assert evaluate_static_forces(scene, np.array([scene.part.mechanism.initial_guess])) == {}


def test_no_poses_give_no_forces() -> None:
    found = evaluate_static_forces(hartung_scene(PAPER_DIMENSIONS), np.zeros((0, 3, 3)))
    assert {name: values.shape for name, values in found.items()} == {
        "spring_force": (0,),
        "static_sleeve_force": (0,),
        "regulating_force": (0,),
    }


def test_a_spring_that_is_none_is_told() -> None:
    scene = telling(hartung_scene(PAPER_DIMENSIONS), SpringForce(name="pull", spring="sprigs"))
    with pytest.raises(gm.MechanismError, match=r"no spring 'sprigs' among the force elements; springs are \['springs'\]"):
        evaluate_static_forces(scene, np.array([scene.part.mechanism.initial_guess]))


@dataclass(frozen=True, kw_only=True)
class Foreign(DerivedReading):
    """An output that nothing is written for."""


def test_an_output_without_an_equation_is_a_fault_of_the_program() -> None:
    scene = telling(hartung_scene(PAPER_DIMENSIONS), Foreign(name="what"))
    poses = np.array([scene.part.mechanism.initial_guess])
    nothing = {"work": np.zeros(1), "dissipated_energy": np.zeros(1), "lags": np.zeros((1, 0))}
    still = StateHistory(times=np.zeros(1), poses=poses, velocities=0.0 * poses, **nothing)
    with pytest.raises(TypeError, match="no equation is known for derived readings of type Foreign"):
        evaluate_derived_readings(scene, still)
