"""The cases of `peers.py` for MuJoCo: generalised coordinates, links as tendons of constant length.

Arms and flywheel are hinges, sleeve and slider slides, so that only the links are left to the constraint solver; with
the balls on slides of their own and tendons for the arms as well, errors are a third larger and steps a tenth dearer.
In the plane that turns with a steady spindle the centrifugal pull is a spring of negative stiffness between the
balls. Where the speed changes the spindle turns in space, with so much inertia that the governor does not change its
speed; for steady speeds that gives the same angles, a twentieth slower.

A constraint gives way: the change of its Jacobian is left out, so the error falls with the square of its time
constant. That is two steps at least (`solref`) unless `refsafe` is off; RK4 bears one step at half the damping, and
errors are a thirteenth of those; still shorter or less damped it gains no more. Projected Gauss-Seidel converges in
eight sweeps, or in 20 where something rubs, cheaper than one step of Newton. Euler and the implicit integrators are
first order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import mujoco
import numpy as np

from peers_cases import GRAVITY, INTERVALS, Case, FloatArray, Governor, SliderCrank, Way

# A coarse step that fails is seen in its error; without this a log file would tell it as well.
mujoco.set_mju_user_warning(lambda _: None)

VERSION = f"MuJoCo {mujoco.__version__}"
LADDER = tuple(2**k for k in range(13))

POINT = 'diaginertia="1e-13 1e-13 1e-13"'
"""MuJoCo asks for some inertia of every body."""

HEAVY = 1e9
"""Moment of inertia of a spindle whose speed is given (kg m2)."""

UNUSED = ("sensor", "limit", "damper", "midphase", "island", "filterparent", "autoreset", "nativeccd", "clampctrl",
          "actuation", "eulerdamp")  # fmt: skip
"""Stages of a step with nothing to do here."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """How constraints are held: the solver's time constant in steps, its damping ratio, and what solves."""

    constant: float = 2.0
    damping: float = 1.0
    solver: str = "PGS"
    iterations: int = 8
    disabled: tuple[str, ...] = ()

    def option(self, step: float) -> str:
        """The element that sets integrator and solver."""
        flags = " ".join(f'{name}="disable"' for name in ("contact", *self.disabled))
        return (
            f'<compiler angle="radian" boundmass="0" boundinertia="0"/><option timestep="{step!r}" integrator="RK4" '
            f'gravity="0 0 {-GRAVITY}" solver="{self.solver}" iterations="{self.iterations}" tolerance="0" '
            f'jacobian="dense"><flag {flags}/></option>'
        )

    def held(self, step: float) -> str:
        """The attributes of a constraint."""
        return f'solref="{self.constant * step!r} {self.damping!r}" solimp="0.9999 0.9999 0.001 0.5 2"'

    def rubbing(self, step: float) -> str:
        """Those of dry friction."""
        return f'solreffriction="{self.constant * step!r} {self.damping!r}" solimpfriction="0.9999 0.9999 0.001 0.5 2"'


SAFE = Tuning(disabled=UNUSED)
BEST = Tuning(constant=1.0, damping=0.5, disabled=("refsafe", *UNUSED))


def ways(case: Case) -> tuple[Way, ...]:
    """As short a time constant as MuJoCo takes of itself, and as short a one as RK4 bears."""
    rubs = isinstance(case.model, Governor) and case.model.friction > 0
    tunings = {"MuJoCo, RK4, solref of two steps": SAFE, "MuJoCo, RK4, solref of one step, half damped": BEST}
    return tuple(
        Way(name=name, prepare=partial(prepared, case, replace(one, iterations=20 if rubs else 8)), ladder=LADDER)
        for name, one in tunings.items()
    )


def prepared(case: Case, tuning: Tuning, steps: int) -> Callable[[], FloatArray]:
    """The model built, and what runs it."""
    step = case.interval / steps
    if isinstance(case.model, SliderCrank):
        return slider_crank(case.model, tuning, step, steps)
    return governor(case, case.model, tuning, step, steps)


