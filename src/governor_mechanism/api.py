"""Public functions of the package. Each imports what it needs on its first call, so that the package imports quickly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from governor_mechanism import public_types as gm  # annotations read as users write them
from governor_mechanism.errors import MechanismError
from governor_mechanism.units.arguments import BY_NAME, FLAG, FUNCTION, NUMBER, NUMBERS, PATH, TEXT, TEXTS_BY_NAME, check_arguments

if TYPE_CHECKING:
    from governor_mechanism.verification.kernel_samples import VariedKey


def list_models() -> dict[str, str]:
    """Return the shipped scenes.

    Returns
    -------
    dict
        Title by name.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> "porter" in gm.list_models()
    True
    """
    from governor_mechanism.scenes.library import read_scene_title, shipped_scenes

    return {name: read_scene_title(path) for name, path in shipped_scenes().items()}


def load(scene: str | Path) -> gm.Scene:
    """Read a scene and verify that it has a consistent initial state.

    Parameters
    ----------
    scene
        Path of a TOML file, or the name of a shipped scene.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    MechanismError
        If the file has mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.load("porter").run.duration
    10.0
    """
    from governor_mechanism.scenes.library import load_scene
    from governor_mechanism.scenes.python_scenes import check_start

    return check_start(load_scene(scene))


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

    resolved_scene = _as_scene(scene)
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


@overload
def crosscheck(scene: gm.SceneSource, kernel: None = None) -> gm.CheckReport: ...


@overload
def crosscheck(
    scene: gm.SceneSource,
    kernel: Callable[..., Any],
    quantity: str = ...,
    over: Mapping[str, gm.InputValues] | None = ...,
    allowed: float | None = ...,
    *,
    names: Mapping[str, str] | None = ...,
    unit: str | None = ...,
    vary: Mapping[str, Any] | Sequence[str] | None = ...,
    random: int | None = ...,
    seed: int = ...,
) -> gm.KernelReport: ...


@check_arguments(kernel=FUNCTION, quantity=TEXT, over=BY_NAME, allowed=NUMBER, names=TEXTS_BY_NAME, unit=TEXT)
def crosscheck(
    scene: gm.SceneSource,
    kernel: Callable[..., Any] | None = None,
    quantity: str = "equilibrium_speed",
    over: Mapping[str, gm.InputValues] | None = None,
    allowed: float | None = None,
    *,
    names: Mapping[str, str] | None = None,
    unit: str | None = None,
    vary: Mapping[str, Any] | Sequence[str] | None = None,
    random: int | None = None,
    seed: int = 0,
) -> gm.CheckReport:
    """Compare the simulation of a scene with all applicable closed forms, or with a function of the user.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone, but over
        time all of them.
    kernel
        Function of numbers or arrays, whose parameters are named after dimensions, readings and inputs; it gets their values in SI. None
        for the closed forms.
    quantity
        What the kernel returns, as "equilibrium_speed" or the name of a reading; `governor-mechanism crosscheck SCENE --list` prints all.
    over
        Values of the inputs of the quantity, as {"arm_angle": [0.3, 0.5]} in SI, or as text, {"arm_angle": "15 deg:45 deg:25"}; several
        inputs give a grid. Over "time", readings are compared with those of a run.
    allowed
        Relative tolerance of the kernel; the default of `verification.user_kernel` if None.
    names
        Our name by the kernel's name where they differ, with a unit if it is not SI, as {"alpha": "arm_angle in deg"}.
    unit
        Unit of the kernel's result, as "rpm"; SI if None.
    vary
        Values of keys of the scene, as in `sweep`; with `random`, the limits, as {"dimensions.arm": ("200 mm", "400 mm")}.
    random
        Number of random samples between the limits of all inputs and keys; None for the grid of all values.
    seed
        Seed of the random samples.

    Returns
    -------
    CheckReport
        Comparison with `passed` and `rows`; it prints as a table. For a kernel a `KernelReport`, with the estimated error of the simulation
        beside each difference and the `worst` case.

    Raises
    ------
    MechanismError
        If `over` is missing for a kernel, a name or value is wrong, or the kernel gives no number anywhere.

    Examples
    --------
    >>> import math
    >>> import governor_mechanism as gm
    >>> gm.crosscheck("slider_crank").passed
    True
    >>> def lift(arm_angle, arm):
    ...     return 2 * arm * (1 - math.cos(arm_angle))
    >>> gm.crosscheck("porter", lift, "sleeve_lift", over={"arm_angle": "15 deg:45 deg:5"}).passed
    True
    """
    if kernel is None:
        from governor_mechanism.verification.registry import check_against_closed_forms

        return check_against_closed_forms(_as_rotating_part(scene))
    from governor_mechanism.verification.user_kernel import KERNEL_RELATIVE_TOLERANCE, check_kernel

    resolved_scene = _as_scene(scene)
    tolerance = KERNEL_RELATIVE_TOLERANCE if allowed is None else allowed
    varied = () if vary is None else _varied_keys(resolved_scene, vary)
    options: dict[str, Any] = {"names": names, "unit": unit, "varied": varied, "random": random, "seed": seed}
    return check_kernel(resolved_scene, kernel, quantity, over, tolerance, **options)


def _varied_keys(scene: gm.Scene, vary: Mapping[str, Any] | Sequence[str]) -> tuple[VariedKey, ...]:
    """Return the keys of a scene that vary, with their numbers; "first:last" stands for two values."""
    from governor_mechanism.studies.sweep.parameters import parse_axes
    from governor_mechanism.verification.kernel_samples import VariedKey

    if isinstance(vary, str):
        vary = [vary]
    if not isinstance(vary, Mapping):
        vary = [text.replace(":", ",") if isinstance(text, str) and text.count(":") == 1 else text for text in vary]
    else:
        vary = {key: text.replace(":", ",") if isinstance(text, str) and text.count(":") == 1 else text for key, text in vary.items()}
    axes = parse_axes(scene.document, vary)
    for axis in axes:
        if not axis.is_numeric:
            raise MechanismError(f"{axis.key} takes words; a kernel is compared over keys of numbers")
    return tuple(VariedKey(key=axis.key, values=tuple(float(value) for value in axis.values), unit=axis.unit) for axis in axes)


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
        Names, rows, statics and runs; it prints as a table. `gm.film(comparison.runs, path)` shows the runs side by side.

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
    from governor_mechanism.studies.comparison.comparison import compare_scenes
    from governor_mechanism.studies.comparison.statics import StaticsQuestion

    question = StaticsQuestion(resistance=resistance, against=against, between=between)
    return compare_scenes([_as_scene(scene) for scene in scenes], question, engine=engine, accuracy=accuracy)


@check_arguments(over=TEXT, values=NUMBERS, rate=NUMBER, acceleration=NUMBER)
def kinematics(scene: gm.SceneSource, over: str, values: gm.FloatValues, rate: float = 1.0, acceleration: float = 0.0) -> gm.Kinematics:
    """Return positions, velocities and accelerations of a mechanism without integration.

    The readings include forces of springs and weights, pressures and shaft speeds where positions and rates alone determine them.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    over
        Name of the reading that drives the mechanism in place of the scene's drivers, or "time" for the drivers themselves.
    values
        Values of the reading, SI, or times, s; shape (n,).
    rate
        First time derivative of the reading at each value, SI/s.
    acceleration
        Second time derivative of the reading at each value, SI/s2.

    Returns
    -------
    Kinematics
        The motion.

    Raises
    ------
    MechanismError
        If the motion is not determined, if the mechanism cannot be assembled, or at a singular configuration.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> motion = gm.kinematics("slider_crank_torque", over="crank_angle", values=[0.1, 0.2], rate=10.0)
    >>> motion.poses.shape[0]
    2
    """
    from governor_mechanism.observables.kinematic_readings import analyse_kinematics

    return analyse_kinematics(_as_scene(scene), over, values, rate, acceleration)


def speed_curve(
    scene: gm.SceneSource, points: int = 500, *, resistance: float | str | None = None, against: str = "sleeve_lift"
) -> gm.SpeedCurve:
    """Return the equilibrium speed over the travel of a mechanism, with stiffness, frequencies, folds and poles.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone.
    points
        Number of points; at least 2.
    resistance
        Resistance, N or N m, or text with a unit, for the insensitivity band; None for no band.
    against
        Name of the reading that the resistance acts along.

    Returns
    -------
    SpeedCurve
        The curve.

    Raises
    ------
    MechanismError
        If the mechanism does not have one degree of freedom, if no spindle speed can balance its loads, or if an argument is wrong.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> curve = gm.speed_curve("watt_improved", points=100)
    >>> curve.speed.shape
    (100,)
    """
    from governor_mechanism.statics.speed_curve import compute_speed_curve

    return compute_speed_curve(_as_rotating_part(scene), points, resistance=resistance, against=against)


def controlling_force(
    scene: gm.SceneSource,
    over: gm.FloatValues | None = None,
    *,
    points: int = 500,
    between: Mapping[str, Sequence[float | str]] | None = None,
    speed_change: float = 0.01,
    resistance: float | str | None = None,
    against: str = "sleeve_lift",
    radius: str | None = None,
    balls: int | None = None,
) -> gm.ControllingForce:
    """Return the controlling force on a ball of a governor against its radius, with effort, power and sensitiveness.

    The controlling force C is the centripetal force that weights and springs exert on each of n balls: n C dr = dV by virtual work, with
    the potential V and the distance r of a ball from the spindle. In equilibrium it is m w^2 r. The effort is the mean force at the sleeve
    while it yields to a relative change of speed, the power this force times the travel of the sleeve, and the sensitiveness the range of
    speed over the mean speed in the working range.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone.
    over
        Values of the leading coordinate, SI; shape (n,). None for the whole travel.
    points
        Number of points over the whole travel; at least 2.
    between
        Working range: two values of one reading, SI numbers or text with a unit, as {"sleeve_lift": ("20 mm", "60 mm")}. None for the
        stops of the scene, or for the travel.
    speed_change
        Relative change of speed for effort and power; above 0 and at most 1.
    resistance
        Resistance along the reading of the sleeve, N or N m, or text with a unit; None for none.
    against
        Name of the reading of the sleeve.
    radius
        Name of the reading that is the distance of a ball from the spindle axis; None if the mechanism has only one.
    balls
        Number of balls that share the force; None for two if the mechanism has a mirror image of the ball, and else one.

    Returns
    -------
    ControllingForce
        Controlling force, slopes and stability, effort and power at each position, and the working range.

    Raises
    ------
    MechanismError
        If no spindle speed can balance the loads, the mechanism does not have one degree of freedom or no such radius, or an argument is
        wrong.

    References
    ----------
    M. Tolle, Regelung der Kraftmaschinen; Th. Bevan, The Theory of Machines, chapter on governors.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> curve = gm.controlling_force("porter", between={"arm_angle": ("20 deg", "45 deg")})
    >>> round(curve.working_range.sensitiveness, 3)
    0.22
    """
    from governor_mechanism.statics.controlling_force import compute_controlling_force

    options: dict[str, Any] = {"between": between, "speed_change": speed_change, "against": against, "radius": radius, "balls": balls}
    return compute_controlling_force(_as_rotating_part(scene), over, points=points, resistance=resistance, **options)


def insensitivity_band(
    scene: gm.SceneSource, over: gm.FloatValues, resistance: float | str, against: str = "sleeve_lift"
) -> gm.InsensitivityBand:
    """Return the spindle speeds between which a resistance keeps a mechanism in equilibrium.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone.
    over
        Values of the leading coordinate, SI; shape (n,).
    resistance
        Resistance, N or N m, or text with a unit such as "40 N"; at least 0.
    against
        Name of the reading that the resistance acts along.

    Returns
    -------
    InsensitivityBand
        The band.

    Raises
    ------
    MechanismError
        If the resistance is wrong, a value is outside the travel, or no speed balances the loads there without resistance.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> band = gm.insensitivity_band("porter", over=[0.5], resistance="40 N")
    >>> bool(band.falling_speed[0] < band.rising_speed[0])
    True
    """
    from governor_mechanism.statics.speed_curve import compute_insensitivity_band

    return compute_insensitivity_band(_as_rotating_part(scene), over, resistance, against)


def equilibria(scene: gm.SceneSource, spindle_speed: float | str | None = None) -> tuple[gm.Equilibrium, ...]:
    """Return all equilibria of a mechanism at a spindle speed, and their stability.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone.
    spindle_speed
        Spindle speed, rad/s, or text with a unit such as "61 rpm"; the first speed of the scene if None.

    Returns
    -------
    tuple of Equilibrium
        At least one, in ascending order. An astatic mechanism has a range of equilibria, the `extent` of one entry.

    Raises
    ------
    MechanismError
        If there is none (the message gives the speeds for which there are some), if the mechanism does not have one degree of freedom,
        or if its loads do not depend on a given speed.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> [equilibrium.stable for equilibrium in gm.equilibria("watt_improved", spindle_speed=6.4)]
    [False, True]
    """
    from governor_mechanism.statics.equilibria import find_equilibria

    return find_equilibria(_as_rotating_part(scene), spindle_speed)


@check_arguments(at=("an equilibrium, as from equilibria", lambda value: hasattr(value, "divergence_rate")))
def linearise(scene: gm.SceneSource, spindle_speed: float | str | None = None, *, at: gm.Equilibrium | None = None) -> gm.Linearisation:
    """Linearise the equations of motion about an equilibrium or a steady rotation, with all dampers.

    Inputs that vary with time have their last value.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    spindle_speed
        Spindle speed, rad/s, or text with a unit; that of the scene if None.
    at
        Equilibrium from `equilibria`. If None, the one nearest to the start, or the steady rotation nearest to it.

    Returns
    -------
    Linearisation
        Eigenvalues and modes with their error, stability, and the state-space form with inputs and outputs by name.

    Raises
    ------
    MechanismError
        If there is no such state, if it is periodic, or if the motion about it has no linear equations.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> round(gm.linearise("porter_dashpot").modes[0].damping_ratio, 3)
    0.132
    """
    from governor_mechanism.engines.initial_state import initial_state
    from governor_mechanism.statics.linearisation import linearise_from_start, linearise_scene, poses_at

    resolved_scene = _as_scene(scene)
    poses, velocities = initial_state(resolved_scene)
    if at is not None:
        return linearise_scene(resolved_scene, poses_at(resolved_scene, at), velocities, spindle_speed)
    return linearise_from_start(resolved_scene, poses, velocities, spindle_speed)


@check_arguments(key=TEXT)
def stability_limit(scene: gm.SceneSource, key: str, low: float | str, high: float | str) -> gm.StabilityLimit[gm.Linearisation]:
    """Return the value of a key of a scene at which its steady state becomes unstable.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    key
        Dotted key of a quantity, as in `sweep`.
    low
        One end of its range, SI, or text with a unit.
    high
        The other end.

    Returns
    -------
    StabilityLimit
        Value, frequency of the oscillations that begin there, and whether they begin softly or hard.

    Raises
    ------
    MechanismError
        If the key is wrong, or the scene is not stable at one end and unstable at the other.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> limit = gm.stability_limit("governed_engine_mean_torque", "part.governor.effects.dashpot.sleeve", 5.0, 100.0)
    >>> round(limit.value, 1), limit.stable_below  # N s/m
    (19.3, False)
    """
    from governor_mechanism.scenes.changed_document import parse_scene_with
    from governor_mechanism.statics.stability_limit import find_stability_limit
    from governor_mechanism.studies.sweep.parameters import parse_axes

    document = _as_scene(scene).document
    (axis,) = parse_axes(document, {key: [low, high]})
    if not axis.is_numeric:
        raise MechanismError(f"{key} takes no quantity, so it has no limit of stability; name the key of a number")

    def linearise_at(value: float) -> gm.Linearisation:
        return linearise(parse_scene_with(document, [(axis.key, f"{value!r} {axis.unit}" if axis.unit else value)]))

    first, last = (float(value) for value in axis.values)
    return find_stability_limit(linearise_at, first, last, key=key, unit=axis.unit)


@check_arguments(longest=NUMBER, progress=FUNCTION)
def accuracy_study(scene: gm.SceneSource, longest: float = 1.0, progress: gm.Progress | None = None) -> gm.AccuracyStudy:
    """Measure error and time of every engine at every setting, against a reference that a second engine confirms.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    longest
        Time limit of a setting, s; slower settings are omitted.
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
    from governor_mechanism.studies.work_precision.study import run_accuracy_study

    return run_accuracy_study(_as_scene(scene), longest, progress)


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

    return run_effects_study(_as_scene(scene), engine, accuracy, progress)


