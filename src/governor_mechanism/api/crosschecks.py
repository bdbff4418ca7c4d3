"""Simulation against closed forms, against kernels of the caller, and against the papers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_rotating_part, as_scene
from governor_mechanism.errors import MechanismError
from governor_mechanism.units.problems import BY_NAME, FLAG, FUNCTION, NUMBER, TEXT, TEXTS_BY_NAME, VARIED, check_arguments, whole_number

if TYPE_CHECKING:
    from governor_mechanism.verification.user_kernel import VariedKey


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


@check_arguments(
    kernel=FUNCTION,
    quantity=TEXT,
    over=BY_NAME,
    allowed=NUMBER,
    names=TEXTS_BY_NAME,
    unit=TEXT,
    vary=VARIED,
    random=whole_number(1),
    seed=whole_number(0),
)
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
        Relative tolerance of the kernel; the default of `verification.user_kernel_comparison` if None.
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
        from governor_mechanism.verification.machines.registry import check_against_closed_forms

        return check_against_closed_forms(as_rotating_part(scene))
    from governor_mechanism.verification.user_kernel_comparison import KERNEL_RELATIVE_TOLERANCE, check_kernel

    resolved_scene = as_scene(scene)
    tolerance = KERNEL_RELATIVE_TOLERANCE if allowed is None else allowed
    varied = () if vary is None else _varied_keys(resolved_scene, vary)
    options: dict[str, Any] = {"names": names, "unit": unit, "varied": varied, "random": random, "seed": seed}
    return check_kernel(resolved_scene, kernel, quantity, over, tolerance, **options)


def _varied_keys(scene: gm.Scene, vary: Mapping[str, Any] | Sequence[str]) -> tuple[VariedKey, ...]:
    """Return the keys of a scene that vary, with their numbers; "first:last" stands for two values."""
    from governor_mechanism.studies.sweep.parameters import parse_axes
    from governor_mechanism.verification.user_kernel import VariedKey

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


@check_arguments(paper=TEXT, simulate=FLAG)
def errata(paper: str | None = None, *, simulate: bool = False) -> gm.Errata:
    """Return what is not right in the papers, found by recomputing and simulating: each place with cause and proof.

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
    from governor_mechanism.papers.errata_results import collect_errata

    return collect_errata(paper, simulate=simulate)
