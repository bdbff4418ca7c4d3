"""Result of a run: arrays, outcome, energy, error estimate, events and cost."""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import RunFailed
from governor_mechanism.model.events import Event
from governor_mechanism.model.named_values import name_values
from governor_mechanism.model.pictures import Figure, Film
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import DataFrame, Dataset, FloatArray
from governor_mechanism.units.short_repr import short_repr, summarise

FLIGHT_DETAIL = "a body flies away"
"""Cause of the end of a run in which a body leaves every bound; its outcome is LEFT_RANGE."""


class Outcome(Enum):
    """How a run ended. Each value is a sentence for the user."""

    DONE = "ran to the end within the requested accuracy"
    NOT_CERTIFIED = "ran to the end; its accuracy was not certified"
    ACCURACY_MISSED = "ran to the end, but the requested accuracy was not reached; relax it (multibody reaches the highest)"
    LEFT_RANGE = "the mechanism leaves the range in which its description is valid, and the run ends there"
    CONTROL_OUT_OF_RANGE = "a control sets what has a range to a value outside it, and the run ends there"
    SHAFT_STALLED = "the shaft would turn back, and the run ends there"
    DEAD_CENTRE = "the coordinate of the engine has a turning point there; try engine multibody"
    STIFF = "the motion is stiff, and this engine integrates explicitly; try engine multibody"
    STEP_LIMIT = "the run needs more steps than the engine allows; shorten it, slow it, or raise max_steps"
    STALLED = "the integration cannot go on from there"
    BRANCH_UNRESOLVED = "which way the mechanism goes on there is finer than the run resolves; try a higher accuracy or engine multibody"
    JOINT_OPENED = "a joint opened by more than a second-order step explains; try engine multibody"

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and met all requirements."""
        return self in (Outcome.DONE, Outcome.NOT_CERTIFIED)

    def describe(self, detail: str) -> str:
        """Return the outcome as a sentence, after its cause if there is one."""
        return f"{detail}: {self.value}" if detail else self.value


@dataclass(frozen=True, kw_only=True, eq=False)
class Energy:
    """Energies at the reported times, J; shape (n,).

    Attributes
    ----------
    kinetic
        Kinetic energy of the motion in the plane.
    potential
        Potential energy of gravity and springs.
    rotation
        Kinetic energy of the rotation about the spindle, J omega^2 / 2, including that of a free spindle.
    jacobi
        Jacobi integral, constant in an exact run: kinetic + potential - rotation (+ rotation for a free spindle), minus the work of
        drivers, dampers, forces and torques. Its changes are errors.
    dissipated_energy
        Energy that dashpots, dry friction and stops have dissipated since the start.
    scale
        Energy scale of the scene, J.
    """

    kinetic: FloatArray
    potential: FloatArray
    rotation: FloatArray
    jacobi: FloatArray
    dissipated_energy: FloatArray
    scale: float

    __repr__ = short_repr

    def _repr_html_(self) -> str:
        """Return what a notebook shows: a row for each quantity."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    @property
    def drift(self) -> float:
        """Largest change of the Jacobi integral, relative to `scale`."""
        return float(np.max(np.abs(self.jacobi - self.jacobi[0]))) / self.scale if self.jacobi.size else 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Reaction:
    """Reaction of a joint on its second body at its second point, at the reported times.

    The first body takes the opposite force at that point. Gears and racks are different: their first body takes a moment of its own,
    -ratio times that of the second body, or radius times the force along the rack.

    Attributes
    ----------
    force
        Components along the axes of the plane, N; shape (n, 2).
    moment
        Moment, N m, anticlockwise; shape (n,).
    determined
        Whether rigid-body mechanics determines the reaction; shape (n,). False for redundant joints, where it is one of many solutions.
    """

    force: FloatArray
    moment: FloatArray
    determined: NDArray[np.bool_]

    __repr__ = short_repr

    def _repr_html_(self) -> str:
        """Return what a notebook shows: a row for each quantity."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    @property
    def magnitude(self) -> FloatArray:
        """Magnitude of the force, N; shape (n,)."""
        return np.hypot(self.force[:, 0], self.force[:, 1])


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of a run.

    Attributes
    ----------
    engine
        Name of the engine.
    reason
        Reason for the choice of the engine.
    step
        Longest step of the finest run, s, or its last one.
    steps
        Number of steps.
    runs
        Number of runs for the error certificate.
    evaluations
        Number of evaluations by force law, over all runs.
    wall_time
        Time of the simulation without setup_time, s.
    setup_time
        Time to build tables, s.
    rejected
        Number of rejected steps.
    iterations
        Number of iterations of the joint solver, if it iterates.
    method
        Integration method, if the engine has a choice.
    events
        Number of contact events: stick, slip, impact, slack.
    model_size
        Counts of the model, such as bodies and constraints.
    """

    engine: str
    reason: str
    step: float
    steps: int
    runs: int
    evaluations: Mapping[str, int]
    wall_time: float
    setup_time: float = 0.0
    rejected: int = 0
    iterations: int = 0
    method: str = ""
    events: int = 0
    model_size: Mapping[str, int] = field(default_factory=dict)

    __repr__ = short_repr


