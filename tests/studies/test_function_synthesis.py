"""Function generators: recovered linkages, proportions from a source, spacing, and what is refused."""

import cmath
import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.synthesis.function import chebyshev_points
from refusing import refuses


def output_angles(lengths, inputs):
    """Angles of the output of an open four-bar by the cosine rule, which the synthesis does not use."""
    ground, crank, coupler, rocker = lengths
    angles = []
    for phi in inputs:
        vector = crank * cmath.exp(1j * phi) - ground
        inner = math.acos((rocker**2 + abs(vector) ** 2 - coupler**2) / (2 * rocker * abs(vector)))
        angles.append(cmath.phase(vector) - inner)
    return np.unwrap(angles)


LENGTHS = (3.2, 1.0, 3.0, 2.5)


@pytest.mark.parametrize(("count", "input_shift", "output_shift"), [(3, 0.0, 0.0), (4, 0.0, 0.4), (5, -0.7, 0.4)])
def test_a_known_linkage_is_recovered_though_its_starts_are_not_known(count, input_shift, output_shift):
    inputs = np.linspace(0.3, 1.9, count)
    pairs = np.column_stack([inputs + input_shift, output_angles(LENGTHS, inputs) + output_shift])
    found = gm.synthesise_function(pairs, ground=3.2)
    nearest = min(found.rows, key=lambda row: np.abs(np.array(row.linkage.lengths) - LENGTHS).max())
    assert nearest.linkage.lengths == pytest.approx(LENGTHS, rel=1e-9)
    assert nearest.defects == "none"
    assert nearest.check.distance < 1e-9


def test_links_of_the_example_of_a_lecture_close_at_its_three_pairs():
    """The ends of input and output are one length of the coupler apart at all pairs: no equation of Freudenstein in it."""
    # Pairs and ground of the example in lecture 12, Three position synthesis, of ME 3751 at Ohio State University (H.-J. Su), in inches.
    pairs = [["35.02 deg", "91.21 deg"], ["67.50 deg", "101.79 deg"], ["100.0 deg", "117.19 deg"]]
    row = gm.synthesise_function(pairs, ground="4.5 in").rows[0]
    ground, crank, coupler, output = row.linkage.lengths
    assert ground == pytest.approx(4.5 * 0.0254, rel=1e-14)
    turned = np.exp(1j * np.radians([[35.02, 91.21], [67.50, 101.79], [100.0, 117.19]]))
    assert np.abs(ground + output * turned[:, 1] - crank * turned[:, 0]) == pytest.approx(coupler, rel=1e-12)
    assert str(row.linkage.type) == "crank-rocker"


PRINTED_LENGTHS = 0.4018, 4.198, 0.8456  # inches
"""Solution of that lecture. Its matrix has -cos 99.976 deg = 0.1732, not -cos 100.0 deg: the input angles are Chebyshev's from 30 to 105
degrees, of which the problem prints two rounded. The output angles are printed to 0.01 degrees."""


def test_the_printed_lengths_lie_within_what_the_rounding_of_the_printed_angles_leaves():
    inputs = [math.degrees(one) for one in chebyshev_points(math.radians(30.0), math.radians(105.0), 3)]
    assert inputs == pytest.approx([35.02, 67.50, 99.976], abs=5e-3)

    def lengths(rounding):
        outputs = np.add([91.21, 101.79, 117.19], rounding)
        pairs = [[f"{first} deg", f"{second} deg"] for first, second in zip(inputs, outputs.tolist(), strict=True)]
        return np.array(gm.synthesise_function(pairs, ground="4.5 in").rows[0].linkage.lengths)[1:] / 0.0254

    nominal = lengths([0.0, 0.0, 0.0])
    uncertainty = sum(np.abs(lengths(one) - nominal) for one in 0.005 * np.eye(3))
    assert np.all(np.abs(nominal - PRINTED_LENGTHS) <= uncertainty)
    assert nominal == pytest.approx(PRINTED_LENGTHS, rel=2e-3)


def test_chebyshevs_points_are_projections_of_points_on_a_half_circle():
    assert chebyshev_points(1.0, 2.0, 3) == pytest.approx([1.5 - 0.25 * np.sqrt(3.0), 1.5, 1.5 + 0.25 * np.sqrt(3.0)], rel=1e-14)


TASK = {"function": "1/x", "over": [1, 2], "input_angles": ["30 deg", "120 deg"], "output_angles": ["240 deg", "330 deg"]}


def test_the_structural_error_vanishes_at_the_pairs_and_shrinks_with_their_number():
    errors = []
    for count in (3, 4, 5):
        found = gm.synthesise_function(**TASK, count=count)
        curve = found.structural_error(1)
        at_pairs = np.interp(found.pairs[:, 0], curve[:, 0], curve[:, 1])
        assert np.abs(at_pairs).max() < 0.02 * np.abs(curve[:, 1]).max() + 1e-6
        errors.append(found.rows[0].error)
    assert errors[0] > errors[1] > errors[2]


def test_pairs_behind_a_toggle_are_named():
    found = gm.synthesise_function(**TASK, count=4)
    assert found.rows[0].defects == "none"
    assert found.rows[1].check.defects == ("branch (2, 3)",)


def test_the_scene_runs_through_the_pairs():
    row = gm.synthesise_function(**TASK).rows[0]
    run = gm.run(row.scene, certify=False)
    assert run.outcome.ok
    swept = np.ptp(run.readings["output_angle"])
    assert swept == pytest.approx(np.ptp(np.angle(row.positions[:, 1] - row.linkage.fixed[1])), abs=1e-6)


def test_files_of_points_are_read_with_their_units(tmp_path):
    table = tmp_path / "angles.csv"
    table.write_text("output_angle [deg],input_angle\n91.21,0.6112143\n101.79,1.1780972\n117.19,1.7453293\n")
    found = gm.synthesise_function(table)
    assert np.degrees(found.pairs) == pytest.approx(np.array([[35.02, 91.21], [67.5, 101.79], [100.0, 117.19]]), abs=1e-5)
    table.write_text("input_angle [deg],output [deg]\n1,2\n")
    refuses("the columns must be input_angle, output_angle", gm.synthesise_function, table)
    table.write_text("input_angle [furlong],output_angle [deg]\n1,2\n2,3\n3,5\n")
    refuses("input_angle of point 1", gm.synthesise_function, table)
    document = tmp_path / "task.toml"
    document.write_text('functoin = "1/x"\n')
    refuses("Did you mean 'function'", gm.synthesise_function, document)
