"""Rows of the table of a comparison: statics of the governors, what each run shows of itself, and shared readings."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.files.plain_values import finite_or_none
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.statics.working_range import WorkingRange
from governor_mechanism.studies.comparison.motion import leading_reading, settling_time
from governor_mechanism.studies.comparison.statics import GovernorStatics
from governor_mechanism.units.quantities import format_quantity, format_reading_name

NEGLIGIBLE_POSITION = 1e-9
"""Length or angle that is shown as zero, m or rad: rounding of positions of machines of some metres, with room."""


@dataclass(frozen=True, kw_only=True)
class ComparedReading:
    """A row of the table: quantity, SI unit, and one value for each scene; None where a scene has none."""

    quantity: str
    unit: str
    values: tuple[float | str | None, ...]

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as text, in customary units."""
        return self.quantity, *(self._format(value) for value in self.values)

    def _format(self, value: float | str | None) -> str:
        if value is None:
            return "-"
        if isinstance(value, str):
            return value
        if self.unit == "ratio":
            return f"{100 * value:.4g} %"
        is_zero = self.unit in ("m", "rad") and abs(value) < NEGLIGIBLE_POSITION
        return format_quantity(0.0 if is_zero else value, self.unit, ".5g")


def static_rows(
    statics: Sequence[GovernorStatics | str],  # statics of each scene, or the reason why it has none
) -> Iterator[ComparedReading]:
    """Yield the rows of statics that at least one scene has."""
    columns = [dict(_static_values(one)) if isinstance(one, GovernorStatics) else {} for one in statics]
    quantities = dict.fromkeys(key for column in columns for key in column)
    for quantity, unit in sorted(quantities, key=lambda key: _STATIC_ORDER.index(key[0])):
        yield ComparedReading(quantity=quantity, unit=unit, values=tuple(column.get((quantity, unit)) for column in columns))


_STATIC_ORDER = (
    "speed of the spindle",
    "sleeve in equilibrium at it",
    "equilibrium",
    "natural frequency there",
    "damping ratio there",
    "effort there, for 1 % of speed",
    "sleeve moves for 1 % of speed by",
    "insensitivity there",
    "jumps at",
    "working range of",
    "working range from",
    "working range to",
    "speed of rest, inner end",
    "speed of rest, outer end",
    "sensitiveness",
    "work capacity",
)
"""Quantities of statics in the order of the table."""


_RANGE_NAMES = {"values": "given values", "stops": "the stops", "travel": "the travel", "run": "the run"}
"""What limits a working range, in the table."""


def _static_values(statics: GovernorStatics) -> Iterator[tuple[tuple[str, str], float | str | None]]:
    """Yield the values of statics of one governor, by quantity and unit."""
    yield ("speed of the spindle", "rad/s"), statics.spindle_speed
    place, mode, force = statics.equilibrium, statics.mode, statics.at_equilibrium
    if place is not None:
        lift = place.readings.get("sleeve_lift")
        yield ("sleeve in equilibrium at it", "m"), lift
        state = "astatic" if place.astatic else "stable" if place.stable else "unstable"
        yield ("equilibrium", ""), "beyond a stop" if statics.is_beyond_stops else state
    if mode is not None and not (place and place.astatic):
        yield ("natural frequency there", "1/s"), mode.natural_frequency
        yield ("damping ratio there", "1"), _rounded_to_zero(mode.damping_ratio)
    if force is not None:
        effort = force.effort
        unit = {"m": "N", "rad": "N m"}[_sleeve_unit(statics, force.against)]
        yield ("effort there, for 1 % of speed", unit), float(effort.effort[0]) if effort.effort[0] else None
        travel = float(effort.lift[0]) if effort.has_lift[0] else None
        yield ("sleeve moves for 1 % of speed by", _sleeve_unit(statics, force.against)), travel
    yield from _curve_values(statics)


def _curve_values(statics: GovernorStatics) -> Iterator[tuple[tuple[str, str], float | str | None]]:
    """Yield what the speed curve and the controlling force over the travel give."""
    curve = statics.curve
    if curve.insensitivity_band is not None and statics.equilibrium is not None:
        found = float(np.interp(statics.equilibrium.coordinate, curve.coordinate, curve.insensitivity_band.insensitivity))
        yield ("insensitivity there", "ratio"), finite_or_none(found)
    if curve.folds:
        yield ("jumps at", "rad/s"), curve.folds[0][1]
    ends: WorkingRange | None = None if statics.controlling_force is None else statics.controlling_force.working_range
    if ends is None:
        return
    unit = _sleeve_unit(statics, statics.controlling_force.against) if statics.controlling_force else "m"
    yield ("working range of", ""), _RANGE_NAMES[statics.range_of]
    for end, value in zip(("from", "to"), ends.sleeve.tolist(), strict=True):
        yield (f"working range {end}", unit), value
    for end, value in zip(("inner", "outer"), ends.speed.tolist(), strict=True):
        yield (f"speed of rest, {end} end", "rad/s"), value
    yield ("sensitiveness", "ratio"), ends.sensitiveness if ends.stable else None
    yield ("work capacity", "J"), ends.work_capacity


def _sleeve_unit(statics: GovernorStatics, reading: str) -> str:
    return "rad" if statics.scene.part.mechanism.reading(reading).quantity == "angle" else "m"


def _rounded_to_zero(ratio: float) -> float:
    """Return a damping ratio, with rounding errors of an undamped motion as zero."""
    return 0.0 if abs(ratio) < 1e-9 else ratio


def run_rows(runs: Sequence[Trajectory]) -> Iterator[ComparedReading]:
    """Yield what each run shows of itself."""
    yield ComparedReading(quantity="run: end", unit="s", values=tuple(float(run.times[-1]) if len(run.times) else None for run in runs))
    leading = tuple(leading_reading(run) for run in runs)
    values = tuple(settling_time(run, name) if name in run.readings else None for run, name in zip(runs, leading, strict=True))
    if any(value is not None for value in values):
        yield ComparedReading(quantity="run: settling time (2 %)", unit="s", values=values)
    yield ComparedReading(quantity="run: events", unit="", values=tuple(str(len(run.events)) for run in runs))
    yield ComparedReading(quantity="run: engine", unit="", values=tuple(run.cost.engine for run in runs))
    yield ComparedReading(quantity="run: error estimate", unit="", values=tuple(_format_error(run) for run in runs))


def _format_error(run: Trajectory) -> str | None:
    return None if run.error_estimate is None else f"{run.error_estimate:.0e}"


def reading_rows(
    runs: Sequence[Trajectory],
    # full name of each shared reading in each run, by plain name
    shared: Mapping[str, tuple[str | None, ...]],
) -> Iterator[ComparedReading]:
    """Yield last, lowest and highest value of the shared readings."""
    for name, full_names in shared.items():
        series = [None if full is None else run.readings[full] for run, full in zip(runs, full_names, strict=True)]
        unit = next(run.units[full] for run, full in zip(runs, full_names, strict=True) if full is not None)
        for word, number in (("last", lambda one: one[-1]), ("lowest", np.min), ("highest", np.max)):
            values = tuple(None if one is None else float(number(one)) for one in series)
            yield ComparedReading(quantity=f"{format_reading_name(name)}, {word}", unit=unit, values=values)
