"""Proell's governor against its closed form: ball radius, equilibrium speed, stability, motion, energy."""

from functools import partial

from governor_mechanism.closed_form import proell as closed
from governor_mechanism.model.scene import Scene
from governor_mechanism.verification.machines.comparisons import Checks
from governor_mechanism.verification.machines.sleeve_governor import GovernorFormulas, check_sleeve_governor


def check_proell_governor(scene: Scene) -> Checks:
    """Yield every comparison that applies to the scene."""
    dimensions = scene.part.dimensions
    names = ("arm", "link", "extension", "ball_mass", "sleeve_mass", "offset", "lug_offset")
    governor = closed.ProellGovernor(
        **{name: dimensions[name] for name in names}, bend=dimensions["extension_angle"], gravity=scene.gravity
    )
    formulas = GovernorFormulas(
        ball_radius=partial(closed.ball_radius, governor),
        equilibrium_speed=partial(closed.equilibrium_speed, governor),
        squared_frequency=partial(closed.squared_natural_frequency, governor),
        acceleration=partial(closed.arm_acceleration, governor),
        spindle_acceleration=partial(closed.spindle_acceleration, governor),
    )
    yield from check_sleeve_governor(scene, formulas)