def explore(scene: gm.SceneSource, *keys: str) -> gm.Exploration:
    """Show a scene in a notebook with sliders: curve and drawing follow while a dimension is dragged.

    Of a governor, the spindle speed has a slider, its equilibria are marked on the speed curve, and the drawing shows the stable one. Of
    another mechanism with one degree of freedom it is the leading coordinate, or the time of its drivers, and a reading is drawn over it.

    The arguments after the scene are names of dimensions or dotted keys, also with a range, as "arm", "arm=200 mm:400 mm" or
    "effects.spring.sleeve.rate"; the first dimensions of the machine if there are none. Without a range, a slider goes from half to
    double the value, as far as the geometry allows.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.

    Returns
    -------
    Exploration
        The view. In a script, `set` does what a slider does; `scene` is the changed scene, `equilibrium` the shown state.

    Raises
    ------
    MechanismError
        If the extra `notebook` is not installed, a key is wrong, or the scene has neither a speed curve nor one degree of freedom.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> view = gm.explore("porter", "arm", "sleeve_mass=10 kg:40 kg")
    >>> view.set("arm", "320 mm")
    >>> view.scene.part.dimensions["arm"], view.equilibrium.stable
    (0.32, True)
    """
    from governor_mechanism.notebook.exploring.exploration import explore_scene

    return explore_scene(_as_scene(scene), keys)


