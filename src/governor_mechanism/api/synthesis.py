"""Synthesis: dimensions of four-bars for what is wanted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import governor_mechanism as gm


def synthesise_function(
    pairs: gm.PointSource | None = None,
    *,
    function: str | Callable[[float], float] | None = None,
    over: Sequence[float | str] | None = None,
    input_angles: Sequence[float | str] | None = None,
    output_angles: Sequence[float | str] | None = None,
    count: int | None = None,
    ground: float | str | None = None,
) -> gm.FunctionSynthesis:
    """Return the four-bars whose output turns as a function of the input, exactly at three, four or five angles.

    Freudenstein's equation is solved for pairs of angles: of input and output from the line of the fixed pivots, anticlockwise. Three
    pairs have one linkage at most. With four the angle at which the output starts is free, with five that of the input too, and all
    linkages are found. Each is run through the pairs with the kinematics of the package.

    Parameters
    ----------
    pairs
        Pairs of an input and an output angle, rad or texts with a unit, or the path of a file: CSV with the columns "input_angle [deg]"
        and "output_angle [deg]", or TOML with `points` or with the other arguments as keys. None for a function.
    function
        The function of x: a formula, as "log10(x)", or a Python function. Its angles have Chebyshev's spacing.
    over
        First and last value of x.
    input_angles
        Angles of the input at these, rad or texts with a unit; proportional to x between.
    output_angles
        Angles of the output at these; proportional to the function between.
    count
        Number of pairs of angles, 3 to 5; None is 3.
    ground
        Distance of the fixed pivots, m or text with a unit; None is 1 m.

    Returns
    -------
    FunctionSynthesis
        The linkages, the best first; it prints as a table. `rows[0].scene` is a scene that runs, `structural_error(1)` how far the output
        of the first is from the function.

    Raises
    ------
    MechanismError
        If there are too few or too many angles, if two coincide, if something is no quantity, or if the function has no finite value.

    References
    ----------
    F. Freudenstein, Approximate synthesis of four-bar linkages, Transactions of the ASME 77 (1955), pp. 853-861.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> angles = {"input_angles": ["30 deg", "120 deg"], "output_angles": ["240 deg", "330 deg"]}
    >>> found = gm.synthesise_function(function="1/x", over=[1, 2], **angles)
    >>> [round(length, 3) for length in found.rows[0].linkage.lengths]
    [1.0, 2.475, 0.912, 2.474]
    """
    from governor_mechanism.studies.synthesis.function import read_function_task
    from governor_mechanism.studies.synthesis.function import synthesise_function as synthesise

    given = {
        "function": function,
        "over": over,
        "input_angles": input_angles,
        "output_angles": output_angles,
        "count": count,
        "ground": ground,
    }
    return synthesise(*read_function_task(pairs, given))
