"""Integrate a scene with contacts: locate each event, select the next contact mode, and restart."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.engines.multibody.settings import MultibodySettings
from governor_mechanism.integrators.projected_dop853 import N_COUNTERS, ProjectedDop853, StepLimits
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_events_and_derivative
from governor_mechanism.mechanics.dynamics.lowering import System, count_output_forces
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_FUNCTION_DTYPE
from governor_mechanism.types import FloatArray, IntArray


class _EventLocationError(Exception):
    """The event functions could not be evaluated within a step."""


class IntegrationContext(Protocol):
    """What an event integrator needs from the integrator that owns it."""

    solver: ProjectedDop853
    max_steps: int
    settings: MultibodySettings

    def input_cubics(self, start: float) -> FloatArray:
        """Return the local cubics of the inputs from a time (s) on."""

    def is_out_of_range(self, state: FloatArray) -> bool:
        """Return whether a state is outside the mechanism's limits."""


class EventIntegrator:
    """Integrator of one run with events at one tolerance; counters are those of `projected_dop853`."""

    def __init__(
        self,
        context: IntegrationContext,
        scene_contacts: SceneContacts,
        tolerance: float,
        time_scale: float,
        max_step_ratio: float,
        counters: IntArray,
    ) -> None:
        self._context, self._scene_contacts, self._counters = context, scene_contacts, counters
        self._tolerance, self._time_scale, self._max_step = tolerance, time_scale, max_step_ratio * time_scale
        self._last_event_time, self._n_simultaneous = -np.inf, 0
        self.output_force_counts = np.zeros(3, dtype=np.int64)
        """Evaluations of springs, dashpots and sliding friction along readings."""
        self._simultaneity = context.settings.event_time_tolerance * time_scale

    def restart_after_breakpoint(self, time: float, state: FloatArray) -> None:
        """Select the contact mode again after an input function has a jump or a kink."""
        self._scene_contacts.change_mode(time, state, self._context.input_cubics(time))

    def integrate_segment(
        self,
        span: tuple[float, float],
        output_times: FloatArray,
        state: FloatArray,
        step: float,
        output_states: FloatArray,
        contact_modes: list[ContactMode],
    ) -> tuple[IntegrationStatus, float, int]:
        """Integrate over a span without breakpoints and fill output_states at output_times.

        Returns the status, the last step size (s) and the number of output times reached.
        """
        t, end = span
        n_filled, scene_contacts = 0, self._scene_contacts
        while t < end:
            system, event_bracket = scene_contacts.model[0], np.empty(2)
            outputs = output_times[n_filled:], output_states[n_filled:]
            status, step, n_reached, t_reached = self._integrate(system, (t, end), state, step, outputs, event_bracket)
            contact_modes += [scene_contacts.mode] * n_reached
            n_filled += n_reached
            if status != IntegrationStatus.EVENT:
                return status, step, n_filled
            t = t_reached
            event_time, triggered = self._locate_event(system, t, state, event_bracket)
            if not triggered and event_time - t <= self._simultaneity:  # a false alarm, too close to search again
                event_time = min(end, t + max(step, self._simultaneity))
            outputs = output_times[n_filled:], output_states[n_filled:]
            _, _, n_reached, _ = self._integrate(_without_event_functions(system), (t, event_time), state, event_time - t, outputs)
            contact_modes += [scene_contacts.mode] * n_reached
            n_filled += n_reached
            t = event_time
            if n_filled and self._context.is_out_of_range(output_states[n_filled - 1]):
                return IntegrationStatus.OUT_OF_RANGE, step, n_filled  # events beyond the limits are irrelevant and may never end
            if triggered and not self._is_below_chattering_limit(t):
                return IntegrationStatus.STALLED, step, n_filled
            if triggered:
                scene_contacts.change_mode(t, state, self._context.input_cubics(t), triggered)
            step = min(step, self._context.settings.restart_step_ratio * self._max_step)
        return IntegrationStatus.DONE, step, n_filled

    def _integrate(
        self,
        system: System,
        span: tuple[float, float],
        state: FloatArray,
        step: float,
        outputs: tuple[FloatArray, FloatArray],
        event_bracket: FloatArray | None = None,
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Integrate up to the end of the span or to the step that contains the first event."""
        max_step = self._max_step * (self._context.settings.event_step_ratio if len(system.event_functions) else 1.0)
        if not span[1] > span[0]:
            return IntegrationStatus.DONE, step, 0, span[0]
        evaluations_before = int(self._counters[2])
        model, cubics = (system, self._scene_contacts.model[1]), self._context.input_cubics(span[0])
        limits = StepLimits(self._tolerance, step or max_step, max_step, self._context.max_steps)
        result = self._context.solver.integrate(model, cubics, span, state, limits, self._counters, outputs, event_bracket)
        self._count_output_forces(system, int(self._counters[2]) - evaluations_before)
        return result

    def _locate_event(self, system: System, t: float, state: FloatArray, event_bracket: FloatArray) -> tuple[float, list[int]]:
        """Return the time of the first event after t and the indices of its contacts; none if it proves not to occur.

        state is at t; event_bracket holds the times between which the event was detected.
        """
        low, high = float(event_bracket[0]), float(event_bracket[1])
        try:
            crossing_times = self._find_crossing_times(system, t, state, low, high)
        except _EventLocationError:
            return high, []  # for example at a change point: the step crosses it, and events there are detected again
        if not crossing_times:
            return high, []
        event_time = min(crossing_times.values())
        simultaneous = [k for k, time in crossing_times.items() if time - event_time <= self._simultaneity]
        return event_time, sorted({int(system.event_functions["contact_index"][k]) for k in simultaneous})

    def _find_crossing_times(self, system: System, t: float, state: FloatArray, low: float, high: float) -> dict[int, float]:
        """Return for each event function that is positive at `high` when (s) it crossed zero after `low`."""
        input_cubics, workspace = self._context.input_cubics(t), self._scene_contacts.model[1]

        def event_values_at(time: float) -> FloatArray:
            state_then = self._integrate_without_events(system, (t, time), state, input_cubics)
            return evaluate_events_and_derivative(system, workspace, input_cubics, time - t, state_then)[0]

        values_low, values_high = event_values_at(low), event_values_at(high)
        positive = np.flatnonzero(values_high > 0.0)
        crossing_times, tolerances = dict[int, float](), system.event_functions["tolerance"]
        for k in positive.tolist():

            def event_function(time: float, k: int = k) -> float:
                return float(event_values_at(time)[k])

            begin, end = (
                _find_negative_start(event_function, low, high, min(float(values_low[k]), 0.0), self._context.settings.max_bracket_halvings)
                if values_low[k] >= -float(tolerances[k])
                else (low, high)
            )
            crossing_times[k] = low if begin is None else float(brentq(event_function, begin, end, xtol=1e-15, rtol=1e-15))
        return crossing_times

    def _integrate_without_events(
        self, system: System, span: tuple[float, float], state: FloatArray, input_cubics: FloatArray
    ) -> FloatArray:
        """Return the state at span[1] from that at span[0], without event functions; input_cubics count from span[0]."""
        final_state, counters = state.copy(), np.zeros(N_COUNTERS, dtype=np.int64)
        if span[1] > span[0]:
            model = _without_event_functions(system), self._scene_contacts.model[1]
            limits = StepLimits(self._tolerance, span[1] - span[0], self._max_step, self._context.settings.max_event_location_steps)
            status, *_ = self._context.solver.integrate(model, input_cubics, span, final_state, limits, counters)
            self._counters[2:] += counters[2:]
            self._count_output_forces(system, int(counters[2]))
            if status != IntegrationStatus.DONE:
                raise _EventLocationError
        return final_state

    def _count_output_forces(self, system: System, evaluations: int) -> None:
        """Count the evaluations of each kind of force along a reading; sticking friction is not evaluated."""
        self.output_force_counts += evaluations * count_output_forces(system)

    def _is_below_chattering_limit(self, t: float) -> bool:
        """Record an event at t and return whether the number of simultaneous events is below its limit."""
        self._n_simultaneous = self._n_simultaneous + 1 if t - self._last_event_time <= self._simultaneity else 0
        self._last_event_time = t
        return self._n_simultaneous < self._context.settings.max_simultaneous_events


def _find_negative_start(
    event_function: Callable[[float], float], low: float, high: float, threshold: float, max_halvings: int
) -> tuple[float | None, float]:
    """Return a time after low at which an event function is below the threshold, and a later one at which it is positive.

    The first is None if the function rises at once.
    """
    positive_time = high
    for halving in range(1, max_halvings):
        middle = low + (high - low) * 0.5**halving
        value = event_function(middle)
        if value < threshold:
            return middle, positive_time
        positive_time = middle if value > 0.0 else positive_time
    return None, high


def _without_event_functions(system: System) -> System:
    """Return the system without event functions."""
    return system._replace(event_functions=np.zeros(0, dtype=EVENT_FUNCTION_DTYPE))
