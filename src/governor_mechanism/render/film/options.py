"""Which options suit a film: its format, and the scenes that it shows. Call it before long work."""

from collections.abc import Sequence
from dataclasses import fields
from importlib import import_module

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmOptionError, FilmOptions, FilmView, list_options
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.machines.engine_room.arrangement import EngineRoomParts, find_governed_engine
from governor_mechanism.render.part_run import require_one_coordinate

PAGE_SUFFIX, DRAWING_SUFFIX = ".html", ".svg"
"""Endings of the names of an interactive page and of an animated drawing, which show one run."""
VIDEO_SUFFIXES = (".mp4", ".webm")
"""Endings of the names of videos, which need ffmpeg."""
_OF_PAGES = ("size", "part", "start", "stop", "slow_down", "paths", "layers")
"""Options that a page takes too."""
_OF_PARTS = ("labels", "forces", "traces", "paths", "layers", "view", "exaggerate")
"""Options of the film of a part, which an engine room does not take."""


def require_suitable_options(options: FilmOptions, scenes: Sequence[Scene], suffix: str) -> None:
    """Check that a film can show what is requested."""
    if suffix == PAGE_SUFFIX:
        _require_page(options, len(scenes))
    if suffix == DRAWING_SUFFIX:
        _require_drawing(options, len(scenes))
    if find_engine_room(scenes, options.part):
        _require_room(options)
    elif options.view is not FilmView.PLANE:
        _require_turning_part(options, scenes)
    for scene in scenes:
        require_points(options.paths or (), scene)
    if options.exaggerate != 1.0:
        for scene in scenes:
            require_one_coordinate(scene)


def require_points(names: Sequence[str], scene: Scene) -> None:
    """Raise FilmOptionError for a path of a point that no part of a scene has."""
    known = scene.mechanism.path_points
    for name in names:
        if name not in known:
            listed = ", ".join(sorted(known))
            raise FilmOptionError(
                "{paths} name {name!r}, and no point has this name; points are {listed}.{hint}",
                name=name,
                listed=listed,
                hint=did_you_mean(name, known),
            )


def require_video_writer(
    suffix: str = ".mp4",  # ending of the file's name
) -> None:
    """Check that videos can be written; call it before long work; raise MechanismError if imageio-ffmpeg is not installed."""
    try:
        import_module("imageio_ffmpeg")
    except ImportError as missing:
        raise MechanismError(f"writing {suffix} needs ffmpeg: pip install imageio-ffmpeg, or write a .gif") from missing


def find_engine_room(scenes: Sequence[Scene], part: str | None) -> EngineRoomParts | None:
    """Return the governed engine that a film of one run shows as an engine room, or None; `part` is the only part to show."""
    return find_governed_engine(scenes[0]) if len(scenes) == 1 and part is None else None


def _list_changed(options: FilmOptions) -> list[str]:
    """Return the names of the options that are not at their defaults."""
    return [one.name for one in fields(options) if getattr(options, one.name) != getattr(DEFAULT_OPTIONS, one.name)]


def _require_page(options: FilmOptions, n_runs: int) -> None:
    """Raise MechanismError for several runs on a page, and for options of frames, which it has not."""
    if n_runs > 1:
        raise MechanismError(f"a page shows one run; got {n_runs}; write a page for each, or a .gif of all")
    if options.frames_per_second is not None:
        raise FilmOptionError("a page draws as often as the screen does and takes no {frames_per_second}; leave it out")
    if changed := [name for name in _list_changed(options) if name not in _OF_PAGES]:
        raise FilmOptionError(f"a page has its own layout, switches and colours; leave {list_options(changed)} out, or {{use_gif}}")


def _require_drawing(options: FilmOptions, n_runs: int) -> None:
    """Raise MechanismError for several runs in an animated drawing, and for a view from outside: its parts change places in depth."""
    if n_runs > 1:
        raise MechanismError(f"an animated drawing shows one run; got {n_runs}; write one for each, or a .gif of all")
    if options.view is not FilmView.PLANE:
        raise FilmOptionError("an animated drawing (.svg) shows the turning plane only; leave {view} out, or {use_gif}")


def _require_room(options: FilmOptions) -> None:
    """Raise MechanismError if something is to be drawn over one part."""
    if requested := [name for name in _list_changed(options) if name in _OF_PARTS]:
        raise FilmOptionError(
            f"the film of a governed engine shows its engine room, which does not take {list_options(requested)}; "
            "leave that out, or show one part by {part}, for example its governor"
        )


def _require_turning_part(options: FilmOptions, scenes: Sequence[Scene]) -> None:
    """Raise MechanismError if no shown part turns with a spindle."""
    parts = [part for scene in scenes for part in scene.parts if options.part in (None, part.name)]
    if not any(part.turns for part in parts):
        machines = ", ".join(dict.fromkeys(part.machine for part in parts))
        template = "the {view} {found!r} shows what turns with a spindle, and nothing shown does ({machines}); leave {view} out"
        raise FilmOptionError(template, found=str(options.view), machines=machines)
