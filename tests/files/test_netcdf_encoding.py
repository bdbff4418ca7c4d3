"""Files of the classic netCDF format, read back by scipy."""

import io
from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.io import netcdf_file

from governor_mechanism.files.netcdf_encoding import encode_netcdf


@dataclass
class StandIn:
    name: str
    dimensions: tuple[str, ...]
    values: np.ndarray
    attributes: dict = field(default_factory=dict)


@pytest.mark.parametrize("n", range(1, 6))
def test_scipy_reads_what_was_written(n):
    values = np.linspace(-1.0, 1e300, 3 * n).reshape(3, n)
    variables = [
        StandIn("number", (), np.array(np.pi)),
        StandIn("flags", ("n",), np.arange(n, dtype=np.int8), {"flag_values": np.array([0, 1], dtype=np.int8), "meaning": ""}),
        StandIn("across", ("n", "three"), values.T, {"units": "m" * n}),  # not contiguous
        StandIn("letters", ("n", "two"), np.full((n, 2), b"x", dtype="S1"), {"long_name": "é"}),
        StandIn("integers", ("three",), np.array([1, -2, 2**31 - 1], dtype=np.int32), {"scale": np.array(0.5)}),
    ]
    content = encode_netcdf({"title": "Größe" * n, "version": np.array([3], dtype=np.int32)}, variables)
    with netcdf_file(io.BytesIO(content), mmap=False) as dataset:
        assert dataset.title.decode() == "Größe" * n
        assert dataset.version == 3
        assert dataset.dimensions == {"n": n, "three": 3, "two": 2}
        assert list(dataset.variables) == [variable.name for variable in variables]
        for variable in variables:
            found = dataset.variables[variable.name]
            assert found.dimensions == variable.dimensions
            np.testing.assert_array_equal(np.asarray(found.data), variable.values)
            assert found._attributes.keys() == variable.attributes.keys()
        assert dataset.variables["across"].units == b"m" * n
        assert dataset.variables["flags"].meaning == b""
        assert dataset.variables["letters"].long_name.decode() == "é"
        assert list(dataset.variables["flags"].flag_values) == [0, 1]
        assert dataset.variables["integers"].scale == 0.5


def test_types_that_the_format_has_not_are_refused():
    with pytest.raises(KeyError):
        encode_netcdf({}, [StandIn("wide", ("n",), np.arange(3))])