@check_arguments(short=FLAG, progress=FUNCTION)
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
        Largest number of processes, or of threads if the rows are run together; a sweep that is faster in one process stays there. The
        rows do not depend on it.
    cluster
        A client of dask.distributed, or the address of its scheduler, as "tcp://host:8786": the rows are computed there.
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
    from governor_mechanism.studies.sweep.cluster import row_computer
    from governor_mechanism.studies.sweep.run import make_task, run_sweep

    resolved_scene = _as_scene(scene)
    task = make_task(resolved_scene, vary, quantities, engine, accuracy, certify, workers, cluster)
    with row_computer(workers, cluster) as compute:
        return run_sweep(resolved_scene, task, compute, out, progress)


def valve_timing(scene: gm.SceneSource) -> gm.ValveTiming:
    """Return the timing of a slide valve: admission, cut-off, release and compression at both ends of the cylinder.

    Crank angles and piston positions come from the mechanism; for machine "slide_valve" also from the exact closed form, and from the
    theory without its error term. Drivers other than that of the crank, as that of a reversing lever, stand still where they start.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.

    Returns
    -------
    ValveTiming
        The timing; it prints as a table.

    Raises
    ------
    MechanismError
        If the mechanism has no valve, or no driven crank that turns fully.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.valve_timing("slide_valve_30"))
    Slide valve, l : r = 30
    event ...
    crank end admission    353.67...
    """
    from governor_mechanism.studies.valve_timing import tabulate_valve_timing

    return tabulate_valve_timing(_as_scene(scene))


