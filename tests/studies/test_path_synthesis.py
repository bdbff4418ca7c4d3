"""Four-bars along a path: printed problems and solutions, recovered linkages, the theorem of Roberts and Chebyshev, and what is refused."""

import itertools

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.synthesis import path as path_module
from governor_mechanism.studies.synthesis.linkage import DEFECTS, FourBarLinkage, check_linkage, judge
from governor_mechanism.studies.synthesis.path import find_cognates, find_linkages, read_path_task
from refusing import refuses


@pytest.fixture(autouse=True)
def few_runs(monkeypatch):
    """Only the best two linkages are run: runs take most of the time."""
    monkeypatch.setattr(path_module, "N_RUN", 2)


CRANK_ROCKER = {"ground": 3.2, "crank": 1.0, "coupler": 3.0, "rocker": 2.5, "place": 1.5 + 0.8j}
LAMBDA = {"ground": 2.0, "crank": 1.0, "coupler": 2.5, "rocker": 2.5, "place": 5.0}
"""Chebyshev's lambda linkage, with its proportions."""


def places(inputs, *, ground, crank, coupler, rocker, place):
    """Moving pivots and point of a four-bar on the axis of x by the cosine rule; shape (n, 3)."""
    start = crank * np.exp(1j * inputs)
    vector = start - ground
    inner = np.arccos((rocker**2 + np.abs(vector) ** 2 - coupler**2) / (2 * rocker * np.abs(vector)))
    end = ground + rocker * np.exp(1j * (np.angle(vector) - inner))
    return np.column_stack([start, end, start + place * (end - start) / coupler])


def pairs(points):
    return np.column_stack([points.real, points.imag])


def find(points, **given):
    """Linkages that pass the points exactly."""
    found = find_linkages(read_path_task(points, given))
    return found[found.cost < path_module.PASSES]


def linkages(found):
    """All that are found, with their cognates, as numbers: pivots and moving pivots."""
    for k in range(len(found.cost)):
        one = FourBarLinkage(fixed=tuple(found.fixed[k]), moving=tuple(found.moving[k, 0]), point=found.reached[k, 0])
        yield from (one, *find_cognates(one))


def least_difference(found, fixed, moving):
    """Distance of the nearest linkage found, or cognate, with either link as input, from a known one."""
    known = np.array([*fixed, *moving])
    return min(np.abs(np.array([*one.fixed[::turn], *one.moving[::turn]]) - known).max() for one in linkages(found) for turn in (1, -1))


NINE_POINTS = [[0.25, 0.0], [0.52, 0.1], [0.8, 0.7], [1.2, 1.0], [1.4, 1.3], [1.1, 1.48], [0.7, 1.4], [0.2, 1.0], [0.02, 0.4]]
"""Problem 3 of C. W. Wampler, A. P. Morgan, A. J. Sommese, Journal of Mechanical Design 114 (1992), p. 153, as J. D. Hauenstein and
F. Sottile print it (alphaCertified, ACM TOMS algorithm 921, FourBar/animate/README): 64 of its 1442 linkages are real, and one of these
passes the points without being taken apart."""


@pytest.mark.parametrize(("starts", "least"), [(300, 5), pytest.param(30_000, 55, marks=pytest.mark.long)])
def test_one_of_the_linkages_through_nine_points_of_the_literature_is_without_defects(starts, least):
    found = find(NINE_POINTS, closed=True, starts=starts)
    assert least <= len(found.cost) <= 64
    lengths = np.abs(found.moving - found.fixed[:, None])
    assert np.ptp(lengths, axis=1).max() < 1e-8 * lengths.max()
    judgement = judge(found.fixed, found.moving)
    assert np.count_nonzero(judgement.defect == 0) == 1
    assert judgement.turns_fully[judgement.defect == 0].all()


