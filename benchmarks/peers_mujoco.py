"""Cases of `peers.py` for MuJoCo: generalised coordinates, links as tendons of constant length.

Arms and flywheel are hinges, sleeve and slider are slides, so that only the links need the constraint solver. With the balls on
slides of their own and tendons for the arms as well, errors are a third larger and a step costs a tenth more.
In the plane of a spindle at constant speed the centrifugal force is a spring of negative stiffness between the balls. If the speed
changes, the spindle rotates in space, with such a large inertia that the governor does not change its speed; at constant speed
that gives the same angles and takes a twentieth longer.

Constraints are compliant. The derivative of the Jacobian is neglected, so the error is proportional to the square of the time
constant. The time constant is at least two steps (`solref`) unless `refsafe` is off. RK4 is stable at one step with half the damping,
with errors thirteen times smaller; shorter time constants or less damping do not improve it. Projected Gauss-Seidel converges in
eight sweeps, or in 20 with friction, and costs less than one Newton step. Euler and the implicit integrators are of first order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import mujoco
import numpy as np

from governor_mechanism.types import FloatArray
from peers_cases import GRAVITY, INTERVALS, Case, Governor, Method, SliderCrank

# A failed coarse step shows in its error; this prevents a log file.
mujoco.set_mju_user_warning(lambda _: None)

VERSION = f"MuJoCo {mujoco.__version__}"
LADDER = tuple(2**k for k in range(13))

POINT_INERTIA = 'diaginertia="1e-13 1e-13 1e-13"'
"""Inertia of a point mass; MuJoCo requires a positive value."""

SPINDLE_INERTIA = 1e9
"""Moment of inertia of a spindle with a given speed (kg m2)."""

DISABLED_STAGES = ("sensor", "limit", "damper", "midphase", "island", "filterparent", "autoreset", "nativeccd", "clampctrl",
          "actuation", "eulerdamp")  # fmt: skip
"""Stages of a step that these models do not need."""


@dataclass(frozen=True, kw_only=True)
class ConstraintSettings:
    """Constraint settings: time constant in steps, damping ratio, and solver."""

    constant: float = 2.0
    damping: float = 1.0
    solver: str = "PGS"
    iterations: int = 8
    disabled: tuple[str, ...] = ()

    def option(self, step: float) -> str:
        """Return the element that sets integrator and solver."""
        flags = " ".join(f'{name}="disable"' for name in ("contact", *self.disabled))
        return (
            f'<compiler angle="radian" boundmass="0" boundinertia="0"/><option timestep="{step!r}" integrator="RK4" '
            f'gravity="0 0 {-GRAVITY}" solver="{self.solver}" iterations="{self.iterations}" tolerance="0" '
            f'jacobian="dense"><flag {flags}/></option>'
        )

    def equality_attributes(self, step: float) -> str:
        """Return the attributes of a constraint."""
        return f'solref="{self.constant * step!r} {self.damping!r}" solimp="0.9999 0.9999 0.001 0.5 2"'

    def friction_attributes(self, step: float) -> str:
        """Return the attributes of dry friction."""
        return f'solreffriction="{self.constant * step!r} {self.damping!r}" solimpfriction="0.9999 0.9999 0.001 0.5 2"'


SAFE = ConstraintSettings(disabled=DISABLED_STAGES)
BEST = ConstraintSettings(constant=1.0, damping=0.5, disabled=("refsafe", *DISABLED_STAGES))


def methods(case: Case) -> tuple[Method, ...]:
    """Return the shortest time constant that MuJoCo accepts by default, and the shortest one that RK4 tolerates."""
    rubs = isinstance(case.model, Governor) and case.model.friction > 0
    tunings = {"MuJoCo, RK4, solref of two steps": SAFE, "MuJoCo, RK4, solref of one step, half damping": BEST}
    return tuple(
        Method(name=name, prepare=partial(prepare_run, case, replace(one, iterations=20 if rubs else 8)), ladder=LADDER)
        for name, one in tunings.items()
    )


def prepare_run(case: Case, tuning: ConstraintSettings, steps: int) -> Callable[[], FloatArray]:
    """Return the compiled model and its run function."""
    step = case.interval / steps
    if isinstance(case.model, SliderCrank):
        return build_slider_crank(case.model, tuning, step, steps)
    return build_governor(case, case.model, tuning, step, steps)


def build_governor(case: Case, shape: Governor, tuning: ConstraintSettings, step: float, steps: int) -> Callable[[], FloatArray]:
    """Build arms on hinges, the sleeve on a slide, links as tendons."""
    ramps = [(begin, end) for begin, end in pairwise(shape.speeds) if begin[0] < end[0]]
    across, down = shape.arm * math.sin(shape.angle), -shape.arm * math.cos(shape.angle)
    arms = "".join(
        f'<body pos="{side * shape.offset} 0 0"><joint type="hinge" axis="0 {-side} 0"/>'
        f'<inertial mass="{shape.ball_mass}" pos="{side * across} 0 {down}" {POINT_INERTIA}/>'
        f'<site name="ball{side}" pos="{side * across} 0 {down}"/></body>'
        for side in (1, -1)
    )
    rubs = f'frictionloss="{shape.friction}" {tuning.friction_attributes(step)}' if shape.friction else ""
    lugs = "".join(f'<site name="lug{side}" pos="{side * shape.offset} 0 0"/>' for side in (1, -1))
    sleeve = (
        f'<body pos="0 0 {2 * down}"><joint type="slide" axis="0 0 1" {rubs}/>'
        f'<inertial mass="{shape.sleeve_mass}" pos="0 0 0" {POINT_INERTIA}/>{lugs}</body>'
    )
    bodies, pull, first = arms + sleeve, "", 0
    if ramps:
        turning = f'<joint type="hinge" axis="0 0 1" armature="{SPINDLE_INERTIA}"/><inertial mass="1" pos="0 0 0" {POINT_INERTIA}/>'
        bodies, first = f"<body>{turning}{bodies}</body>", 1
    else:
        stiffness = -0.5 * shape.ball_mass * shape.speeds[0][1] ** 2
        ends = '<site site="ball1"/><site site="ball-1"/>'
        pull = f'<spatial stiffness="{stiffness!r}" springlength="0">{ends}</spatial>'
    links = "".join(f'<spatial name="link{side}"><site site="ball{side}"/><site site="lug{side}"/></spatial>' for side in (1, -1))
    holds = "".join(f'<tendon tendon1="link{side}" {tuning.equality_attributes(step)}/>' for side in (1, -1))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco>{tuning.option(step)}<worldbody>{bodies}</worldbody><tendon>{links}{pull}</tendon><equality>{holds}</equality></mujoco>"
    )
    data, slopes = mujoco.MjData(model), np.zeros(INTERVALS)
    for (begin, low), (end, high) in ramps:
        slopes[(case.times[:-1] >= begin - 1e-9) & (case.times[:-1] < end - 1e-9)] = (high - low) / (end - begin)

    def run() -> FloatArray:
        """Run once and return the angles."""
        mujoco.mj_resetData(model, data)
        angles, coordinates, pushes = np.empty(INTERVALS + 1), data.qpos, data.qfrc_applied
        angles[0] = 0.0
        if ramps:
            data.qvel[0] = shape.speeds[0][1]
        for k in range(INTERVALS):
            if ramps:
                pushes[0] = SPINDLE_INERTIA * slopes[k]
            mujoco.mj_step(model, data, steps)
            angles[k + 1] = coordinates[first]
        return shape.angle + angles

    return run


def build_slider_crank(shape: SliderCrank, tuning: ConstraintSettings, step: float, steps: int) -> Callable[[], FloatArray]:
    """Build the flywheel on a hinge, the slider on a slide, the rod as a tendon."""
    along, up = math.cos(shape.angle), math.sin(shape.angle)
    inertia = shape.flywheel_inertia
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco>{tuning.option(step)}<worldbody><body><joint type="hinge" axis="0 -1 0"/>'
        f'<inertial mass="{shape.flywheel_mass}" pos="{shape.centre * along} 0 {shape.centre * up}" '
        f'diaginertia="{inertia} {inertia} {inertia}"/>'
        f'<site name="pin" pos="{shape.crank * along} 0 {shape.crank * up}"/></body>'
        f'<body pos="{shape.slider} 0 0"><joint type="slide" axis="1 0 0"/>'
        f'<inertial mass="{shape.slider_mass}" pos="0 0 0" {POINT_INERTIA}/><site name="slider" pos="0 0 0"/></body>'
        '</worldbody><tendon><spatial name="rod"><site site="pin"/><site site="slider"/></spatial></tendon>'
        f'<equality><tendon tendon1="rod" {tuning.equality_attributes(step)}/></equality></mujoco>'
    )
    data = mujoco.MjData(model)

    def run() -> FloatArray:
        """Run once and return the angles."""
        mujoco.mj_resetData(model, data)
        data.qvel[:] = shape.rate, shape.slider_rate
        data.qfrc_applied[1] = shape.force
        angles, coordinates = np.empty(INTERVALS + 1), data.qpos
        angles[0] = 0.0
        for k in range(INTERVALS):
            mujoco.mj_step(model, data, steps)
            angles[k + 1] = coordinates[0]
        return shape.angle + angles

    return run