@check_arguments(count=NUMBER)
def valve_gears(scenes: gm.SceneSource | Sequence[gm.SceneSource] = (), count: int = 41) -> gm.ValveGears:
    """Compare valve gears: lead, cut-off and travel of the valve from full forward to full back gear.

    In back gear the crank turns the other way.

    Parameters
    ----------
    scenes
        One or several scenes, paths of files, or names of shipped scenes, whose `[valve]` names their reverser; the shipped gears if empty.
    count
        Number of positions of the reversing gear.

    Returns
    -------
    ValveGears
        The gears; it prints as a table.

    Raises
    ------
    MechanismError
        If a scene has no valve, or a valve no reverser.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> print(gm.valve_gears(["gooch", "joy"], count=3))
    gear ...
    Gooch's gear     +1.00 ...
    """
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.studies.valve_gears import SHIPPED_GEARS, compare_valve_gears

    sources: Sequence[gm.SceneSource] = [scenes] if isinstance(scenes, str | Path | Scene) else scenes
    return compare_valve_gears([_as_scene(scene) for scene in sources or SHIPPED_GEARS], count)


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

    return map_stability(_as_scene(scene), vary, n_border_columns=border_points, n_workers=workers, progress=progress)


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
    from governor_mechanism.studies.regulation.paper_rules import study_paper_rules

    return study_paper_rules(progress)


