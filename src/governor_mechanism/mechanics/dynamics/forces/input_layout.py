"""Where the inputs of a scene stand in the one vector that all kernels read."""

from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.mechanics.dynamics.forces.contacts import Contact
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import NO_INDEX


@dataclass(frozen=True)
class InputLayout:
    """Slices of the inputs, in their order.

    `further` are the factors of loads and what lags follow: as functions of time they are zero. `friction_inputs` has the
    friction limit of each contact, or NO_INDEX.
    """

    spindle_speeds: slice
    drives: slice
    element_loads: slice
    friction_limits: slice
    further: slice
    friction_inputs: tuple[int, ...]

    @property
    def loads(self) -> slice:
        """Inputs of `loads_of`: the loads of force elements, then the friction limits."""
        return slice(self.element_loads.start, self.friction_limits.stop)

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return int(self.further.stop)


def make_input_layout(loads: Sequence[InputFunction], contacts: Sequence[Contact], n_spindle_speeds: int, n_drives: int) -> InputLayout:
    """Return the layout of given spindle speeds, drives and the loads of a scene, of which the last ones are friction limits."""
    has_friction = [contact.friction is not None for contact in contacts]
    n_frictions = sum(has_friction)
    spindle_speeds = slice(0, n_spindle_speeds)
    drives = _slice_behind(spindle_speeds, n_drives)
    element_loads = _slice_behind(drives, len(loads) - n_frictions)
    friction_limits = _slice_behind(element_loads, n_frictions)
    limits = iter(range(friction_limits.start, friction_limits.stop))
    return InputLayout(
        spindle_speeds=spindle_speeds,
        drives=drives,
        element_loads=element_loads,
        friction_limits=friction_limits,
        further=_slice_behind(friction_limits, sum(map(_count_further, loads))),
        friction_inputs=tuple(next(limits) if has_one else NO_INDEX for has_one in has_friction),
    )


def _slice_behind(before: slice, count: int) -> slice:
    return slice(before.stop, before.stop + count)


def _count_further(load: InputFunction) -> int:
    """Return how many inputs the functions of a load need: each factor has one, and each lag one that it follows."""
    n_lags = sum(bool(function.lag) for function in (*load.functions, *load.factors))
    return len(load.factors) + n_lags
