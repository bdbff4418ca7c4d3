"""Positions of linkages and the timing of valves: what needs no forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.units.problems import QUANTITIES, QUANTITY, TEXT, TEXTS, check_arguments, whole_number


@check_arguments(over=TEXT, values=QUANTITIES, rate=QUANTITY, acceleration=QUANTITY, readings=TEXTS)
def kinematics(
    scene: gm.SceneSource,
    over: str | None = None,
    values: gm.QuantityValues | None = None,
    rate: float | str = 1.0,
    acceleration: float | str = 0.0,
    *,
    readings: Sequence[str] = (),
) -> gm.KinematicStudy:
    """Return positions, velocities and accelerations of a mechanism without integration, and what holds of the whole linkage.

    The readings include forces of springs and weights, pressures and shaft speeds where positions and rates alone determine them.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    over
        Name of the reading that drives the mechanism in place of the scene's drivers, or "time" for the drivers themselves. None is the
        angle of the body that a driver turns, or else the leading coordinate.
    values
        Values of the reading, SI, or times, s, or texts with a unit such as "20 deg"; shape (n,). None is 361 values over a whole turn,
        or over the travel of the reading.
    rate
        First time derivative of the reading at each value, SI/s, or text with a unit.
    acceleration
        Second time derivative of the reading at each value, SI/s2, or text with a unit.
    readings
        Further readings, beside those that the scene names in `run.readings`: "velocity.POINT" and "acceleration.POINT" with components
        ".x", ".y" and ".magnitude", "curvature.POINT", "transmission_angle.COUPLER", "instantaneous_centre.BODY.BODY" with ".x" and
        ".y", and "mechanical_advantage.INPUT.OUTPUT" of two readings. NaN where one is not defined; `notes` says where and why.

    Returns
    -------
    KinematicStudy
        The motion; `mobility`, `four_bars`, `dead_centres`, `toggles` and `time_ratios` of the linkage. It prints as a table.

    Raises
    ------
    MechanismError
        If the motion is not determined, if the mechanism cannot be assembled, at a singular configuration, or if there is no such reading.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> motion = gm.kinematics("slider_crank_torque", over="crank_angle", values=[0.1, 0.2], rate=10.0)
    >>> motion.poses.shape[0]
    2
    >>> print(gm.kinematics("drag_link").four_bars[0])
    four-bar ground ...double crank...
    """
    from governor_mechanism.studies.kinematics import study_kinematics

    return study_kinematics(as_scene(scene), over, values, rate, acceleration, readings)


def assemblies(scene: gm.SceneSource) -> gm.Assemblies:
    """Return all ways in which the joints of a mechanism close at its drives, start values and given angles.

    Loops of two bodies are solved in closed form and larger ones by homotopy, so that none is missed; where a guide curve or a gear
    forbids that, they are sought from many starts, and `complete` is False. `assembly = 2` in a scene file takes the second.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.

    Returns
    -------
    Assemblies
        The list; it prints as a table, and its method `plot` draws a sheet.

    Raises
    ------
    MechanismError
        If a motion is left, with the number of values that must be given, or if the joints cannot close.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> len(gm.assemblies("quick_return"))
    2
    """
    from governor_mechanism.studies.assemblies import list_scene_assemblies

    return list_scene_assemblies(as_scene(scene))


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
    from governor_mechanism.studies.valve_gears import tabulate_valve_timing

    return tabulate_valve_timing(as_scene(scene))


@check_arguments(count=whole_number(2))
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
    from governor_mechanism.studies.valve_gears import SHIPPED_GEARS, compare_valve_gears

    sources = scenes if isinstance(scenes, list | tuple) else [cast("gm.SceneSource", scenes)]
    return compare_valve_gears([as_scene(scene) for scene in sources or SHIPPED_GEARS], count)
