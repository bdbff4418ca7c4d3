"""The commands `sensitivities`, `fit` and `optimise`; heavy imports are made when one needs them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import governor_mechanism as gm
from governor_mechanism.cli import console
from governor_mechanism.cli.compare import SideBySideFormat
from governor_mechanism.cli.options import Changes, SceneName, load_changed, refuse_idle_options, stem_of
from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figure_files import FigureFiles

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
    levels, intervals = _read_noise(noise or []), [tuple(one.split(":")) for one in without or []]
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
        with console.show_progress_bar("film") as progress:
            runs = [gm.run(one) for one in (optimum.before, optimum.scene)]
            files.append(gm.film(runs, figures.folder / f"{stem}.{film.value}", titles=["before", "after"], progress=progress))
    return console.CommandResult(optimum, files=files, ok=optimum.ok)
