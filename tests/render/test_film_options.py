"""What a film shows on demand: layouts, readings, colours, forces; when it is slowed, and where it closes on a whole period."""

import dataclasses
import inspect
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import governor_mechanism as gm
from decoding import data_of, decode_film, page_data_of, painter_of, pixel_of, words_of
from drawing_checks import of_role
from governor_mechanism.model.results.pictures import FilmKeywords, FilmLayout, FilmOptions, Theme
from governor_mechanism.render.artists import Brush, themed_colour
from governor_mechanism.render.film.frame_painter import ForceArrows
from governor_mechanism.render.film.moving_parts import CurvePanel
from governor_mechanism.render.film.painters import make_painter
from governor_mechanism.render.film.svg_animation import TOLERANCE, key_frames
from governor_mechanism.render.film.timing import MIN_FRAMES_PER_TURN, select_timing
from governor_mechanism.render.frame_data import FrameData, find_forces
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon, TextShape
from governor_mechanism.render.motion_layers import MotionLayers
from governor_mechanism.render.page.page_data import roles_of
from governor_mechanism.render.page.views import show_run
from governor_mechanism.render.style import PAPER, ROLE_STYLES, parse_rgb
from stub_run import GOVERNOR_DIMENSIONS, fake_run

PERIOD = 1.7
"""Period of the stub run, s."""
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=4.0, output_interval=0.02)


def blue_of(theme):
    return [255 * part for part in themed_colour(ROLE_STYLES["ball"].fill, theme)[:3]]


@pytest.mark.parametrize(("layout", "theme"), [*((layout, Theme.LIGHT) for layout in FilmLayout), (FilmLayout.MACHINE, Theme.DARK)])
def test_the_ball_is_drawn_at_its_position_in_every_layout(porter, layout, theme):
    painter = painter_of(porter, layout=layout, theme=theme, footer=False)
    view, k = painter.view, 7
    left, top, right, bottom = (round(edge) for edge in view.rect)
    machine = painter.draw(k)[top:bottom, left:right, :3].astype(int)
    rows, columns = np.nonzero(np.abs(machine - blue_of(theme)).max(axis=2) < 32)
    column, row = pixel_of(view, *porter.poses[10 * k, 0, :2])
    is_right = columns > pixel_of(view, 0.0, 0.0)[0] - left
    # Pin and shine take pixels from the ball: its middle is between its edges.
    edges = [(one[is_right].min() + one[is_right].max()) / 2 for one in (columns, rows)]
    assert np.hypot(edges[0] + left - column, edges[1] + top - row) < 1.5


@pytest.mark.parametrize(("layout", "width"), [("machine", 480), ("machine+plots", 480), ("wide", 853)])
def test_a_layout_has_its_width(porter, layout, width):
    assert painter_of(porter, layout=layout).draw(0).shape == (480, width, 4)


@pytest.fixture(scope="module")
def slider_crank():
    return gm.run(gm.load("slider_crank_torque").replace({"run.duration": "0.1 s"}), certify=False)


def machine_painter(runs, **options):
    """Return the painter of a film of machines alone."""
    times = np.linspace(0.0, 0.1, 4)
    return make_painter(runs, (0.0, 0.1), times, 1.0, FilmOptions(layout="machine", **options))


@pytest.mark.parametrize(
    "options", [{}, {"footer": False}, {"forces": True, "size": 720}, {"labels": True}, {"paths": ["crank pin"]}], ids=repr
)
def test_the_frame_of_a_wide_machine_alone_is_as_high_as_the_machine_needs(slider_crank, options):
    size = options.get("size", 480)
    pixels = machine_painter((slider_crank,), **options).draw(1)[..., :3].astype(int)
    height, width = pixels.shape[:2]
    assert height < 0.75 * size
    has_ink = np.abs(pixels - parse_rgb(PAPER)).max(axis=2) > 24
    machine = has_ink[round(40 / 480 * size) : height - round(28 / 480 * size)]
    columns = np.flatnonzero(machine.any(axis=0))
    rows = np.flatnonzero(machine.any(axis=1))
    assert np.ptp(columns) > 0.9 * width
    assert rows[0] < 0.2 * height
    assert rows[-1] > 0.55 * height
    assert np.diff(rows).max() < 0.1 * size


