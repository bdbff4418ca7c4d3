"""The command `design`: machines designed by the procedures of their papers.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import typer

from governor_mechanism.cli import console
from governor_mechanism.cli.given_options import remember_options
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.studies.hartung.design import HartungDesign
    from governor_mechanism.studies.pendulum.results import PendulumDesign
    from governor_mechanism.studies.pendulum.simulation import SimulatedDesign

_Inputs = TypeVar("_Inputs")

_OPTIONS = ("--with", "--out", "--no-figure", "--format", "--theme", "--json", "--help")
"""Options of the command, for a misspelt one."""


class DesignTarget(StrEnum):
    """Machines that can be designed."""

    HARTUNG = "hartung"
    FLYWHEEL = "flywheel"
    GOVERNED_ENGINE = "governed-engine"
    PENDULUM = "pendulum"
    HARTNELL = "hartnell"


@dataclasses.dataclass(frozen=True)
class GivenInputs:
    """Inputs of the command line: assignments of --with, and the values of options with the names of inputs."""

    assignments: Sequence[str]
    options: Mapping[str, str]

    def replace(self, defaults: _Inputs) -> _Inputs:
        """Return the default inputs with the given ones in their place."""
        from governor_mechanism.studies.design_inputs import option_of, parse_assignments

        names = self.options if self.assignments else [one.name for one in dataclasses.fields(cast("Any", defaults))]
        remember_options({name: option_of(name) for name in names})
        return parse_assignments(defaults, self.assignments, self.options)


def design(
    context: typer.Context,
    machine: Annotated[DesignTarget, typer.Argument(help="The machine to design.")],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--with", help='An input that replaces the one of the paper, for example "wire=14 mm"; also --wire "14 mm". Repeatable.'
        ),
    ] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Design a machine by the procedure of its paper.

    hartung: bell cranks, springs, stress and sleeve force of a governor, and a scene file that can be run. flywheel: energy, inertia, rim
    and arms of the flywheel of an air-expansion engine for an allowed energy_ratio or coefficient of speed fluctuation, or the fluctuation
    of a given inertia; load_pressure=closing takes the load with which the cycle closes. The flywheel is then simulated, and a scene file
    written.

    governed-engine: cylinder, flywheel, Porter governor, throttle rod and dashpot for a power, a speed and a droop. The engine is then
    simulated while its load falls to the half, and a scene file written: --power "20 PS" --speed "120 rpm" --droop 4%.

    pendulum: masses, arms, suspension and limits of speed of a Porter, Watt or improved Watt governor by Zehnder's steps I to VIII. Statics
    and a run of the scene that is written stand beside the wanted numbers: --kind watt --lowest-speed "60 rpm" --highest-speed "63 rpm".

    hartnell: the spring of a Hartnell governor for two speeds, by the textbooks' formula and by exact statics, beside the simulated speeds
    at both ends of the lift, and a scene file: --lowest-speed "290 rpm" --highest-speed "310 rpm" --lift "15 mm".

    Every input may be given as an option of its name. Writes figures. With the inputs of the paper, the printed numbers are compared with
    the recomputed ones, and where they differ the cause is named.
    """
    console.prepare_folder(figures.folder)
    design_machine = {
        DesignTarget.HARTUNG: _design_hartung,
        DesignTarget.FLYWHEEL: _design_flywheel,
        DesignTarget.GOVERNED_ENGINE: _design_governed_engine,
        DesignTarget.PENDULUM: _design_pendulum,
        DesignTarget.HARTNELL: _design_hartnell,
    }[machine]
    given = GivenInputs(changes or (), parse_input_options(context.args))
    result, warnings = design_machine(given, figures)
    if as_json:
        for warning in warnings:  # the text output contains them
            console.print_to_stderr(warning)
    return dataclasses.replace(result, values={"machine": machine.value, **result.values})


def parse_input_options(words: Sequence[str]) -> dict[str, str]:
    """Return the values of options that are no options of the command, by the names of inputs: "--ball-mass 5kg" or "--ball_mass=5kg".

    Parameters
    ----------
    words
        What is left of the command line.

    Returns
    -------
    dict[str, str]
        Values by name.

    Raises
    ------
    MechanismError
        If an option has no value or is given twice, or a word belongs to no option.
    """
    from governor_mechanism.errors import MechanismError, did_you_mean

    values: dict[str, str] = {}
    remaining = iter(words)
    for word in remaining:
        option, sign, value = word.partition("=")
        if not option.startswith("--") or option == "--":
            raise MechanismError(f'{word!r} belongs to no option; a value with blanks stands in quotes, as --power "20 PS"')
        name = option[2:].replace("-", "_")
        text = value if sign else next(remaining, None)
        if text is None or (not sign and text.startswith("--")):
            raise MechanismError(f"{option} has no value; an input has one: {option} VALUE.{did_you_mean(option, _OPTIONS)}")
        if name in values:
            raise MechanismError(f"{option} is given twice; give it once")
        values[name] = text
    return values


