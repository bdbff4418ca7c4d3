"""Linear equations in state-space form, and their frequency response."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.statics.first_order_system import ComplexArray
from governor_mechanism.types import FloatArray
from governor_mechanism.units.short_repr import short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class StateSpace:
    """State-space form x' = A x + B u, y = C x + D u with the names of states, inputs u and outputs y. All in SI."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    __repr__ = short_repr

    def frequency_response(
        self,
        frequencies: Sequence[float] | FloatArray,  # angular frequencies, rad/s; shape (n,)
    ) -> ComplexArray:
        """Return the complex amplitudes of the outputs for unit amplitudes of the inputs.

        Result: amplitudes, SI; shape (n, outputs, inputs). Raises MechanismError if a frequency is exactly
        that of an undamped mode.
        """
        try:
            columns = np.array([np.linalg.solve(1j * float(w) * np.eye(len(self.A)) - self.A, self.B) for w in frequencies])
        except np.linalg.LinAlgError as error:
            raise MechanismError(
                "a frequency is that of an undamped mode, where the response is infinite; take another frequency"
            ) from error
        response: ComplexArray = self.C @ columns.reshape(-1, *self.B.shape) + self.D
        return response