@pytest.mark.parametrize("scene", ["porter_clearance", "slide_valve_marks", "governed_engine"])
def test_a_bare_film_has_no_words_nor_keys(scene):
    """But the same drawing, at least as large: words would be illegible in a small picture, and take room."""
    run = gm.run(gm.load(scene).replace({"run.duration": "0.1 s"}), certify=False)
    bare, worded = (
        make_painter((run,), (0.0, 0.1), np.array([0.0, 0.1]), 1.0, FilmOptions(layout=layout)) for layout in ("bare", "machine")
    )
    seen, all_seen = ([one for one in painter.canvases[0].figure.findobj() if one.get_visible()] for painter in (bare, worded))
    assert not [one for one in seen if isinstance(one, Text) and one.get_text()]
    assert [one for one in all_seen if isinstance(one, Text) and one.get_text()]
    assert bare.draw(1).shape[0] < worded.draw(1).shape[0] or bare.canvases[0].view.scale > worded.canvases[0].view.scale


def test_keys_are_not_seen_without_their_words():
    axes = Figure().add_subplot()
    shapes = [
        Polygon("live steam key", ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
        Circle("ball", 0.0, 0.0, 1.0),
        TextShape("scale", 0.0, 0.0, "a", 1.0),
    ]
    seen = [[one.get_visible() for one in Brush(axes, 1.0, shows_words=shows).paint(shapes)] for shows in (True, False)]
    assert seen == [[True, True, True], [False, True, False]]


def test_machines_alone_side_by_side_have_one_height(slider_crank, porter):
    shapes = [machine_painter(runs).draw(1).shape[:2] for runs in ((slider_crank,), (porter,), (slider_crank, porter))]
    assert shapes[0][0] < shapes[1][0] == 480
    assert shapes[2] == (480, 960)


def test_the_ground_of_a_dark_film_is_dark_and_exact(tmp_path, porter):
    path = gm.film(porter, tmp_path / "a.gif", stop=0.2, theme="dark")
    frames, _ = decode_film(path)
    # 31 colours keep the ground exactly, so that nothing stays behind a shape that has moved away.
    assert frames[-1][2, 2].tolist() == [round(255 * part) for part in themed_colour(PAPER, Theme.DARK)[:3]]
    assert frames[-1].mean() < 60 < min(parse_rgb(PAPER))


def test_chosen_readings_are_plotted_in_their_order(porter):
    painter = painter_of(porter, readings=("ball_radius", "arm_angle"))
    panels = [panel for panel in painter.panels if isinstance(panel, CurvePanel)]
    radius, angle = (panel.curves[0][:, 1] for panel in panels)
    np.testing.assert_allclose(radius, 1e3 * porter.readings["ball_radius"])
    np.testing.assert_allclose(angle, np.degrees(porter.readings["arm_angle"]))


def test_a_plot_has_all_samples_however_few_frames_there_are(porter):
    painter = painter_of(porter, 3)
    panel = next(panel for panel in painter.panels if isinstance(panel, CurvePanel))
    assert len(panel.curves[0]) == len(porter.times)


def test_the_first_frame_shows_the_whole_curves(porter):
    painter = painter_of(porter)
    first, last = (painter.draw(k)[50:140, 340:465, :3].astype(int) for k in (0, 20))
    ground = np.array(parse_rgb(PAPER))
    # The pale curve has a third of the contrast.
    is_marked = [np.abs(one - ground).max(axis=2) > limit for one, limit in ((first, 6), (last, 20))]
    # All that the last frame shows is there already, but for the dot.
    assert (is_marked[0] & is_marked[1]).sum() > 0.9 * is_marked[1].sum()


def test_a_film_without_footer_has_no_words_below_and_states_a_failure(porter):
    words = [words_of(painter_of(porter, footer=footer).figure) for footer in (True, False)]
    stated = [{word.split()[0] for word in shown if word.startswith(("accurate", "engine:"))} for shown in words]
    assert stated == [{"accurate", "engine:"}, set()]


def test_force_arrows_are_as_long_as_the_forces(porter):
    data = data_of(porter, 5)
    arrows, forces = ForceArrows(data, data.drawing.bounds, shows_all=True), find_forces(data)
    speed, mass = data.readings["spindle_speed"].values[2], 5.0
    shapes = list(shapes_of(arrows.parts(), 2))
    shafts, heads = (of_role(shapes, "centrifugal force", kind) for kind in (Lines, Polygon))
    lengths = [abs(head.points[0][0] - shaft.lines[0][0][0]) for shaft, head in zip(shafts, heads, strict=True)]
    assert lengths == pytest.approx(2 * [mass * speed**2 * data.poses[2, 0, 0] * arrows.scale], rel=1e-9)
    assert arrows.kinds == list(dict.fromkeys(force.kind for force in forces))


def test_layers_show_the_velocities_of_pins_and_the_pole_of_the_coupler():
    run = gm.run(gm.load("drag_link").replace({"run.duration": "0.5 s", "run.output_interval": "0.01 s"}))
    data = data_of(run, 6)
    layers = MotionLayers(data, data.drawing.bounds, gm.FilmOptions(layers=["velocity", "acceleration", "poles"]).layers)
    frame = 3
    shapes = list(shapes_of(layers.parts(), frame))
    crank, speed = float(data.readings["crank_angle"].values[frame]), float(run.rates["crank_angle"][0])
    tip = 0.12 * np.exp(1j * crank)
    follower = float(data.readings["follower_angle"].values[frame])
    direction = np.exp(1j * follower)
    # Crank and follower meet in the pole: s tip = 0.05 + t direction.
    pole = tip * 0.05 * direction.imag / (tip.real * direction.imag - tip.imag * direction.real)
    mark = next(shape for shape in shapes if shape.role == "instantaneous centre")
    centre = np.mean([complex(*point) for point in mark.lines[1]])
    assert abs(centre - pole) < 1e-6  # between reported times velocities are interpolated
    shafts, heads = (of_role(shapes, "velocity", kind) for kind in (Lines, Polygon))
    starts = np.array([complex(*shaft.lines[0][0]) for shaft in shafts])
    tips = np.array([complex(*head.points[0]) for head in heads])
    arrows = tips - starts
    assert abs(starts[0] - tip) < 1e-9
    assert (arrows[0] / (1j * speed * tip)).real > 0.0
    # Normal to both cranks, and as long as the velocities: their ratio is that of the distances from the pole.
    rates = np.abs(arrows) / np.abs(starts - pole)
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)
    for start, arrow in zip(starts, arrows, strict=True):
        assert abs(((start - pole).conjugate() * arrow).real) < 1e-3 * abs(start - pole) * abs(arrow)
    assert [words.split(" ")[0] for _, words in layers.captions] == ["v", "a", "poles"]
    # A page draws the same.
    (view,) = show_run(run, None, (0.0, 0.5), data.times, 1.0, layers=gm.FilmOptions(layers=["velocity", "poles"]).layers).views
    on_page = [shape for shape in view.shapes_at(frame) if shape.role in ("velocity", "instantaneous centre")]
    assert on_page == [shape for shape in shapes if shape.role != "acceleration"]
    assert "instantaneous centre" in roles_of(page_data_of(run, data.times, layers=["poles"]))


