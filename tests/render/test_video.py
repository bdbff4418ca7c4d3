"""Videos need a writer of their own, which is asked for before any work."""

from __future__ import annotations

import importlib
import sys

import pytest

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.film.writer import require_video_writer, write_film
from render.stub_run import GOVERNOR_DIMENSIONS, fake_run

# The package offers a function of this name in the module's stead.
film_module = importlib.import_module("governor_mechanism.render.film.writer")


def test_a_video_without_ffmpeg_is_refused_with_the_cure(tmp_path, monkeypatch):
    porter = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(film_module, "_select_time_span", pytest.fail)
    with pytest.raises(MechanismError, match="pip install imageio-ffmpeg"):
        write_film(porter, tmp_path / "a.mp4")
    with pytest.raises(MechanismError, match="pip install imageio-ffmpeg"):
        require_video_writer()
    assert list(tmp_path.iterdir()) == []


def test_a_video_lasts_as_long_as_the_run(tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    import imageio.v2 as imageio

    path = write_film(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0), tmp_path / "a.mp4", size=321)
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["duration"] == pytest.approx(1.0)
        assert reader.get_data(0).shape == (322, 322, 3)
