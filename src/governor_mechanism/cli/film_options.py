"""Options of films on the command line, the same for every command that writes one. Nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film.options import FilmLayout, FilmOptions, require_page_options
from governor_mechanism.units.quantities import number_or_text, parse_quantity

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene

LayoutOption = Annotated[FilmLayout, typer.Option(help="Layout of the film: the machine alone, or with plots in a square or in 16:9.")]
ReadingsOption = Annotated[
    str | None, typer.Option(help='Plotted readings, for example "arm_angle,rate of sleeve_lift"; by default those that suit the machine.')
]
NoFooterOption = Annotated[bool, typer.Option("--no-footer", help="Leave out the line on accuracy and engine at the bottom of the film.")]
LabelsOption = Annotated[bool, typer.Option("--labels", help="Name the parts and the main angle on the film.")]
ForcesOption = Annotated[
    bool, typer.Option("--forces", help="Draw weights, centrifugal forces, springs and dampers as arrows on the film.")
]
TracesOption = Annotated[bool, typer.Option("--traces", help="Draw the paths of the mass centres on the film.")]
StartOption = Annotated[str | None, typer.Option(help='Start of the film, for example "2 s"; by default that of the run.')]
StopOption = Annotated[str | None, typer.Option(help="End of the film; by default that of the run, or of its last whole turn or period.")]
SlowDownOption = Annotated[
    float | None, typer.Option(help="Seconds of film per second of the run; by default 1, and more for short runs and fast cranks.")
]


def check_film_options(scene: Scene, chosen: Mapping[str, Any], frames_per_second: float | None, *, is_page: bool) -> None:
    """Check before a simulation what its film will not take, so that no run is lost.

    Parameters
    ----------
    scene
        The scene.
    chosen
        The options by `gather_film_options`.
    frames_per_second
        The frame rate, or None.
    is_page
        Whether the film is an interactive page.

    Raises
    ------
    MechanismError
        If there is no such reading, or a page does not take an option.
    """
    if is_page:
        frame_options = {name: value for name, value in chosen.items() if name not in ("start", "stop", "slow_down")}
        require_page_options(frames_per_second, FilmOptions(**frame_options))
    if "readings" in chosen:
        from governor_mechanism.render.shown_readings import RATE_START

        names = [one.name for one in scene.describe().readings]
        names += [f"{RATE_START}{name}" for name in names]
        for name in chosen["readings"]:
            if name not in names:
                raise MechanismError(f"--readings: there is no reading {name!r}; there are {', '.join(names)}.{did_you_mean(name, names)}")


def gather_film_options(
    *,
    layout: FilmLayout,
    readings: str | None,
    no_footer: bool,
    labels: bool,
    forces: bool,
    traces: bool,
    start: str | None,
    stop: str | None,
    slow_down: float | None,
    theme: Theme,
    is_page: bool = False,
) -> Mapping[str, Any]:
    """Return the options of `write_film` by name, without those at their defaults.

    Parameters
    ----------
    layout
        Layout of the film.
    readings
        Names of readings with commas between; None for those that suit the machine.
    no_footer
        Whether to leave out the line on accuracy and engine.
    labels
        Whether to name the parts.
    forces
        Whether to draw the forces.
    traces
        Whether to draw the paths of the mass centres.
    start
        Start of the film as text with a unit, or None.
    stop
        End of the film as text with a unit, or None.
    slow_down
        Seconds of film per second of the run, or None.
    theme
        Theme of the figures; a film takes it if it is dark.
    is_page
        Whether the film is an interactive page, which follows the theme of the reader's screen.

    Returns
    -------
    Mapping
        The options.

    Raises
    ------
    MechanismError
        If a time is not understood.
    """
    times = {
        name: parse_quantity(number_or_text(text), "time", f"--{name}")
        for name, text in (("start", start), ("stop", stop))
        if text is not None
    }
    switches = {"labels": labels, "forces": forces, "traces": traces}
    return {
        **times,
        **{name: True for name, is_on in switches.items() if is_on},
        **({} if slow_down is None else {"slow_down": slow_down}),
        **({} if readings is None else {"readings": [name.strip() for name in readings.split(",") if name.strip()]}),
        **({"footer": False} if no_footer else {}),
        **({} if layout is FilmLayout.MACHINE_AND_PLOTS else {"layout": layout.value}),
        **({"theme": theme.value} if theme is Theme.DARK and not is_page else {}),
    }