def timing_of(run, stop=None, slow_down=None):
    return select_timing((run,), None, None, stop, slow_down, 25.0)


def test_a_periodic_run_closes_on_its_last_whole_period(porter):
    timing = timing_of(porter)
    assert timing.time_span[1] == pytest.approx(2 * PERIOD, abs=1e-3)
    times = np.linspace(*timing.time_span, round(25 * 2 * PERIOD) + 1)
    poses = FrameData(porter, porter.scene.part, timing.time_span, times).poses
    steps = np.abs(np.diff(poses, axis=0)).max(axis=(1, 2))
    assert np.abs(poses[-1] - poses[0]).max() <= steps.max()
    # An explicit end is kept.
    assert timing_of(porter, stop=4.0).time_span == (0.0, 4.0)


def test_a_run_that_is_not_periodic_is_shown_whole(porter):
    # It stops after its first period: what follows would be cut off.
    resting = porter.times > PERIOD
    poses, velocities = porter.poses.copy(), porter.velocities.copy()
    poses[resting], velocities[resting] = poses[0], 0.0
    stopped = dataclasses.replace(porter, poses=poses, velocities=velocities)
    decaying = dataclasses.replace(porter, poses=porter.poses * np.exp(-0.1 * porter.times)[:, None, None])
    assert [timing_of(run).time_span for run in (stopped, decaying)] == [(0.0, 4.0), (0.0, 4.0)]


