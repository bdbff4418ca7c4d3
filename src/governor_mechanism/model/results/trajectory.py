"""Result of a run: times, motion, readings, and what follows from them."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Final, Protocol, Unpack

from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.model.events import Event
from governor_mechanism.model.motion_state import MotionState
from governor_mechanism.model.results.pictures import Figure, Film, FilmKeywords, FilmOptions, show_film_options
from governor_mechanism.model.results.records import Cost, Energy, Outcome, Reaction, Recurrence, SpeedFluctuation
from governor_mechanism.model.results.result import Column, Result, item_column, name_values, path_column
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import DataFrame, Dataset, FloatArray
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import summarise

TIME_COLUMN: Final = "time"
"""Name of the column of the reported times."""

REPORTED_TIME_TOLERANCE: Final = 1e-12
"""Difference of a time from a reported one, relative to the last, up to which it is that one: rounding."""


class DeferredResults(Protocol):
    """Results that a motion implies, computed on first access."""

    def reactions(self) -> Mapping[str, Reaction]:
        """Return the reactions by joint name."""

    def events(self) -> tuple[Event, ...]:
        """Return the events in order of time."""

    def event_notes(self) -> tuple[str, ...]:
        """Return sentences on events that may be missing."""

    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Return the extreme speeds of shafts by the reading of their angle."""

    def recurrences(self) -> Mapping[str, Recurrence]:
        """Return how named crossings recur, by their names."""

    def lags_at(self, k: int) -> tuple[float, ...]:
        """Return the states of the lags at reported time k."""

    def states_near_events(self, times: FloatArray) -> Mapping[int, tuple[FloatArray, FloatArray]]:
        """Return poses and velocities (bodies, 3) at those of times (n,) s that a contact event shares an interval of reports with."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory(Result):
    """Result of a run.

    Attributes
    ----------
    scene
        The simulated scene.
    times
        Reported times, s; shape (n,).
    poses
        Poses x (m), y (m), angle (rad) of the mass centres in the plane of the part; shape (n, bodies, 3).
    velocities
        Their time derivatives; shape (n, bodies, 3).
    readings
        Readings by name, SI; shape (n,).
    rates
        Time derivatives of the readings that are positions, SI/s; shape (n,).
    units
        SI units of the readings.
    scales
        Scales of relative errors, SI: of each reading, of its rate ("rate of ..."), of the joint gap and of the event times. They follow
        the motion: a stiff spring that hardly swings does not set them.
    joint_gap
        Largest gap of any joint, m; shape (n,).
    energy
        Energies.
    outcome
        How the run ended.
    cost
        Cost of the run.
    detail
        Cause of an early end, or empty.
    error_estimate
        Largest error of a reading or rate at any reported time, relative to its scale; None if not certified.
    reading_errors
        Largest error by reading, SI; empty if not certified.
    settings
        Settings of the engine.
    n_excluded
        Number of samples excluded from the error estimate because an event is too close. The estimate bounds the time of that event.
    mobility
        Number of degrees of freedom that joints and drivers leave.
    notes
        Sentences on the assembly of the start.
    deferred_results
        Provider of reactions and events.
    """

    scene: Scene
    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    units: Mapping[str, str]
    scales: Mapping[str, float]
    joint_gap: FloatArray
    energy: Energy
    outcome: Outcome
    cost: Cost
    detail: str = ""
    error_estimate: float | None = None
    reading_errors: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, float | str] = field(default_factory=dict)
    n_excluded: int = 0
    mobility: int = 1
    notes: tuple[str, ...] = ()
    deferred_results: DeferredResults | None = field(default=None, repr=False, compare=False)

    index: ClassVar[str] = TIME_COLUMN
    attributes: ClassVar[tuple[str, ...]] = ("title=scene.title", "outcome=message", "error_estimate")
    figure: ClassVar[str] = "render.figures.time_series.readings_figure"

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", name_values("reading", self.readings))
        object.__setattr__(self, "rates", name_values("rate", self.rates))

    def __repr__(self) -> str:
        """Return scene, engine, number of reported times, readings and outcome in at most three lines."""
        span = f"{len(self.times)} times to {self.times[-1]:g} s" if len(self.times) else "no times"
        error = "not certified" if self.error_estimate is None else f"error {self.error_estimate:.1g}"
        scene = f"{summarise(self.scene.title)}; {self.cost.engine}"
        return f"Trajectory({scene}; {span}; readings {summarise(self.readings)}; {self.outcome.name}, {error})"

    @property
    def columns(self) -> tuple[Column, ...]:
        """Times and readings; a reading "time" is named "reading time"."""
        names = {f"reading {name}" if name == TIME_COLUMN else name: name for name in self.readings}
        readings = (item_column(key, "readings", name, unit=self.units[name]) for key, name in names.items())
        return Column(TIME_COLUMN, unit="s", value="times"), *readings

    def _further_columns(self, rates: bool, paths: Sequence[str]) -> Iterator[Column]:
        """Yield the rates, as "rate of ...", if wanted, and the coordinates of points."""
        for name in self.rates if rates else ():
            yield item_column(f"rate of {name}", "rates", name, unit=f"{self.units[name]}/s")
        for name in paths:
            yield from (path_column(name, axis) for axis in "xy")

    @cached_property
    def reactions(self) -> Mapping[str, Reaction]:
        """Reactions by joint name, computed on first access."""
        return name_values("joint", {} if self.deferred_results is None else self.deferred_results.reactions())

    @cached_property
    def paths(self) -> Mapping[str, FloatArray]:
        """Paths, m, shape (n, 2): of named points, of moving pins (by the joint), of mass centres (by the body), of "crank.end"."""
        from governor_mechanism.mechanics.kinematics.constraint_rows import point_paths

        return name_values("point", point_paths(self.scene.mechanism, self.poses))

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time: contact events, turning points and change points. Computed on first access."""
        return () if self.deferred_results is None else self.deferred_results.events()

    @cached_property
    def event_notes(self) -> tuple[str, ...]:
        """Sentences on events that may be missing from `events`, or less accurate. Computed with the events."""
        return () if self.deferred_results is None else self.deferred_results.event_notes()

    @cached_property
    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Extreme speeds in the last turn of each shaft of an engine, by the reading of its angle. Computed on first access."""
        return name_values("shaft angle", {} if self.deferred_results is None else self.deferred_results.speed_fluctuations())

    @cached_property
    def recurrences(self) -> Mapping[str, Recurrence]:
        """How named crossings recur, as the beat of a clock: interval, and energies from one to the next. Computed on first access."""
        return name_values("recurring event", {} if self.deferred_results is None else self.deferred_results.recurrences())

    def state(self, time: float | None = None) -> MotionState:
        """Return the state at a reported time, from which another run can go on: `gm.run(scene, start=run.state())`.

        Parameters
        ----------
        time
            One of `times`, s; the last of them if None.

        Returns
        -------
        MotionState
            Poses and velocities of all bodies, states of lags, and the time on the clock of the scene.

        Raises
        ------
        MechanismError
            If that is no reported time, or the run is a saved one whose scene has lags.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> first = gm.run("porter", times=[0, 1])
        >>> second = gm.run("porter", times=[0, 1], start=first.state())
        >>> whole = gm.run("porter", times=[0, 1, 2])
        >>> bool(abs(second.readings["arm_angle"][-1] - whole.readings["arm_angle"][-1]) < 1e-6)
        True
        """
        times = self.times.tolist()
        tolerance = REPORTED_TIME_TOLERANCE * abs(times[-1]) if times else 0.0
        found = [k for k, one in enumerate(times) if isinstance(time, int | float) and abs(one - time) <= tolerance]
        if time is None and times:
            found = [len(times) - 1]
        if not found:
            reported = f"{len(times)} times from {times[0]:g} s to {times[-1]:g} s" if times else "no time at all"
            raise MechanismError(f"a state is one at a reported time; found {format_value(time)}, and the run reports {reported}")
        k = found[0]
        poses, velocities = (tuple(tuple(row) for row in rows[k].tolist()) for rows in (self.poses, self.velocities))
        return MotionState(
            time=float(self.times[k]) + (self.scene.state.time if self.scene.state else 0.0),
            bodies=self.body_names,
            poses=poses,
            velocities=velocities,
            lags=() if self.deferred_results is None else self.deferred_results.lags_at(k),
        )

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of `poses`."""
        return tuple(body.name for body in self.scene.mechanism.bodies)

    @property
    def message(self) -> str:
        """Outcome as a sentence, after its cause if there is one."""
        return self.outcome.describe(self.detail)

    @property
    def requested_accuracy(self) -> float:
        """Largest relative error of a reading that the run was to have."""
        return float(self.settings["asked_accuracy"])

    def raise_if_failed(self) -> None:
        """Raise RunFailed unless the run reached its end and met its accuracy."""
        if not self.outcome.ok:
            raise RunFailed(self.message)

    def to_xarray(self) -> Dataset:
        """Return all arrays as a data set of xarray, as `xarray.open_dataset` reads it from the netCDF file of `save`.

        Returns
        -------
        xarray.Dataset
            Readings (as "reading_arm_angle"), rates ("rate_arm_angle"), errors, motion, energies, reactions and events with their units, by
            time, body, component and joint.

        Raises
        ------
        MechanismError
            If xarray is not installed.
        """
        from governor_mechanism.files.results import make_xarray_dataset

        return make_xarray_dataset(self)

    def to_dataframe(self, *, rates: bool = False, paths: Sequence[str] = ()) -> DataFrame:
        """Return the readings as a table of pandas with the times as index; `attrs["units"]` has the units.

        Parameters
        ----------
        rates
            Whether the table has columns "rate of ...", too.
        paths
            Names of points, as `paths` names them, whose coordinates are columns "foot.x" and "foot.y", too.

        Returns
        -------
        pandas.DataFrame
            The table, SI.

        Raises
        ------
        MechanismError
            If pandas is not installed, or there is no such point.
        """
        from governor_mechanism.files.results import tabulate_result

        return tabulate_result(self, self._further_columns(rates, paths))

    def as_json(self) -> Mapping[str, Any]:
        """Return the summary of the run in the types of JSON: outcome, errors, final readings, events and cost.

        Its arrays are those of `to_dataframe` and `to_xarray`.

        Returns
        -------
        dict
            What the JSON file of `save` has.
        """
        from governor_mechanism.files.results import summarise_run

        return summarise_run(self)

    def plot(self, *readings: str) -> Figure:
        """Draw readings over time, in everyday units; a notebook shows the figure, and `save` writes it as PNG, SVG or PDF.

        The arguments are names of readings, or "rate of ..." for a rate. Without any, it is an overview: of more than 8 readings those that
        tell most, with the names of the others; those that stay constant have a line of text. A curve whose oscillations are too narrow
        to be resolved is drawn as its range and its mean within a turn.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If there is no such reading, or the run has no reported time.
        """
        return self._draw(readings)

    def plot_diagnostics(self) -> Figure:
        """Draw the joint gap and the energy drift over time, which are zero in an exact run; `save` writes the figure.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If the run has no reported time.
        """
        from governor_mechanism.render.figures.time_series import diagnostics_figure

        return diagnostics_figure(self)

    def plot_paths(self, *points: str) -> Figure:
        """Draw the paths of points to one scale on both axes; `save` writes the figure.

        The arguments are names of `paths`; without any, those are drawn that the scene names in `[run] paths`, or else the first eight of
        points that move: named points stand before pins, mass centres and ends of rods.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If there is no such point, or the run has no reported time.
        """
        from governor_mechanism.render.figures.kinematics import path_figure

        return path_figure(self.scene.title, self.paths, points or self.scene.run.paths)

    def plot_reactions(self, *joints: str, axes: str = "plane") -> Figure:
        """Draw the forces of joints as polar plots: the curve of the tip of the force on the second body, to one scale on both axes.

        The positional arguments are names of joints; without any, all whose force a rigid model determines, of which six are drawn.

        Parameters
        ----------
        axes
            "plane" for components along the axes of the plane, "body" for those along the axes of the second body of the joint.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If there is no such joint, a rigid model does not determine its force, or the run has no reported time.
        """
        from governor_mechanism.render.figures.kinematics import joint_force_figure

        return joint_force_figure(self, joints, axes)

    @show_film_options
    def film(
        self, path: str | os.PathLike[str], *, progress: Callable[[int, int], None] | None = None, **options: Unpack[FilmKeywords]
    ) -> Film:
        """Write the run as an animation and return its file, which a notebook shows.

        `gm.film` documents the parameters and errors.
        """
        from governor_mechanism.notebook.result_table import film_run

        return film_run(self, path, progress=progress, **options)

    def save_dxf(
        self, path: str | os.PathLike[str], *, time: float | str | None = None, paths: Sequence[str] | None = None, part: str | None = None
    ) -> Path:
        """Write the mechanism in one position as a drawing in DXF, true to scale in millimetres.

        Layers: "ground", "parts" (outlines), "pins" and "paths" (whole curves over the run).

        Parameters
        ----------
        path
            The file, which ends in .dxf.
        time
            Time of the position, s, or text with a unit; the start if None.
        paths
            Names of points, as `paths` names them; those that the scene names in `[run] paths` if None.
        part
            Name of the part, in a scene of several.

        Returns
        -------
        Path
            Path of the file.

        Raises
        ------
        MechanismError
            If an argument is not valid, ezdxf is not installed, the file cannot be written, or the run has no reported time.
        """
        from governor_mechanism.render.dxf import write_dxf

        return write_dxf(self, path, time=time, paths=paths, part=part)

    def save(
        self,
        folder: str | os.PathLike[str],
        *,
        name: str | None = None,
        figures: bool = True,
        figure_formats: Sequence[str] = ("png",),
        theme: str = "light",
        film: str | None = None,
        film_options: FilmOptions | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> tuple[Path, ...]:
        """Write readings (CSV), all arrays (netCDF), a record (JSON) and figures into a folder: all files or none.

        `gm.open_run(folder)` reads the run back.

        Parameters
        ----------
        folder
            The folder. It is created unless it exists.
        name
            Start of the names of the files; that of the scene if None.
        figures
            Whether to draw the figures.
        figure_formats
            Formats of the figures: "png", "svg", "pdf".
        theme
            Colours of the figures: "light", "dark", or "transparent" (without the paper).
        film
            "gif", "svg", "mp4" or "webm" for a film, too, or "html" for an interactive page.
        film_options
            Options of the film, as `gm.FilmOptions(size=720, stop="2 s")`; their defaults if None.
        progress
            Called with the numbers of frames done and of all.

        Returns
        -------
        tuple of Path
            Paths of the files.

        Raises
        ------
        MechanismError
            If an argument is not valid, a file cannot be written, or the run has no reported time.
        """
        from governor_mechanism.render.results_folder import save_run

        return save_run(
            self,
            folder,
            name=name,
            figures=figures,
            figure_formats=figure_formats,
            theme=theme,
            film=film,
            film_options=film_options,
            progress=progress,
        )

    def _repr_html_(self) -> str:
        """Return what a notebook shows: outcome, accuracy, and a row for each reading."""
        from governor_mechanism.notebook.result_table import run_html

        return run_html(self)
