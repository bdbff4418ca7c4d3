"""Runs and films."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import governor_mechanism as gm
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
    times: gm.QuantityValues | None = None,
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
        Reported times, s, or texts with a unit; shape (n,). Those of the scene if None.
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
    from governor_mechanism.units.quantities import convert_texts

    resolved_scene = as_scene(scene)
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
    start: float | str | None = None,
    stop: float | str | None = None,
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
    """Write one run, or several side by side, as an animation.

    Runs share the axes of their readings and, if their machines are of like kind and size, their scale. A run that ends before the others
    rests in its last position, and says when it ended.

    Parameters
    ----------
    run
        A run, or a list of up to 6.
    path
        File that ends in .gif, .mp4, .webm, .svg or .html; .mp4 and .webm need the optional dependency `video`, .svg is an animated drawing
        of one run, and .html an interactive page of one run.
    titles
        Titles of several runs; those of their scenes if None.
    size
        Height of the film in pixels, and its width per run of one part; at least 320. A page fits its window.
    frames_per_second
        Frames per second of film, 1 to 50. None is 25, and 12.5 for an engine room; a GIF that would exceed 700 kB (480 pixels high) takes
        a lower rate, down to 10. A page has none of its own.
    part
        Name of the part to show. None shows all parts, each in a panel of its own; an engine and the governor that it drives, and that
        controls it, are shown as one elevation of an engine room.
    start
        Start of the shown part of the runs, s, or text with a unit. None is the first reported time.
    stop
        End of the shown part of the runs, s, or text with a unit. None is the last reported time of any. By
        default, the film of a run that is periodic to its end closes on its last whole turn or period, so that
        it repeats without a jump; without a start, the film of an engine room ends soon after the governor has
        settled, and says so. A page shows the whole run.
    slow_down
        Seconds of film per second of the run; 1 is true time. None is true time for runs of 1 to 60 s; shorter runs are slowed and longer
        ones sped up to a film of 4 to 20 s. A crank that would make a turn in fewer than 20 frames is slowed further, and of a long run the
        first turns are shown. The film of an engine room is sped up by a whole number to at most 10 s.
        A page begins as its run is long, but in true time up to 100 s.
    layout
        "machine" alone, "machine+plots" in a square, or "wide": 16:9 with the plots beside.
    readings
        Names of up to 4 plotted readings, or "rate of ..."; None for those that suit the machine.
    theme
        Colours: "light" or "dark". A page follows the reader's screen.
    footer
        Whether the last line states accuracy and engine; an early end of the run is always stated.
    labels
        Whether the parts and the angle of the leading reading are named.
    forces
        Whether the forces on the bodies are drawn: weight, centrifugal force, springs and dampers.
    traces
        Whether the paths of the mass centres are drawn.
    view
        How parts that turn with a spindle are seen: "plane" for the turning plane, "outside" for the turning governor from the side, or
        "both". A spindle that would make a turn in fewer than 10 frames is then slowed as a crank is. A film from outside closes on the
        last period after which the spindle has made whole turns to 2 % of a turn; where there is none, it closes on the motion in the plane
        alone, and the spindle jumps when the film repeats.
    exaggerate
        Magnification of the motion about its mean position, at least 1, for motions too small to be seen; the plots stay true. The scene
        must have one part whose positions follow one free coordinate.
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
