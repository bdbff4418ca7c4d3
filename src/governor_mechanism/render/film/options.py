"""What a film shows and how: its layout, plots, colours, and what is drawn beside the machine on demand. Nothing heavy is imported here."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import StrEnum

from governor_mechanism.errors import did_you_mean
from governor_mechanism.model.part import Part
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film_option_error import FilmOptionError, list_options
from governor_mechanism.units.quantities import format_value

MAX_PLOTS = 4
"""Largest number of plots: more would leave each less than an eighth of the frame's height for its curve."""


class FilmLayout(StrEnum):
    """Layout of a film: the machine alone, with plots in a square, or with plots beside it in 16:9."""

    MACHINE = "machine"
    MACHINE_AND_PLOTS = "machine+plots"
    WIDE = "wide"


class FilmView(StrEnum):
    """View of a part that turns with a spindle: its plane, from outside, or both side by side."""

    PLANE = "plane"
    OUTSIDE = "outside"
    BOTH = "both"


@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """What the frames of a film show.

    Attributes
    ----------
    layout
        The layout.
    readings
        Names of the plotted readings, as in `Trajectory.readings`, or "rate of ..."; none for those that the drawing chooses.
    theme
        Light or dark.
    footer
        Whether the last line states accuracy and engine. An early end of the run is stated in any case.
    labels
        Whether the parts are named, and the angle of the leading reading is marked.
    forces
        Whether the forces on the bodies are drawn as arrows.
    traces
        Whether the paths of the mass centres are drawn.
    view
        How parts that turn with a spindle are seen.
    exaggerate
        Magnification of the motion about its mean position; 1 is the true motion.
    """

    layout: FilmLayout = FilmLayout.MACHINE_AND_PLOTS
    readings: tuple[str, ...] = ()
    theme: Theme = Theme.LIGHT
    footer: bool = True
    labels: bool = False
    forces: bool = False
    traces: bool = False
    view: FilmView = FilmView.PLANE
    exaggerate: float = 1.0


DEFAULT_OPTIONS = FilmOptions()
"""Options of a film of which nothing is requested."""


def make_film_options(
    layout: str,
    readings: Sequence[str] | None,
    theme: str,
    *,
    footer: bool,
    labels: bool,
    forces: bool,
    traces: bool,
    view: str = FilmView.PLANE,
    exaggerate: float = 1.0,
) -> FilmOptions:
    """Return the checked options of a film.

    Parameters
    ----------
    layout
        Name of a layout.
    readings
        Names of readings; None for those that the drawing chooses.
    theme
        "light" or "dark".
    footer
        Whether the last line states accuracy and engine.
    labels
        Whether the parts are named.
    forces
        Whether the forces are drawn.
    traces
        Whether the paths of the mass centres are drawn.
    view
        Name of a view.
    exaggerate
        Magnification of the motion, at least 1.

    Returns
    -------
    FilmOptions
        The options.

    Raises
    ------
    MechanismError
        If there is no such layout, theme or view, the magnification is out of range, options do not go together, or the readings are no
        list of texts, too many, or have no place in the layout.
    """
    _require_one_of("layout", layout, FilmLayout)
    if theme not in (Theme.LIGHT, Theme.DARK):
        raise FilmOptionError("a film's {theme} must be light or dark, for its frames have a ground; got {found!r}", found=theme)
    names = _require_readings(readings, layout)
    _require_one_of("view", view, FilmView)
    overlays = [name for name, is_on in (("labels", labels), ("forces", forces), ("traces", traces)) if is_on]
    if overlays and view == FilmView.OUTSIDE:
        raise FilmOptionError(
            f"{list_options(overlays)} are drawn on the turning plane, which the {{view}} 'outside' does not show; "
            "leave them out, or choose the {view} 'both'"
        )
    if not (math.isfinite(exaggerate) and exaggerate >= 1.0):
        raise FilmOptionError("{exaggerate} must be a number of at least 1, which is the true motion; got {found:g}", found=exaggerate)
    if forces and exaggerate > 1.0:
        raise FilmOptionError("{forces} are those of the true positions, which {exaggerate} does not show; leave one of the two out")
    return FilmOptions(
        layout=FilmLayout(layout),
        readings=tuple(dict.fromkeys(names)),
        theme=Theme(theme),
        footer=footer,
        labels=labels,
        forces=forces,
        traces=traces,
        view=FilmView(view),
        exaggerate=float(exaggerate),
    )


