"""Order of the constraint rows: rows of a common body stand near each other, and no band is wider than that."""

from itertools import combinations

import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.dynamics.arrays import make_system_workspace
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.model.joints import Distance
from scene_parts import body_point, ground_point, make_mechanism, point_mass, scene_of, x_reading


def chain(n_links: int) -> gm.Scene:
    """Return balls that hang on each other by links."""
    ends = [ground_point(), *(body_point(f"ball {k}") for k in range(n_links))]
    links = [Distance(name=f"link {k}", first=ends[k], second=ends[k + 1], length=0.2) for k in range(n_links)]
    sketch = [(0.0, -0.2 * (k + 1), 0.0) for k in range(n_links)]
    balls = [point_mass(end.body, 1.0) for end in ends[1:]]
    return scene_of(make_mechanism(balls, links, [x_reading("ball 0")], sketch, size=0.2))


@pytest.mark.parametrize("scene", [chain(1), chain(2), chain(6), *map(gm.load, ("porter", "four_bar_chain", "andrews_squeezer"))])
def test_the_band_holds_every_pair_of_rows_with_a_common_body_and_no_more(scene):
    system = make_system(scene)[0]
    bodies = [set(row) - {-1} for row in system.constraint_rows.row_bodies.tolist()]
    distances = [k - i for (i, first), (k, second) in combinations(enumerate(bodies), 2) if first & second]
    assert system.bandwidth == max(distances, default=0)
    assert make_system_workspace(system).band.shape == (len(bodies), system.bandwidth + 1)


def test_rows_of_a_chain_have_neighbours_alone():
    assert make_system(chain(6))[0].bandwidth == 1
