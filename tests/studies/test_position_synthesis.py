"""Four-bars through positions of a body: recovered linkages, laws of Burmester's theory, and what is refused."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.synthesis.positions import Displacements, burmester_curves, circle_equations, find_dyads

FIXED = np.array([0j, 3.2 + 0j])


def guided_positions(count):
    """Positions of a body on the coupler of a crank-rocker 3.2, 1, 3, 2.5, and its moving pivots, by the cosine rule."""
    crank, coupler, rocker = 1.0, 3.0, 2.5
    start = crank * np.exp(1j * np.linspace(0.3, 1.9, 5))[:count]
    vector = start - FIXED[1]
    inner = np.arccos((rocker**2 + np.abs(vector) ** 2 - coupler**2) / (2 * rocker * np.abs(vector)))
    end = FIXED[1] + rocker * np.exp(1j * (np.angle(vector) - inner))
    angle = np.angle(end - start)
    point = start + (1.5 + 0.8j) * np.exp(1j * angle)
    return np.column_stack([point.real, point.imag, angle + 0.3]), (start[0], end[0])


def pole(first, second):
    turn = np.exp(1j * (second[2] - first[2]))
    start, end = (complex(*one[:2]) for one in (first, second))
    return (end - turn * start) / (1 - turn)


def curve_equation(body, centres):
    """The cubic of centre points, relative to its terms: determinants of the equations of three circles in the moving pivot."""
    equations, at = circle_equations(body), centres - body.point
    values = []
    for x, y in zip(at.real, at.imag, strict=True):
        p, q = equations[:, 4], equations[:, 5]
        rows = np.column_stack(
            [equations[:, 0] + x * p - y * q, equations[:, 1] + y * p + x * q, equations[:, 6] + equations[:, 2:4] @ (x, y)]
        )
        values.append(np.linalg.det(rows) / (1.0 + abs(complex(x, y))) ** 3)
    return np.array(values)


def pairs(points):
    return [[one.real, one.imag] for one in points]


@pytest.mark.parametrize("chosen", ["fixed_pivots", "moving_pivots"])
def test_three_positions_and_two_pivots_give_back_the_linkage(chosen):
    positions, moving = guided_positions(3)
    found = gm.synthesise_positions(positions, **{chosen: pairs(FIXED if chosen == "fixed_pivots" else moving)})
    assert found.rows[0].linkage.lengths == pytest.approx((3.2, 1.0, 3.0, 2.5), rel=1e-9)
    assert found.rows[0].defects == "none"
    assert found.rows[0].check.distance < 1e-9
    assert "branch" in found.rows[1].defects  # the rocker drives, and cannot lead through a toggle


def test_text_table_and_figure_say_where_and_how_large_it_is():
    """The pivots that were given stand in text and table, and a bar is as long as its words say."""
    positions, _ = guided_positions(3)
    found = gm.synthesise_positions(positions, fixed_pivots=pairs(FIXED))
    assert "(0, 0)  (3200, 0)" in str(found).splitlines()[1]
    row = found.to_dataframe().iloc[0]
    assert row[["input_pivot_x", "input_pivot_y", "output_pivot_x", "output_pivot_y"]].to_list() == pytest.approx([0.0, 0.0, 3.2, 0.0])
    figure = found.plot()
    assert [text.get_text() for text in figure.legends[0].get_texts()][:3] == ["input", "output", "coupler"]
    for panel in figure.axes:
        (words,) = (text.get_text() for text in panel.texts if text.get_text().endswith(" mm"))
        (bar,) = (line for line in panel.lines if line.get_transform() is panel.transAxes)
        assert np.ptp(bar.get_xdata()) * np.ptp(panel.get_xlim()) == pytest.approx(1e-3 * float(words.removesuffix(" mm")))


def test_burmesters_curves_hold_all_circles_and_pass_the_poles():
    positions, moving = guided_positions(4)
    body = Displacements(positions)
    curves = burmester_curves(body)
    radii = np.abs(body.moved(curves[:, 1]) - curves[:, :1])
    near = np.abs(curves).max(axis=1) < 30.0
    assert np.ptp(radii, axis=1)[near].max() < 1e-10
    poles = np.array([pole(positions[first], positions[second]) for second in range(4) for first in range(second)])
    assert np.abs(curve_equation(body, poles)).max() < 1e-12
    assert np.abs(curve_equation(body, curves[near, 0])).max() < 1e-9
    assert np.abs(curve_equation(body, poles + 0.1)).min() > 1e3 * np.abs(curve_equation(body, poles)).max()
    assert np.abs(curves - [FIXED[0], moving[0]]).max(axis=1).min() < 0.05


def test_four_positions_have_linkages_without_defects():
    positions, _ = guided_positions(4)
    found = gm.synthesise_positions(positions)
    best = found.rows[0]
    assert best.defects == "none"
    assert best.check.distance < 1e-9
    assert abs(best.check.transmission - np.pi / 2) < np.radians(30.0)


def test_five_positions_have_the_dyads_of_the_linkage_that_guides_them():
    positions, moving = guided_positions(5)
    found = gm.synthesise_positions(positions)
    for fixed, end in zip(FIXED, moving, strict=True):
        assert min(abs(one.fixed - fixed) + abs(one.moving - end) for one in found.dyads) < 1e-9
    assert found.rows[0].linkage.lengths == pytest.approx((3.2, 1.0, 3.0, 2.5), rel=1e-9)


def test_five_positions_have_four_two_or_no_dyads():
    """Roots of a quartic: an even number is real; every one has its five moving pivots on a circle."""
    generator = np.random.default_rng(3)
    counts = set()
    for _ in range(40):
        body = Displacements(generator.uniform(-1.0, 1.0, (5, 3)))
        dyads = find_dyads(body)
        counts.add(len(dyads))
        for one in dyads:
            radii = np.abs(body.moved(one.moving) - one.fixed)
            assert np.ptp(radii) < 1e-8 * radii.max()
    assert counts == {0, 2, 4}


POSITIONS = [[0, 0, 0], [1, 0.5, "20 deg"], [2, 0.5, "50 deg"]]


def test_a_map_holds_the_circles_and_their_linkages_run_as_it_says():
    found = gm.map_pivots(POSITIONS, moving_pivots=[[0, 0]], count=21)
    body = Displacements(np.array([[0, 0, 0], [1, 0.5, np.radians(20.0)], [2, 0.5, np.radians(50.0)]]))
    places, centres = found.x + 1j * found.y, found.other_x + 1j * found.other_y
    is_near = np.abs(centres) < 1e3
    radii = np.abs(body.moved(places) - centres[:, None])
    assert np.ptp(radii, axis=1)[is_near].max() < 1e-9
    assert np.abs(radii[is_near, 0] - found.link[is_near]).max() < 1e-12
    assert sum(region.share for region in found.regions) == pytest.approx(1.0, rel=1e-14)
    defects = {"input turns fully": "none", "input rocks": "none", "branch": "branch"}
    for region in found.regions:
        if region.name in defects:
            chosen = [[0, 0], [region.x, region.y]]
            rows = gm.synthesise_positions(POSITIONS, moving_pivots=chosen).rows
            row = next(one for one in rows if abs(one.linkage.moving[0]) < 1e-12)  # the link of the first pivot drives
            assert row.defects.startswith(defects[region.name])
            assert row.check.turns_fully == (region.name == "input turns fully")
