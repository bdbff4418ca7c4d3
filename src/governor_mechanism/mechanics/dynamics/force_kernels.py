"""Force laws as compiled kernels, for calls from other kernels."""

from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.numerics.jit import jit_internal

centrifugal_force_jit = jit_internal(force_laws.centrifugal_force)
centrifugal_moment_jit = jit_internal(force_laws.centrifugal_moment)
damper_force_jit = jit_internal(force_laws.damper_force)
spindle_inertia_rate_jit = jit_internal(force_laws.spindle_inertia_rate)
spindle_inertia_jit = jit_internal(force_laws.spindle_inertia)
spring_force_jit = jit_internal(force_laws.spring_force)
weight_jit = jit_internal(force_laws.weight)
