"""The commands `sensitivities`, `fit`, `optimise` and `synthesise ...`; heavy imports are made when one needs them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.compare import SideBySideFormat, film_side_by_side
from governor_mechanism.cli.options import Changes, SceneName, load_changed, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import FilmOptions
from governor_mechanism.render.figure_files import FigureFiles

if TYPE_CHECKING:
    from governor_mechanism.studies.synthesis.dimensions import DimensionSynthesis
    from governor_mechanism.studies.synthesis.linkage import Synthesis


Unknowns = Annotated[list[str], typer.Option(help="An unknown with its bounds: dimensions.ball_mass=4kg:6kg. Repeatable.")]


def sensitivities(
    scene: SceneName,
    of: Annotated[
        list[str],
        typer.Option(help='A number taken from the run, as in a sweep: sleeve_lift, "max arm_angle", "frequency of ...". Repeatable.'),
    ],
    by: Annotated[list[str], typer.Option(help="A key of the scene that has a number, as dimensions.arm. Repeatable.")],
    changes: Changes = None,
    engine: console.EngineOfRuns = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Accuracy of the runs, relative to the scale of each reading. [1e-10]")] = None,
    workers: console.Workers = 1,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the derivatives of numbers by keys of a scene, with their errors; write a figure, a table (CSV) and a record (JSON).

    The exit status is 1 if a derivative does not exist, since a contact begins or ends there, or a value has a kink.
    """
    loaded = load_changed(scene, changes)
    with console.show_status("differentiating"):
        result = gm.sensitivities(loaded, of, by, engine=engine, accuracy=accuracy, workers=workers)
    stem = f"{stem_of(loaded)}_sensitivities"
    files = figures.save_data(result, stem)
    if any(row.elasticity is not None for row in result.rows):
        files += figures.save_figures(result, stem)
    return console.CommandResult(result, files=files, ok=result.ok)