@check_arguments(paper=TEXT, simulate=FLAG)
def errata(paper: str | None = None, *, simulate: bool = False) -> gm.Errata:
    """Return what recomputing and simulating the papers has found: errors, misprints and slips of rounding, each with its proof.

    Parameters
    ----------
    paper
        "redtenbacher", "zehnder", "marks" or "dubois"; None for all.
    simulate
        Whether to simulate the machines that show the main errors, too.

    Returns
    -------
    Errata
        The errata, every right value recomputed now; it prints as tables.

    Raises
    ------
    MechanismError
        If there is no such paper.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> angle = gm.errata("dubois").errata[0]
    >>> angle.printed, angle.right
    ('133 deg', '137.33 deg')
    """
    from governor_mechanism.studies.errata.collection import collect_errata

    return collect_errata(paper, simulate=simulate)


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

    begin, duration = None if at is None else parse_quantity(at, "time", "at"), parse_quantity(ramp, "time", "ramp")
    fractions = parse_load_step(load_step)
    return study_load_change(_as_scene(scene), fractions, at=begin, ramp=duration, engine=engine, accuracy=accuracy)


def design_flywheel(**inputs: float | str) -> gm.FlywheelDesign:
    """Design the flywheel of an air-expansion engine by Redtenbacher's procedure, or find the fluctuation of a given one.

    The inputs that are given replace those of the paper: numbers in SI, or texts with a unit. Of the engine area, stroke, cut_off,
    clearance, pump_area, pump_stroke, pump_clearance, atmospheric_pressure, supply_pressure, back_pressure, load_pressure ("closing": the
    load with which the cycle closes) and speed; of the requirement one of energy_ratio, coefficient and inertia; of the wheel rim_radius,
    rim_share, width_ratio, density, rim_stress, arms, hub_radius and arm_stress.

    Returns
    -------
    FlywheelDesign
        The design; it prints as text, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, or the engine cannot carry its load.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_flywheel(load_pressure="closing", coefficient=0.02)
    >>> round(design.inertia)
    3996
    """
    from governor_mechanism.studies.design_inputs import change_inputs
    from governor_mechanism.studies.flywheel.design import design_flywheel as design
    from governor_mechanism.studies.flywheel.inputs import PAPER_INPUTS

    return design(change_inputs(PAPER_INPUTS, inputs))