def _design_hartung(given: GivenInputs, figures: FigureFiles) -> tuple[console.CommandResult, tuple[str, ...]]:
    from governor_mechanism.studies.hartung.design import design_hartung
    from governor_mechanism.studies.hartung.inputs import PAPER_INPUTS
    from governor_mechanism.studies.hartung.paper_comparison import compare_with_paper

    inputs = given.replace(PAPER_INPUTS)
    is_paper_design = inputs == PAPER_INPUTS
    with console.show_status("designing"):
        hartung_design = design_hartung(inputs)
        files = [_write_hartung_scene(hartung_design, figures.folder)]
        if figures.formats:
            files += _write_hartung_figures(hartung_design, figures, is_paper_design=is_paper_design)
    values: dict[str, object] = {"design": hartung_design.as_json()}
    text = hartung_design.summary_lines()
    if is_paper_design:
        comparison = compare_with_paper()
        values["paper"] = comparison.as_json()
        text = [f"{comparison}\n", *text]
    return console.CommandResult(text=text, values=values, files=files), hartung_design.warnings


def _write_hartung_scene(hartung_design: HartungDesign, out: Path) -> Path:
    from governor_mechanism.studies.hartung.scene_export import export_scene_document

    comment = "A Hartung governor, designed by the procedure of Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620."
    return _write_scene(export_scene_document(hartung_design), comment, out / "hartung_design.toml")


def _write_scene(document: Mapping[str, Any], comment: str, path: Path) -> Path:
    """Write a scene file that begins with a comment, and return its path."""
    from governor_mechanism.files.atomic_write import atomic_write
    from governor_mechanism.scenes.toml_text import format_scene_toml

    with atomic_write(path) as temporary:
        temporary.write_text(format_scene_toml(document, comment), encoding="utf-8")
    return path


def _write_hartung_figures(hartung_design: HartungDesign, figures: FigureFiles, *, is_paper_design: bool) -> list[Path]:
    """Draw the spring lines and the spread of the sleeve force; with the inputs of the paper, its spring lines at 132 deg."""
    from governor_mechanism.render.figures.hartung.design import sleeve_force_figure, spring_lines_figure
    from governor_mechanism.studies.hartung.design import design_hartung

    drawn_design = hartung_design
    if is_paper_design:
        drawn_design = design_hartung(dataclasses.replace(hartung_design.inputs, angle=math.radians(132), sleeve_arm=0.170))
    spring_lines = spring_lines_figure(drawn_design, with_printed_points=is_paper_design)
    return figures.save(spring_lines, "hartung_spring_lines") + figures.save(sleeve_force_figure(hartung_design), "hartung_sleeve_force")


def _design_flywheel(given: GivenInputs, figures: FigureFiles) -> tuple[console.CommandResult, tuple[str, ...]]:
    from governor_mechanism.studies.flywheel.design import design_flywheel
    from governor_mechanism.studies.flywheel.inputs import PAPER_INPUTS
    from governor_mechanism.studies.flywheel.paper_comparison import compare_with_paper
    from governor_mechanism.studies.flywheel.simulation import export_scene_document, format_simulated_wheels, simulate_wheels

    inputs = given.replace(PAPER_INPUTS)
    flywheel_design = design_flywheel(inputs)
    comparison = compare_with_paper() if inputs == PAPER_INPUTS else None
    with console.show_status("simulating"):
        simulated = simulate_wheels(flywheel_design, comparison)
    comment = "The engine of `design flywheel` with its flywheel, under the load that closes the cycle; Redtenbacher, 1853."
    files = [
        _write_scene(export_scene_document(flywheel_design, flywheel_design.inertia), comment, figures.folder / "flywheel_design.toml")
    ]
    if figures.formats:
        from governor_mechanism.render.figures.flywheel.design import draw_flywheel_plate

        with console.show_status("drawing"):
            files += figures.save(draw_flywheel_plate(flywheel_design, simulated, comparison), "flywheel_design")
    values: dict[str, object] = {"design": flywheel_design.as_json(), "simulated": [wheel.as_json() for wheel in simulated]}
    text = [*flywheel_design.summary_lines(), f"\n{format_simulated_wheels(simulated)}"]
    if comparison is not None:
        values["paper"] = comparison.as_json()
        text = [f"{comparison}\n", *text]
    return console.CommandResult(text=text, values=values, files=files), flywheel_design.warnings


