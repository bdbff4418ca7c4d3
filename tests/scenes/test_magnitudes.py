"""A number that nothing built or moving has is refused where it stands, before an engine multiplies it."""

import pytest

import governor_mechanism as gm
from governor_mechanism.model.part import Start
from governor_mechanism.model.time_functions import Harmonic, PrescribedMotion

HUGE_VALUES = [
    ("parabolic", "start.ball_rate", 1e160, "within 1e+06 m/s"),
    ("porter", "start.arm_rate", "1e7 rad/s", "within 1e+06 rad/s"),
    ("porter", "start.arm_angle", -1e160, "within 1e+09 rad"),
    ("porter", "effects.gravity", 1e160, "within 1e+06 m/s^2"),
    ("porter", "spindle.speed", 1e160, "within 1e+06 rad/s"),
    ("porter", "spindle.speed", [[0, 12.0], [1, "1e160 rpm"]], "within 1e+06 rad/s"),
    ("porter_cyclic", "spindle.cycles_per_turn", 1e160, "within 1e+09; found 1e+160"),
    ("porter_free_spindle", "spindle.torque", 1e160, "within 1e+09 N m"),
    ("porter_free_spindle", "spindle.start_speed", -1e160, "within 1e+06 rad/s"),
    ("slider_crank", "dimensions.crank_speed", 1e160, "within 1e+06 rad/s"),
    ("air_engine", "start.crank_rate", 1e160, "within 1e+06 rad/s"),
    ("air_engine", "dimensions.load_torque", [[0, 1.0], [1, 1e160]], "within 1e+09 N m"),
    ("governed_engine", "coupling.gear.ratio", 1e160, "between 1e-09 and 1e+09 in SI; found 1e+160"),
    ("governed_engine", "coupling.gear.ratio", 1e-300, "between 1e-09 and 1e+09 in SI; found 1e-300"),
    ("governed_engine", "part.engine.start.crank_rate", 1e160, "within 1e+06 rad/s"),
    ("governed_engine", "load.rated_torque", 1e160, "within 1e+09 N m"),
    ("quick_return", "run.duration", 1e160, "within 1e+09 s"),
    ("joy", "joint.engine.rate", 1e160, "within 1e+06 rad/s"),
]


@pytest.mark.parametrize(("name", "key", "value", "sentence"), HUGE_VALUES)
def test_a_huge_number_is_refused_at_its_key(name: str, key: str, value: object, sentence: str) -> None:
    scene = gm.load(name)
    with pytest.raises(gm.MechanismError) as caught:
        scene.replace({key: value})
    (problem,) = caught.value.problems
    assert sentence in problem
    assert key.rpartition(".")[2] in problem


def test_objects_are_bounded_as_files_are() -> None:
    with pytest.raises(gm.MechanismError, match="start rate of 'arm_angle' must lie within"):
        Start(rates={"arm_angle": 1e160})
    for motion in (
        lambda: PrescribedMotion.constant_rate(0.0, 1e160),
        lambda: PrescribedMotion(times=(0.0, 1e-9), values=(0.0, 1.0)),
        lambda: PrescribedMotion.constant_rate(0.0, 1.0, (Harmonic(amplitude=1e160, frequency=1.0),)),
    ):
        with pytest.raises(gm.MechanismError, match="rate of a motion, per second, must lie within"):
            motion()
