"""The command line: `models`, `run`, `equilibria`, `crosscheck`. Heavy imports wait until a command needs them."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.console import (
    BAD_INPUT,
    FAILED,
    INTERRUPTED,
    OK,
    Answered,
    guarded_command,
    number,
    print_json,
    progress_bar,
    say,
    working,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import DrivenSlide, DrivenTurn

if TYPE_CHECKING:
    from governor_mechanism.characteristic import Equilibrium, SpeedCurve
    from governor_mechanism.scene import Scene
    from governor_mechanism.trajectory import Trajectory

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
    except Answered:
        raise
    except SystemExit as stop:
        if stop.code == BAD_INPUT and "--json" in sys.argv:
            print_json({"outcome": "bad_input", "problems": ["the command's words are off; see --help"]})
        raise
    except KeyboardInterrupt:  # before a command was reached
        say("interrupted")
        raise SystemExit(INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        from governor_mechanism import __version__

        print(__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Simulate, film and cross-check the mechanisms that once controlled machines."""


@app.command()
@guarded_command
def models(as_json: AsJson = False) -> int:
    """List the shipped scenes, one line each."""
    from governor_mechanism.library import shipped, title_of

    scenes = {name: title_of(path) for name, path in shipped().items()}
    if as_json:
        print_json({"models": [{"name": name, "title": title} for name, title in scenes.items()]})
        return OK
    width = max(map(len, scenes))
    for name, title in scenes.items():
        print(f"{name:<{width}}  {title}")
    return OK


@app.command()
@guarded_command
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

    if film is FilmFormat.MP4 and not no_film:
        from governor_mechanism.render.film import require_video_writer

        require_video_writer()
    _prepare_folder(out)
    opened = gm.load(scene)
    with working("simulating"):
        result = gm.run(opened, engine=engine, accuracy=accuracy)
    stem = Path(result.scene.source).stem or "scene"
    files = _write(result, out, stem, None if no_film else film)
    if as_json:
        print_json({**summary(result), "files": [str(path) for path in files]})
    else:
        print(describe(result))
        print("wrote " + ", ".join(str(path) for path in files))
        if not result.outcome.ok:
            say(result.message)
    return OK if result.outcome.ok else FAILED


@app.command()
@guarded_command
def crosscheck(scene: SceneName, as_json: AsJson = False) -> int:
    """Compare the simulation of a scene with every closed form that applies; exit status 1 when one does not agree."""
    import governor_mechanism as gm

    opened = gm.load(scene)
    with working("simulating"):
        report = gm.crosscheck(opened)
    if as_json:
        rows = [
            {
                "quantity": row.quantity,
                "simulated": number(row.simulated),
                "expected": number(row.expected),
                "difference": number(row.difference),
                "allowed": row.allowed,
                "unit": row.unit,
                "reason": row.reason,
                "passed": row.passed,
            }
            for row in report.rows
        ]
        print_json(
            {
                "title": report.title,
                "against": report.against,
                "passed": report.passed,
                "rows": rows,
                "notes": list(report.notes),
            }
        )
    else:
        print(report)
    return OK if report.passed else FAILED


