"""The commands that run a scene many times: `accuracy`, `effects`, `regulation`, `sweep`.

Heavy imports wait until a command needs them.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from governor_mechanism.cli.console import FAILED, OK, guarded_command, print_json, progress_bar, say, working
from governor_mechanism.cli.options import RESULTS, AsJson, FigureFolder, NoFigure, SceneName, prepare_folder

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene


@guarded_command
def accuracy(
    scene: SceneName,
    wanted: Annotated[
        float | None, typer.Option("--for", help="An error, relative to each reading's scale: what reaches it soonest.")
    ] = None,
    longest: Annotated[float, typer.Option(help="Seconds that one setting may take, the reference not.")] = 1.0,
    out: FigureFolder = RESULTS,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Measure the error and the time of every engine at every setting; write figure, table (CSV) and record (JSON)."""
    import governor_mechanism as gm
    from governor_mechanism.studies.work_precision.results import require_error

    if wanted is not None:
        require_error(wanted)
    prepare_folder(out)
    opened = gm.load(scene)
    with progress_bar("accuracy") as progress:
        study = gm.accuracy_study(opened, longest, progress)
    stem = f"{Path(opened.source).stem or 'scene'}_accuracy"
    files = [study.save_csv(out / f"{stem}.csv"), study.save_json(out / f"{stem}.json")]
    told = wanted is None or wanted >= study.reference.floor
    reached = wanted is None or (told and study.cheapest_for(wanted) is not None)
    advice = None if wanted is None else study.advice(wanted) if told else study.too_fine(wanted)
    if not no_figure:
        from governor_mechanism.render.figures.work_precision import accuracy_figure

        files.append(accuracy_figure(study, out / f"{stem}.png", wanted if told else None))
    if as_json:
        asked = {} if wanted is None else {"for": wanted, "advice": advice, "reached": reached}
        print_json({**study.as_json(), **asked, "files": [str(path) for path in files]})
    else:
        print("\n".join([str(study), *([advice] if advice else []), *(f"wrote {path}" for path in files)]))
    return OK if reached else FAILED


