"""A number that nothing built or moving has is refused where it stands, before an engine multiplies it."""

from governor_mechanism.model.part import Start
from governor_mechanism.model.time_functions import Harmonic, PrescribedMotion
from refusing import refuses


def test_objects_are_bounded_as_files_are() -> None:
    refuses("start rate of 'arm_angle' must lie within", Start, rates={"arm_angle": 1e160})
    for motion in (
        lambda: PrescribedMotion.constant_rate(0.0, 1e160),
        lambda: PrescribedMotion(times=(0.0, 1e-9), values=(0.0, 1.0)),
        lambda: PrescribedMotion.constant_rate(0.0, 1.0, (Harmonic(amplitude=1e160, frequency=1.0),)),
    ):
        refuses("rate of a motion, per second, must lie within", motion)
