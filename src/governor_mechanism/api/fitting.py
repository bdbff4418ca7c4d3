"""From what is wanted or measured to the values of a scene: sensitivities, fits, optima."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.types import DataFrame
from governor_mechanism.units.problems import BY_NAME, LIST, NUMBER, PATH, TEXT, TEXTS, check_arguments, whole_number


@check_arguments(by=TEXTS, engine=TEXT, accuracy=NUMBER, workers=whole_number(1))
def sensitivities(
    scene: gm.SceneSource,
    of: Mapping[str, str | Callable[[gm.Trajectory], float]] | Sequence[str],
    by: Sequence[str],
    *,
    engine: str = "auto",
    accuracy: float | None = None,
    workers: int = 1,
    cluster: str | gm.ClusterClient | None = None,
) -> gm.Sensitivities:
    """Return derivatives of numbers taken from the run of a scene by keys of the scene, with their errors.

    A derivative is a central difference of four certified runs at two steps, extrapolated. Where it does not exist, since a contact begins
    or ends there, or a value has a kink, its row says so.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    of
        Numbers as in a sweep: "sleeve_lift" for the final value of a reading, and its derivative over time in `histories`; "max arm_angle",
        "frequency of arm_angle", or functions of the run by name. Extremes are those at the times where the scene itself has them.
    by
        Keys of the scene that have numbers, as "dimensions.arm".
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; 1e-10 if None.
    workers
        Largest number of processes.
    cluster
        A client of dask.distributed, or the address of its scheduler, for the runs.

    Returns
    -------
    Sensitivities
        A row for each number and key with the derivative and its error, SI; it prints as a table.

    Raises
    ------
    MechanismError
        If the arguments have mistakes, or the scene cannot be run.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> found = gm.sensitivities("porter", ["frequency of arm_angle"], ["dimensions.arm"])
    >>> round(found.at("frequency of arm_angle", "dimensions.arm").value, 4)
    -1.9639
    """
    from governor_mechanism.studies.sensitivities import find_sensitivities

    return find_sensitivities(as_scene(scene), of, by, engine=engine, accuracy=accuracy, workers=workers, cluster=cluster)


@check_arguments(engine=TEXT, starts=whole_number(1), seed=whole_number(0), profile=TEXTS, workers=whole_number(1))
def fit(
    scene: gm.SceneSource,
    data: str | Path | DataFrame | Mapping[str, gm.QuantityValues],
    over: Mapping[str, Sequence[float | str]] | Sequence[str],
    *,
    noise: float | str | Mapping[str, float | str] | None = None,
    without: Sequence[Sequence[float | str]] = (),
    profile: Sequence[str] = (),
    engine: str = "auto",
    starts: int = 2,
    seed: int = 0,
    workers: int = 1,
    cluster: str | gm.ClusterClient | None = None,
) -> gm.Fit:
    """Find the values of keys of a scene with which its readings fit measured ones best, and what the data say of their errors.

    The sum of the squared differences, relative to the noise, is minimised between the bounds, from the scene's own values and from the
    best of random points.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene. Its values are the first start.
    data
        Path of a CSV file, a table of pandas, or values by name: the column "time" and a column for each measured reading. A unit stands in
        the heading, as "sleeve_lift [mm]"; without one values are SI. Empty cells do not count.
    over
        Lower and upper bound by key, as {"dimensions.ball_mass": ("4 kg", "6 kg")} or ["dimensions.ball_mass=4kg:6kg"]; values and rates of
        [start] may be among them.
    noise
        Standard deviation of a measured value, or one by reading; None estimates it from the residuals.
    without
        Intervals of time that do not count, as [("1 s", "1.5 s")].
    profile
        Keys whose 95 % interval is found by fitting all other values again.
    engine
        Name of an engine, or "auto".
    starts
        Number of starts of the search.
    seed
        Seed of the random points.
    workers
        Largest number of processes for several starts; the result depends on it by rounding at most.
    cluster
        A client of dask.distributed, or the address of its scheduler, for them.

    Returns
    -------
    Fit
        Values, standard errors, 95 % intervals, correlations, residuals, the scene with these values, and which combinations the
        data do not determine; it prints as a table. `converged` is False if the search was interrupted or found no minimum.

    Raises
    ------
    MechanismError
        If scene, data or bounds have mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> run = gm.run("porter", accuracy=1e-8)
    >>> data = {"time": run.times[:300], "sleeve_lift": run.readings["sleeve_lift"][:300]}
    >>> fit = gm.fit("porter", data, {"spindle.speed": ("115 rpm", "128 rpm")}, noise="0.1 mm", starts=1)
    >>> round(fit.values["spindle.speed"], 6)
    12.566371
    """
    from governor_mechanism.studies.fitting.results import read_measurements
    from governor_mechanism.studies.fitting.search import FitQuestion, fit_measurements
    from governor_mechanism.studies.sweep.workers import row_computer
    from governor_mechanism.studies.unknowns import parse_unknowns
    from governor_mechanism.units.problems import ProblemCollector

    resolved, collector = as_scene(scene), ProblemCollector()
    unknowns = collector.attempt("", parse_unknowns, resolved, over) or ()
    measurements = collector.attempt("", read_measurements, resolved, data, noise, without) or ()
    collector.raise_if_failed()
    options: dict[str, Any] = {"engine": engine, "n_starts": starts, "seed": seed, "profiled": tuple(profile)}
    with row_computer(workers, cluster) as compute:
        return fit_measurements(FitQuestion(scene=resolved, unknowns=unknowns, measurements=measurements, **options), compute)


@check_arguments(
    subject_to=TEXTS,
    quantities=BY_NAME,
    report=LIST,
    workers=whole_number(1),
    method=TEXT,
    starts=whole_number(1),
    seed=whole_number(0),
    engine=TEXT,
    accuracy=NUMBER,
    out=PATH,
)
def optimise(
    scene: gm.SceneSource,
    over: Mapping[str, Sequence[float | str]] | Sequence[str],
    *,
    minimise: gm.Objective | None = None,
    maximise: gm.Objective | None = None,
    subject_to: Sequence[str] = (),
    quantities: Mapping[str, gm.Objective] | None = None,
    report: Sequence[gm.Objective] = (),
    method: str = "local",
    starts: int = 1,
    seed: int = 0,
    engine: str = "auto",
    accuracy: float | None = None,
    workers: int = 1,
    cluster: str | gm.ClusterClient | None = None,
    out: str | Path | None = None,
) -> gm.Optimum:
    """Find the values of keys of a scene with which a quantity is least or greatest, under conditions.

    An impossible geometry, or a run that ends early, lies outside. Ctrl-C keeps the best values so far.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene. Its values are the first start.
    over
        Lower and upper bound by key, as {"dimensions.ball_mass": ("4 kg", "6 kg")} or ["dimensions.ball_mass=4kg:6kg"].
    minimise
        What is made least: a quantity as in a sweep, as "max sleeve_lift"; a name from `quantities`; or a function of the run, or of the
        scene if its parameter is called `scene`, which then needs no run. Of several values, as in several gears, the largest counts.
    maximise
        What is made greatest instead.
    subject_to
        Conditions, as "max sleeve_lift <= 120 mm": a quantity, <=, >= or =, and a limit.
    quantities
        Names for quantities and functions, to be used in conditions.
    report
        Further quantities that the result states before and after.
    method
        "local" follows gradients from the starts, "global" searches all of the bounds first.
    starts
        Number of starts of a local search: the scene's own values, and the best of random ones.
    seed
        Seed of the random numbers.
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; 1e-8 if None.
    workers
        Largest number of processes for random starts and global searches; the result depends on it by rounding at most.
    cluster
        A client of dask.distributed, or the address of its scheduler, for them.
    out
        File in which computed values are kept while the search runs. A search that was interrupted continues from it.

    Returns
    -------
    Optimum
        Values before and after, the objective, the conditions with their margins, and the scene with the best values; it prints as tables.
        `converged` is False if the search was interrupted, found no optimum, or nothing that meets all conditions.

    Raises
    ------
    MechanismError
        If scene, bounds, objective or conditions have mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> found = gm.optimise("porter", ["dimensions.arm=280mm:320mm"], maximise="frequency of arm_angle")
    >>> found.converged, found.values
    (True, {'dimensions.arm': 0.28})
    """
    from governor_mechanism.studies.optimisation.optimise import find_optimum
    from governor_mechanism.studies.optimisation.question import QuestionReader
    from governor_mechanism.studies.sweep.workers import row_computer

    options: dict[str, Any] = {"engine": engine, "accuracy": accuracy, "workers": workers, "cluster": cluster, "named": quantities}
    reader = QuestionReader(as_scene(scene), is_kept=out is not None, **options)
    least, greatest = ([] if one is None else [one] for one in (minimise, maximise))
    question = reader.read(over, least, greatest, subject_to, method, report)
    with row_computer(workers, cluster) as compute:
        return find_optimum(question, method, starts, seed, compute, None if out is None else Path(out))


@check_arguments(
    minimise=LIST,
    maximise=LIST,
    subject_to=TEXTS,
    quantities=BY_NAME,
    workers=whole_number(1),
    points=whole_number(3),
    method=TEXT,
    starts=whole_number(1),
    seed=whole_number(0),
    engine=TEXT,
    accuracy=NUMBER,
)
def trade_off(
    scene: gm.SceneSource,
    over: Mapping[str, Sequence[float | str]] | Sequence[str],
    *,
    minimise: Sequence[gm.Objective] = (),
    maximise: Sequence[gm.Objective] = (),
    subject_to: Sequence[str] = (),
    quantities: Mapping[str, gm.Objective] | None = None,
    points: int = 7,
    method: str = "local",
    starts: int = 1,
    seed: int = 0,
    engine: str = "auto",
    accuracy: float | None = None,
    workers: int = 1,
    cluster: str | gm.ClusterClient | None = None,
) -> gm.TradeOff:
    """Find what one objective costs in another: the best of the first for limits of the second.

    The limits go in equal steps from the second objective at the best of the first to its own best.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    over
        Lower and upper bound by key, as in `optimise`.
    minimise
        Quantities or functions that are made least, as in `optimise`; those of `minimise` and `maximise` are two together.
    maximise
        Quantities or functions that are made greatest.
    subject_to
        Conditions, as in `optimise`.
    quantities
        Names for quantities and functions, to be used in conditions.
    points
        Number of points; at least 3.
    method
        "local" or "global".
    starts
        Number of starts of each local search.
    seed
        Seed of the random numbers.
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; 1e-8 if None.
    workers
        Largest number of processes for random starts and global searches.
    cluster
        A client of dask.distributed, or the address of its scheduler, for them.

    Returns
    -------
    TradeOff
        Both objectives and the values at each point; it prints as a table, and `plot` draws the curve.

    Raises
    ------
    MechanismError
        If scene, bounds, objectives or conditions have mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> def short(scene):
    ...     return (scene.part.dimensions["arm"] - 0.29) ** 2
    >>> def long(scene):
    ...     return (scene.part.dimensions["arm"] - 0.31) ** 2
    >>> curve = gm.trade_off("porter", ["dimensions.arm=280mm:320mm"], minimise=[short, long], points=3)
    >>> [round(row.values["dimensions.arm"], 3) for row in curve.rows]
    [0.29, 0.296, 0.31]
    """
    from governor_mechanism.studies.optimisation.optimise import find_trade_off
    from governor_mechanism.studies.optimisation.question import QuestionReader
    from governor_mechanism.studies.sweep.workers import row_computer

    reader = QuestionReader(as_scene(scene), engine=engine, accuracy=accuracy, workers=workers, cluster=cluster, named=quantities)
    question = reader.read(over, minimise, maximise, subject_to, method, n_objectives=2)
    with row_computer(workers, cluster) as compute:
        return find_trade_off(question, points, method, starts, seed, compute)
