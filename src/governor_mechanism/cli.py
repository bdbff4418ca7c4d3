"""The command line: `governor-mechanism models | run | crosscheck`. Heavy imports wait until a command needs them."""

from __future__ import annotations

import functools
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from governor_mechanism.errors import GovernorMechanismError, MechanismError

if TYPE_CHECKING:
    from governor_mechanism.trajectory import Trajectory

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

app = typer.Typer(
    name="governor-mechanism",
    help="Simulate, film and cross-check the mechanisms that once controlled machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A TOML file, or the name of a shipped scene.")]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output and nothing else there.")
]


class FilmFormat(StrEnum):
    """How a run is filmed."""

    GIF = "gif"
    MP4 = "mp4"


def main() -> None:
    """Entry point of the command."""
    try:
        app()
    except KeyboardInterrupt:  # before a command was reached
        _say("interrupted")
        raise SystemExit(INTERRUPTED) from None


def _guarded(command: Callable[..., int]) -> Callable[..., None]:
    """Turn a command's failures into one sentence each and an exit status."""

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        try:
            status = command(*args, **options)
        except MechanismError as error:
            status = _refuse(list(error.problems), as_json=bool(options.get("as_json")))
        except GovernorMechanismError as error:
            status = _refuse([str(error)], as_json=bool(options.get("as_json")))
        except OSError as error:
            status = _refuse(
                [f"cannot write {error.filename or 'the results'}: {error.strerror or error}"], as_json=False
            )
        except KeyboardInterrupt:
            _say("interrupted; files already complete were kept, no half-written one was left")
            status = INTERRUPTED
        raise typer.Exit(status)

    return guarded


@app.command()
@_guarded
def models(as_json: AsJson = False) -> int:
    """List the shipped scenes, one line each."""
    from governor_mechanism.library import shipped, title_of

    scenes = {name: title_of(path) for name, path in shipped().items()}
    if as_json:
        _print_json({"models": [{"name": name, "title": title} for name, title in scenes.items()]})
        return OK
    width = max(map(len, scenes))
    for name, title in scenes.items():
        print(f"{name:<{width}}  {title}")
    return OK


@app.command()
@_guarded
def run(
    scene: SceneName,
    engine: Annotated[str, typer.Option(help="auto, or the name of an engine; the scene's own if left out.")] = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Relative to each reading's scale; the scene's own.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("results"),
    film: Annotated[FilmFormat, typer.Option(help="Kind of film; mp4 needs the extra 'video'.")] = FilmFormat.GIF,
    no_film: Annotated[bool, typer.Option("--no-film", help="Leave the film out.")] = False,
    as_json: AsJson = False,
) -> int:
    """Simulate a scene; write its film, figure, readings (CSV), arrays (netCDF) and a record (JSON)."""
    import governor_mechanism as gm
    from governor_mechanism.saving import summary

    result = gm.run(gm.load(scene), engine=engine, accuracy=accuracy)
    stem = Path(result.scene.source).stem or "scene"
    files = _write(result, out, stem, None if no_film else film)
    if as_json:
        _print_json({**summary(result), "files": [str(path) for path in files]})
    else:
        print(describe(result))
        print("wrote " + ", ".join(str(path) for path in files))
    if not result.outcome.ok:
        _say(result.message)
    return OK if result.outcome.ok else FAILED


@app.command()
@_guarded
def crosscheck(scene: SceneName, as_json: AsJson = False) -> int:
    """Compare the simulation of a scene with every closed form that applies; exit status 1 when one does not agree."""
    import governor_mechanism as gm

    report = gm.crosscheck(gm.load(scene))
    if as_json:
        rows = [
            {
                "quantity": row.quantity,
                "simulated": row.simulated,
                "expected": row.expected,
                "difference": row.difference,
                "allowed": row.allowed,
                "unit": row.unit,
                "reason": row.reason,
                "passed": row.passed,
            }
            for row in report.rows
        ]
        _print_json({"title": report.title, "against": report.against, "passed": report.passed, "rows": rows})
    else:
        print(report)
    return OK if report.passed else FAILED


def describe(result: Trajectory) -> str:
    """A run in a few lines: how it ended, how accurate, where it is, what it cost."""
    cost = result.cost
    asked = result.settings["asked_accuracy"]
    accurate = "" if result.error_estimate is None else f"accurate to {result.error_estimate:.1g} (asked {asked:.1g}); "
    final = ", ".join(f"{name} {_everyday(values[-1], result.units[name])}" for name, values in result.readings.items())
    laws = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    return "\n".join(
        [
            result.scene.title,
            f"{result.message}",
            f"{accurate}joints closed to {result.joint_gap.max():.1e} m, energy drift {result.energy.drift:.1e}",
            f"at {result.times[-1]:g} s: {final}",
            f"engine {cost.engine} ({cost.reason}): {cost.runs} runs, {cost.steps:,} steps, "
            f"finest {cost.step * 1e3:.3g} ms, {cost.iterations} iterations, {cost.wall_time:.2g} s",
            f"law evaluations: {laws or 'none'}",
        ]
    )


def _everyday(value: float, unit: str) -> str:
    """A reading in the unit an engineer says it in."""
    factors = {"rad": (57.29577951308232, "deg"), "m": (1e3, "mm"), "rad/s": (9.549296585513721, "rpm")}
    factor, name = factors.get(unit, (1.0, unit))
    return f"{value * factor:.4f} {name}"


def _write(result: Trajectory, out: Path, stem: str, film: FilmFormat | None) -> list[Path]:
    """Write every result; the record comes last, so that where it stands the others are complete."""
    import governor_mechanism as gm
    from governor_mechanism.render.figures import readings_figure
    from governor_mechanism.saving import save_csv, save_json, save_netcdf

    if out.exists() and not out.is_dir():
        raise MechanismError(f"--out {out} is a file; give the name of a folder")
    out.mkdir(parents=True, exist_ok=True)
    files = {kind: out / f"{stem}.{kind}" for kind in ("csv", "nc", "png", "json")}
    save_csv(result, files["csv"])
    save_netcdf(result, files["nc"])
    readings_figure(result, files["png"])
    written = [files["csv"], files["nc"], files["png"]]
    if film is not None and len(result.times) > 1:
        with _progress("film") as progress:
            written.insert(0, gm.film(result, out / f"{stem}.{film.value}", progress=progress))
    save_json(result, files["json"])
    return [*written, files["json"]]


@contextmanager
def _progress(what: str) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on a terminal, nothing in a pipe."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _refuse(problems: list[str], *, as_json: bool) -> int:
    for problem in problems:
        _say(problem)
    if as_json:
        _print_json({"outcome": "bad_input", "problems": problems})
    return BAD_INPUT


def _say(message: str) -> None:
    print(message, file=sys.stderr)


def _print_json(value: dict[str, Any]) -> None:
    print(json.dumps(value, indent=2, allow_nan=False))


if __name__ == "__main__":
    main()
