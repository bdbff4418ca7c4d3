"""Frames drawn by a second process: the same film, and nothing left of either process when one of them fails."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys

import numpy as np
import pytest

from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.render.film import frame_stream
from governor_mechanism.render.film.frame_stream import MAX_SLOTS, draw_beside, stream_frames
from governor_mechanism.render.film.writer import write_film
from render.stub_run import GOVERNOR_DIMENSIONS, fake_run

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux copies a process safely")

N_FRAMES = MAX_SLOTS + 8
"""More frames than may wait to be encoded."""


class NumberedFrames:
    """Frames of one colour, the number of the frame, in pixels that the next frame overwrites; the one of a number fails."""

    def __init__(self, failure=None, failing_frame=-1):
        self._pixels, self._failure, self._failing_frame = np.zeros((2, 3, 4), dtype=np.uint8), failure, failing_frame
        self.process_ids = set()

    def draw(self, k):
        if k == self._failing_frame:
            self._failure()
        self.process_ids.add(os.getpid())
        self._pixels[:] = k
        return self._pixels


def fail():
    raise ValueError("no ink")


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def test_frames_come_in_order_from_another_process():
    source = NumberedFrames()
    with draw_beside(source, N_FRAMES) as frames:
        numbers = [int(pixels[0, 0, 0]) for pixels in frames]
    assert numbers == list(range(N_FRAMES))
    assert source.draw(0).max() == 0  # this process drew the first frame alone
    assert source.process_ids == {os.getpid()}
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("failing_frame", [1, N_FRAMES - 1])
@pytest.mark.parametrize(
    ("failure", "error", "message"), [(fail, ValueError, "no ink"), (die, GovernorMechanismError, "ended before frame")]
)
def test_a_failure_of_the_other_process_is_reported(failure, error, message, failing_frame):
    with pytest.raises(error, match=message), draw_beside(NumberedFrames(failure, failing_frame), N_FRAMES) as frames:
        assert len(list(frames)) < N_FRAMES
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
@pytest.mark.parametrize("n_taken", [0, 1, N_FRAMES - 1])
def test_the_other_process_ends_with_this_one(error, n_taken):
    def take_some():
        with draw_beside(NumberedFrames(), N_FRAMES) as frames:
            for _ in range(n_taken):
                next(frames)
            raise error

    with pytest.raises(error):
        take_some()
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize(("load", "n_processes"), [(0.0, 2), (64.0, 1)])
def test_a_second_process_needs_an_idle_processor(monkeypatch, load, n_processes):
    monkeypatch.setattr(os, "getloadavg", lambda: (load, load, load))
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(64)))
    with stream_frames(NumberedFrames(), frame_stream.MIN_FRAMES_FOR_TWO_PROCESSES) as frames:
        assert len(multiprocessing.active_children()) == n_processes - 1
        assert int(next(frames)[0, 0, 0]) == 0
    with stream_frames(NumberedFrames(), frame_stream.MIN_FRAMES_FOR_TWO_PROCESSES - 1) as frames:
        assert multiprocessing.active_children() == []
        assert int(next(frames)[0, 0, 0]) == 0


def test_films_of_one_and_of_two_processes_are_equal(tmp_path, monkeypatch):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0)
    write_film(run, tmp_path / "one.gif")
    monkeypatch.setattr(frame_stream, "MIN_FRAMES_FOR_TWO_PROCESSES", 1)
    monkeypatch.setattr(frame_stream, "_has_idle_processor", lambda: True)
    write_film(run, tmp_path / "two.gif")
    assert (tmp_path / "one.gif").read_bytes() == (tmp_path / "two.gif").read_bytes()


def test_an_interrupted_film_of_two_processes_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(frame_stream, "MIN_FRAMES_FOR_TWO_PROCESSES", 1)
    monkeypatch.setattr(frame_stream, "_has_idle_processor", lambda: True)

    def stop(done, total):
        if done > total // 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0), tmp_path / "a.gif", progress=stop)
    assert list(tmp_path.iterdir()) == []
    assert multiprocessing.active_children() == []