@app.command()
@guarded_command
def equilibria(
    scene: SceneName,
    speed: Annotated[
        str | None, typer.Option(help='Of the spindle, as "6.4 rad/s" or "61 rpm"; the scene\'s own.')
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the figure.")] = Path("results"),
    no_figure: Annotated[bool, typer.Option("--no-figure", help="Leave the figure out.")] = False,
    as_json: AsJson = False,
) -> int:
    """Find every position of rest at a speed, with its stability; draw the characteristic, speed against travel."""
    import governor_mechanism as gm
    from governor_mechanism.units import parse

    _prepare_folder(out)
    opened = gm.load(scene)
    wanted = None if speed is None else parse(speed, "angular_speed", "--speed")
    found = gm.equilibria(opened, wanted)
    curve = gm.speed_curve(opened)
    name = opened.part.mechanism.coordinate
    files = []
    if not no_figure:
        from governor_mechanism.render.characteristic import characteristic_figure

        files.append(
            characteristic_figure(opened, curve, out / f"{Path(opened.source).stem}_characteristic.png", found)
        )
    if as_json:
        kept = ("coordinate", "readings", "stable", "stiffness", "frequency", "growth_rate")
        rests = [{key: getattr(rest, key) for key in kept} for rest in found]
        folds = [{"coordinate": value, "speed": at} for value, at in curve.folds]
        print_json({"coordinate": name, "equilibria": rests, "folds": folds, "files": [str(path) for path in files]})
        return OK
    print("\n".join([opened.title, *_rests(opened, found, curve), *(f"wrote {path}" for path in files)]))
    return OK


def _rests(scene: Scene, found: tuple[Equilibrium, ...], curve: SpeedCurve) -> list[str]:
    """A line for each position of rest, and for each jump."""
    unit = "rad" if scene.part.mechanism.reading(curve.name).quantity == "angle" else "m"
    lines = []
    for rest in found:
        swing, growth = f"stable, swings at {rest.frequency:.6g} rad/s", f"unstable, grows at {rest.growth_rate:.6g} /s"
        where = f"{curve.name.replace('_', ' ')} {_everyday(rest.coordinate, unit)}"
        lines.append(f"{where}: {swing if rest.stable else growth}; stiffness {rest.stiffness:.6g}")
    lines += [] if found else ["no position of rest at this speed within the travel"]
    return lines + [f"jumps at {_everyday(value, unit)}, {_everyday(at, 'rad/s')}" for value, at in curve.folds]


def describe(result: Trajectory) -> str:
    """A run in a few lines: how it ended, how accurate, where it is, what it cost."""
    cost = result.cost
    asked = result.settings["asked_accuracy"]
    estimate = result.error_estimate
    accurate = "" if estimate is None else f"accurate to {estimate:.1g} (asked {asked:.1g}); "
    final = ", ".join(
        f"{name.replace('_', ' ')} {_everyday(values[-1], result.units[name])}"
        for name, values in result.readings.items()
        if len(values)
    )
    gap = result.joint_gap.max(initial=0.0)
    laws = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    return "\n".join(
        [
            result.scene.title,
            result.message,
            *result.notes,
            f"{accurate}joints closed to {gap:.1e} m, energy drift {result.energy.drift:.1e}",
            f"at {result.times[-1] if len(result.times) else 0:g} s: {final}",
            f"{_mobility(result)}; {_passed(result)}",
            f"engine {cost.engine} ({cost.reason}): {cost.runs} runs, {cost.steps:,} steps, simulated in "
            f"{cost.wall_time:.2g} s{f', {cost.method}' if cost.method else ''}",
            f"law evaluations: {laws or 'none'}",
        ]
    )


def _mobility(result: Trajectory) -> str:
    joints = [joint for part in result.scene.parts for joint in part.mechanism.joints]
    drives = sum(isinstance(joint, DrivenTurn | DrivenSlide) for joint in joints)
    return f"mobility {result.mobility}" + (f" beside {drives} driven" if drives else "")


EVENTS = 3
"""So many are told one by one."""


def _passed(result: Trajectory) -> str:
    """What the motion passed, and the joint that carried most."""
    told = [str(event) for event in result.events[:EVENTS]]
    more = len(result.events) - len(told)
    events = "; ".join(told + [f"and {more} more events"] * (more > 0)) or "no dead centre or change point passed"
    forces = {name: reaction.size for name, reaction in result.reactions.items()}
    largest = max(forces, key=lambda name: forces[name].max(initial=0.0), default=None)
    if largest is None or not len(result.times):
        return events
    at = int(forces[largest].argmax())
    loose = [name for name, reaction in result.reactions.items() if not reaction.determined.all()]
    carried = f"largest joint force {forces[largest][at]:.4g} N in {largest!r} at {result.times[at]:.4g} s"
    redundant = f"; not settled by rigid bodies: the forces of {', '.join(map(repr, loose))}" if loose else ""
    return f"{events}\n{carried}{redundant}"


def _everyday(value: float, unit: str) -> str:
    """A reading in the unit an engineer says it in."""
    factors = {"rad": (57.29577951308232, "deg"), "m": (1e3, "mm"), "rad/s": (9.549296585513721, "rpm")}
    factor, name = factors.get(unit, (1.0, unit))
    return f"{round(value * factor, 4) + 0.0:.4f} {name}"  # adding zero: no minus before a zero


def _write(result: Trajectory, out: Path, stem: str, film: FilmFormat | None) -> list[Path]:
    """Write every result: the film, which takes longest, first, and the record last.

    Interrupted in the film, the results of an earlier run stay as they were; where a record stands, all is complete.
    """
    import governor_mechanism as gm
    from governor_mechanism.render.figures import readings_figure
    from governor_mechanism.saving import save_csv, save_json, save_netcdf

    written = []
    if film is not None and len(result.times) > 1:
        with progress_bar("film") as progress:
            written.append(gm.film(result, out / f"{stem}.{film.value}", progress=progress))
    writers = {"csv": save_csv, "nc": save_netcdf, "png": readings_figure, "json": save_json}
    for kind, write in writers.items():
        path = out / f"{stem}.{kind}"
        write(result, path)
        written.append(path)
    return written


def _prepare_folder(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise MechanismError(f"--out {out} is a file; give the name of a folder")
    out.mkdir(parents=True, exist_ok=True)


if __name__ == "__main__":
    main()
