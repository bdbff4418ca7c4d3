"""The equilibria of what turns with a spindle, as a curve beside the drawing."""

import re
from dataclasses import replace
from typing import Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.governor_view import GovernorView, make_governor_view
from governor_mechanism.statics.equilibrium_speed import has_equilibrium_speed

COLOUR: Final = re.compile(r'(fill|stroke)="#([0-9a-fA-F]{6})"')
"""A colour of a picture, which has a counterpart on a dark ground."""


class EquilibriumPlot:
    """The speed curve of a scene, with that of the scene as it was opened behind it."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._first = scene, _view_of(scene)

    def draw(self, scene: Scene) -> dict[str, str] | None:
        """Return the curve as SVG, and sentences on the equilibria; None if no spindle speed balances the loads of the scene."""
        view = _view_of(scene)
        if view is None:
            return None
        if self._first is not None and scene != self._scene:
            view = replace(view, given=self._first.speed_curve)
        state = view.solve(view.variable.value, None)
        picture = view.plot(state, "", is_faded=False)
        return {"picture": COLOUR.sub(r'\1="var(--c-\2)"', picture), "sentences": state.problem or " ".join(state.sentences)}


def _view_of(scene: Scene) -> GovernorView | None:
    """Return the view of the part of a scene that turns with a spindle; None without one, or without a speed curve."""
    turns = any(part.turns for part in scene.parts)
    if not turns or (len(scene.parts) == 1 and not has_equilibrium_speed(scene)):
        return None
    try:
        return make_governor_view(scene, "")
    except MechanismError:
        return None