LINE_POINTS = [[0.5, 1.06], [-0.83, -0.27], [-0.34, 0.22], [-0.13, 0.43], [0.22, 0.78]]
LINE_SOLUTIONS = np.array(
    [
        [-0.0877960434509403, -0.85138690751564, 0.235837391307301, -1.41899202703639],
        [0.0193359267851516, -0.937757011012446, 1.22226669109342, -1.08285087742709],
        [-0.595728628822183, -0.617010917712341, 0.118171353650905, -1.82939267557673],
        [-0.158077261086826, -0.793782551346416, -0.548761782690284, 0.278116829722178],
        [14.265306631912, -6.51576530896231, -0.621791031677556, -0.0713939584963069],
        [-1.79178664902321, 1.04613207405924, -1.46486338398045, 1.21676347168425],
        [0.130643755560844, -0.942516053801942, 0.963729735050218, -1.01577587226827],
        [-0.358757861563373, -0.537230434093211, 0.0870595124133798, 1.5543474028655],
        [-11.0926159017278, 0.450863935272926, -0.396207302280832, -1.04172821286545],
        [-0.154697709323186, -0.812626279169727, 3.30145715645532, -2.31860323051595],
        [-0.0801573081756841, -0.855275240173407, -0.297321862562434, -2.18414388671793],
        [0.676178657404253, -0.613650952963839, 0.356055523659319, 0.310794500797803],
        [1.4739209688177, -1.71128474823024, -0.654679846479676, 0.028907166911727],
        [-0.264640920049152, -0.69691152780256, 0.370368746423895, -1.54221173415608],
        [-1.0856845753759, -0.352998488913482, 0.319028475056347, 0.687883260707162],
    ]
)
"""Problem 7 of A. P. Morgan, C. W. Wampler, Journal of Mechanical Design 112 (1990), pp. 544-550, with the fixed pivots (0, 0) and
(1, 0), and all its real solutions as J. Verschelde prints them (PHCpack, phcpy documentation, "A 4-Bar Mechanism"): arms from the first
point to the moving pivots."""


def test_five_points_on_a_line_have_the_printed_solutions():
    found = find(LINE_POINTS, fixed_pivots=[[0, 0], [1, 0]], starts=400, seed=1)
    arms = found.moving[:, 0] - complex(*LINE_POINTS[0])
    arms = np.where(np.abs(found.fixed[:, :1]) < 0.5, arms, arms[:, ::-1])
    computed = np.stack([arms.real, arms.imag], axis=2).reshape(-1, 4)
    assert len(computed) == 15
    gaps = np.abs(computed[:, None] - LINE_SOLUTIONS).max(axis=2)
    assert sorted(gaps.argmin(axis=0)) == list(range(15))
    assert gaps.min(axis=0).max() < 1e-11  # the longest arm, 16, to 12 digits


@pytest.mark.parametrize("dimensions", [CRANK_ROCKER, LAMBDA])
def test_nine_points_of_a_curve_return_the_linkage_that_drew_it(dimensions):
    known = places(np.linspace(0.3, 5.5, 9), **dimensions)
    found = find(pairs(known[:, 2]), closed=True, starts=200)
    assert least_difference(found, (0.0, dimensions["ground"]), known[0, :2]) < 1e-7


def test_a_whole_curve_returns_the_linkage_that_drew_it():
    """Least squares from the nearest of random linkages; the run passes all points."""
    known = places(np.linspace(0.0, 2.0 * np.pi, 30, endpoint=False), **CRANK_ROCKER)
    row = gm.synthesise_path(pairs(known[:, 2]), closed=True, starts=2000).rows[0]
    assert row.defects == "none"
    assert row.check.distance < 1e-9
    family = [sorted(one.lengths) for one in (row.linkage, *row.cognates)]
    assert min(np.abs(np.array(lengths) - [1.0, 2.5, 3.0, 3.2]).max() for lengths in family) < 1e-7
    assert gm.run(row.scene, certify=False).outcome.ok


