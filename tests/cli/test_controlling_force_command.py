"""The controlling force in the command `equilibria`: its lines, its JSON, its figure."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import json_of, succeed


@pytest.mark.long
def test_effort_power_and_sensitiveness_are_printed_drawn_and_given_as_json(tmp_path):
    words = ["equilibria", "porter", "--resistance", "40 N", "--range", "arm_angle=20 deg:45 deg", "--speed-change", "0.02"]
    result = succeed(*words, "--out", str(tmp_path))
    *_, effort, ends = (line for line in result.stdout.splitlines() if not line.startswith("wrote"))
    mean_force = (0.02 + 0.0002) * 25 * 9.81  # (p + p^2 / 2) (m + M) g of Porter's rhombus
    assert f"effort {mean_force:.6g} N at sleeve_lift for 2 % of speed, power" in effort
    assert "working range 20 deg to 45 deg: 106.845 rpm to 133.192 rpm, sensitiveness" in ends
    assert "with resistance 97.7444 rpm to" in ends
    assert (tmp_path / "porter_controlling_force.png").read_bytes().startswith(b"\x89PNG")
    told = json_of(*words, "--no-figure")["controlling_force"]
    (row,) = told["at_equilibria"]
    assert row["force"] == pytest.approx(25 * 9.81 * math.tan(row["coordinate"]), rel=1e-9)
    assert row["power"] == pytest.approx(mean_force * row["lift"], rel=1e-9)
    assert told["balls"] == 2
    assert told["working_range"]["limited_by"] == "values"


def test_an_astatic_governor_has_an_effort_but_no_power():
    told = json_of("equilibria", "parabolic", "--no-figure")["controlling_force"]
    assert told["at_equilibria"][0]["power"] is None
    text = succeed("equilibria", "parabolic", "--no-figure").stdout
    assert "no power: it is astatic" in text
    assert "sensitiveness 0: isochronous" in text


def test_without_balls_the_reason_is_given_only_where_it_is_asked_for():
    assert "distance of a ball" in json_of("equilibria", "haug_governor", "--no-figure")["controlling_force"]
    assert "controlling" not in succeed("equilibria", "haug_governor", "--no-figure").stdout


def test_every_speed_line_is_the_centrifugal_force_of_its_label():
    """A point mass has straight lines C = m w^2 r through the origin, and the astatic governor's curve is one of them."""
    curve = gm.controlling_force("parabolic", points=50)
    (panel,) = curve.plot().axes
    lines = [line for line in panel.lines if line.get_xdata()[0] == line.get_ydata()[0] == 0.0]
    labels = [float(text.get_text().removesuffix(" rpm")) for text in panel.texts if text.get_text().endswith(" rpm")]
    slopes = [line.get_ydata()[-1] / line.get_xdata()[-1] * 1e3 for line in lines]
    np.testing.assert_allclose(slopes, (np.array(labels) * math.pi / 30) ** 2, rtol=1e-9)
    assert 120.0 in labels
    (neutral,) = (line for line in panel.lines if str(line.get_label()).startswith("neutral"))
    np.testing.assert_allclose(neutral.get_ydata(), slopes[labels.index(120.0)] * neutral.get_xdata() / 1e3, rtol=1e-9)
