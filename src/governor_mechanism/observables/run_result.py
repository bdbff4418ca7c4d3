"""Result of a run as an engine returns it, from which its trajectory is made."""

from collections.abc import Callable
from dataclasses import dataclass, field

from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.model.events import Event
from governor_mechanism.model.trajectory import Energy, Outcome
from governor_mechanism.observables.singular_configurations import DenseOutput
from governor_mechanism.observables.state_history import StateHistory
from governor_mechanism.types import FloatArray, IntArray

StateProvider = Callable[[], tuple[StateHistory, tuple[ContactMode, ...], DenseOutput | None]]
"""Function that computes the states and contact modes at the monitor times, and a dense output between them where there is one."""


@dataclass(frozen=True, kw_only=True)
class Observables:
    """Observables at n times.

    Attributes
    ----------
    readings
        Readings by name, SI; shape (n,) each.
    rates
        Rates of the readings by name, SI per second; shape (n,) each.
    units
        Units of the readings by name.
    joint_gap
        Largest constraint violation, m; shape (n,).
    energy
        Energy balance.
    """

    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    units: dict[str, str]
    joint_gap: FloatArray
    energy: Energy


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """Result of an engine's run, from which the trajectory is made.

    Attributes
    ----------
    reported_states
        States at the reported times.
    monitor_states
        States at all monitor times, or a function that computes them.
    observables
        Observables at the reported times.
    outcome
        How the run ended; None while a run that reached its end is not yet compared with the requested accuracy.
    detail
        Details of the outcome, as text.
    step
        Longest step, s, or the last one.
    error_estimate
        Largest error relative to the scales; None without a certificate.
    reading_errors
        Error of each reading, rate, and the joints, SI.
    dense_output
        Motion between the monitor times, where the engine can give it.
    contact_modes
        Contact mode at each monitor time; empty without contacts.
    reported_indices
        Monitor times that are reported.
    contact_events
        Contact events that the engine located.
    n_excluded
        Number of reported times excluded from the error estimate because they are too close to an event.
    """

    reported_states: StateHistory
    monitor_states: StateHistory | StateProvider
    observables: Observables
    outcome: Outcome | None
    detail: str
    step: float = 0.0
    error_estimate: float | None = None
    reading_errors: dict[str, float] = field(default_factory=dict)
    dense_output: DenseOutput | None = None
    contact_modes: tuple[ContactMode, ...] = ()
    reported_indices: slice | IntArray | None = None
    contact_events: tuple[Event, ...] = ()
    n_excluded: int = 0

    @property
    def n_reached(self) -> int:
        """Number of reported times that the run reached."""
        return len(self.reported_states.times)
