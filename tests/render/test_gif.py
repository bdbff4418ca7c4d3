"""GIFs written frame by frame are read back by Pillow with the same colours and times."""

import io
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import governor_mechanism as gm
from decoding import decode_film
from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.film import writer as film_writer
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from governor_mechanism.render.film.writer import FRAME_RATES, MAX_GIF_SIZE, FilmFrames, choose_gif_rate
from stub_run import GOVERNOR_DIMENSIONS, fake_run


def make_frame(colour):
    frame = np.zeros((20, 30, 4), dtype=np.uint8)
    frame[..., 3] = 255
    frame[5:15, 10:20, :3] = colour
    return frame


def write_and_read(sequence, palette=None):
    """Return frames and display times (s) that Pillow reads from a GIF of (frame, hundredths of a second) pairs."""
    palette = palette or Palette([(0, 0, 0), (255, 0, 0)], [frame for frame, _ in sequence])
    file = io.BytesIO()
    writer = GifWriter(file, palette)
    for frame, delay in sequence:
        writer.add(frame, delay)
    writer.close()
    file.seek(0)
    return decode_film(file)


def test_equal_frames_are_merged_and_lengthened():
    red, green = make_frame((255, 0, 0)), make_frame((0, 200, 0))
    shown, durations = write_and_read([(red, 4), (red.copy(), 5), (green, 4), (red, 3), (red, 3)])
    assert durations == pytest.approx([0.09, 0.04, 0.06])
    assert_array_equal(shown, np.array([red, green, red])[..., :3])


@pytest.mark.parametrize("first", ["still", "covered"])
def test_a_pale_edge_is_restored_after_something_passed_before_it(first):
    """Also if that stands before it in the first frame: most frames show the edge."""
    ground, line, edge = (252, 251, 246), (213, 212, 206), (232, 231, 226)
    dark, blend = (0, 90, 45), (200, 200, 194)  # of what passes, and of its own edge
    still, covered, leaving = (np.full((20, 30, 4), 255, dtype=np.uint8) for _ in range(3))
    still[..., :3] = ground
    still[:, 10, :3], still[:, (9, 11), :3] = line, edge
    covered[:], leaving[:] = still, still
    covered[5:15, 5:15, :3], leaving[5:15, 5:15, :3] = dark, blend
    frames = [still, covered, leaving, still][first == "covered" :]
    shown, _ = write_and_read([(frame, 4) for frame in frames], Palette([ground, line, dark], [frames[0], leaving, still, still]))
    whole, _ = write_and_read([(still, 4)], Palette([ground, line, dark], [still, leaving]))
    assert_array_equal(shown[-1], whole[0])


def test_a_frame_longer_than_the_gif_limit_is_split():
    red = make_frame((255, 0, 0))
    _, durations = write_and_read([(red, 40000)] * 3)
    assert sum(durations) == pytest.approx(1200.0)


@pytest.mark.parametrize("n_colours", [5, 12, 13, 20])
def test_flat_areas_are_shown_exactly_with_few_colours_and_with_many(n_colours):
    """Also where short gaps of unchanged pixels are written again."""
    random = np.random.default_rng(7)
    colours = random.choice(np.arange(8, 256, 8), (n_colours, 3), replace=True).astype(np.uint8)
    frames = [np.pad(colours[random.integers(0, n_colours, (24, 40))], ((0, 0), (0, 0), (0, 1)), constant_values=255) for _ in range(3)]
    for frame in frames[1:]:
        frame[:, ::3] = frames[0][:, ::3]
        frame[:, 20:] = frames[0][:, 20:]
    palette = Palette([tuple(colour) for colour in colours.tolist()], frames, few_colours=True)
    assert palette.bits == (4 if n_colours <= 12 else 5)
    shown, _ = write_and_read([(frame, 4) for frame in frames], palette)
    assert_array_equal(shown, np.array(frames)[..., :3])


def test_a_film_that_is_compressed_beside_has_the_same_bytes(tmp_path):
    frames = [StripesPainter(40).paint(k) for k in range(6)]
    palette = Palette([(0, 0, 0), (255, 255, 255)], frames)
    sizes, contents = [], []
    with ThreadPoolExecutor(1) as compressor:
        for k, one in enumerate((None, compressor)):
            with (tmp_path / f"{k}.gif").open("wb") as file:
                writer = GifWriter(file, palette, one)
                for frame in frames:
                    writer.add(frame, 4)
                    sizes.append(writer.size)
                writer.close()
            contents.append((tmp_path / f"{k}.gif").read_bytes())
    assert contents[0] == contents[1]
    assert sizes[:6] == sizes[6:]
    assert 0 < sizes[-1] < len(contents[0])


class StripesPainter:
    """Frames of which a number of rows are other at random in every frame."""

    canvases = ()

    def __init__(self, n_rows):
        self.n_rows = n_rows

    def paint(self, k):
        frame = np.full((480, 480, 4), 255, dtype=np.uint8)
        frame[: self.n_rows, :, :3] = np.random.default_rng(k).choice([0, 255], (self.n_rows, 480, 1))
        return frame

    draw = paint


@pytest.mark.long
@pytest.mark.parametrize(
    ("n_rows", "lowest_rate", "rate"), [(0, 0.0, 25.0), (480, 0.0, FRAME_RATES[-1]), (480, 18.0, 20.0), (480, 40.0, 25.0)]
)
def test_a_film_that_changes_much_gets_fewer_frames_but_as_many_as_its_turns_need(n_rows, lowest_rate, rate):
    painter = StripesPainter(n_rows)
    film = FilmFrames(painter=painter, n_frames=200, frame_rate=25.0, duration=8.0, theme=Theme.LIGHT, few_colours=True)
    assert choose_gif_rate(film, MAX_GIF_SIZE, lowest_rate) == rate


def test_a_film_over_the_largest_size_is_written_again_and_one_within_it_as_it_is(tmp_path, monkeypatch):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.2)
    natural = gm.film(run, tmp_path / "natural.gif", size=320)
    _, durations = decode_film(natural)
    size = natural.stat().st_size
    monkeypatch.setattr(film_writer, "MAX_GIF_SIZE", 1.5 * size)  # for a height of 480
    assert gm.film(run, tmp_path / "within.gif", size=320).read_bytes() == natural.read_bytes()
    for share in (0.9, 0.2):  # noticed at the end, and early
        monkeypatch.setattr(film_writer, "MAX_GIF_SIZE", share * 1.5 * size)
        smaller = gm.film(run, tmp_path / "smaller.gif", size=320)
        assert smaller.stat().st_size < size
        _, longer = decode_film(smaller)
        assert sum(longer) == pytest.approx(sum(durations), abs=100.0)
        assert len(longer) <= len(durations)
