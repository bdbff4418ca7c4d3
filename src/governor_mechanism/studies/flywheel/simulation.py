"""Designed flywheels put to the test: the engine with each of them simulated under the load that closes its cycle."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.closed_form.flywheel import wheel as formulas
from governor_mechanism.closed_form.flywheel.engine import stored_work
from governor_mechanism.closed_form.flywheel.equilibrium import energy_fluctuation
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.flywheel.design import FlywheelDesign
from governor_mechanism.studies.flywheel.inputs import ENGINE_INPUTS, closed_cycle
from governor_mechanism.studies.flywheel.paper_comparison import PaperComparison
from governor_mechanism.types import FloatArray
from governor_mechanism.units.text_table import format_table

N_TURNS = 2
"""Turns that are simulated and shown."""

ACCURACY = 1e-8
"""Accuracy of the simulation: far below the fluctuation."""

POINTS_PER_TURN = 200
"""Reported times in a turn."""


@dataclass(frozen=True, kw_only=True)
class SimulatedWheel:
    """A flywheel as it ran.

    Attributes
    ----------
    sized_by
        How it was sized.
    inertia
        Its moment of inertia, kg m2.
    lowest, highest
        Lowest and highest speed in the last turn, rad/s.
    coefficient
        Coefficient of speed fluctuation, (highest - lowest) / mean speed of the design.
    allowed
        The coefficient that the design allows.
    crank_angles, speeds
        Crank angle (rad) and speed (rad/s) of the shaft at the reported times; shape (n,).
    """

    sized_by: str
    inertia: float
    lowest: float
    highest: float
    coefficient: float
    allowed: float
    crank_angles: FloatArray
    speeds: FloatArray

    @property
    def excess(self) -> float:
        """Coefficient relative to the allowed one."""
        return self.coefficient / self.allowed

    def as_json(self) -> dict[str, Any]:
        """Return the wheel as plain values."""
        return plain_record(self, excess=self.excess)


def export_scene_document(design: FlywheelDesign, inertia: float) -> dict[str, Any]:
    """Return a runnable scene of the engine with a flywheel, under the load that closes its cycle, on its periodic motion.

    Parameters
    ----------
    design
        Design of the flywheel.
    inertia
        Moment of inertia of the flywheel, kg m2.

    Returns
    -------
    dict[str, Any]
        The document of a scene file.
    """
    inputs, mean_speed = design.inputs, design.inputs.speed
    dimensions: dict[str, Any] = {name: float(getattr(inputs, name)) for name in ENGINE_INPUTS}
    dimensions |= {"load_pressure": "closing", "inertia": inertia, "rim_radius": inputs.rim_radius}
    return {
        "title": "Engine with its flywheel, designed",
        "machine": "flywheel_engine",
        "dimensions": dimensions,
        "start": {"crank_angle": 0.0, "crank_rate": _start_speed(design, inertia)},
        "run": {
            "duration": N_TURNS * math.tau / mean_speed,
            "output_interval": math.tau / mean_speed / POINTS_PER_TURN,
            "accuracy": ACCURACY,
        },
    }


def _start_speed(design: FlywheelDesign, inertia: float) -> float:
    """Return the speed (rad/s) at the dead centre of the periodic motion with the mean speed of the design, by the mean of its rule."""
    engine = closed_cycle(design.engine)
    extremes = energy_fluctuation(engine)
    limits = {"inertia": inertia, "energy": extremes.energy, "mean_speed": design.inputs.speed}
    lowest, _ = formulas.speed_limits(**limits, mean_energy=design.inputs.coefficient is None and design.inputs.inertia is None)
    work = -float(stored_work(engine, crank_angle=extremes.slowest_angle))
    return float(formulas.speed_after_work(inertia=inertia, start_speed=lowest, work=work))


def simulate_wheels(design: FlywheelDesign, comparison: PaperComparison | None = None) -> list[SimulatedWheel]:
    """Simulate the engine over two turns with the flywheel of a design, or with those by each of the paper's sums.

    Parameters
    ----------
    design
        Design of the flywheel.
    comparison
        The paper's numbers, if the design is that of the paper.

    Returns
    -------
    list[SimulatedWheel]
        How the flywheels ran.

    Raises
    ------
    MechanismError
        If a run does not reach its end, or the shaft makes no complete turn.
    """
    wheels = [(wheel.sized_by, wheel.inertia) for wheel in comparison.wheels] if comparison else [("design", design.inertia)]
    return [_simulate_wheel(design, sized_by, inertia) for sized_by, inertia in wheels]


def _simulate_wheel(design: FlywheelDesign, sized_by: str, inertia: float) -> SimulatedWheel:
    scene = parse_scene_document(export_scene_document(design, inertia))
    engine, reason = select_engine(scene.run.engine, scene)
    run = engine.run(scene, reason=reason)
    extremes = run.speed_fluctuations.get("crank_angle")
    if not run.outcome.ok or extremes is None:
        raise MechanismError(f"the simulation of the flywheel of {inertia:.6g} kg m2 failed: {run.message}")
    return SimulatedWheel(
        sized_by=sized_by,
        inertia=inertia,
        lowest=extremes.lowest,
        highest=extremes.highest,
        coefficient=(extremes.highest - extremes.lowest) / design.inputs.speed,
        allowed=design.coefficient,
        crank_angles=np.asarray(run.readings["crank_angle"]),
        speeds=np.asarray(run.readings["shaft_speed"]),
    )


def format_simulated_wheels(wheels: Sequence[SimulatedWheel]) -> str:
    """Return a table of simulated flywheels.

    Parameters
    ----------
    wheels
        Wheels as they ran.

    Returns
    -------
    str
        The table.
    """
    rows = (
        (
            wheel.sized_by,
            f"{wheel.inertia:.6g}",
            f"{wheel.lowest:.6g}",
            f"{wheel.highest:.6g}",
            f"{wheel.coefficient:.6g}",
            f"{wheel.excess:.5g}",
        )
        for wheel in wheels
    )
    return format_table(
        ("simulated over two turns", "kg m2", "lowest, rad/s", "highest, rad/s", "fluctuation", "times the allowed"), rows, "lrrrrr"
    )