def turning_run(run, turns_per_second):
    """Return a run whose first body turns in the plane of the drawing."""
    poses, velocities = run.poses.copy(), run.velocities.copy()
    poses[:, :, :2], velocities[:] = poses[0, :, :2], 0.0
    rate = 2 * np.pi * turns_per_second
    poses[:, 0, 2], velocities[:, 0, 2] = rate * run.times, rate
    readings = run.readings | {"spindle_speed": np.full(len(run.times), 12.0)}
    return dataclasses.replace(run, poses=poses, velocities=velocities, readings=readings)


def test_a_motion_comes_back_with_the_speed_of_its_spindle_not_before(porter):
    """Positions alone return within any time in which friction holds the sleeve."""
    run = turning_run(porter, 1.0)
    speeds = 12.0 + np.sin(2 * np.pi * run.times / 3.0)
    run = dataclasses.replace(run, readings=run.readings | {"spindle_speed": speeds})
    assert timing_of(run).time_span[1] == pytest.approx(3.0, abs=0.02)  # RETURN_TOLERANCE


def test_a_fast_crank_is_slowed_and_closes_on_a_whole_turn(porter):
    run = turning_run(porter, 6.3)
    timing = timing_of(run)
    assert 25.0 * timing.slow_down / 6.3 >= MIN_FRAMES_PER_TURN
    assert timing.lowest_frame_rate * timing.slow_down / 6.3 == pytest.approx(0.5 * MIN_FRAMES_PER_TURN)  # of a GIF that is too large
    turns = 6.3 * timing.time_span[1]
    assert turns == pytest.approx(round(turns), abs=1e-2)  # RETURN_TOLERANCE
    assert timing_of(turning_run(porter, 0.7)).slow_down == timing_of(run, slow_down=1.0).slow_down == 1.0  # the other as requested


@pytest.mark.parametrize(("options", "message"), [
    ({"size": 100}, "must be 320 to 4320 pixels"),
    ({"frames_per_second": 100}, "1 to 50"),
    ({"start": 1.0, "stop": 9.0}, "within the run, 0..4 s"),
    ({"part": "governer"}, "Did you mean 'governor'"),
    ({"layout": "square"}, "machine, machine\\+plots, wide"),
    ({"layout": "wid"}, r"; got 'wid'\. Did you mean 'wide'\?$"),
    ({"theme": "transparent"}, "light or dark"),
    ({"readings": ["arm_angel"]}, "arm_angle"),
    ({"readings": "arm_angle"}, "list of names"),
    ({"readings": ["arm_angle"], "layout": "machine"}, "plots no readings"),
    ({"readings": list("abcde")}, "at most 4"),
    ({"labels": 1.5}, "labels"),
    ({"labls": True}, r"a film has no option 'labls'; its options are .*\. Did you mean 'labels'\?$"),
    ({"exaggerate": 0.5}, "at least 1"),
    ({"exaggerate": 2.0, "forces": True}, "leave one of the two out"),
    ({"view": "above"}, "plane, outside, both"),
    ({"view": "outsid"}, r"^a film's view must be one of plane, outside, both; got 'outsid'\. Did you mean 'outside'\?$"),
    ({"view": "outside", "labels": True}, "choose the view 'both'"),
])  # fmt: skip
def test_wrong_options_are_refused(tmp_path, porter, options, message):
    with pytest.raises(gm.MechanismError, match=message):
        gm.film(porter, tmp_path / "a.gif", **options)
    assert list(tmp_path.iterdir()) == []


