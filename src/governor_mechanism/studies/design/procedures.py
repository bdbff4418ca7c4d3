"""The designs by name: inputs, procedure, simulation and the paper's numbers of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.studies.design import flywheel, flywheel_paper, governed_engine, hartnell, hartung, hartung_paper, pendulum
from governor_mechanism.studies.design.engine_governor import DEFAULT_INPUTS as ENGINE_INPUTS
from governor_mechanism.studies.design.simulated_engines import simulate_governed_engine, simulate_wheels
from governor_mechanism.studies.design.simulated_governors import simulate_hartnell, simulate_pendulum
from governor_mechanism.studies.design.skeleton import Design


@dataclass(frozen=True)
class Procedure:
    """How a machine is designed.

    Attributes
    ----------
    inputs
        Its default inputs.
    design
        Function of the inputs that returns the design.
    simulate
        Function of the design and of the paper's numbers, or None, that returns how the machine runs; None: it is not simulated.
    compare
        Function that returns the paper's numbers beside the recomputed ones, if the default inputs are those of a paper.
    """

    inputs: Any
    design: Callable[[Any], Design]
    simulate: Callable[[Any, Any], Any] | None = None
    compare: Callable[[], Any] | None = None


PROCEDURES: Mapping[str, Procedure] = {
    "hartung": Procedure(hartung.PAPER_INPUTS, hartung.design_hartung, compare=hartung_paper.compare_with_paper),
    "flywheel": Procedure(flywheel.PAPER_INPUTS, flywheel.design_flywheel, simulate_wheels, flywheel_paper.compare_with_paper),
    "governed-engine": Procedure(ENGINE_INPUTS, governed_engine.design_governed_engine, lambda design, _: simulate_governed_engine(design)),
    "pendulum": Procedure(pendulum.DEFAULT_INPUTS, pendulum.design_pendulum, lambda design, _: simulate_pendulum(design)),
    "hartnell": Procedure(hartnell.DEFAULT_INPUTS, hartnell.design_hartnell, lambda design, _: simulate_hartnell(design)),
}
"""The procedures by the names of the command line."""
