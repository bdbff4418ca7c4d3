"""Quantities of a run that a kernel may compute: readings over time, and the speed fluctuation of an engine."""

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.effects.gas_pressure import work_per_stroke
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.coupling.coupled_system import SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import mean_gas_torque
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.user_kernel.simulated import ROUNDING, Column, Input, Quantity, Simulated

TIME = "time"
RATE_PREFIX = "rate_of_"

MIN_ACCURACY = 1e-10
"""Accuracy of a run below which engines may not certify it."""


def run_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield every reading of a run, and its rate, over time."""
    units = {reading.name: READING_UNITS[reading.quantity] for reading in scene.mechanism.readings}
    rates = {RATE_PREFIX + name: "1/s" if unit == "1" else f"{unit}/s" for name, unit in units.items()}
    units |= {one.name: one.unit for one in scene.mechanism.derived_readings}
    for plane in scene.system.planes:
        units |= {plane.prefix + SPINDLE_SPEED: "rad/s", plane.prefix + SPINDLE_TORQUE: "N m"}
    for name, unit in (units | rates).items():
        yield Quantity(
            name=name,
            unit=unit,
            description=f"{name.replace('_', ' ')} in a run of the scene",
            inputs={TIME: Input("s")},
            arguments=tuple(other for other in units | rates if other != name),
            evaluate=partial(_evaluate_in_run, name=name),
        )


def engine_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield the mean gas torque and the fluctuation of speed and energy of an engine that gas drives; none for other scenes."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    if not gases or any(gas.strokes_differ for gas in gases):
        return
    yield Quantity(
        name="mean_gas_torque",
        unit="N m",
        description="mean torque of the gas over a stroke",
        inputs={},
        arguments=(),
        evaluate=_evaluate_mean_torque,
    )
    yield Quantity(
        name="speed_fluctuation",
        unit="1",
        description="coefficient of speed fluctuation in the last turn of a run, (highest - lowest) / mean",
        inputs={},
        arguments=(),
        evaluate=partial(_evaluate_fluctuation, is_energy=False),
    )
    if not scene.effects and len(scene.parts) == 1:  # reciprocating masses would store work too
        yield Quantity(
            name="energy_fluctuation",
            unit="J",
            description="work that the flywheel stores between lowest and highest speed in the last turn of a run",
            inputs={},
            arguments=(),
            evaluate=partial(_evaluate_fluctuation, is_energy=True),
        )


def _run(scene: Scene, times: FloatArray | None, accuracy: float) -> Trajectory:
    requested = max(MIN_ACCURACY, min(scene.run.accuracy, accuracy))
    engine, reason = select_engine(scene.run.engine, scene, requested)
    return engine.run(scene, times=times, accuracy=requested, reason=reason)


def _note_early_end(run: Trajectory) -> tuple[str, ...]:
    return () if run.outcome.ok else (f"the run is compared as far as it went: {run.message}",)


def _evaluate_in_run(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, name: str) -> Simulated:
    """Return a reading (n,) or its rate at times (n,); fewer if the run ends early."""
    run = _run(scene, inputs[TIME], accuracy)
    if not len(run.times):
        raise MechanismError(f"the run has no result to compare: {run.message}")
    columns = {TIME: Column(run.times, "s")}
    columns |= {reading: Column(values, run.units[reading]) for reading, values in run.readings.items()}
    for reading, values in run.rates.items():
        unit = run.units[reading]
        columns[RATE_PREFIX + reading] = Column(values, f"{unit}/s" if unit != "1" else "1/s")
    key = f"rate of {name.removeprefix(RATE_PREFIX)}" if name.startswith(RATE_PREFIX) else name
    values = columns.pop(name).values
    if key not in run.reading_errors:
        raise MechanismError(f"the run has no error estimate for {name}, and proves nothing: {run.message}")
    error = run.reading_errors[key]
    scale = float(run.scales.get(key, np.max(np.abs(values))))
    return Simulated(values=values, errors=np.full(len(values), error), arguments=columns, scale=scale, notes=_note_early_end(run))


def _evaluate_mean_torque(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float) -> Simulated:
    """Return the mean torque (1,) of the gas, N m; the works of the gases partly cancel, and their rounding stays."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    magnitude = sum(abs(work_per_stroke([gas])) for gas in gases)
    return Simulated(values=np.array([mean_gas_torque(scene)]), errors=np.array([ROUNDING * magnitude]), arguments={})


def _evaluate_fluctuation(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, is_energy: bool) -> Simulated:
    """Return the fluctuation (1,) of speed, or of the kinetic energy of the flywheel, J, in the last turn of a run."""
    run = _run(scene, None, accuracy)
    if not run.outcome.ok or len(run.speed_fluctuations) != 1:
        cause = run.message if not run.outcome.ok else "the shaft makes no complete turn; make the run longer"
        raise MechanismError(f"there is no speed fluctuation to compare: {cause}")
    (extremes,) = run.speed_fluctuations.values()
    error = 2 * run.reading_errors["shaft_speed"]  # of either extreme
    if is_energy:
        inertia = scene.part.dimensions["inertia"]
        value, error = 0.5 * inertia * (extremes.highest**2 - extremes.lowest**2), inertia * extremes.mean * error
    else:
        value, error = extremes.coefficient, error / extremes.mean
    return Simulated(values=np.array([value]), errors=np.array([error]), arguments={})
