"""What a film shows and how: its layout, plots, colours, and what is drawn beside the machine on demand. Nothing heavy is imported here."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import StrEnum

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.units.quantities import format_value

MAX_PLOTS = 4
"""Largest number of plots: more would leave each less than an eighth of the frame's height for its curve."""


class FilmLayout(StrEnum):
    """Layout of a film: the machine alone, with plots in a square, or with plots beside it in 16:9."""

    MACHINE = "machine"
    MACHINE_AND_PLOTS = "machine+plots"
    WIDE = "wide"


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
    """

    layout: FilmLayout = FilmLayout.MACHINE_AND_PLOTS
    readings: tuple[str, ...] = ()
    theme: Theme = Theme.LIGHT
    footer: bool = True
    labels: bool = False
    forces: bool = False
    traces: bool = False


DEFAULT_OPTIONS = FilmOptions()
"""Options of a film of which nothing is requested."""


def make_film_options(
    layout: str, readings: Sequence[str] | None, theme: str, *, footer: bool, labels: bool, forces: bool, traces: bool
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

    Returns
    -------
    FilmOptions
        The options.

    Raises
    ------
    MechanismError
        If there is no such layout or theme, or the readings are no list of texts, too many, or have no place in the layout.
    """
    if layout not in set(FilmLayout):
        raise MechanismError(f"a film's layout must be one of {', '.join(FilmLayout)}; got {layout!r}.{did_you_mean(layout, FilmLayout)}")
    if theme not in (Theme.LIGHT, Theme.DARK):
        raise MechanismError(f"a film's theme must be light or dark, for its frames have a ground; got {theme!r}")
    names = () if readings is None else readings
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise MechanismError(f"readings of a film must be a list of names, as ['arm_angle']; got {format_value(readings)}")
    if len(names) > MAX_PLOTS:
        raise MechanismError(f"a film plots at most {MAX_PLOTS} readings; got {len(names)}: {', '.join(names)}")
    if names and layout == FilmLayout.MACHINE:
        raise MechanismError("a film of the layout 'machine' plots no readings; leave them out, or choose 'machine+plots' or 'wide'")
    return FilmOptions(
        layout=FilmLayout(layout),
        readings=tuple(dict.fromkeys(names)),
        theme=Theme(theme),
        footer=footer,
        labels=labels,
        forces=forces,
        traces=traces,
    )


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
        raise MechanismError("a page draws as often as the screen does and takes no frames per second; leave them out")
    if options != DEFAULT_OPTIONS:
        changed = [one.name for one in fields(options) if getattr(options, one.name) != getattr(DEFAULT_OPTIONS, one.name)]
        raise MechanismError(f"a page has its own layout, switches and colours; leave {' and '.join(changed)} out, or write a .gif")