@dataclass(frozen=True, kw_only=True)
class SpeedFluctuation:
    """Extreme speeds of a shaft in the last complete turn of a run.

    Attributes
    ----------
    lowest, highest
        Lowest and highest speed, rad/s.
    lowest_angle, highest_angle
        Angles at which the shaft has them, rad.
    """

    lowest: float
    highest: float
    lowest_angle: float
    highest_angle: float

    @property
    def mean(self) -> float:
        """Arithmetic mean of both speeds, rad/s."""
        return 0.5 * (self.lowest + self.highest)

    @property
    def coefficient(self) -> float:
        """Coefficient of speed fluctuation, (highest - lowest) / mean."""
        return (self.highest - self.lowest) / self.mean

    def __str__(self) -> str:
        low, high = (f"{speed:.6g} rad/s at {math.degrees(angle) % 360:.4g} deg" for speed, angle in self._extremes)
        return f"in the last turn {low} to {high}, coefficient of speed fluctuation {self.coefficient:.5g}"

    @property
    def _extremes(self) -> tuple[tuple[float, float], ...]:
        return (self.lowest, self.lowest_angle), (self.highest, self.highest_angle)

    def as_json(self) -> dict[str, float]:
        """Return the speeds, angles, mean and coefficient by name."""
        names = ("lowest", "highest", "lowest_angle", "highest_angle", "mean", "coefficient")
        return {name: getattr(self, name) for name in names}