def design_governed_engine(**inputs: float | str) -> gm.GovernedEngineDesign:
    """Design an engine with its flywheel and Porter governor for a power, a speed and a droop.

    The droop is the speed without load less that at full load, over their mean. The inputs that are given replace the defaults, 20 PS at
    120 rpm with 4 %: numbers in SI, or texts with a unit. Of the requirement power, speed, droop, speed_fluctuation and torque_reserve; of
    the engine stroke_ratio, pump_area_ratio, cut_off, clearance, pump_clearance, supply_pressure, back_pressure, atmospheric_pressure and
    rim_speed; of the governor arm, arm_angle, sleeve_travel or offset, mass_ratio or gear_ratio, resistance, insensitivity or ball_mass,
    dashpot and gravity.

    Returns
    -------
    GovernedEngineDesign
        The design; it prints as text, `scene` is the engine under a load that falls to the half, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, the pressures give no work, or the governor cannot have the droop.

    References
    ----------
    L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14; I. A. Wischnegradsky (Vyshnegradskii), Civilingenieur 23 (1877),
    pp. 95-132.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_governed_engine(power="20 PS", speed="120 rpm", droop=0.04)
    >>> round(design.flywheel.inertia)
    2926
    """
    from governor_mechanism.studies.design_inputs import change_inputs
    from governor_mechanism.studies.governed_engine.design import design_governed_engine as design
    from governor_mechanism.studies.governed_engine.inputs import DEFAULT_INPUTS

    return design(change_inputs(DEFAULT_INPUTS, inputs))


