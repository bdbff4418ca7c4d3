"""Lowering of a part with one degree of freedom to the arrays of its Lagrangian coefficients."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces.force_elements import lower_outputs
from governor_mechanism.mechanics.dynamics.forces.output_forces import OUTPUT_FORCE_DTYPE, output_force_record
from governor_mechanism.mechanics.dynamics.system.body_records import BODY_DTYPE, make_body_record
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.coordinate_assembly import lower_assembly
from governor_mechanism.mechanics.reduction.node_evaluation import OUTPUT_LIMIT_DTYPE, ReductionArrays
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene


def lower_lagrangian(
    scene: Scene,
    prefix: str,
    part: Part,
    # readings of the part that are evaluated with the coefficients, among them those of the effects
    outputs: Sequence[str],
    effects: Sequence[OutputForce],
) -> ReductionArrays:
    """Lower a part with one degree of freedom to the arrays of its Lagrangian coefficients; gas is left out: its force has kinks.

    The coordinate has no bounds, outputs have no limits, and the spindle speed may change.

    Result: what determines the coefficients.
    """
    mechanism, plane = part.mechanism, next(iter(scene.system.planes), None)
    has_centrifugal_forces = plane is not None and plane.is_loaded
    own_elements = [
        element
        for element in scene.mechanism.force_elements
        if not acts_elsewhere(element, prefix, part) and not isinstance(element, CylinderGas)
    ]
    rows, element_forces = lower_outputs(scene.mechanism, outputs, own_elements, {}, 0)
    first_body = scene.mechanism.body_index(prefix + mechanism.bodies[0].name)
    for side in ("first", "second"):
        rows.table[side] -= np.where(rows.table[side] >= 0, first_body, 0)
    effect_records = [output_force_record(effect, outputs.index(effect.reading)) for effect in effects]
    if effect_records:
        element_forces = np.concatenate([np.array(effect_records, dtype=OUTPUT_FORCE_DTYPE), element_forces])
    return ReductionArrays(
        assembly=lower_assembly(mechanism),
        mass=np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).ravel(),
        bodies=np.array([make_body_record(body, part.gravity, has_centrifugal_forces - 1) for body in mechanism.bodies], dtype=BODY_DTYPE),
        has_centrifugal_forces=has_centrifugal_forces,
        output_rows=rows._replace(row_bodies=bodies_of_rows(rows.table)),
        forces=element_forces,
        n_loads=sum(len(element.loads) for element in own_elements),
        output_scales=np.array([scene.mechanism.output_scale(name) for name in outputs]),
        limits=np.zeros(0, dtype=OUTPUT_LIMIT_DTYPE),
        steady_speed=-1.0,
        time_scale=time_scale(scene),
        low=-math.inf,
        high=math.inf,
        full_turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        is_conservative=False,
    )


def acts_elsewhere(element: ForceElement, prefix: str, part: Part) -> bool:
    """Return whether a force element acts on no body of a part."""
    return {prefix + body.name for body in part.mechanism.bodies}.isdisjoint(element.bodies)