def test_every_option_is_shown_where_films_are_made():
    """The names stand twice: with the types that users write, and with what the record keeps."""
    names = [one.name for one in dataclasses.fields(gm.FilmOptions)]
    assert list(FilmKeywords.__annotations__) == names
    for function in (gm.film, gm.Trajectory.film, gm.FilmOptions):
        parameters = inspect.signature(function).parameters
        assert [name for name in parameters if name in names] == names
        assert gm.FilmOptions(**{name: parameters[name].default for name in names}) == gm.FilmOptions()
    documented = re.findall(r"^(\w+)\n    \S", inspect.getdoc(gm.film), flags=re.MULTILINE)
    assert set(names) <= set(documented)


def test_a_changed_record_is_checked_too():
    assert dataclasses.replace(gm.FilmOptions(start="500 ms"), stop="1 s") == gm.FilmOptions(start=0.5, stop=1.0)
    with pytest.raises(gm.MechanismError, match="plots no readings"):
        dataclasses.replace(gm.FilmOptions(readings=["arm_angle"]), layout="machine")


def test_a_run_is_saved_with_the_film_that_is_asked_for(porter, tmp_path):
    film, *_ = porter.save(tmp_path, figures=False, film="gif", film_options=gm.FilmOptions(size=320, stop=0.1, frames_per_second=5))
    assert decode_film(film)[0].shape[1:3] == (320, 320)


def test_a_page_and_several_drawings_are_refused(tmp_path, porter):
    with pytest.raises(gm.MechanismError, match="leave labels and forces out"):
        gm.film(porter, tmp_path / "a.html", labels=True, forces=True)
    with pytest.raises(gm.MechanismError, match="shows one run; got 2"):
        gm.film([porter, porter], tmp_path / "a.svg")


def test_an_animated_drawing_has_true_time_and_no_scripts(tmp_path, porter):
    path = gm.film(porter, tmp_path / "a.svg", stop=1.0, labels=True)
    assert path.stat().st_size < 400_000
    root = ElementTree.parse(path).getroot()
    animations = [one for kind in ("animate", "animateTransform") for one in root.iter(SVG + kind)]
    assert {one.get("dur") for one in animations} == {"1s"}
    assert not list(root.iter(f"{SVG}script"))
    for one in animations:
        times = [float(time) for time in (one.get("keyTimes") or "0;1").split(";")]
        assert len(times) == len(one.get("values").split(";"))
        assert times == sorted(times)
        assert times[0] == 0.0


def test_key_frames_reproduce_a_motion():
    angle = np.linspace(0.0, 4.0, 60)
    places = np.column_stack([100.0 * np.cos(angle), 5.0 * angle])
    keys = key_frames(places)
    between = np.column_stack([np.interp(np.arange(60), keys, column[keys]) for column in places.T])
    assert np.abs(between - places).max() <= TOLERANCE
    assert len(keys) < 40


def test_a_ball_of_an_animated_drawing_is_drawn_once_and_follows_the_run(tmp_path, porter):
    root = ElementTree.parse(gm.film(porter, tmp_path / "a.svg", stop=1.0, layout="machine")).getroot()
    moving = [(group, group.find(f"{SVG}animateTransform")) for group in root.iter(f"{SVG}g")]
    fill = ROLE_STYLES["ball"].fill
    tracks = [
        np.array([[float(value) for value in place.split()] for place in move.get("values").split(";")])
        for group, move in moving
        if move is not None and move.get("type") == "translate" and any(one.get("fill") == fill for one in group.findall(f"{SVG}g"))
    ]
    assert len(tracks) == 2
    shown = porter.times <= 1.0
    angle = porter.readings["arm_angle"][shown]
    sideways, upward = np.ptp(np.sin(angle)), np.ptp(np.cos(angle))
    for track in tracks:
        # Both extents are good to the tolerance of the key frames at either end.
        width, height = np.ptp(track, axis=0)
        assert abs(width / sideways - height / upward) < 2 * TOLERANCE * (1 / sideways + 1 / upward)