def _design_governed_engine(given: GivenInputs, figures: FigureFiles) -> tuple[console.CommandResult, tuple[str, ...]]:
    from governor_mechanism.studies.governed_engine.design import design_governed_engine
    from governor_mechanism.studies.governed_engine.inputs import DEFAULT_INPUTS
    from governor_mechanism.studies.governed_engine.simulation import simulate_design

    engine_design = design_governed_engine(given.replace(DEFAULT_INPUTS))
    with console.show_status("simulating"):
        simulated = simulate_design(engine_design)
    comment = (
        "The engine of `design governed-engine` under its governor; the load falls to the half.\n"
        "The resistance at the sleeve is left out: add dry_friction to the effects of the governor."
    )
    files = [_write_scene(engine_design.scene_document, comment, figures.folder / "governed_engine_design.toml")]
    if figures.formats:
        from governor_mechanism.render.figures.governed_engine_design import governed_engine_figure

        with console.show_status("drawing"):
            files += figures.save(governed_engine_figure(engine_design, simulated), "governed_engine_design")
    values = {"design": engine_design.as_json(), "simulated": simulated.as_json()}
    text = [*engine_design.summary_lines(), f"\n{simulated}"]
    return console.CommandResult(text=text, values=values, files=files, ok=simulated.ok), engine_design.warnings


def _design_pendulum(given: GivenInputs, figures: FigureFiles) -> tuple[console.CommandResult, tuple[str, ...]]:
    from governor_mechanism.studies.pendulum.design import design_pendulum
    from governor_mechanism.studies.pendulum.inputs import DEFAULT_INPUTS
    from governor_mechanism.studies.pendulum.simulation import simulate_design

    pendulum_design = design_pendulum(given.replace(DEFAULT_INPUTS))
    with console.show_status("simulating"):
        simulated = simulate_design(pendulum_design)
    comment = (
        "A pendulum governor, designed by steps I to VIII of L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.\n"
        "Its resistance holds it half way up until the rising speed leaves the band of insensitivity."
    )
    files = [_write_scene(pendulum_design.scene_document, comment, figures.folder / "pendulum_design.toml")]
    if figures.formats:
        with console.show_status("drawing"):
            files += _write_pendulum_figures(pendulum_design, simulated, figures)
    values = {"design": pendulum_design.as_json(), "simulated": simulated.as_json()}
    text = [pendulum_design, f"\n{simulated}"]
    return console.CommandResult(text=text, values=values, files=files, ok=simulated.ok), pendulum_design.warnings


def _write_pendulum_figures(pendulum_design: PendulumDesign, simulated: SimulatedDesign, figures: FigureFiles) -> list[Path]:
    """Draw the design, and if its path osculates a parabola Zehnder's plate of them, which then starts in the lowest position."""
    from governor_mechanism.render.figures.parabolic.isochronous_data import has_isochronous_parabolas
    from governor_mechanism.render.figures.parabolic.isochronous_plate import isochronous_figure
    from governor_mechanism.render.figures.pendulum_design import pendulum_figure

    files = figures.save(pendulum_figure(pendulum_design, simulated), "pendulum_design")
    if pendulum_design.is_osculating and has_isochronous_parabolas(pendulum_design.scene):
        files += figures.save(isochronous_figure(pendulum_design.scene), "pendulum_design_parabolas")
    return files


def _design_hartnell(given: GivenInputs, figures: FigureFiles) -> tuple[console.CommandResult, tuple[str, ...]]:
    from governor_mechanism.studies.hartnell.design import design_hartnell
    from governor_mechanism.studies.hartnell.inputs import DEFAULT_INPUTS
    from governor_mechanism.studies.hartnell.simulation import simulate_design

    hartnell_design = design_hartnell(given.replace(DEFAULT_INPUTS))
    with console.show_status("simulating"):
        simulated = simulate_design(hartnell_design)
    comment = (
        "A Hartnell governor with the spring of `design hartnell`: exact statics, with the weight of the balls.\n"
        "The dashpot and the steps of the speed are not part of the design."
    )
    files = [_write_scene(hartnell_design.scene_document, comment, figures.folder / "hartnell_design.toml")]
    if figures.formats:
        from governor_mechanism.render.figures.hartnell_design import hartnell_figure

        with console.show_status("drawing"):
            files += figures.save(hartnell_figure(hartnell_design), "hartnell_design")
    values = {"design": hartnell_design.as_json(), "simulated": simulated.as_json()}
    text = [hartnell_design, f"\n{simulated}"]
    return console.CommandResult(text=text, values=values, files=files, ok=simulated.ok), hartnell_design.warnings
