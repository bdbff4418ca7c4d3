"""Text and JSON of the controlling force in the command `equilibria`: effort and power at each equilibrium, and sensitiveness."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import DEFAULT_SPEED_CHANGE, ControllingForce
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.equilibrium_speed import format_coordinate
from governor_mechanism.statics.working_range import WorkingRange
from governor_mechanism.units.quantities import format_quantity, number_or_text


@dataclass(frozen=True, kw_only=True)
class ControllingForceReport:
    """Controlling force over the travel and at the equilibria of a scene, or the reason why there is none."""

    scene: Scene
    curve: ControllingForce | None
    at_equilibria: ControllingForce | None
    reason: str = ""

    def lines(self) -> list[str]:
        """Return one line per equilibrium with effort and power, and one on the working range; none without a controlling force."""
        points, curve = self.at_equilibria, self.curve
        lines = [] if points is None else [_format_effort(self.scene, points, index) for index in range(len(points.coordinate))]
        return lines if curve is None else [*lines, _format_working_range(self.scene, curve)]

    def as_json(self) -> object:
        """Return effort and power at the equilibria and the working range in SI, or the reason why there is no controlling force."""
        points, curve = self.at_equilibria, self.curve
        if curve is None:
            return self.reason
        names = ("coordinate", "radius", "force", "force_slope", "speed_line_slope", "equivalent_mass", "speed", "sleeve", "stable")
        rows = [] if points is None else [{name: getattr(points, name)[k] for name in names} for k in range(len(points.coordinate))]
        for row, values in zip(rows, _effort_values(points), strict=True):
            row |= values
        about = {"radius": curve.radius_name, "balls": curve.n_balls, "against": curve.against, "speed_change": curve.effort.speed_change}
        return {**about, "at_equilibria": rows, "working_range": _range_values(curve.working_range)}


def report_controlling_force(
    scene: Scene,
    equilibria: Sequence[Equilibrium],
    *,
    working_range: str | None,  # working range as "READING=LOW:HIGH"; None for the stops or the travel
    speed_change: float | None,  # relative change of speed for effort and power; None for 1 %
    resistance: float | None,  # resistance at the sleeve, N or N m; None for none
    against: str,
    is_wanted: bool,  # whether the user gave an option that needs a controlling force
) -> ControllingForceReport:
    """Return the controlling force of a scene of one part.

    Result: the controlling force. A scene without one, as that of a mechanism without balls, gets the reason
    instead. Raises MechanismError if a controlling force is wanted and there is none, or an option is wrong.
    """
    options: dict[str, Any] = {
        "between": None if working_range is None else parse_range(working_range),
        "speed_change": DEFAULT_SPEED_CHANGE if speed_change is None else speed_change,
        "resistance": resistance,
        "against": against,
    }
    places = [point.coordinate for point in equilibria]
    try:
        curve = gm.controlling_force(scene, **options)
        points = gm.controlling_force(scene, places, **options) if places else None
    except MechanismError as error:
        if is_wanted:
            raise
        return ControllingForceReport(scene=scene, curve=None, at_equilibria=None, reason=error.problems[0])
    return ControllingForceReport(scene=scene, curve=curve, at_equilibria=points)


def parse_range(text: str) -> Mapping[str, tuple[float | str, float | str]]:
    """Return both values of a working range "READING=LOW:HIGH" by its reading; raise MechanismError for another text."""
    name, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and name.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--range {text!r} is not understood; write "READING=LOW:HIGH", as in "sleeve_lift=20 mm:60 mm"')
    return {name.strip(): (number_or_text(low), number_or_text(high))}


def _effort_values(points: ControllingForce | None) -> list[dict[str, float | None]]:
    """Return effort, lift and power of each position in SI; None where the sleeve does not come to a new equilibrium."""
    if points is None:
        return []
    effort = points.effort
    columns = zip(effort.effort, effort.lift, effort.power, effort.has_lift, strict=True)
    return [{"effort": mean, "lift": lift if found else None, "power": power if found else None} for mean, lift, power, found in columns]


def _range_values(ends: WorkingRange | None) -> object:
    """Return the working range in SI, or None."""
    if ends is None:
        return None
    names = ("lift", "range_of_speed", "mean_speed", "sensitiveness", "range_of_speed_with_resistance")
    return plain_record(ends, **{name: getattr(ends, name) for name in names})


def _format_effort(scene: Scene, points: ControllingForce, index: int) -> str:
    """Return controlling force, effort and power at a position in a sentence."""
    is_angle = scene.part.mechanism.reading(points.against).quantity == "angle"
    effort, place = points.effort, format_coordinate(scene, float(points.coordinate[index]))
    force = f"at {place}: controlling force of a ball {points.force[index]:.6g} N"
    change, unit = f"{100 * effort.speed_change:g} % of speed", "N m" if is_angle else "N"
    mean_force = f"effort {effort.effort[index]:.6g} {unit} at {points.against} for {change}"
    if effort.has_lift[index]:
        lift = format_quantity(float(effort.lift[index]), "rad" if is_angle else "m")
        return f"{force}; {mean_force}, power {effort.power[index]:.6g} J over {lift}"
    cause = "it is astatic" if points.astatic[index] else "it ends its travel before" if points.stable[index] else "it is unstable"
    return f"{force}; {mean_force}, no power: {cause}"


def _format_working_range(scene: Scene, curve: ControllingForce) -> str:
    """Return the sensitiveness over the working range in a sentence."""
    ends = curve.working_range
    if ends is None:
        return 'for the sensitiveness give a working range, as in --range "sleeve_lift=20 mm:60 mm": the scene has no stops'
    places = " to ".join(format_coordinate(scene, float(value)) for value in ends.coordinate)
    low, high = (format_quantity(float(speed), "rad/s") for speed in ends.speed)
    text = f"working range {places}: {low} to {high}"
    if curve.astatic.all():
        return f"{text}, sensitiveness 0: isochronous"
    if not ends.stable:
        return f"{text}, unstable in part, so that it has no sensitiveness"
    text += f", sensitiveness {ends.sensitiveness:.6g} of the mean speed, work capacity {ends.work_capacity:.6g} J"
    if not curve.resistance:
        return text
    falling, rising = (format_quantity(float(speed), "rad/s") for speed in (ends.falling_speed[0], ends.rising_speed[1]))
    return f"{text}; with resistance {falling} to {rising}"
