"""Runs and films."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from governor_mechanism import public_types as gm  # annotations read as users write them
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.units.arguments import FLAG, PATH, check_arguments


def compile_kernels() -> gm.KernelCompilation:
    """Compile all kernels into the cache on disk, so that no later process waits for them: for container images and clusters.

    Without this, each kernel is compiled when it is first needed. Kernels in the cache are not compiled again.

    Returns
    -------
    KernelCompilation
        What was compiled, how long it took, and the folder of the cache; it prints as a table.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.compile_kernels())  # doctest: +SKIP
    """
    from governor_mechanism.studies.kernel_compilation import compile_all_kernels

    return compile_all_kernels()


@check_arguments(certify=FLAG)
def run(
    scene: gm.SceneSource,
    engine: str | gm.Engine = "auto",
    accuracy: float | None = None,
    times: gm.FloatValues | None = None,
    certify: bool = True,
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
        Reported times, s; shape (n,). Those of the scene if None.
    certify
        Whether to estimate the error by further runs, and to refine until the accuracy is met.

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

    resolved_scene = as_scene(scene)
    name = resolved_scene.run.engine if isinstance(engine, str) and engine == "auto" else engine
    selected_engine, reason = select_engine(name, resolved_scene, accuracy)
    return selected_engine.run(resolved_scene, times=times, accuracy=accuracy, certify=certify, reason=reason)


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
    from governor_mechanism.files.saved_run import open_saved_run

    return open_saved_run(path)


def film(
    run: gm.Trajectory | Sequence[gm.Trajectory],
    path: str | Path,
    *,
    titles: Sequence[str] | None = None,
    size: int = 480,
    frames_per_second: float | None = None,
    part: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    slow_down: float | None = None,
    layout: str = "machine+plots",
    readings: Sequence[str] | None = None,
    theme: str = "light",
    footer: bool = True,
    labels: bool = False,
    forces: bool = False,
    traces: bool = False,
    view: str = "plane",
    exaggerate: float = 1.0,
    progress: gm.Progress | None = None,
) -> Path:
    """Write one or several runs as an animation.

    Parameters
    ----------
    run
        A run, or several, which are shown side by side; one that ends before the others rests and says so.
    path
        Path of the file: .gif, .svg, .mp4 or .webm with the optional dependency `video`, or .html for an interactive page of one run.
    titles
        Titles of several runs; those of their scenes if None.
    size
        Height of the film in pixels, and its width per run of one part; at least 320.
    frames_per_second
        Frames per second of film, 1 to 50; chosen by the scene if None.
    part
        Name of the part to show; all parts if None.
    start
        Start of the shown part, s; the first time of the runs if None.
    stop
        End of the shown part, s; the last time of the runs if None, or the end of its last whole period, or when a governed engine
        has settled.
    slow_down
        Seconds of film per second of the run; chosen by the duration if None.
    layout
        "machine" alone, "machine+plots" in a square, or "wide": 16:9 with the plots beside.
    readings
        Names of up to 4 plotted readings, or "rate of ..."; those that suit the machine if None.
    theme
        Colours: "light" or "dark".
    footer
        Whether the last line states accuracy and engine.
    labels
        Whether the parts and the main angle are named.
    forces
        Whether weights, centrifugal forces, springs and dampers are drawn as arrows.
    traces
        Whether the paths of the mass centres are drawn.
    view
        Of parts that turn with a spindle: "plane" for the turning plane, "outside" for the turning governor from the side, or "both".
    exaggerate
        Magnification of the motion about its mean position, for motions too small to be seen; the plots stay true.
    progress
        Called with the numbers of frames done and of all.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    MechanismError
        If the path, the runs, the titles or a number is not valid, or ffmpeg is missing for .mp4 or .webm.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.film(gm.run("porter", times=[0.0, 0.1, 0.2]), "porter.gif").name
    'porter.gif'
    """
    from governor_mechanism.render.film.writer import write_film

    return write_film(
        run,
        path,
        titles=titles,
        size=size,
        frames_per_second=frames_per_second,
        part=part,
        start=start,
        stop=stop,
        slow_down=slow_down,
        layout=layout,
        readings=readings,
        theme=theme,
        footer=footer,
        labels=labels,
        forces=forces,
        traces=traces,
        view=view,
        exaggerate=exaggerate,
        progress=progress,
    )
