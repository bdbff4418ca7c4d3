"""Many runs: comparisons, sweeps, accuracy, effects, hard cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.units.problems import BY_NAME, FLAG, FUNCTION, NUMBER, PATH, QUANTITY, TEXT, TEXTS, check_arguments


@check_arguments(accuracy=NUMBER, against=TEXT, between=BY_NAME)
def compare(
    *scenes: gm.SceneSource,
    engine: str | gm.Engine = "auto",
    accuracy: float | None = None,
    resistance: float | str | None = None,
    against: str = "sleeve_lift",
    between: Mapping[str, Sequence[float | str]] | None = None,
) -> gm.Comparison:
    """Run two to six scenes, governors or others, and set their statics and readings side by side.

    Each is a scene, the path of a file, or the name of a shipped scene.

    Parameters
    ----------
    engine
        Name of an engine, or an engine with its own settings; "auto" takes that of each scene.
    accuracy
        Accuracy of all runs, relative to the scale of each reading; that of each scene if None.
    resistance
        Resistance along the reading of the sleeve for the insensitivity, N or N m, or text with a unit; None for none.
    against
        Name of the reading of the sleeve.
    between
        Working range: two values of one reading, as {"sleeve_lift": ("20 mm", "60 mm")}. None for the stops of each scene, or else for what
        its run covers.

    Returns
    -------
    Comparison
        Names, rows, statics and runs; it prints as a table, and its `film` shows the runs side by side.

    Raises
    ------
    MechanismError
        If a scene or an argument is wrong, or there are too few or too many scenes.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.compare("porter", "watt"))
    porter vs watt
    ...
    """
    from governor_mechanism.studies.compared_quantities import StaticsQuestion
    from governor_mechanism.studies.comparison import compare_scenes

    question = StaticsQuestion(resistance=resistance, against=against, between=between)
    return compare_scenes([as_scene(scene) for scene in scenes], question, engine=engine, accuracy=accuracy)


@check_arguments(engine=TEXT, certify=FLAG, out=PATH, progress=FUNCTION)
def sweep(
    scene: gm.SceneSource,
    vary: Mapping[str, Any] | Sequence[str],
    quantities: Mapping[str, str | Callable[[gm.Trajectory], float]] | Sequence[str] | None = None,
    *,
    engine: str = "auto",
    accuracy: float | None = None,
    certify: bool = False,
    workers: int = 1,
    cluster: str | gm.ClusterClient | None = None,
    out: str | Path | None = None,
    progress: gm.Progress | None = None,
) -> gm.Sweep:
    """Run a scene for every combination of values of its keys, and record quantities of each run.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    vary
        Values by key, as {"dimensions.arm": [0.2, "300 mm"]}, or as on the command line, ["dimensions.arm=200mm:400mm:50"].
    quantities
        Names such as "settled arm_angle", "frequency of arm_angle" or "max rate of sleeve_lift", or functions of the run by name. The words
        before a reading are final, min, max, span, mean, settled, amplitude of and frequency of, and of an angle that turns mean speed of
        and speed fluctuation of. None takes what characterises the motion; `reason_of_choice` of the result says why.
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; that of the scene if None.
    certify
        Whether to estimate the errors.
    workers
        Largest number of processes; a sweep that is faster in one process stays there. The rows do not depend on it.
    cluster
        A client of dask.distributed, or the address of its scheduler, as `tcp://host:8786`: the rows are computed there.
    out
        Folder for the rows. A sweep that was interrupted continues from it.
    progress
        Function of the number of finished and of all rows.

    Returns
    -------
    Sweep
        Rows in SI, each with its outcome, and access by `column` and `grid`; `endings` counts rows that ended early, did not settle or did
        not oscillate. A row that cannot be run states the reason.

    Raises
    ------
    MechanismError
        If the arguments have mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> table = gm.sweep("porter", {"dimensions.arm": ["280 mm", "300 mm"]}, ["min arm_angle"])
    >>> table.column("min arm_angle").round(3).tolist()
    [0.329, 0.459]
    """
    from governor_mechanism.studies.sweep.run import make_task, run_sweep
    from governor_mechanism.studies.sweep.workers import row_computer

    resolved_scene = as_scene(scene)
    task = make_task(resolved_scene, vary, quantities, engine, accuracy, certify, workers, cluster)
    with row_computer(workers, cluster) as compute:
        return run_sweep(resolved_scene, task, compute, out, progress)


@check_arguments(longest=QUANTITY, progress=FUNCTION)
def accuracy_study(scene: gm.SceneSource, longest: float | str = 1.0, progress: gm.Progress | None = None) -> gm.AccuracyStudy:
    """Measure error and time of every engine at every setting, against a reference that a second engine confirms.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    longest
        Time limit of a setting, s, or text with a unit; slower settings are omitted.
    progress
        Function of the number of finished and of all settings.

    Returns
    -------
    AccuracyStudy
        Errors and times, with `cheapest_for` and `advice` for an accuracy; it prints as a table.

    Raises
    ------
    MechanismError
        If there is no reference.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> scene = gm.load("porter").replace({"run.duration": "0.1 s"})
    >>> study = gm.accuracy_study(scene, longest=0.01)
    >>> [variant.name for variant in study.variants]
    ['reduced', 'multibody', 'impulse extrapolated', 'impulse staggered', 'impulse plain']
    >>> advice = study.advice(1e-6)  # the fastest of them, and the times of the others
    """
    from governor_mechanism.studies.work_precision import run_accuracy_study
    from governor_mechanism.units.quantities import parse_quantity

    return run_accuracy_study(as_scene(scene), parse_quantity(longest, "time", "longest"), progress)


@check_arguments(engine=TEXT, progress=FUNCTION)
def effects_study(
    scene: gm.SceneSource, engine: str = "auto", accuracy: float | None = None, progress: gm.Progress | None = None
) -> gm.EffectsStudy:
    """Measure the influence of each effect of a scene on the readings, and its cost.

    The scene is run as it is, and once with each effect switched.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; that of the scene if None.
    progress
        Function of the number of finished and of all runs.

    Returns
    -------
    EffectsStudy
        Changes and costs, and effects that may be left out; it prints as a table.

    Raises
    ------
    MechanismError
        If the scene cannot be run.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.effects_study(gm.load("porter").replace({"run.duration": "0.1 s"})))
    Porter governor, open arms: engine reduced, ...
    """
    from governor_mechanism.studies.effect_ablation import run_effects_study

    return run_effects_study(as_scene(scene), engine, accuracy, progress)


@check_arguments(names=TEXTS, short=FLAG, progress=FUNCTION)
def hard_cases(names: Sequence[str] = (), short: bool = False, progress: gm.Progress | None = None) -> gm.HardCasesReport:
    """Run the hard cases by every engine and judge each run.

    A run passes if its true error is within its error estimate, or if it ends with an outcome that the case names.

    Parameters
    ----------
    names
        Names of the cases, such as "dead-centre"; all without any.
    short
        Whether to run only the few values of the short form.
    progress
        Called with the number of finished values and the number of all.

    Returns
    -------
    HardCasesReport
        One row per case, value of its hard parameter, and engine.

    Raises
    ------
    MechanismError
        If a name is unknown.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.hard_cases(["not-a-number"]).ok
    True
    """
    from governor_mechanism.studies.hard_cases.study import run_hard_cases

    return run_hard_cases(names, short=short, progress=progress)
