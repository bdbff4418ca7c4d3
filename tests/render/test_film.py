"""Films have the right duration, show bodies at their positions, and leave no partial file."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from PIL import Image

import governor_mechanism as gm
from decoding import assert_words_are_clear, boxes_of, data_of, decode_film, paint_frames, painter_of, pixel_of, words_of
from governor_mechanism.render.film.frame_canvas import FRAME_CLOSING_LINE_LENGTH
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.gif_encoder import Palette, pack_pixels
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import ELEVATION_RECT
from governor_mechanism.render.shown_readings import format_closing_lines
from governor_mechanism.render.style import FILM_COLOURS, PAPER, ROLE_STYLES, parse_rgb
from stub_run import GOVERNOR_DIMENSIONS, fake_run


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, output_interval=0.02)


@pytest.fixture(scope="module")
def porter_film(tmp_path_factory, porter):
    """A film of the run, and the calls of its progress."""
    calls = []
    path = gm.film(porter, tmp_path_factory.mktemp("film") / "a.gif", progress=lambda done, total: calls.append((done, total)))
    return path, calls


@pytest.fixture(scope="module")
def shown_and_painted(porter, porter_film):
    """The frames of the film as decoded, and as painted."""
    return decode_film(porter_film[0])[0], np.array(paint_frames(porter))


@pytest.mark.parametrize(("duration", "rate"), [
    (0.13, 25), (0.13, 20), (0.07, 30), (0.02, 25), (0.2, 41),
    *(pytest.param(*one, marks=pytest.mark.long) for one in ((0.53, 24), (1.0, 50), (0.2, 50), (0.2, 30))),
])  # fmt: skip
def test_all_frames_of_a_gif_last_equally_long_and_together_as_long_as_the_run_to_half_a_frame(tmp_path, duration, rate):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=duration, output_interval=duration / 10)
    _, durations = decode_film(gm.film(run, tmp_path / "a.gif", frames_per_second=rate, slow_down=1))
    assert len(set(durations)) == 1
    assert durations[0] >= 0.02  # below 2 hundredths viewers slow a frame down to 10
    assert sum(durations) == pytest.approx(duration, abs=0.5 / rate)


def test_a_run_at_rest_keeps_its_duration(tmp_path):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=0.6, output_interval=0.1, amplitude=0.0, speed=0.0)
    shown, durations = decode_film(gm.film(run, tmp_path / "a.gif", slow_down=1))
    # Only the time and the curves change.
    assert sum(durations) == pytest.approx(0.6, abs=1e-9)
    assert len(shown) == len(durations)


@pytest.mark.parametrize(("start", "stop", "rate"), [(0.0, 10.0, 25), (3.0, 4.37, 20), (0.0, 0.06, 25), (0.0, 61.3, 50), (1.0, 1.0, 25)])
def test_a_frame_shows_the_middle_of_its_share_of_the_time(start, stop, rate):
    times = schedule_frames(start, stop, rate)
    edges = np.linspace(start, stop, len(times) + 1)
    np.testing.assert_allclose(times, 0.5 * (edges[1:] + edges[:-1]), rtol=1e-12)
    assert abs(len(times) - rate * (stop - start)) <= max(0.5, 1.0 - rate * (stop - start))


def test_a_gif_repeats_for_ever_and_lasts_as_long_as_the_run(porter_film):
    with Image.open(porter_film[0]) as image:
        assert image.info["loop"] == 0
        assert image.size == (480, 480)
    assert sum(decode_film(porter_film[0])[1]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_the_ball_is_drawn_at_its_position(name):
    run = fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, output_interval=0.04, mean_angle=30.0)
    times = schedule_frames(0.0, 1.0, 5)
    painter = FramePainter(run, [FrameData(run, run.scene.part, (0.0, 1.0), times)])
    view = painter.view
    middle = round(pixel_of(view, 0.0, 0.0)[0])
    styles = ROLE_STYLES["ball"], ROLE_STYLES["ball shine"]
    colours = [parse_rgb(colour) for style in styles for colour in (style.fill, style.stroke) if colour != "none"]
    for k in range(len(times)):
        machine = painter.draw(k)[:, : int(ELEVATION_RECT[2]), :3]
        differences = [np.abs(machine.astype(int) - colour).max(axis=2) for colour in colours]
        rows, columns = np.nonzero(np.min(differences, axis=0) < 32)  # blended edges too
        x, y = run.poses[round(times[k] / 0.04), 0, :2]
        column, row = pixel_of(view, x, y)
        # Half of the mask belongs to the left ball.
        right = columns > middle
        assert np.hypot(columns[right].mean() - column, rows[right].mean() - row) < 1.5


def test_poses_between_reports_follow_the_velocities():
    coarse = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0, output_interval=0.1)
    fine = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0, output_interval=0.001)
    times = np.linspace(0.0, 2.0, 401)
    between = FrameData(coarse, coarse.scene.part, (0.0, 2.0), times).poses
    exact = fine.poses[np.round(times / 0.001).astype(int)]
    # Cubic: h^4 / 384 times the fourth derivative, about 0.1 m * (2 pi / 1.7 s)^4; straight lines would miss by 1e-3 m.
    assert np.abs(between - exact).max() < 1e-5


def test_the_plan_turns_by_the_integral_of_the_speed(porter):
    speed = porter.readings["spindle_speed"]
    exact = np.sum((speed[1:] + speed[:-1]) / 2 * np.diff(porter.times))
    assert data_of(porter).spindle_angle[-1] == pytest.approx(exact)


def test_a_part_of_a_run_keeps_its_duration(tmp_path, porter):
    assert sum(decode_film(gm.film(porter, tmp_path / "a.gif", start=0.25, stop=0.65))[1]) == pytest.approx(0.4, abs=1e-9)


def test_a_gif_shows_the_frames(shown_and_painted):
    shown, painted = shown_and_painted
    assert painted.shape == shown.shape
    assert painted.dtype == np.uint8
    difference = np.abs(shown.astype(int) - painted).max(axis=3)
    # 31 colours: flat areas are exact, blended edges close.
    assert (difference == 0).mean() > 0.9
    assert (difference > 64).mean() < 2e-3


def test_equal_runs_give_equal_films(tmp_path):
    runs = {f"{k}.gif": fake_run(GOVERNOR_DIMENSIONS["crossed"], duration=0.2) for k in range(2)}
    first, second = (gm.film(run, tmp_path / name, slow_down=1).read_bytes() for name, run in runs.items())
    assert first == second


@pytest.mark.parametrize(("error", "old"), [(KeyboardInterrupt, None), (RuntimeError, b"old")])
def test_an_exception_leaves_no_file_and_keeps_the_old_one(tmp_path, porter, error, old):
    def stop(done, total):
        if done > total // 2:
            raise error

    path = tmp_path / "a.gif"
    if old:
        path.write_bytes(old)
    with pytest.raises(error):
        gm.film(porter, path, frames_per_second=5, progress=stop)
    assert [one.read_bytes() for one in tmp_path.iterdir()] == ([old] if old else [])


def test_films_do_not_import_pyplot():
    code = "from governor_mechanism.render import film, figures; import sys; print('matplotlib.pyplot' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_progress_counts_to_the_end(porter_film):
    assert porter_film[1] == [(k, 25) for k in range(1, 26)]


def test_the_numbers_of_a_scale_next_to_wide_arms_are_not_cut_off():
    picture = painter_of(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0, mean_angle=60.0, amplitude=25.0), 51)
    assert max(box.x1 for words, box in boxes_of(picture.figure) if words.endswith("00 mm") and box.y0 > 60) <= ELEVATION_RECT[2]


@pytest.mark.parametrize(
    ("name", "outcome"),
    [*((name, gm.Outcome.DONE) for name in GOVERNOR_DIMENSIONS), ("porter", gm.Outcome.LEFT_RANGE), ("crossed", gm.Outcome.LEFT_RANGE)],
)
def test_no_words_are_cut_off_or_overlap(name, outcome):
    title = "A governor with a title far longer than anybody should give to a scene, with arms, links and a sleeve"
    run = fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, output_interval=0.04, mean_angle=30.0, title=title, outcome=outcome)
    if not outcome.ok:
        run = dataclasses.replace(run, detail="arm_angle: " + 20 * "a very long cause, ")
    picture = painter_of(run, 26)
    picture.update(25)
    boxes = boxes_of(picture.figure)
    assert len(boxes) > 15
    assert_words_are_clear(boxes)


def test_cached_numbers_look_like_the_text(porter):
    shown = data_of(porter, 51)
    regular = FramePainter(porter, [shown], animated=False)
    regular.update(20)
    regular.figure.canvas.draw()
    drawn = np.asarray(regular.figure.canvas.buffer_rgba())
    cached = FramePainter(porter, [shown]).draw(20)
    inks = []
    for pixels in (drawn, cached):
        time = pixels[6:30, 420:456, :3].astype(int)
        ink = (time[0, 0] - time).clip(0).sum(axis=2)
        rows, columns = np.nonzero(ink > 100)
        inks.append((ink.sum(), rows.min(), rows.max(), columns.min(), columns.max()))
    (ink_of_text, *box_of_text), (ink_of_copy, *box_of_copy) = inks
    # Characters of a text may start at fractions of a pixel, copies start at whole ones.
    assert np.abs(np.subtract(box_of_text, box_of_copy)).max() <= 2
    assert ink_of_copy == pytest.approx(ink_of_text, rel=0.05)


def test_the_footer_states_accuracy_or_early_end():
    short = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=0.1, output_interval=0.05)

    def lines(**changes):
        return format_closing_lines(dataclasses.replace(short, **changes), FRAME_CLOSING_LINE_LENGTH)[0]

    def footer(**changes):
        return words_of(painter_of(dataclasses.replace(short, **changes), 2).figure)

    assert "accurate to 4e-07, requested 1e-06" in footer(error_estimate=3.1e-7)
    assert "accurate to 3e-07, requested 1e-04" in lines(error_estimate=3e-7, settings={"asked_accuracy": 1e-4})
    assert "accurate only to 3e-03, requested 1e-06" in lines(error_estimate=2.1e-3, outcome=gm.Outcome.ACCURACY_MISSED)
    assert "accuracy not certified (requested 1e-06)" in lines(error_estimate=None)
    cause = "arm_angle: the arms are at 90 degrees to the spindle (dead centre), at about t = 0.115 s"
    words = footer(outcome=gm.Outcome.LEFT_RANGE, detail=cause)
    assert cause in words
    assert gm.Outcome.LEFT_RANGE.value in words
    assert gm.Outcome.STEP_LIMIT.value in lines(outcome=gm.Outcome.STEP_LIMIT)


def test_wrong_names_and_empty_runs_are_refused(tmp_path, porter):
    with pytest.raises(gm.MechanismError, match=r"must end in \.gif or \.mp4"):
        gm.film(porter, tmp_path / "a.avi")
    with pytest.raises(gm.MechanismError, match="does not exist"):
        gm.film(porter, tmp_path / "nowhere" / "a.gif")
    nothing = dataclasses.replace(porter, times=porter.times[:0], outcome=gm.Outcome.LEFT_RANGE)
    with pytest.raises(gm.MechanismError, match="the range in which"):
        gm.film(nothing, tmp_path / "a.gif")


def test_moving_shapes_leave_no_traces(shown_and_painted):
    shown, still = shown_and_painted
    bare = (still == parse_rgb(PAPER)).all(axis=3)
    assert bare.mean() > 0.5
    assert (shown[bare] == parse_rgb(PAPER)).all()


def test_areas_keep_their_colour_where_translucent_ones_overlap(tmp_path):
    """The frame of the yoke opens and covers the disc of the crank; a colour of its own would leave stripes behind its edges."""
    run = gm.run("scotch_yoke", times=np.linspace(0.0, 1.0, 26))
    shown, _ = decode_film(gm.film(run, tmp_path / "a.gif"))
    painted = np.array(paint_frames(run))
    assert painted.shape == shown.shape
    for before, after in zip(painted[::4].astype(int), shown[::4], strict=True):
        _, places, counts = np.unique(before @ [1, 256, 256**2], return_inverse=True, return_counts=True)
        large = counts > 1500  # the lines of a grid have less
        assert large.sum() > 3
        assert np.abs(after - before)[large[places]].max() <= 1


def test_the_palette_keeps_all_film_colours(porter):
    samples = [painter_of(porter, 2).draw(1)]
    palette = Palette([parse_rgb(colour) for colour in FILM_COLOURS], samples)
    assert len(palette.colours) <= 31
    film_colours = np.array([parse_rgb(colour) for colour in FILM_COLOURS], dtype=np.uint8)
    assert_array_equal(palette.colours[palette.indices_of(pack_pixels(np.pad(film_colours, ((0, 0), (0, 1)))))], film_colours)
