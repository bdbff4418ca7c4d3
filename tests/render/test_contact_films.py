"""Films of parts that touch: every frame shows the profiles where the bodies are at its time, and as far apart as they are."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.disc_cam import CamRise, lift_at
from governor_mechanism.model.curves import CornerOutline
from governor_mechanism.model.events import EventKind
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.moving_parts import ShapePanel
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import governor_document

N_FRAMES = 12
SHARES_OF_INTERVAL = np.array([-0.3, 0.3])
"""Times of frames beside a strike, in intervals of the reports."""
DURATIONS = {"disc_cam": 0.1, "disc_cam_flat_follower": 0.1, "geneva": 1.0, "graham_escapement": 1.2, "ratchet": 1.0}


class Film:
    """What a film of a scene draws, frame by frame, and a run of its own that reports at the times of the frames."""

    def __init__(self, name):
        self.scene, duration = gm.load(name), DURATIONS[name]
        times = np.linspace(0.0, duration, round(duration / self.scene.run.output_interval) + 1)
        run = gm.run(self.scene, times=times, accuracy=1e-9, certify=False)
        # What lies between the same reports as a strike is the hardest to draw: a curve through both would cut it off.
        strikes = [event.time for event in run.events if event.kind is EventKind.IMPACT and 0.0 < event.time < duration]
        near = np.add.outer(strikes, SHARES_OF_INTERVAL * times[1]).ravel()
        frame_times = schedule_frames(0.0, duration, N_FRAMES / duration)
        self.times = np.unique(np.concatenate([frame_times, near[(near > 0.0) & (near < duration)]]))
        self.exact = gm.run(self.scene, times=[0.0, *self.times], accuracy=1e-9, certify=False).poses[1:]
        painter = FramePainter(run, [FrameData(run, self.scene.part, (0.0, duration), self.times)])
        self.pixel = 1.0 / painter.view.scale
        """Size of a pixel, m."""
        self._panel = next(panel for panel in painter.panels if isinstance(panel, ShapePanel))

    def plates(self, k):
        """Return the corners (n, 2) of each plate that frame k shows, m."""
        shown = zip(self._panel.groups, self._panel.paths_at(k), strict=True)
        return [np.array(path.vertices) for group, path in shown if path is not None and group[0].role == "plate"]

    def pose(self, k, body):
        """Return the pose of a body at the time of frame k, by the run of its own: x, y and angle."""
        return self.exact[k, self.scene.part.mechanism.body_index(body)]


def place(pose, points):
    """Return points (n, 2) of a body with a pose in the plane."""
    x, y, angle = pose
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.array([x, y]) + np.asarray(points) @ turn.T


def largest_distance(points, drawn):
    """Return the largest distance (m) of points from the nearest of drawn ones."""
    return np.hypot(*(points[:, np.newaxis] - drawn[np.newaxis]).transpose(2, 0, 1)).min(axis=1).max()


@pytest.mark.parametrize("name", ["geneva", "graham_escapement", "ratchet", "disc_cam_flat_follower"])
def test_the_corners_of_all_outlines_are_drawn_where_the_bodies_are(name):
    film = Film(name)
    mechanism, moved = film.scene.mechanism, 0.0
    outlines = [one for one in mechanism.outlines if isinstance(one.outline, CornerOutline)]
    assert outlines
    for one in outlines:
        corners = [(corner.x + one.origin.x, corner.y + one.origin.y) for corner in one.outline.corners]
        placed = [place(film.pose(k, one.origin.body), corners) for k in range(len(film.times))]
        for k, points in enumerate(placed):
            assert largest_distance(points, np.concatenate(film.plates(k))) < 0.1 * film.pixel, (one.origin.body, film.times[k])
        first = np.concatenate(film.plates(0))
        moved = max(moved, *(largest_distance(points, first) for points in placed))
    assert moved > 5 * film.pixel  # the first frame shows it elsewhere


def test_the_profile_of_a_cam_is_drawn_where_the_roller_touches_it():
    """Each point of the profile is nearest to the path of the roller's centre at the radius of the roller, and the roller touches it."""
    film, roller = Film("disc_cam"), 0.01
    rise = CamRise(law="cycloidal", lift=0.015, angle=math.radians(120), mass=0.4, stiffness=2000.0, preload=20.0)
    share = np.linspace(0.0, 1.0, 4001)
    lifts = np.array([lift_at(rise, share=float(one)) for one in share])
    heights = 0.04 + np.concatenate([lifts, np.full(2001, 0.015), lifts[::-1], np.zeros(2001)])
    turns = np.radians(np.concatenate([120 * share, 120 + 60 * share[::2], 180 + 120 * share, 300 + 60 * share[::2]]))
    path = np.column_stack([heights * np.cos(turns), heights * np.sin(turns)])
    for k in range(len(film.times)):
        cam, (x, y, _) = film.pose(k, "cam"), film.pose(k, "follower")
        profile, *_ = film.plates(k)
        placed, centre = place(cam, path), np.array([x, y - 0.05])
        distances = np.hypot(*(profile[:, np.newaxis] - placed[np.newaxis]).transpose(2, 0, 1)).min(axis=1)
        np.testing.assert_allclose(distances, roller, atol=2e-6)
        assert np.hypot(*(profile - centre).T).min() == pytest.approx(roller, abs=1e-5)


def sleeve_between_stops():
    """A Porter governor whose falling sleeve bounces on its lower stop, in the engine of one coordinate."""
    effects = {"gravity": True, "centrifugal": True, "stops": {"arm_angle": ["20 deg", "40 deg"], "restitution": 0.6}}
    run = {"duration": 1.0, "output_interval": 0.02, "engine": "reduced"}
    return parse_scene_document(governor_document(effects=effects, spindle={"speed": "60 rpm"}, start={"arm_angle": "35 deg"}, run=run))


@pytest.mark.parametrize("name", ["geneva", "graham_escapement", "ratchet", "sleeve between stops"])
def test_frames_beside_a_strike_are_those_of_a_run_that_reports_there(name):
    scene = gm.load(name) if name in DURATIONS else sleeve_between_stops()
    duration = DURATIONS.get(name, 1.0)
    times = np.linspace(0.0, duration, round(duration / scene.run.output_interval) + 1)
    run = gm.run(scene, times=times, accuracy=1e-9, certify=False)
    strikes = [event.time for event in run.events if event.kind is EventKind.IMPACT]
    near = np.add.outer(strikes, SHARES_OF_INTERVAL * times[1]).ravel()
    frame_times = np.unique(near[np.isin(np.searchsorted(times, near), np.searchsorted(times, strikes)) & (near < duration)])
    assert len(frame_times) > 1
    exact = gm.run(scene, times=[0.0, *frame_times], accuracy=1e-9, certify=False)
    data = FrameData(run, scene.part, (0.0, duration), frame_times)
    left, right, bottom, top = data.drawing.bounds
    # A pixel of a film of 600: a curve through the reports misses by 0.2 to 6 of them, and the velocities by a tenth and more.
    pixel, length = max(right - left, top - bottom) / 600, scene.mechanism.length_scale
    shifts = np.abs(data.poses - exact.poses[1:]) * [1.0, 1.0, length]
    assert shifts.max() < 1e-6 * pixel
    differences = np.abs(data.velocities_at(frame_times) - exact.velocities[1:]) * [1.0, 1.0, length]
    assert differences.max() < 1e-6 * np.abs(exact.velocities * [1.0, 1.0, length]).max()
