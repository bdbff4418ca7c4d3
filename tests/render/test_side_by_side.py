"""Runs side by side: each is shown unchanged, on one scale, with its full duration, and rests at its end."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

import governor_mechanism as gm
from decoding import decode_film, paint_frames, words_of
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.painters import SideBySidePainter
from governor_mechanism.render.frame_data import FrameData
from stub_run import GOVERNOR_DIMENSIONS, fake_run

TITLES = ("without the dashpot", "with the dashpot")


@pytest.fixture(scope="module")
def pair():
    return [fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.3, output_interval=0.05, amplitude=swing) for swing in (8.0, 3.0)]


@pytest.fixture(scope="module")
def pair_film(tmp_path_factory, pair):
    return gm.film(pair, tmp_path_factory.mktemp("film") / "a.gif", titles=TITLES)


def side_by_side(runs, titles=TITLES):
    data = [[FrameData(run, run.scene.part, (0.0, 1.3), np.linspace(0, 1.3, 26))] for run in runs]
    return SideBySidePainter(runs, titles, data)


@pytest.mark.long
def test_the_film_has_the_duration_of_its_runs(tmp_path, pair_film):
    runs = [fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.03, output_interval=0.1, amplitude=swing) for swing in (8.0, 3.0)]
    odd_film = gm.film(runs, tmp_path / "a.gif", titles=TITLES, frames_per_second=20)
    for path, duration, rate in ((pair_film, 1.3, 25), (odd_film, 1.03, 20)):
        assert sum(decode_film(path)[1]) == pytest.approx(duration, abs=0.5001 / rate)
    with Image.open(pair_film) as image:
        assert image.size == (960, 480)
        assert image.info["loop"] == 0


@pytest.mark.long
def test_equal_runs_are_shown_twice(tmp_path):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=0.2, output_interval=0.05)
    shown, _ = decode_film(gm.film([run, run], tmp_path / "a.gif", slow_down=1))
    alone = np.array(paint_frames(run, slow_down=1))
    assert len(shown) == len(alone)
    for half in (shown[:, :, :480], shown[:, :, 480:]):
        difference = np.abs(half.astype(int) - alone).max(axis=3)
        # As in a film of one run, except for the rule between them.
        assert (difference == 0).mean() > 0.9
        assert (difference > 64).mean() < 4e-3


def test_both_runs_share_scale_and_axes(pair):
    first, second = side_by_side(pair).painters
    assert first.view == second.view
    for one, other in zip(first.figure.axes, second.figure.axes, strict=True):
        assert one.get_ylim() == other.get_ylim()
        assert one.get_xlim() == other.get_xlim()
    low, high = first.figure.axes[0].get_ylim()
    assert low < 32.0
    assert high > 48.0


def test_each_run_has_its_title(pair):
    for titles, expected in ((TITLES, TITLES), (None, [run.scene.title for run in pair])):
        for picture, title in zip(side_by_side(pair, titles).painters, expected, strict=True):
            assert title in words_of(picture.figure)


def test_the_frames_of_both_move(pair_film):
    shown, _ = decode_film(pair_film)
    for half in (shown[:, :, :280], shown[:, :, 480:760]):
        assert (half[0] != half[10]).any()
    assert (shown[10][50:430, :280] != shown[10][50:430, 480:760]).any()


@pytest.mark.long
def test_a_shorter_run_rests_at_its_end_and_says_so(tmp_path, pair):
    longer = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0, output_interval=0.02, amplitude=5.0)
    path = gm.film([pair[0], longer, pair[1]], tmp_path / "a.gif", frames_per_second=10)
    shown, durations = decode_film(path)
    assert sum(durations) == pytest.approx(2.0, abs=1e-9)
    assert shown.shape[1:] == (480, 3 * 480, 3)
    ended, still = shown[-5], shown[-1]
    for left, has_ended in ((0, True), (480, False), (960, True)):
        columns = slice(left, left + 480)
        assert np.array_equal(ended[:, columns], still[:, columns]) == has_ended
    data = FrameData(pair[0], pair[0].scene.part, (0.0, 2.0), np.linspace(0, 2.0, 21))
    assert data.times.max() == data.times[-1] == pytest.approx(1.3)
    assert data.has_ended.sum() == 7
    texts = FramePainter(pair[0], [data], 480).counters[0].texts
    assert texts[13:15] == ["1.30", "ended at 1.30"]


def test_machines_of_unlike_size_have_scales_of_their_own(pair):
    def painters(arm):
        other = fake_run({**GOVERNOR_DIMENSIONS["porter"], "arm": arm, "offset": 0.0}, duration=1.3, output_interval=0.05)
        return side_by_side([pair[0], other]).painters

    scales = [painter.view.scale for painter in painters(0.6)]
    assert scales[0] == scales[1]
    scales = [painter.view.scale for painter in painters(3.0)]
    assert scales[0] > 5 * scales[1]


def test_wrong_lists_are_refused(tmp_path, pair):
    first, second = pair
    early = dataclasses.replace(
        second, outcome=gm.Outcome.LEFT_RANGE, **{name: getattr(second, name)[:0] for name in ("times", "poses", "velocities")}
    )
    for runs, titles, message in (
        ([first, early], None, r"run 2, .* has no reported time"),
        ([first] * 7, None, "one run, or up to 6 side by side; got 7"),
        ([], None, "got 0"),
        (pair, ("one",), "titles must be a list of 2"),
        (pair, "ab", "titles must be a list of 2"),
        (first, ("one", "two"), "titles are for a film of several runs"),
        ([first, 5], None, "a list of several"),
    ):
        with pytest.raises(gm.MechanismError, match=message):
            gm.film(runs, tmp_path / "a.gif", titles=titles)
    assert list(tmp_path.iterdir()) == []
