"""Videos need imageio-ffmpeg, which is checked before any work."""

import sys

import pytest

import governor_mechanism as gm
from governor_mechanism.render.film.options import VIDEO_SUFFIXES, require_video_writer
from stub_run import GOVERNOR_DIMENSIONS, fake_run


@pytest.mark.parametrize("suffix", VIDEO_SUFFIXES)
def test_a_video_without_ffmpeg_is_refused(tmp_path, monkeypatch, suffix):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(gm.MechanismError, match="pip install imageio-ffmpeg"):
        gm.film(object(), tmp_path / f"a{suffix}")  # refused before the run is looked at
    with pytest.raises(gm.MechanismError, match="pip install imageio-ffmpeg"):
        require_video_writer()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", VIDEO_SUFFIXES)
def test_a_video_has_the_duration_of_the_run(tmp_path, suffix):
    pytest.importorskip("imageio_ffmpeg")
    import imageio.v2 as imageio

    path = gm.film(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0), tmp_path / f"a{suffix}", size=321)
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["duration"] == pytest.approx(1.0)
        assert reader.get_data(0).shape == (322, 322, 3)
