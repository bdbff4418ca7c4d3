"""Design of a Hartnell governor: the spring for two speeds, by the textbooks' formula and by exact statics.

The textbooks neglect the weight of the balls and the obliquity of the arms. Both springs are held against the exact governor: the textbook
spring gives other speeds at the ends of the lift, the exact one the wanted speeds.

References
----------
R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Hartnell governor".
"""

import math
from dataclasses import replace

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.hartnell.inputs import DEFAULT_INPUTS, RPM, HartnellInputs, Travel, resolve_inputs
from governor_mechanism.studies.hartnell.results import HartnellDesign, SleeveSpring, build_governor
from governor_mechanism.studies.hartnell.scene_export import export_scene_document

SPEED_CHANGE = 0.01
"""Relative change of speed for which effort and power are stated, as textbooks do."""


def design_hartnell(inputs: HartnellInputs = DEFAULT_INPUTS) -> HartnellDesign:
    """Design the spring of a Hartnell governor for two speeds.

    Parameters
    ----------
    inputs
        The inputs; by default those of a textbook example.

    Returns
    -------
    HartnellDesign
        The design.

    Raises
    ------
    MechanismError
        If the inputs are not valid, or no spring of positive rate and compression holds the two speeds.
    """
    resolved, travel = resolve_inputs(inputs)
    governor, speeds = build_governor(resolved), (resolved.lowest_speed, resolved.highest_speed)
    weight = resolved.sleeve_mass * resolved.gravity
    ends = tuple(zip(travel.radii, travel.arm_angles, speeds, strict=True))
    textbook_forces = [
        float(closed.textbook_sleeve_force(governor, ball_radius=radius, spindle_speed=speed)) - weight for radius, _, speed in ends
    ]
    exact_forces = [float(closed.spring_force(governor, arm_angle=angle, spindle_speed=speed)) for _, angle, speed in ends]
    textbook_lift = (travel.radii[1] - travel.radii[0]) * resolved.sleeve_arm / resolved.ball_arm
    _require_spring(exact_forces, resolved)
    exact = _make_spring(governor, travel, exact_forces, travel.lift)
    textbook = _make_spring(governor, travel, textbook_forces, textbook_lift)
    design = HartnellDesign(
        inputs=resolved,
        travel=travel,
        textbook=textbook,
        exact=exact,
        textbook_effort=SPEED_CHANGE * (0.5 * sum(textbook_forces) + weight),
        effort=_exact_effort(governor, travel.middle_angle, 0.5 * sum(exact_forces)),
        warnings=tuple(_find_warnings(textbook, resolved)),
    )
    return replace(design, scene_document=export_scene_document(design))


def _require_spring(forces: list[float], inputs: HartnellInputs) -> None:
    """Raise MechanismError unless a spring that presses the sleeve down, harder in the highest position, gives the exact forces (N)."""
    lowest, highest = forces
    speeds = f"{inputs.lowest_speed / RPM:.6g} and {inputs.highest_speed / RPM:.6g} rpm"
    if lowest <= 0:
        raise MechanismError(
            f"at {inputs.lowest_speed / RPM:.6g} rpm the weights alone hold down the sleeve: the spring would have to lift it by "
            f"{-lowest:.6g} N in the lowest position; raise lowest_speed, take heavier balls, or reduce sleeve_mass"
        )
    if highest <= lowest:
        ratio = inputs.highest_speed / inputs.lowest_speed
        raise MechanismError(
            f"the speeds {speeds} need a spring force of {lowest:.6g} N in the lowest and {highest:.6g} N in the highest position, a rate "
            f"that is not positive; with these weights a ratio of the speeds above {ratio:.6g} is needed: raise highest_speed"
        )


def _make_spring(governor: closed.HartnellGovernor, travel: Travel, forces: list[float], lift: float) -> SleeveSpring:
    """Return the spring with two forces (N) over a lift (m), and the speeds that it gives the exact governor."""
    rate = (forces[1] - forces[0]) / lift
    # the textbooks' lift may differ from that of the arms, on which the spring is then fitted
    fitted = (forces[0], forces[0] + rate * travel.lift)
    low, high = (_find_speed(governor, angle, force) for angle, force in zip(travel.arm_angles, fitted, strict=True))
    return SleeveSpring(forces=(forces[0], forces[1]), rate=rate, compression=forces[0] / rate, speeds=(low, high))


def _find_speed(governor: closed.HartnellGovernor, arm_angle: float, force: float) -> float:
    """Return the speed of equilibrium (rad/s); raise MechanismError where the weight of the balls alone drives them outward."""
    try:
        return float(closed.equilibrium_speed(governor, arm_angle=arm_angle, spring_force=force))
    except MechanismError as error:
        raise MechanismError(
            f"at these speeds the textbooks may not neglect the weight of the balls: under their spring, {force:.6g} N at "
            f"{math.degrees(arm_angle):.4g} deg, it drives the balls outward at any speed; raise lowest_speed and highest_speed"
        ) from error


def _exact_effort(governor: closed.HartnellGovernor, arm_angle: float, force: float) -> float:
    """Return the mean force (N) on a sleeve held at an arm angle (rad) under a spring force (N), for a change of speed of 1 %."""
    speed = float(closed.equilibrium_speed(governor, arm_angle=arm_angle, spring_force=force))
    raised = float(closed.spring_force(governor, arm_angle=arm_angle, spindle_speed=(1 + SPEED_CHANGE) * speed))
    return 0.5 * (raised - force)


def _find_warnings(textbook: SleeveSpring, inputs: HartnellInputs) -> list[str]:
    """Return a sentence if the textbook spring makes the exact governor unstable."""
    if textbook.speeds[1] > textbook.speeds[0]:
        return []
    return [
        f"with the textbook spring the governor is unstable: it stands still at {textbook.speeds[0] / RPM:.6g} rpm in the lowest and at "
        f"{textbook.speeds[1] / RPM:.6g} rpm in the highest position, though {inputs.highest_speed / RPM:.6g} rpm are wanted there; take "
        "the exact spring"
    ]
