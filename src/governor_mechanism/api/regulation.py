"""Engines under their governors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.units.problems import FUNCTION, TEXT, TEXTS, check_arguments, whole_number


@check_arguments(engine=TEXT)
def load_change_study(
    scene: gm.SceneSource,
    load_step: str | Sequence[float] = (1.0, 0.5),
    *,
    at: float | str | None = None,
    ramp: float | str = 0.0,
    engine: str = "auto",
    accuracy: float | None = None,
) -> gm.LoadChangeStudy:
    """Change the load of a governed engine and measure how the governor answers.

    The run starts in the equilibrium under the first load; speeds are averaged over a turn of the shaft.

    Parameters
    ----------
    scene
        A scene with a `[load]` under a governor, the path of a file, or the name of a shipped scene.
    load_step
        Load before and after the change, relative to `load.rated_torque`: two numbers, or a text such as "100%:50%".
    at
        Time of the change, s, or text with a unit; a tenth of the duration if None.
    ramp
        Duration of the change, s, or text with a unit; 0 for a step.
    engine
        Name of an engine; "auto" uses the engine of the scene.
    accuracy
        Accuracy of the run, relative to the scale of each reading; that of the scene if None.

    Returns
    -------
    LoadChangeStudy
        Droop, overshoot, settling time, hunting, energies and the run; it prints as a table.

    Raises
    ------
    MechanismError
        If the scene is no governed engine, the first load has no equilibrium, or an argument is wrong.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> study = gm.load_change_study("governed_engine_mean_torque", "100%:50%")
    >>> study.verdict, round(study.droop, 4)
    (<Verdict.SETTLES: 'settles'>, 0.0227)
    """
    from governor_mechanism.studies.regulation.load_change import parse_load_step, study_load_change
    from governor_mechanism.units.quantities import parse_quantity

    begin = None if at is None else parse_quantity(at, "time", "at")
    duration = parse_quantity(ramp, "time", "ramp")
    fractions = parse_load_step(load_step)
    return study_load_change(as_scene(scene), fractions, at=begin, ramp=duration, engine=engine, accuracy=accuracy)


@check_arguments(vary=TEXTS, border_points=whole_number(0), workers=whole_number(1), progress=FUNCTION)
def stability_map(
    scene: gm.SceneSource,
    vary: Sequence[str] = (),
    *,
    border_points: int = 8,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> gm.StabilityMap:
    """Map where a governed engine is stable and where it hunts, over two parameters, under its last load.

    By eigenvalues with the torque averaged over a turn; the border under the cyclic torque is located by simulation: there a Floquet
    multiplier of the periodic motion has the magnitude 1.

    Parameters
    ----------
    scene
        A scene with a `[load]` under a governor, the path of a file, or the name of a shipped scene.
    vary
        Two texts "key=first:last:count"; inertia of the flywheel and dashpot on the sleeve if empty.
    border_points
        Number of values of the first parameter at which the border is located; 0 for none.
    workers
        Largest number of processes; the result does not depend on it.
    progress
        Called with the numbers of points done and of all.

    Returns
    -------
    StabilityMap
        Growth rates, frequencies, Vyshnegradskii's parameters where they apply, and the border.

    Raises
    ------
    MechanismError
        If the scene is no governed engine, its cut-off moves, or the parameters are wrong.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> keys = ["part.engine.dimensions.inertia=1000 kg m^2:2000 kg m^2:2", "part.governor.effects.dashpot.sleeve=20 N s/m:100 N s/m:2"]
    >>> gm.stability_map("governed_engine_mean_torque", keys, border_points=0).stable_share
    1.0
    """
    from governor_mechanism.studies.regulation.stability_map import map_stability

    return map_stability(as_scene(scene), vary, n_border_columns=border_points, n_workers=workers, progress=progress)


@check_arguments(progress=FUNCTION)
def paper_rules(progress: Callable[[int, int], None] | None = None) -> gm.PaperRules:
    """Test the rules of the papers about governing on the simulated engine.

    Parameters
    ----------
    progress
        Called with the numbers of rules tested and of all.

    Returns
    -------
    PaperRules
        For each rule what the paper says, what the simulation shows, and whether it holds; it prints as a table.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.paper_rules())  # doctest: +SKIP
    """
    from governor_mechanism.papers.rules_study import study_paper_rules

    return study_paper_rules(progress)
