"""The commands `synthesise`: dimensions of four-bars, and of any mechanism, for what is wanted; they import late."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.options import Changes, SceneName, load_changed, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.studies.synthesis.dimensions import DimensionSynthesis
    from governor_mechanism.studies.synthesis.linkage import Synthesis

PointFile = Annotated[str, typer.Argument(metavar="FILE", help="A file of points: CSV with units in the header, or TOML.")]
Take = Annotated[int, typer.Option(help="Number of the linkage whose scene file is written.")]


def function(file: PointFile, take: Take = 1, *, figures: FigureFiles, as_json: console.AsJson = False) -> console.CommandResult:
    """Find the four-bars that generate a function, exactly at three to five angles, by Freudenstein's equation.

    FILE has the columns "input_angle [deg]" and "output_angle [deg]", or as TOML: function = "log10(x)", over = [1, 2],
    input_angles, output_angles, count and ground. The exit status is 1 if there is no linkage without a defect.
    """
    with console.show_status("solving Freudenstein's equation"):
        return _report(gm.synthesise_function(file), file, take, figures)


def positions(
    file: PointFile,
    take: Take = 1,
    draw_map: Annotated[bool, typer.Option("--map", help="For three positions: what each place of the second pivot makes.")] = False,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the four-bars whose coupler passes three, four or five positions of a body, in their order.

    FILE has the columns "x [mm]", "y [mm]" and "angle [deg]", or as TOML: points = [["0 mm", "0 mm", "0 deg"], ...], and for three
    positions fixed_pivots or moving_pivots, two points. With --map the first of them is kept, or else the point of the body; the map is
    written as a table, a record and a figure. The exit status is 1 if there is no linkage without a defect.
    """
    if draw_map:
        refuse_idle_options("take", condition="with --map")
        result, stem = gm.map_pivots(file), f"{Path(file).stem}_map"
        return console.CommandResult(result, files=figures.save_all(result, stem), ok=result.is_possible)
    with console.show_status("running four-bars through the positions"):
        return _report(gm.synthesise_positions(file), file, take, figures)


def path(
    file: PointFile,
    closed: Annotated[bool, typer.Option("--closed", help="The path ends where it starts.")] = False,
    starts: Annotated[int | None, typer.Option(help="Number of random starts. [2000, along a curve 10000]")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the random starts. [0]")] = None,
    take: Take = 1,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the four-bars whose coupler has a point that passes up to nine points, or lies along a curve of more, with their cognates.

    FILE has the columns "x [mm]" and "y [mm]", and "input_angle [deg]" for a timing, or as TOML: points = [["0 mm", "0 mm"], ...], and
    fixed_pivots, two points, closed, starts and seed. The exit status is 1 if there is no linkage without a defect.
    """
    with console.show_status("searching four-bars from random starts"):
        return _report(gm.synthesise_path(file, closed=closed or None, starts=starts, seed=seed), file, take, figures)


def dimensions(
    scene: SceneName,
    point: Annotated[str, typer.Option(help="Name of the point that draws the path, as in run.paths.")],
    path: Annotated[str, typer.Option(metavar="FILE", help='A file of points: CSV with the columns "x [mm]" and "y [mm]", or TOML.')],
    over: Annotated[list[str], typer.Option(help="An unknown with its bounds: dimensions.rocker=2m:3m. Repeatable.")],
    changes: Changes = None,
    along: Annotated[str | None, typer.Option(help="The reading that drives the mechanism. [the angle of the crank]")] = None,
    between: Annotated[str | None, typer.Option(help="First and last value of that reading, 90deg:270deg. [a whole turn]")] = None,
    starts: Annotated[int, typer.Option(help="Number of starts: the scene's own values, and random ones.")] = 6,
    seed: Annotated[int, typer.Option(help="Seed of the random starts.")] = 0,
    take: Take = 1,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the dimensions of a mechanism of your own with which one of its points draws a path.

    The path is passed in the order of its points, wherever it begins. The exit status is 1 if the search does not converge.
    """
    loaded = load_changed(scene, changes)
    ends = None if between is None else between.split(":")
    with console.show_status("searching dimensions"), console.first_interrupt_is_answered():
        result = gm.synthesise_dimensions(loaded, over, point, path, along=along, between=ends, starts=starts, seed=seed)
    return _write(result, f"{stem_of(loaded)}_dimensions", take, figures, ok=result.ok)


def _report(result: Synthesis, file: str, take: int, figures: FigureFiles) -> console.CommandResult:
    """Return what a command prints, after it has written what it found."""
    stem = Path(file).stem
    if not result.rows and take == 1:
        return console.CommandResult(result, files=[], ok=False)
    return _write(result, stem, take, figures, ok=bool(result.rows) and not result.rows[0].check.defects)


def _write(result: Synthesis | DimensionSynthesis, stem: str, take: int, figures: FigureFiles, *, ok: bool) -> console.CommandResult:
    """Return what a command prints, after it has written the scene of one row, the table, the record and the figure."""
    if not 1 <= take <= len(result.rows):
        raise MechanismError(f"--take must be the number of a linkage, 1 to {len(result.rows)}; found {take}")
    scene_file = result.rows[take - 1].scene.save(figures.folder / f"{stem}_{take}.toml")
    return console.CommandResult(result, files=[scene_file, *figures.save_all(result, stem)], ok=ok)


synthesis_app = typer.Typer(
    help="Find four-bars, or dimensions of any mechanism, for what is wanted.", no_args_is_help=True, rich_markup_mode=None
)
for command in (function, positions, path, dimensions):
    console.add_command(synthesis_app, command)
