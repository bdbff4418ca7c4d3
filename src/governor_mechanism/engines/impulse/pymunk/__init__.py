"""A mechanism as pymunk bodies, joints and loads: the only package that imports pymunk.

A Chipmunk step moves positions with the old velocities, then applies forces, then solves the joints. So velocities live
at half steps: with joint errors removed completely in each step, and loads taken at the pose the step is about to
reach, that is a second-order SHAKE/Verlet scheme. Used in the plain way, with pymunk's defaults, it is first order.
"""

from __future__ import annotations

from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.pymunk.step_inputs import StepInputs

__all__ = ["PymunkModel", "StepInputs"]
