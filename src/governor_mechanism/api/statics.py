"""Equilibria, their stability, and the forces of governors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_rotating_part, as_scene
from governor_mechanism.errors import MechanismError
from governor_mechanism.units.problems import TEXT, check_arguments


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

    return compute_speed_curve(as_rotating_part(scene), points, resistance=resistance, against=against)


def controlling_force(
    scene: gm.SceneSource,
    over: gm.QuantityValues | None = None,
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
        Values of the leading coordinate, SI, or texts with a unit such as "20 deg"; shape (n,). None for the whole travel.
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
    return compute_controlling_force(as_rotating_part(scene), over, points=points, resistance=resistance, **options)


def insensitivity_band(
    scene: gm.SceneSource, over: gm.QuantityValues, resistance: float | str, against: str = "sleeve_lift"
) -> gm.InsensitivityBand:
    """Return the spindle speeds between which a resistance keeps a mechanism in equilibrium.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; of several parts, the one that turns with a spindle, alone.
    over
        Values of the leading coordinate, SI, or texts with a unit such as "20 deg"; shape (n,).
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

    return compute_insensitivity_band(as_rotating_part(scene), over, resistance, against)


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

    return find_equilibria(as_rotating_part(scene), spindle_speed)


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

    resolved_scene = as_scene(scene)
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
    from governor_mechanism.statics.linearisation import find_stability_limit
    from governor_mechanism.studies.sweep.parameters import parse_axes

    document = as_scene(scene).document
    (axis,) = parse_axes(document, {key: [low, high]})
    if not axis.is_numeric:
        raise MechanismError(f"{key} takes no quantity, so it has no limit of stability; name the key of a number")

    def linearise_at(value: float) -> gm.Linearisation:
        return linearise(parse_scene_with(document, [(axis.key, f"{value!r} {axis.unit}" if axis.unit else value)]))

    first, last = (float(value) for value in axis.values)
    return find_stability_limit(linearise_at, first, last, key=key, unit=axis.unit)


def explore(scene: gm.SceneSource, *keys: str) -> gm.Exploration:
    """Show a scene in a notebook as the live page: drag its points, change its quantities, and motion, plots and equilibria follow.

    It is the page of `governor-mechanism open`, in an output cell. Each change is answered by a certified run.

    The arguments after the scene are names of dimensions or dotted keys that are offered alone, also with a range, as "arm",
    "arm=200 mm:400 mm" or "effects.spring.sleeve.rate"; all quantities of the scene if there are none. Without a range, a slider goes
    from half to double the value.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.

    Returns
    -------
    Exploration
        The view. In a script, `set` does what a slider does; `scene` is the changed scene, and `run` its run.

    Raises
    ------
    MechanismError
        If a key is wrong, or the scene cannot be run.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> view = gm.explore("porter", "arm", "sleeve_mass=10 kg:40 kg")
    >>> view.set("arm", "320 mm")
    >>> view.scene.part.dimensions["arm"], view.problem
    (0.32, '')
    """
    from governor_mechanism.notebook.exploration import explore_scene

    return explore_scene(as_scene(scene), keys)
