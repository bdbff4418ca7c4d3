"""Planar mechanisms of machine control: described once, run by several engines, checked against closed forms.

import governor_mechanism as gm
run = gm.run(gm.load("porter"), accuracy=1e-8)
print(run.readings["arm_angle"][-1], run.error_estimate)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from governor_mechanism.errors import GovernorMechanismError, MechanismError, RunFailed, UnsupportedEffect

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from governor_mechanism.engines import Engine
    from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.model.trajectory import Trajectory
    from governor_mechanism.statics.equilibria import Equilibrium
    from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
    from governor_mechanism.studies.effect_ablation import EffectsStudy
    from governor_mechanism.studies.slide_valve.valve_timing import ValveTiming
    from governor_mechanism.studies.sweep.run import Sweep
    from governor_mechanism.studies.work_precision.results import AccuracyStudy
    from governor_mechanism.verification.registry import CheckReport

__version__ = "0.1.0"


def load(scene: str | Path) -> Scene:
    """Read a scene: a path to a TOML file, or the name of a shipped scene.

    Raises MechanismError with every mistake of the file, one sentence each.
    """
    from governor_mechanism.engines.initial_state import initial_state
    from governor_mechanism.scenes.library import load_scene as load_scene

    loaded_scene = load_scene(scene)
    try:
        initial_state(loaded_scene)  # an impossible start is a mistake of the file, not of the run
    except MechanismError as error:
        raise MechanismError(*(f"{loaded_scene.source}: {problem}" for problem in error.problems)) from None
    return loaded_scene


def run(
    scene: Scene | str | Path,
    engine: str | Engine = "auto",
    accuracy: float | None = None,
    times: NDArray[np.float64] | Sequence[float] | None = None,
    certify: bool = True,
) -> Trajectory:
    """Simulate a scene and return what happened, how accurate it is and what it cost.

    engine is a name or an engine with settings of its own; accuracy is relative to each reading's scale; times (n,) s
    are reported instead of the scene's own. Raises MechanismError for a wrong description, UnsupportedEffect for an
    engine that lacks an effect; a run that ends early comes back with a named outcome.
    """
    from governor_mechanism.engines import select_engine

    resolved_scene = _resolve_scene(scene)
    name = resolved_scene.run.engine if engine == "auto" else engine
    selected_engine, reason = select_engine(name, resolved_scene, accuracy) if isinstance(name, str) else (name, "given")
    return selected_engine.run(resolved_scene, times=times, accuracy=accuracy, certify=certify, reason=reason)


def crosscheck(
    scene: Scene | str | Path,
    kernel: Callable[..., float] | None = None,
    quantity: str = "equilibrium_speed",
    over: Mapping[str, Any] | None = None,
    allowed: float | None = None,
) -> CheckReport:
    """Compare the simulation of a scene with every closed form that applies, or with a function of the caller's.

    A kernel gets its arguments by the names of dimensions and readings, in SI, and is compared over the values
    `over={"arm_angle": [...]}` of the leading coordinate; allowed is its relative tolerance. The report has .passed,
    .rows, and prints as a table.
    """
    resolved_scene = _resolve_scene(scene)
    if kernel is None:
        from governor_mechanism.verification.registry import check_against_closed_forms

        return check_against_closed_forms(resolved_scene)
    from governor_mechanism.verification.user_kernel import KERNEL_RELATIVE_TOLERANCE, check_kernel

    if over is None:
        coordinate = resolved_scene.part.mechanism.coordinate
        raise MechanismError(f"crosscheck needs over={{{coordinate!r}: [...]}}, the values at which to compare a kernel")
    return check_kernel(resolved_scene, kernel, quantity, over, KERNEL_RELATIVE_TOLERANCE if allowed is None else allowed)


def kinematics(
    scene: Scene | str | Path, over: str, values: Sequence[float] | NDArray[np.float64], rate: float = 1.0, acceleration: float = 0.0
) -> Kinematics:
    """Positions, velocities and accelerations of a scene's mechanism, without integration.

    over is a reading that takes the values (n,) SI at `rate` and `acceleration` (SI/s, SI/s2), whatever drives the
    scene has; or "time" (s), along which its drives move it. Raises MechanismError where that settles no motion.
    """
    from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics

    return solve_kinematics(_resolve_scene(scene), over, values, rate, acceleration)


def speed_curve(
    scene: Scene | str | Path, points: int = 500, *, resistance: float | str | None = None, against: str = "sleeve_lift"
) -> SpeedCurve:
    """The speed at which a scene's mechanism rests, over its whole travel, with stiffness, frequencies and folds.

    With a resistance (N, or N m; or "40 N") at the reading `against`, its insensitivity band too. Raises MechanismError for
    a mechanism of another mobility than one, and where nothing that the spindle's turning could balance pulls at it.
    """
    from governor_mechanism.statics.speed_curve import compute_speed_curve as curve

    return curve(_resolve_scene(scene), points, resistance=resistance, against=against)


def insensitivity_band(
    scene: Scene | str | Path, over: Sequence[float] | NDArray[np.float64], resistance: float | str, against: str = "sleeve_lift"
) -> InsensitivityBand:
    """Between which spindle speeds a resistance (N, or N m; or "40 N") at a reading holds a scene's mechanism.

    over are values (n,) SI of its leading coordinate. Raises MechanismError for a negative resistance, for values
    outside the travel, and where no speed holds the mechanism without resistance.
    """
    from governor_mechanism.statics.speed_curve import compute_insensitivity_band as band

    return band(_resolve_scene(scene), over, resistance, against)


def equilibria(scene: Scene | str | Path, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """Every equilibrium position at a spindle speed (rad/s, or "61 rpm"; the scene's first if left out), and its stability.

    An astatic mechanism rests over a range, its `extent`. Raises MechanismError for a mechanism of another mobility
    than one, for a speed where nothing turns with the spindle, and where there is no rest at that speed, with the
    speeds at which there is.
    """
    from governor_mechanism.statics.equilibria import find_equilibria

    return find_equilibria(_resolve_scene(scene), spindle_speed)


def accuracy_study(scene: Scene | str | Path, longest: float = 1.0, progress: Callable[[int, int], None] | None = None) -> AccuracyStudy:
    """Every engine at every setting: its error against a reference that another engine confirms, and its time.

    Settings that take more than `longest` (s) are left out. The study has .cheapest_for(1e-6), .advice(1e-6), .points,
    and prints as a table. Raises MechanismError where there is no reference.
    """
    from governor_mechanism.studies.work_precision.study import run_accuracy_study as study

    return study(_resolve_scene(scene), longest, progress)


def effects_study(
    scene: Scene | str | Path, engine: str = "auto", accuracy: float | None = None, progress: Callable[[int, int], None] | None = None
) -> EffectsStudy:
    """What each effect of a scene changes in its readings and what it costs, and which may be left out.

    The scene is run as it is, and with each effect switched. Raises MechanismError where it cannot be run.
    """
    from governor_mechanism.studies.effect_ablation import run_effects_study as study

    return study(_resolve_scene(scene), engine, accuracy, progress)


def sweep(
    scene: Scene | str | Path,
    vary: Mapping[str, Any] | Sequence[str],
    quantities: Mapping[str, str | Callable[[Trajectory], float]] | Sequence[str] | None = None,
    *,
    engine: str = "auto",
    accuracy: float | None = None,
    certify: bool = False,
    workers: int = 1,
    out: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sweep:
    """Run a scene at every combination of values of its keys, and take some numbers from each run.

    vary is {"dimensions.arm": [0.2, "300 mm"]}, or as on the command line ["dimensions.arm=200mm:400mm:50"];
    quantities are names such as "max arm_angle" or "final rate of sleeve_lift" (min, max and span are over the reported
    times), or names of your own with functions of the run. Rows are made by so many processes, and do not depend on it.
    With out, a folder, they are kept as they come, and the same sweep started again goes on from there. The result has
    .column(name), .grid(name) and .rows, SI, each row with its outcome. Raises MechanismError with every mistake of
    what was asked; a row that cannot be run says so, and stops no other.
    """
    from governor_mechanism.studies.sweep.run import sweep as run_sweep

    return run_sweep(
        _resolve_scene(scene),
        vary,
        quantities,
        engine=engine,
        accuracy=accuracy,
        certify=certify,
        workers=workers,
        out=out,
        progress=progress,
    )


def valve_timing(scene: Scene | str | Path) -> ValveTiming:
    """When a slide valve admits, cuts off, releases and shuts in steam, at both ends of the cylinder.

    By crank angle and stroke: found on the mechanism, by the exact closed form, and by theory without its error term.
    Raises MechanismError for another machine.
    """
    from governor_mechanism.studies.slide_valve.valve_timing import tabulate_valve_timing as events

    return events(_resolve_scene(scene))


def _resolve_scene(scene: Scene | str | Path) -> Scene:
    return load(scene) if isinstance(scene, str | Path) else scene


def film(run: Trajectory | Sequence[Trajectory], path: str | Path, **options: Any) -> Path:
    """Write a run as an animation (.gif, or .mp4 with the extra `video`); options as in `render.film.film`.

    Two runs that report the same times stand side by side, under the option titles=("left", "right").
    """
    from governor_mechanism.render.film.writer import write_film as write_film

    return write_film(run, path, **options)


__all__ = [
    "GovernorMechanismError",
    "MechanismError",
    "RunFailed",
    "UnsupportedEffect",
    "accuracy_study",
    "crosscheck",
    "effects_study",
    "equilibria",
    "film",
    "insensitivity_band",
    "kinematics",
    "load",
    "run",
    "speed_curve",
    "sweep",
    "valve_timing",
]