def test_a_noisy_curve_is_followed_as_closely_as_by_the_linkage_that_drew_it():
    """Least squares: no linkage of the search is worse than the true one; order counts though neighbours are exchanged by the noise."""
    known = places(np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False), **CRANK_ROCKER)[:, 2]
    noise = np.random.default_rng(1).normal(0.0, 0.02, (2, 120)).T @ [1.0, 1j]
    row = gm.synthesise_path(pairs(known + noise), closed=True, starts=4000).rows[0]
    assert row.defects == "none"
    gaps = row.positions[:, 2] - (known + noise)
    assert np.sum(np.abs(gaps) ** 2) < np.sum(np.abs(noise) ** 2)


@pytest.mark.parametrize(("step", "given"), [(2, {}), (4, {"fixed_pivots": [[0, 0], [3.2, 0]]})])
def test_points_with_input_angles_return_the_linkage(step, given):
    inputs = np.linspace(0.3, 2.5, 9)[::step]
    known = places(inputs, **CRANK_ROCKER)
    found = find(np.column_stack([pairs(known[:, 2]), inputs]), starts=500, **given)
    assert least_difference(found, (0.0, 3.2), known[0, :2]) < 1e-7
    turned = np.unwrap(np.angle(found.moving[:, :, 0] - found.fixed[:, :1]), axis=1)
    assert np.abs(turned - turned[:, :1] - (inputs - inputs[0])).max() < 1e-8


def test_few_points_leave_linkages_free_that_pass_them():
    points = NINE_POINTS[:4]
    found = gm.synthesise_path(points, starts=100)
    good = [row for row in found.rows if row.defects == "none"]
    assert good
    assert max(row.check.distance for row in good) < 1e-9


def test_nine_points_in_clusters_have_a_linkage_near_them():
    """Where the exact solution is not found, the nearest by least squares keep their order and come near."""
    known = places(np.array([0.1, 0.2, 0.3, 2.0, 2.1, 2.2, 4.0, 4.1, 4.2]), **{**CRANK_ROCKER, "place": 0.9 + 2.4j})[:, 2]
    row = gm.synthesise_path(pairs(known), closed=True, starts=300).rows[0]
    assert row.defects == "none"
    assert row.check.distance < 0.01 * np.ptp(known.real)


def test_a_straight_line_is_drawn_straighter_than_by_the_lambda_linkage():
    """The line is as long as that of the lambda linkage over half a turn, relative to its crank."""
    line = places(np.linspace(0.5 * np.pi, 1.5 * np.pi, 181), **LAMBDA)[:, 2]
    deviation = 0.5 * np.ptp(line.imag) / np.ptp(line.real)
    row = gm.synthesise_path(np.column_stack([np.linspace(0.0, 1.0, 12), np.zeros(12)]), starts=2000).rows[0]
    assert row.defects == "none"
    assert row.check.distance < deviation


def circles_meet(first, radius, second, other_radius):
    distance = abs(second - first)
    along = (radius**2 - other_radius**2 + distance**2) / (2.0 * distance)
    across = np.sqrt(max(radius**2 - along**2, 0.0))
    return [first + (second - first) / distance * (along + sign * 1j * across) for sign in (1, -1)]


def gap_at(linkage, point):
    """How far the coupler of a linkage is from fitting between its links when its point is at a place: by circles about pivots."""
    (first, second), (start, end) = linkage.fixed, linkage.moving
    arms = [abs(linkage.point - pivot) for pivot in (start, end)]
    starts = circles_meet(first, abs(start - first), point, arms[0])
    ends = circles_meet(second, abs(end - second), point, arms[1])
    shape = (linkage.point - start) / (end - start)
    return min(abs(point - one - shape * (other - one)) for one, other in itertools.product(starts, ends))