def fit(
    scene: SceneName,
    data: Annotated[
        Path, typer.Option(help="A CSV file: a column time, and one for each measured reading, with units as in 'sleeve_lift [mm]'.")
    ],
    over: Unknowns,
    changes: Changes = None,
    noise: Annotated[
        list[str] | None,
        typer.Option(
            help='Standard deviation of the measured values, "0.1 mm", or of one reading, "sleeve_lift=0.1 mm". [from the residuals]'
        ),
    ] = None,
    without: Annotated[list[str] | None, typer.Option(help="An interval of time that does not count: 1s:1.5s. Repeatable.")] = None,
    profile: Annotated[
        list[str] | None, typer.Option(help="An unknown whose interval is found by fitting all others again. Repeatable.")
    ] = None,
    engine: console.EngineOfRuns = "auto",
    starts: Annotated[int, typer.Option(help="Number of starts of the search: the scene's own values, and random ones.")] = 2,
    seed: Annotated[int, typer.Option(help="Seed of the random starts.")] = 0,
    workers: Annotated[int, typer.Option(help="Largest number of processes for several starts.")] = 1,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the values with which a scene fits measured readings best; write them as a scene, a table (CSV), a record and a figure.

    Values have standard errors and 95 % intervals; combinations that the data do not determine are named. Ctrl-C keeps the best values
    so far. The exit status is 1 if the search does not converge.
    """
    loaded = load_changed(scene, changes)
    levels = _read_noise(noise or [])
    intervals = [tuple(one.split(":")) for one in without or []]
    with console.show_status("fitting"), console.first_interrupt_is_answered():
        options: dict[str, Any] = {"engine": engine, "starts": starts, "seed": seed, "workers": workers}
        result = gm.fit(loaded, data, over, noise=levels, without=intervals, profile=profile or (), **options)
    stem = f"{stem_of(loaded)}_fit"
    scene_file = result.scene.save(figures.folder / f"{stem}.toml")
    return console.CommandResult(result, files=[scene_file, *figures.save_all(result, stem)], ok=result.ok)


def _read_noise(noise: list[str]) -> str | dict[str, str] | None:
    """Return one standard deviation for all readings, or one for each."""
    pairs = [one.partition("=") for one in noise]
    if all(separator for _, separator, _ in pairs):
        return {name.strip(): level for name, _, level in pairs} or None
    if len(pairs) > 1:
        raise MechanismError('noise: give one standard deviation for all readings, as "0.1 mm", or each with a name, "sleeve_lift=0.1 mm"')
    return noise[0]


def optimise(
    scene: SceneName,
    over: Unknowns,
    minimise: Annotated[
        list[str] | None,
        typer.Option(help='What is made least: a quantity as in a sweep, "max sleeve_lift". Two objectives give their trade-off.'),
    ] = None,
    maximise: Annotated[list[str] | None, typer.Option(help="What is made greatest instead. Repeatable.")] = None,
    subject_to: Annotated[
        list[str] | None, typer.Option(help='A condition: "max sleeve_lift <= 120 mm", with <=, >= or =. Repeatable.')
    ] = None,
    report: Annotated[list[str] | None, typer.Option(help="A further quantity that is stated before and after. Repeatable.")] = None,
    changes: Changes = None,
    is_global: Annotated[bool, typer.Option("--global", help="Search all of the bounds first, and not from the starts alone.")] = False,
    starts: Annotated[int, typer.Option(help="Number of starts of a local search: the scene's own values, and random ones.")] = 1,
    seed: Annotated[int, typer.Option(help="Seed of the random numbers.")] = 0,
    points: Annotated[int, typer.Option(help="Number of points of a trade-off.")] = 7,
    engine: console.EngineOfRuns = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Accuracy of the runs, relative to the scale of each reading. [1e-8]")] = None,
    workers: Annotated[int, typer.Option(help="Largest number of processes.")] = 1,
    film: Annotated[SideBySideFormat | None, typer.Option(help="Write a film of before and after side by side, in this format.")] = None,
    *,
    figures: FigureFiles,
    as_json: console.AsJson = False,
) -> console.CommandResult:
    """Find the values with which a quantity of a scene is least or greatest, under conditions; write scene, table, record and figure.

    An impossible geometry lies outside. Ctrl-C keeps the best values so far, and the same command continues. The exit status is 1 if the
    search does not converge, or nothing that it found meets all conditions.
    """
    loaded = load_changed(scene, changes)
    options: dict[str, Any] = {"method": "global" if is_global else "local", "starts": starts, "seed": seed, "engine": engine}
    options |= {"accuracy": accuracy, "workers": workers, "subject_to": subject_to or ()}
    least, greatest = minimise or [], maximise or []
    if is_global:
        refuse_idle_options("starts", condition="with --global")
    if len(least) + len(greatest) > 1:
        refuse_idle_options("report", "film", condition="with two objectives")
        with console.show_status("optimising"):
            result = gm.trade_off(loaded, over, minimise=least, maximise=greatest, points=points, **options)
        return console.CommandResult(result, files=figures.save_all(result, f"{stem_of(loaded)}_trade_off"), ok=result.ok)
    refuse_idle_options("points", condition="without a second objective")
    goals: dict[str, Any] = {"minimise": least[0] if least else None, "maximise": greatest[0] if greatest else None, "report": report or ()}
    stem = f"{stem_of(loaded)}_optimum"
    with console.show_status("optimising"), console.first_interrupt_is_answered():
        optimum = gm.optimise(loaded, over, **goals, **options, out=figures.folder / f"{stem}.part")
    files = [optimum.scene.save(figures.folder / f"{stem}.toml"), *figures.save_all(optimum, stem)]
    if film is not None:
        with console.show_status("simulating"):
            runs = [gm.run(one) for one in (optimum.before, optimum.scene)]
        files += film_side_by_side(runs, figures.folder / f"{stem}.{film.value}", FilmOptions(), ["before", "after"])
    return console.CommandResult(optimum, files=files, ok=optimum.ok)


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