def design_pendulum(**inputs: float | str) -> gm.PendulumDesign:
    """Design a pendulum governor, after Watt or Porter, by Zehnder's procedure I to VIII.

    The inputs that are given replace the defaults, a Porter governor for 120 to 126 rpm against 6 kgf: numbers in SI, or texts with a unit.
    kind is "porter", "watt" or "improved-watt"; of the requirement lowest_speed, highest_speed, mass_ratio, insensitivity,
    speed_fluctuation and resistance; of the geometry start_radius, one of arm and offset, and joint_ratio; and gravity.

    Returns
    -------
    PendulumDesign
        The design; it prints as text, `scene` is the governor under a rising speed, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, or no such governor reaches the highest speed.

    References
    ----------
    L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_pendulum(arm="300 mm")
    >>> round(1e3 * design.sleeve_lift, 3)
    36.128
    """
    from governor_mechanism.studies.design_inputs import change_inputs
    from governor_mechanism.studies.pendulum.design import design_pendulum as design
    from governor_mechanism.studies.pendulum.inputs import DEFAULT_INPUTS

    return design(change_inputs(DEFAULT_INPUTS, inputs))


def design_hartnell(**inputs: float | str) -> gm.HartnellDesign:
    """Design the spring of a Hartnell governor for two speeds, by the textbooks' formula and by exact statics.

    The inputs that are given replace those of a textbook example, 290 to 310 rpm over a lift of 15 mm: numbers in SI, or texts with a unit.
    ball_mass, sleeve_mass, ball_arm, sleeve_arm, bell_crank_angle, pivot_radius (inner_radius if left out), inner_radius, one of
    outer_radius and lift, lowest_speed, highest_speed and gravity.

    Returns
    -------
    HartnellDesign
        The design; it prints as text, `scene` is the governor under a rising speed, and `as_json` returns plain values.

    Raises
    ------
    MechanismError
        If an input is not valid, the arms do not give the lift, or no spring holds the two speeds.

    References
    ----------
    R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Hartnell governor".

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> design = gm.design_hartnell(lift="15 mm")
    >>> round(design.textbook.rate / 1e3, 2), round(design.exact.rate / 1e3, 2)
    (19.75, 20.69)
    """
    from governor_mechanism.studies.design_inputs import change_inputs
    from governor_mechanism.studies.hartnell.design import design_hartnell as design
    from governor_mechanism.studies.hartnell.inputs import DEFAULT_INPUTS

    return design(change_inputs(DEFAULT_INPUTS, inputs))


def _as_rotating_part(scene: gm.SceneSource) -> gm.Scene:
    """Return a scene of the part that turns with a spindle, alone."""
    from governor_mechanism.engines.rotating_part import rotating_part_alone

    return rotating_part_alone(_as_scene(scene))


def _as_scene(scene: gm.SceneSource) -> gm.Scene:
    """Return a scene as it is, and load one that is given by name or path."""
    from governor_mechanism.model.scene import Scene

    return scene if isinstance(scene, Scene) else load(scene)


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