class DeferredResults(Protocol):
    """Results that a motion implies, computed on first access."""

    def reactions(self) -> Mapping[str, Reaction]:
        """Return the reactions by joint name."""

    def events(self) -> tuple[Event, ...]:
        """Return the events in order of time."""

    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Return the extreme speeds of shafts by the reading of their angle."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
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
    settings: Mapping[str, Any] = field(default_factory=dict)
    n_excluded: int = 0
    mobility: int = 1
    notes: tuple[str, ...] = ()
    deferred_results: DeferredResults | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", name_values("reading", self.readings))
        object.__setattr__(self, "rates", name_values("rate", self.rates))

    def __repr__(self) -> str:
        """Return scene, engine, number of reported times, readings and outcome in at most three lines."""
        span = f"{len(self.times)} times to {self.times[-1]:g} s" if len(self.times) else "no times"
        error = "not certified" if self.error_estimate is None else f"error {self.error_estimate:.1g}"
        scene = f"{summarise(self.scene.title)}; {self.cost.engine}"
        return f"Trajectory({scene}; {span}; readings {summarise(self.readings)}; {self.outcome.name}, {error})"

    @cached_property
    def reactions(self) -> Mapping[str, Reaction]:
        """Reactions by joint name, computed on first access."""
        return name_values("joint", {} if self.deferred_results is None else self.deferred_results.reactions())

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time: contact events, turning points and change points. Computed on first access."""
        return () if self.deferred_results is None else self.deferred_results.events()

    @cached_property
    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Extreme speeds in the last turn of each shaft of an engine, by the reading of its angle. Computed on first access."""
        return name_values("shaft angle", {} if self.deferred_results is None else self.deferred_results.speed_fluctuations())

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of `poses`."""
        return tuple(body.name for body in self.scene.mechanism.bodies)

    @property
    def message(self) -> str:
        """Outcome as a sentence, after its cause if there is one."""
        return self.outcome.describe(self.detail)

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
        from governor_mechanism.files.table import make_xarray_dataset

        return make_xarray_dataset(self)

    def to_dataframe(self, *, rates: bool = False) -> DataFrame:
        """Return the readings as a table of pandas with the times as index; `attrs["units"]` has the units.

        Parameters
        ----------
        rates
            Whether the table has columns "rate of ...", too.

        Returns
        -------
        pandas.DataFrame
            The table, SI.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        from governor_mechanism.files.table import tabulate_run

        return tabulate_run(self, rates=rates)

    def plot(self, *readings: str) -> Figure:
        """Draw readings over time, in everyday units; a notebook shows the figure, and `save` writes it as PNG, SVG or PDF.

        The arguments are names of readings, or "rate of ..." for a rate. Without any, all readings are drawn; those that stay constant
        have a line of text.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If there is no such reading, or the run has no reported time.
        """
        from governor_mechanism.render.figures.time_series import readings_figure

        return readings_figure(self, readings)

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

    def film(
        self,
        path: str | os.PathLike[str],
        *,
        size: int = 480,
        frames_per_second: float | None = None,
        part: str | None = None,
        start: float | None = None,
        stop: float | None = None,
        slow_down: float | None = None,
        layout: str = "machine+plots",
        readings: Sequence[str] | None = None,
        theme: str = "light",
        footer: bool = True,
        labels: bool = False,
        forces: bool = False,
        traces: bool = False,
        view: str = "plane",
        exaggerate: float = 1.0,
        progress: Callable[[int, int], None] | None = None,
    ) -> Film:
        """Write the run as an animation, which a notebook shows.

        Parameters
        ----------
        path
            Path of the file: .gif, .svg, .mp4 or .webm with the optional dependency `video`, or .html for an interactive page.
        size
            Height of the film in pixels; at least 320.
        frames_per_second
            Frames per second of film, 1 to 50; chosen by the scene if None.
        part
            Name of the part to show; all parts if None.
        start
            Start of the shown part of the run, s; its first time if None.
        stop
            End of the shown part of the run, s; its last time if None, or the end of its last whole period, or when a governed engine
            has settled.
        slow_down
            Seconds of film per second of the run; chosen by the duration if None.
        layout
            "machine" alone, "machine+plots" in a square, or "wide": 16:9 with the plots beside.
        readings
            Names of up to 4 plotted readings, or "rate of ..."; those that suit the machine if None.
        theme
            Colours: "light" or "dark".
        footer
            Whether the last line states accuracy and engine.
        labels
            Whether the parts and the main angle are named.
        forces
            Whether weights, centrifugal forces, springs and dampers are drawn as arrows.
        traces
            Whether the paths of the mass centres are drawn.
        view
            Of parts that turn with a spindle: "plane" for the turning plane, "outside" for the turning governor from the side, or "both".
        exaggerate
            Magnification of the motion about its mean position, for motions too small to be seen; the plots stay true.
        progress
            Called with the numbers of frames done and of all.

        Returns
        -------
        Film
            The file.

        Raises
        ------
        MechanismError
            If the path or a number is not valid, or ffmpeg is missing for .mp4 or .webm.
        """
        from governor_mechanism.notebook.film import film_run

        return film_run(
            self,
            path,
            size=size,
            frames_per_second=frames_per_second,
            part=part,
            start=start,
            stop=stop,
            slow_down=slow_down,
            layout=layout,
            readings=readings,
            theme=theme,
            footer=footer,
            labels=labels,
            forces=forces,
            traces=traces,
            view=view,
            exaggerate=exaggerate,
            progress=progress,
        )

    def save(
        self,
        folder: str | os.PathLike[str],
        *,
        name: str | None = None,
        figures: bool = True,
        figure_formats: Sequence[str] = ("png",),
        theme: str = "light",
        film: str | None = None,
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

        return save_run(self, folder, name=name, figures=figures, figure_formats=figure_formats, theme=theme, film=film, progress=progress)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: outcome, accuracy, and a row for each reading."""
        from governor_mechanism.notebook.run_table import run_html

        return run_html(self)