@guarded_command
def effects(
    scene: SceneName,
    engine: Annotated[str, typer.Option(help="One engine for all the runs.")] = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Relative to each reading's scale.")] = None,
    out: FigureFolder = RESULTS,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Show what each effect of a scene changes and what it costs, and which may be left out."""
    import governor_mechanism as gm

    prepare_folder(out)
    opened = gm.load(scene)
    with progress_bar("effects") as progress:
        study = gm.effects_study(opened, engine, accuracy, progress)
    files = []
    if not no_figure:
        from governor_mechanism.render.figures.effect_ablation import effects_figure

        files.append(effects_figure(study, out / f"{Path(opened.source).stem or 'scene'}_effects.png"))
    if as_json:
        print_json({**study.as_json(), "files": [str(path) for path in files]})
    else:
        print(study)
        print("".join(f"wrote {path}" for path in files))
    return OK


class Regulation(StrEnum):
    """What is asked about how a governor regulates."""

    TWITCH = "twitch"
    PLAY = "play"
    SETTLING = "settling"
    JUMP = "jump"


@guarded_command
def regulation(
    study: Annotated[Regulation, typer.Argument(help="What to ask.")],
    scene: Annotated[str, typer.Argument(help="Of a scene of yours; a shipped one where it is left out.")] = "",
    out: FigureFolder = RESULTS,
) -> int:
    """Twitching against unevenness or play, settling against the brake, the jump against the ramp; many runs each."""
    from governor_mechanism.render.figures import regulation as figures
    from governor_mechanism.studies.regulation import registry as studies

    prepare_folder(out)
    path = out / f"{study.value}.png"
    with working("running"):
        match study:
            case Regulation.TWITCH:
                twitched = studies.twitch(_scene(scene, "porter_twitch"), studies.SHARES)
                figures.twitch_figure(twitched, path)
                told = f"twitches from {twitched.threshold:.6g} of the standing band on, which is {twitched.band:.6g}"
            case Regulation.PLAY:
                names = [scene] if scene else ["porter_play", "watt_play"]
                played = [studies.play_and_twitch(_scene(name, ""), studies.PLAYS) for name in names]
                figures.play_figure(played, path)
                told = "\n".join(f"{one.title}: {one.finding}" for one in played)
            case Regulation.SETTLING:
                settled = studies.settling(_scene(scene, "porter_load_step"), studies.BRAKES)
                figures.settling_figure(settled, path)
                told = f"settles soonest, in {settled.best[1]:.4g} s, with a brake of {settled.best[0]:.4g} N s/m"
            case Regulation.JUMP:
                jumped = studies.jump(_scene(scene, "watt_improved"), studies.RATES)
                figures.jump_figure(jumped, path)
                told = (
                    f"falls {jumped.falling_exponent.value:.4f} +- {jumped.falling_exponent.scatter:.1g} (exponent of "
                    f"the rate) below {jumped.fold_speed:.6g} rad/s, jumps above {jumped.stop_speed:.6g} rad/s"
                )
    print(f"{told}\nwrote {path}")
    return OK


def _scene(name: str, shipped: str) -> Scene:
    import governor_mechanism as gm

    return gm.load(name or shipped)


@guarded_command
def sweep(
    scene: SceneName,
    vary: Annotated[
        list[str],
        typer.Option(help="key=first:last:count or key=value,value,... as dimensions.arm=200mm:400mm:50; repeatable."),
    ],
    quantity: Annotated[
        list[str] | None,
        typer.Option(help='As "max arm_angle", "rate of arm_angle", "duration"; repeatable. [leading coordinate]'),
    ] = None,
    engine: Annotated[str, typer.Option(help="One engine for all rows; the scene's own if left out.")] = "auto",
    accuracy: Annotated[float | None, typer.Option(help="Relative to each reading's scale; the scene's own.")] = None,
    certify: Annotated[bool, typer.Option("--certify", help="Estimate the error of every run.")] = False,
    workers: Annotated[int, typer.Option(help="Processes; the result does not depend on it.")] = 1,
    out: Annotated[Path, typer.Option(help="Folder for table, record and figure, where the sweep goes on.")] = RESULTS,
    no_figure: NoFigure = False,
    as_json: AsJson = False,
) -> int:
    """Run a scene at a grid or list of values of its keys; started again after an interruption it goes on."""
    import governor_mechanism as gm
    from governor_mechanism.studies.sweep.checkpoint import journal_path

    prepare_folder(out)
    opened = gm.load(scene)
    journal = journal_path(out, opened.source)
    counted = _Counted()
    try:
        with progress_bar("sweep") as counted.bar:
            found = gm.sweep(
                opened,
                vary,
                quantity or None,
                engine=engine,
                accuracy=accuracy,
                certify=certify,
                workers=workers,
                out=out,
                progress=counted,
            )
    except KeyboardInterrupt:
        if journal.exists():
            say(f"{counted.done} of {counted.total} rows are in {journal}; the same command goes on from there")
        raise
    files = [journal.with_suffix(kind) for kind in (".csv", ".json")]
    if not no_figure:
        from governor_mechanism.render.figures.sweep import sweep_figure

        files.append(sweep_figure(found, journal.with_suffix(".png")))
    if as_json:
        print_json({**found.as_json(), "files": [str(path) for path in files]})
    else:
        print("\n".join([str(found), *(f"wrote {path}" for path in files)]))
    return OK if found.ok else FAILED


class _Counted:
    """Passes progress on to a bar, where there is one, and remembers it."""

    def __init__(self) -> None:
        self.done = self.total = 0
        self.bar: Callable[[int, int], None] | None = None

    def __call__(self, done: int, total: int) -> None:
        self.done, self.total = done, total
        if self.bar is not None:
            self.bar(done, total)