def governor(case: Case, shape: Governor, tuning: Tuning, step: float, steps: int) -> Callable[[], FloatArray]:
    """Arms on hinges, the sleeve on a slide, links as tendons."""
    ramps = [(begin, end) for begin, end in pairwise(shape.speeds) if begin[0] < end[0]]
    across, down = shape.arm * math.sin(shape.angle), -shape.arm * math.cos(shape.angle)
    arms = "".join(
        f'<body pos="{side * shape.offset} 0 0"><joint type="hinge" axis="0 {-side} 0"/>'
        f'<inertial mass="{shape.ball_mass}" pos="{side * across} 0 {down}" {POINT}/>'
        f'<site name="ball{side}" pos="{side * across} 0 {down}"/></body>'
        for side in (1, -1)
    )
    rubs = f'frictionloss="{shape.friction}" {tuning.rubbing(step)}' if shape.friction else ""
    lugs = "".join(f'<site name="lug{side}" pos="{side * shape.offset} 0 0"/>' for side in (1, -1))
    sleeve = (
        f'<body pos="0 0 {2 * down}"><joint type="slide" axis="0 0 1" {rubs}/>'
        f'<inertial mass="{shape.sleeve_mass}" pos="0 0 0" {POINT}/>{lugs}</body>'
    )
    bodies, pull, first = arms + sleeve, "", 0
    if ramps:
        turning = f'<joint type="hinge" axis="0 0 1" armature="{HEAVY}"/><inertial mass="1" pos="0 0 0" {POINT}/>'
        bodies, first = f"<body>{turning}{bodies}</body>", 1
    else:
        stiffness = -0.5 * shape.ball_mass * shape.speeds[0][1] ** 2
        ends = '<site site="ball1"/><site site="ball-1"/>'
        pull = f'<spatial stiffness="{stiffness!r}" springlength="0">{ends}</spatial>'
    links = "".join(f'<spatial name="link{side}"><site site="ball{side}"/><site site="lug{side}"/></spatial>' for side in (1, -1))
    holds = "".join(f'<tendon tendon1="link{side}" {tuning.held(step)}/>' for side in (1, -1))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco>{tuning.option(step)}<worldbody>{bodies}</worldbody><tendon>{links}{pull}</tendon><equality>{holds}</equality></mujoco>"
    )
    data, slopes = mujoco.MjData(model), np.zeros(INTERVALS)
    for (begin, low), (end, high) in ramps:
        slopes[(case.times[:-1] >= begin - 1e-9) & (case.times[:-1] < end - 1e-9)] = (high - low) / (end - begin)

    def run() -> FloatArray:
        mujoco.mj_resetData(model, data)
        angles, coordinates, pushes = np.empty(INTERVALS + 1), data.qpos, data.qfrc_applied
        angles[0] = 0.0
        if ramps:
            data.qvel[0] = shape.speeds[0][1]
        for k in range(INTERVALS):
            if ramps:
                pushes[0] = HEAVY * slopes[k]
            mujoco.mj_step(model, data, steps)
            angles[k + 1] = coordinates[first]
        return shape.angle + angles

    return run


def slider_crank(shape: SliderCrank, tuning: Tuning, step: float, steps: int) -> Callable[[], FloatArray]:
    """The flywheel on a hinge, the slider on a slide, the rod as a tendon."""
    along, up = math.cos(shape.angle), math.sin(shape.angle)
    inertia = shape.flywheel_inertia
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco>{tuning.option(step)}<worldbody><body><joint type="hinge" axis="0 -1 0"/>'
        f'<inertial mass="{shape.flywheel_mass}" pos="{shape.centre * along} 0 {shape.centre * up}" '
        f'diaginertia="{inertia} {inertia} {inertia}"/>'
        f'<site name="pin" pos="{shape.crank * along} 0 {shape.crank * up}"/></body>'
        f'<body pos="{shape.slider} 0 0"><joint type="slide" axis="1 0 0"/>'
        f'<inertial mass="{shape.slider_mass}" pos="0 0 0" {POINT}/><site name="slider" pos="0 0 0"/></body>'
        '</worldbody><tendon><spatial name="rod"><site site="pin"/><site site="slider"/></spatial></tendon>'
        f'<equality><tendon tendon1="rod" {tuning.held(step)}/></equality></mujoco>'
    )
    data = mujoco.MjData(model)

    def run() -> FloatArray:
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
