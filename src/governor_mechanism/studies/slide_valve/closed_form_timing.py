"""Timing of a slide valve that an eccentric drives: in closed form, and by Zeuner's law alone."""

import math
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.machines.slide_valve import prescribed_centre
from governor_mechanism.model.scene import Scene


class ClosedFormEvent(NamedTuple):
    """A valve event in closed form: crank angles (rad) and strokes, exact and by Zeuner's law with infinitely long rods."""

    exact: float
    theory: float
    exact_stroke: float
    theory_stroke: float


def closed_form_event(scene: Scene, name: str) -> ClosedFormEvent:
    """Return a valve event of a slide valve scene in closed form.

    Result: crank angles and strokes, the fractions of the piston stroke from the event's own end.
    """
    dimensions = scene.part.dimensions
    eccentric, train = Eccentric.from_dimensions(dimensions), CrankTrain.from_dimensions(dimensions)
    angle_of = partial(event_angle, event=name, outside_lap=dimensions["outside_lap"], inside_lap=dimensions["inside_lap"])
    exact, theory = angle_of(eccentric, centre=prescribed_centre(scene)), angle_of(replace(eccentric, rod=math.inf))
    end, ideal_train = name.rsplit(" ", 1)[0], replace(train, rod=math.inf)
    return ClosedFormEvent(exact, theory, _stroke_fraction(train, exact, end), _stroke_fraction(ideal_train, theory, end))


def _stroke_fraction(train: CrankTrain, angle: float, end: str) -> float:
    """Return the fraction of the stroke at a crank angle (rad), measured from one of the cylinder ends."""
    # The closed form counts from the outer dead centre, half a revolution later.
    fraction = float(travel_from_outer_dead_centre(train, crank_angle=angle + math.pi)) / (2 * train.crank)
    return fraction if end == "head end" else 1.0 - fraction
