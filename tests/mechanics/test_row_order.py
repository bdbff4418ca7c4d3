"""Order of the constraint rows: rows of a common body stand near each other, and no band is wider than that."""

from __future__ import annotations

from itertools import combinations

import pytest

import governor_mechanism as gm
from coupled_scenes import coupled_scene
from governor_mechanism.mechanics.dynamics.system.arrays import make_system_workspace
from governor_mechanism.mechanics.dynamics.system.lowering import make_system
from governor_mechanism.model.joints import GROUND, Distance, Point
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.part import FIXED_PLANE, Part
from governor_mechanism.model.scene import Scene


def chain(n_links: int) -> Scene:
    """Return balls that hang on each other by links."""
    names = [GROUND, *(f"ball {k}" for k in range(n_links))]
    mechanism = Mechanism(
        bodies=tuple(Body(name=name, mass=1.0, can_rotate=False) for name in names[1:]),
        joints=tuple(
            Distance(name=f"link {k}", first=Point(body=names[k]), second=Point(body=names[k + 1]), length=0.2) for k in range(n_links)
        ),
        readings=(PointCoordinate(name="x", quantity="length", point=Point(body="ball 0"), direction_x=1.0, direction_y=0.0),),
        coordinate="x",
        length_scale=0.2,
        initial_guess=tuple((0.0, -0.2 * (k + 1), 0.0) for k in range(n_links)),
    )
    return coupled_scene(Part(name="chain", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE))


@pytest.mark.parametrize("scene", [chain(1), chain(2), chain(6), *map(gm.load, ("porter", "four_bar_chain", "andrews_squeezer"))])
def test_the_band_holds_every_pair_of_rows_with_a_common_body_and_no_more(scene):
    system = make_system(scene)[0]
    bodies = [set(row) - {-1} for row in system.constraint_rows.row_bodies.tolist()]
    distances = [k - i for (i, first), (k, second) in combinations(enumerate(bodies), 2) if first & second]
    assert system.bandwidth == max(distances, default=0)
    assert make_system_workspace(system).band.shape == (len(bodies), system.bandwidth + 1)


def test_rows_of_a_chain_have_neighbours_alone():
    assert make_system(chain(6))[0].bandwidth == 1
