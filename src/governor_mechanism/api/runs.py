"""Runs and films, and a mechanism under the hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import FilmKeywords, FilmOptions, show_film_options
from governor_mechanism.units.problems import FLAG, PATH, check_arguments


@check_arguments(certify=FLAG)
def run(
    scene: gm.SceneSource,
    engine: str | gm.Engine = "auto",
    accuracy: float | None = None,
    times: gm.QuantityValues | None = None,
    certify: bool = True,
    start: gm.MotionState | None = None,
) -> gm.Trajectory:
    """Simulate a scene.

    A run that ends early returns normally; its `outcome` says why it ended.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    engine
        Name of an engine, "auto" for the cheapest suitable one, or an engine with its own settings.
    accuracy
        Largest error relative to the scale of each reading; that of the scene if None.
    times
        Reported times, s, or texts with a unit; shape (n,). Those of the scene if None.
    certify
        Whether to estimate the error by further runs, and to refine until the accuracy is met.
    start
        State to go on from, as `run.state()`, of this scene or of one with other numbers; the start of the scene if None. Time 0 of the run
        is the time of the state, where everything that the scene prescribes over time goes on.

    Returns
    -------
    Trajectory
        Motion, readings, energies, events, error estimate and cost.

    Raises
    ------
    MechanismError
        If the scene or an argument is wrong.
    UnsupportedEffect
        If the engine cannot model an effect or a joint of the scene.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> run = gm.run("porter", accuracy=1e-8)
    >>> run.outcome.ok, run.error_estimate <= 1e-8
    (True, True)
    >>> round(float(run.readings["arm_angle"].max()), 4)  # rad
    0.6981
    """
    from governor_mechanism.engines import select_engine
    from governor_mechanism.engines.continuation import continue_scene
    from governor_mechanism.units.quantities import convert_texts

    resolved_scene = as_scene(scene) if start is None else continue_scene(as_scene(scene), start)
    name = resolved_scene.run.engine if isinstance(engine, str) and engine == "auto" else engine
    selected_engine, reason = select_engine(name, resolved_scene, accuracy)
    reported_times = convert_texts(times, "time", "times")
    return selected_engine.run(resolved_scene, times=reported_times, accuracy=accuracy, certify=certify, reason=reason)


@check_arguments(path=PATH)
def open_run(path: str | Path) -> gm.Trajectory:
    """Read a run that `run.save` or the command `run` wrote, with the same arrays, events and accuracy.

    Parameters
    ----------
    path
        The folder of the run, or one of its files if the folder holds several runs.

    Returns
    -------
    Trajectory
        The run.

    Raises
    ------
    MechanismError
        If there is no such run, its file is damaged or of another version, or no scene file describes its scene.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> run = gm.run("porter", times=[0.0, 0.5, 1.0])
    >>> [file.suffix for file in run.save("results", figures=False)]
    ['.csv', '.nc', '.json']
    >>> bool((gm.open_run("results").readings["arm_angle"] == run.readings["arm_angle"]).all())
    True
    """
    from governor_mechanism.files.netcdf import open_saved_run

    return open_saved_run(path)


@show_film_options
def film(
    run: gm.Trajectory | Sequence[gm.Trajectory],
    path: str | Path,
    *,
    titles: Sequence[str] | None = None,
    progress: gm.Progress | None = None,
    **options: Unpack[FilmKeywords],
) -> Path:
    """Write one run, or several side by side, as an animation.

    Runs share the axes of their readings and, if their machines are of like kind and size, their scale. A run that ends before the others
    rests in its last position, and says when it ended. The options are those of `FilmOptions`.

    Parameters
    ----------
    run
        A run, or a list of up to 6.
    path
        File that ends in .gif, .mp4, .webm, .svg or .html; .mp4 and .webm need the optional dependency `video`, .svg is an animated drawing
        of one run, and .html an interactive page of one run.
    titles
        Titles of several runs; those of their scenes if None.
    progress
        Called as ``progress(done, total)`` after each frame; once for a page.

    Returns
    -------
    Path
        Path of the film. No file is left behind if an exception is raised.

    Raises
    ------
    MechanismError
        If the path, the runs, the titles or an option is not valid, or ffmpeg is missing for .mp4 or .webm.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.film(gm.run("porter", times=[0.0, 0.1, 0.2]), "porter.gif").name
    'porter.gif'
    """
    from governor_mechanism.render.film.writer import write_film

    return write_film(run, path, FilmOptions(**options), titles=titles, progress=progress)


def open(*scenes: gm.SceneSource, port: int = 0, browser: bool = True) -> None:
    """Open a scene in the browser, where its quantities are changed and its points dragged; it ends with an interrupt.

    Several scenes stand beside each other; without any, there is a list to choose from. Each is the path of a file, the name of a
    shipped scene, or a scene.

    Each change is answered by a certified run. The page is served to this machine alone, under an address that no other page knows.

    Parameters
    ----------
    port
        Port of the page; 0 takes any free one.
    browser
        Whether the page is opened; its address is printed anyway.

    Raises
    ------
    MechanismError
        If the extra `live` is not installed, a scene cannot be run, there are more than four, or the port is taken.
    """
    try:
        from governor_mechanism.live.server import serve
    except ImportError as error:
        text = f"the live page needs starlette, uvicorn and websockets ({error}); install the extra: pip install 'governor-mechanism[live]'"
        raise MechanismError(text) from None
    serve([as_scene(one) for one in scenes], port, opens_browser=browser, tell=lambda address: print(f"{address}\nCtrl-C ends it"))