def test_cognates_draw_the_same_path():
    """Roberts and Chebyshev, over random crank-rockers and points of their couplers."""
    generator = np.random.default_rng(5)
    for _ in range(20):
        place = complex(*generator.normal(1.5, 1.5, 2))
        path = places(np.linspace(0.0, 2.0 * np.pi, 12), **{**CRANK_ROCKER, "place": place})
        linkage = FourBarLinkage(fixed=(0j, 3.2 + 0j), moving=tuple(path[0, :2]), point=path[0, 2])
        cognates = find_cognates(linkage)
        assert len(cognates) == 2
        for one in (linkage, *cognates):
            assert max(gap_at(one, point) for point in path[:, 2]) < 1e-6  # circles that touch: the root of rounding
        assert sum("crank-rocker" in str(one.type) for one in (linkage, *cognates)) == 2  # the third is a double rocker


def test_a_cognate_of_hoekens_linkage_is_chebyshevs():
    path = places(np.array([0.7]), **LAMBDA)[0]
    cognates = find_cognates(FourBarLinkage(fixed=(0j, 2.0 + 0j), moving=tuple(path[:2]), point=path[2]))
    assert any(np.abs(np.array(one.lengths) - [4.0, 5.0, 2.0, 5.0]).max() < 1e-12 for one in cognates)


@pytest.mark.parametrize("count", [7, pytest.param(400, marks=pytest.mark.long)])
def test_defects_by_signs_are_those_of_runs(count):
    """Random linkages through three positions of a body, in all classes, by the kinematics of the package."""
    generator = np.random.default_rng(4)
    seen = set()
    for _ in range(count):
        turn, shift = np.exp(1j * np.array([0.0, *generator.uniform(-2.0, 2.0, 2)])), generator.normal(size=(2, 3)).T @ [1.0, 1j]
        moving = shift[:, None] + turn[:, None] * (generator.normal(size=(2, 2)) @ [1.0, 1j])
        fixed = np.array([circle_centre(moving[:, k]) for k in range(2)])
        if np.abs(fixed).max() < 50.0:
            seen.add(compare_defects(fixed, moving))
    assert len(seen) >= 3


def compare_defects(fixed, moving):
    """Code of the gravest defect, by signs and by a run."""
    linkage = FourBarLinkage(fixed=tuple(fixed), moving=tuple(moving[0]), point=moving[0, 0])
    defects = check_linkage(linkage, np.column_stack([moving, moving[:, 0]])).defects
    gravest = max((DEFECTS.index(text.split()[0]) for text in defects), default=0)
    assert gravest == judge(fixed[None], moving[None]).defect[0]
    return gravest


def test_a_run_does_not_change_its_branch_where_another_is_near():
    """Coupler and output nearly fold on the way to the third position, which is on the other branch."""
    first, second = [-0.6926 - 0.5699j, -0.2081 - 0.0444j, 0.3605 + 0.6679j], [0.5093 - 0.7278j, 0.7716 - 0.7582j, 0.917 - 0.409j]
    moving = np.column_stack([first, second])
    fixed = np.array([circle_centre(moving[:, k]) for k in range(2)])
    assert DEFECTS[compare_defects(fixed, moving)] == "branch"


def circle_centre(points):
    rows = points[1:] - points[0]
    matrix = np.column_stack([rows.real, rows.imag])
    x, y = np.linalg.solve(matrix, 0.5 * np.abs(rows) ** 2)
    return points[0] + complex(x, y)


POINTS = [[0, 0], [1, 0.5], [2, 0.5]]


@pytest.mark.parametrize(
    ("header", "message"), [("x [mm],z [mm]", "columns must be x, y .and input_angle., as .*; found x, z"), ("x [mm],y [kg]", "kg")]
)
def test_a_wrong_header_gets_a_sentence(tmp_path, header, message):
    file = tmp_path / "points.csv"
    file.write_text(f"{header}\n0,0\n1,2\n")
    refuses(message, gm.synthesise_path, file)
