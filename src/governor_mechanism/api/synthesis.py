"""Synthesis: dimensions of four-bars, and of any mechanism, for what is wanted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.units.problems import TEXT, check_arguments, whole_number


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


def map_pivots(
    positions: gm.PointSource,
    *,
    moving_pivots: Sequence[Sequence[float | str]] | None = None,
    fixed_pivots: Sequence[Sequence[float | str]] | None = None,
    span: float | str | None = None,
    count: int | None = None,
) -> gm.PivotMap:
    """Return the map of the second pivot of the four-bars through three positions of a body, with the first one chosen.

    Each place of the second pivot has one linkage. The map says whether its input, the link at the first pivot, turns fully or rocks, or
    which is its gravest defect, with the length of its output link and the least transmission angle at the positions, by the signs and
    sizes of the angles between the links.

    Parameters
    ----------
    positions
        Three rows of x, y and the angle of the body, or the path of a file, as in `synthesise_positions`.
    moving_pivots
        A list of the first moving pivot in the first position, in the fixed axes; a second one is not used. None, without `fixed_pivots`,
        is the point of the body.
    fixed_pivots
        A list of the first fixed pivot, for a map of the second fixed one.
    span
        Width and height of the map, m or text with a unit; None is four times the extent of the positions.
    count
        Number of places on each side; None is 101.

    Returns
    -------
    PivotMap
        The regions; it prints as a table, and `plot` draws the map.

    Raises
    ------
    MechanismError
        If there are not three positions, if two coincide, if the body does not turn, if the link of the first pivot would be a slider, or
        if something is no quantity.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> found = gm.map_pivots([[0, 0, 0], [1, 0.5, "20 deg"], [2, 0.5, "50 deg"]], moving_pivots=[[0, 0]])
    >>> found.regions[0].name
    'input turns fully'
    """
    from governor_mechanism.studies.synthesis.pivot_map import map_pivots as make_map
    from governor_mechanism.studies.synthesis.pivot_map import read_map_task

    given = {"moving_pivots": moving_pivots, "fixed_pivots": fixed_pivots, "span": span, "count": count}
    return make_map(*read_map_task(positions, given))


def synthesise_path(
    points: gm.PointSource,
    *,
    closed: bool | None = None,
    fixed_pivots: Sequence[Sequence[float | str]] | None = None,
    starts: int | None = None,
    seed: int | None = None,
) -> gm.PathSynthesis:
    """Return the four-bars whose coupler has a point that passes given points, or is nearest to a curve of many.

    Nine points determine a linkage, five with chosen fixed pivots or with input angles, three with both; fewer leave dimensions free. The
    equations are solved from many random starts, and each solution found is listed once; a search does not prove that there are no
    others. Along more points the linkages are the nearest by least squares; so they are where no linkage without defects is found that
    passes the points exactly. Of each with its two cognates, which draw the same path, the one with the fewest defects and the best
    transmission angle is run through the points with the kinematics of the package.

    Parameters
    ----------
    points
        Rows of x and y, SI or texts with a unit, in the order in which they are passed, or the path of a file: CSV with the columns
        "x [mm]" and "y [mm]", or TOML with `points` and the other arguments as keys. A third column "input_angle [deg]" is a timing:
        angles of the input, of which the differences count.
    closed
        Whether the path ends where it starts, so that the input must turn fully; None is False.
    fixed_pivots
        Two fixed pivots, of input and output.
    starts
        Number of random starts; None is 2000, and 10,000 along a curve.
    seed
        Seed of the random starts; None is 0.

    Returns
    -------
    PathSynthesis
        The linkages, the best first; it prints as a table. `rows[0].scene` is a scene that runs, `rows[0].cognates` are its cognates, and
        `not_run` further linkages.

    Raises
    ------
    MechanismError
        If there are too few or too many points, if neighbours coincide, if input angles neither rise nor fall, or if something is no
        quantity.

    References
    ----------
    C. W. Wampler, A. P. Morgan, A. J. Sommese, Complete solution of the nine-point path synthesis problem for four-bar linkages, Journal
    of Mechanical Design 114 (1992), pp. 153-159.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> found = gm.synthesise_path([[0, 0], [1, 0.2], [2, 0.2], [3, 0]], starts=200)
    >>> found.rows[0].defects
    'none'
    """
    from governor_mechanism.studies.synthesis.path import read_path_task
    from governor_mechanism.studies.synthesis.path import synthesise_path as synthesise

    return synthesise(read_path_task(points, {"closed": closed, "fixed_pivots": fixed_pivots, "starts": starts, "seed": seed}))


def synthesise_positions(
    positions: gm.PointSource,
    *,
    fixed_pivots: Sequence[Sequence[float | str]] | None = None,
    moving_pivots: Sequence[Sequence[float | str]] | None = None,
) -> gm.PositionSynthesis:
    """Return the four-bars whose coupler passes three, four or five positions of a body.

    Of three positions two pivots are chosen, and the others follow. Four have pivots on both of Burmester's curves: pairs of their points
    are taken that pass the positions in order, with the best transmission angles. Five have four dyads at most, with six four-bars. Each
    linkage is run through the positions with the kinematics of the package.

    Parameters
    ----------
    positions
        Rows of x, y and the angle of the body, SI or texts with a unit, in the order in which they are passed, or the path of a file: CSV
        with the columns "x [mm]", "y [mm]" and "angle [deg]", or TOML with `points` and the pivots as keys.
    fixed_pivots
        Two fixed pivots, for three positions.
    moving_pivots
        Two moving pivots at the first position, in the fixed axes, for three positions.

    Returns
    -------
    PositionSynthesis
        The linkages, the best first; it prints as a table. `rows[0].scene` is a scene that runs, `centre_curve` and `circle_curve` are
        Burmester's curves, and `dyads` all pairs of a fixed and a moving pivot of five positions.

    Raises
    ------
    MechanismError
        If there are too few or too many positions, if two coincide, if the body does not turn, if pivots are missing or not free, or if
        something is no quantity.

    References
    ----------
    G. N. Sandor, A. G. Erdman, Advanced mechanism design 2 (1984), chapter 3; J. M. McCarthy, G. S. Soh, Geometric design of linkages
    (2011), chapter 5.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> positions = [[0, 0, 0], [1, 0.5, "20 deg"], [2, 0.5, "50 deg"]]
    >>> found = gm.synthesise_positions(positions, moving_pivots=[[0, 0], [1, 0.5]])
    >>> len(found.dyads)
    2
    """
    from governor_mechanism.studies.synthesis.positions import read_position_task
    from governor_mechanism.studies.synthesis.positions import synthesise_positions as synthesise

    return synthesise(*read_position_task(positions, {"fixed_pivots": fixed_pivots, "moving_pivots": moving_pivots}))


@check_arguments(point=TEXT, along=TEXT, starts=whole_number(1), seed=whole_number(0))
def synthesise_dimensions(
    scene: gm.SceneSource,
    over: Mapping[str, Sequence[float | str]] | Sequence[str],
    point: str,
    path: gm.PointSource,
    *,
    along: str | None = None,
    between: Sequence[float | str] | None = None,
    starts: int = 6,
    seed: int = 0,
) -> gm.DimensionSynthesis:
    """Find dimensions of a mechanism of one's own with which one of its points draws a path.

    The sum of the squared distances of the given points from the path is minimised, which passes them in their order, in either direction;
    where on it the first lies is free. An impossible geometry lies outside.

    Parameters
    ----------
    scene
        A scene of one part, the path of a file, or the name of a shipped scene. Its values are the first start.
    over
        Lower and upper bound by key, as {"dimensions.rocker": ("2 m", "3 m")} or ["dimensions.rocker=2m:3m"].
    point
        Name of the point, as in `run.paths`.
    path
        Rows of x and y, m or texts with a unit, or the path of a file: CSV with the columns "x [mm]" and "y [mm]", or TOML with `points`.
    along
        Name of the reading that drives the mechanism, or "time"; None as in `kinematics`.
    between
        First and last value of that reading; None for a whole turn, or for its travel.
    starts
        Number of starts: the scene's own values, and the best of random ones.
    seed
        Seed of the random starts.

    Returns
    -------
    DimensionSynthesis
        All different solutions, the best first; it prints as a table. `rows[0].scene` is a scene that runs.

    Raises
    ------
    MechanismError
        If scene, bounds, point or path have mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> line = [[0.0, 4.0], [1.0, 4.0], [2.0, 4.0], [3.0, 4.0], [4.0, 4.0]]
    >>> found = gm.synthesise_dimensions("chebyshev_lambda", ["dimensions.rocker=2m:3m"], "rod.end", line, starts=1)
    >>> round(found.rows[0].values["dimensions.rocker"], 2)
    2.5
    """
    from governor_mechanism.studies.synthesis.dimensions import read_dimension_task
    from governor_mechanism.studies.synthesis.dimensions import synthesise_dimensions as synthesise

    return synthesise(read_dimension_task(as_scene(scene), over, point, path, along, between, {"n_starts": starts, "seed": seed}))
