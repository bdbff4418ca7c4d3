"""Results that are kept with the object they belong to."""

from dataclasses import dataclass, replace

from governor_mechanism.numerics.once_per_object import once_per_object


@dataclass(frozen=True)
class Disc:
    """A description."""

    radius: float


def test_a_result_is_computed_once_for_each_object_and_each_function():
    calls = []

    @once_per_object
    def area(disc):
        calls.append(disc)
        return 3.0 * disc.radius**2

    @once_per_object
    def diameter(disc):
        return 2.0 * disc.radius

    disc = Disc(2.0)
    assert area(disc) == area(disc) == 12.0
    assert diameter(disc) == 4.0
    assert len(calls) == 1
    assert area(replace(disc, radius=1.0)) == 3.0  # a copy with changes is another object
    assert Disc(2.0) == disc