def _require_one_of(name: str, found: str, allowed: type[StrEnum]) -> None:
    """Raise FilmOptionError unless an option is one of some words."""
    if found not in set(allowed):
        template = f"a film's {{{name}}} must be one of {', '.join(allowed)}; got {{found!r}}.{{hint}}"
        raise FilmOptionError(template, found=found, hint=did_you_mean(found, allowed))


def _require_readings(readings: Sequence[str] | None, layout: str) -> Sequence[str]:
    """Return the names of readings; raise FilmOptionError if they are no list of names, too many, or have no place in the layout."""
    names = () if readings is None else readings
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise FilmOptionError("{readings} of a film must be a list of names, as ['arm_angle']; got {found}", found=format_value(readings))
    if len(names) > MAX_PLOTS:
        template = "a film plots at most {most} readings, and {readings} names {count}: {found}; leave some out"
        raise FilmOptionError(template, most=MAX_PLOTS, count=len(names), found=", ".join(names))
    if names and layout == FilmLayout.MACHINE:
        raise FilmOptionError(
            "a film of the {layout} 'machine' plots no readings; leave {readings} out, or choose the {layout} 'machine+plots' or 'wide'"
        )
    return names


def require_page_options(frames_per_second: float | None, options: FilmOptions) -> None:
    """Check that no option of frames is set, which a page has not; call it before long work.

    Parameters
    ----------
    frames_per_second
        The frame rate, or None.
    options
        The options.

    Raises
    ------
    MechanismError
        If one is set.
    """
    if frames_per_second is not None:
        raise FilmOptionError("a page draws as often as the screen does and takes no {frames_per_second}; leave it out")
    if options != DEFAULT_OPTIONS:
        changed = [one.name for one in fields(options) if getattr(options, one.name) != getattr(DEFAULT_OPTIONS, one.name)]
        raise FilmOptionError(f"a page has its own layout, switches and colours; leave {list_options(changed)} out, or {{use_gif}}")


def require_view(parts: Sequence[Part], view: str) -> None:
    """Check that a view has something to show; call it before long work.

    Parameters
    ----------
    parts
        The shown parts.
    view
        Name of the view.

    Raises
    ------
    MechanismError
        If no part turns with a spindle, but a view from outside is requested.
    """
    if view != FilmView.PLANE and not any(part.turns for part in parts):
        machines = ", ".join(dict.fromkeys(part.machine for part in parts))
        template = "the {view} {found!r} shows what turns with a spindle, and nothing shown does ({machines}); leave {view} out"
        raise FilmOptionError(template, found=str(view), machines=machines)


def require_room_options(options: FilmOptions) -> None:
    """Check that nothing is to be drawn over one part, where an engine room is shown; call it before long work.

    Parameters
    ----------
    options
        The options.

    Raises
    ------
    MechanismError
        If something is.
    """
    names = ("labels", "forces", "traces", "view", "exaggerate")
    requested = [name for name in names if getattr(options, name) != getattr(DEFAULT_OPTIONS, name)]
    if requested:
        raise FilmOptionError(
            f"the film of a governed engine shows its engine room, which does not take {list_options(requested)}; "
            "leave that out, or show one part by {part}, for example its governor"
        )


def require_drawing_options(options: FilmOptions) -> None:
    """Check that an animated drawing can show what is requested; call it before long work.

    Parameters
    ----------
    options
        The options.

    Raises
    ------
    MechanismError
        If a view from outside is requested, whose parts change places in depth.
    """
    if options.view is not FilmView.PLANE:
        raise FilmOptionError("an animated drawing (.svg) shows the turning plane only; leave {view} out, or {use_gif}")
