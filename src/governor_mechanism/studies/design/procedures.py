"""The designs by name: inputs, procedure, simulation and the paper's numbers of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.model.results.result import Result
from governor_mechanism.studies.design import flywheel, governed_engine, hartnell, hartung, pendulum
from governor_mechanism.studies.design.engine_governor import DEFAULT_INPUTS as ENGINE_INPUTS
from governor_mechanism.studies.design.simulated import simulate_governed_engine, simulate_hartnell, simulate_pendulum, simulate_wheels
from governor_mechanism.studies.design.skeleton import Design


@dataclass(frozen=True)
class Procedure:
    """How a machine is designed."""

    inputs: Any  # its default inputs
    design: Callable[[Any], Design]  # function of the inputs that returns the design
    # function of the design and of the paper's numbers, or None, that returns how the machine runs; None:
    # it is not simulated
    simulate: Callable[[Any, Any], Any] | None = None
    # function that returns the paper's numbers beside the recomputed ones, if the default inputs are those
    # of a paper
    compare: Callable[[], Any] | None = None


@dataclass(frozen=True, kw_only=True)
class DesignReport(Result):
    """A design with what was simulated of it, and with the numbers of a paper."""

    machine: str  # name of the procedure
    design: Design
    simulated: Any = None  # how it runs; None if it is not simulated
    paper: Any = None  # the numbers of the paper, if the inputs are those of a paper, or None

    figure_set = "render.figures.designs.design_figures"

    @property
    def ok(self) -> bool:
        """Whether the simulated machine does what was wanted."""
        return self.simulated.ok if self.simulated else True

    def as_json(self) -> Mapping[str, Any]:
        """Return what there is as plain values in SI."""
        return {name: value for name, value in super().as_json().items() if value is not None}

    def __str__(self) -> str:
        """Return the numbers of the paper, the design, and how it runs."""
        paper = [f"{self.paper}\n"] if self.paper else []
        simulated = [f"\n{self.simulated}"] if self.simulated else []
        return "\n".join([*paper, f"{self.design}", *simulated])


PROCEDURES: Mapping[str, Procedure] = {
    "hartung": Procedure(hartung.PAPER_INPUTS, hartung.design_hartung, compare=hartung.compare_with_paper),
    "flywheel": Procedure(flywheel.PAPER_INPUTS, flywheel.design_flywheel, simulate_wheels, flywheel.compare_with_paper),
    "governed-engine": Procedure(ENGINE_INPUTS, governed_engine.design_governed_engine, lambda design, _: simulate_governed_engine(design)),
    "pendulum": Procedure(pendulum.DEFAULT_INPUTS, pendulum.design_pendulum, lambda design, _: simulate_pendulum(design)),
    "hartnell": Procedure(hartnell.DEFAULT_INPUTS, hartnell.design_hartnell, lambda design, _: simulate_hartnell(design)),
}
"""The procedures by the names of the command line."""
