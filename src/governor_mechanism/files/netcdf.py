"""Write a run as netCDF, and read the arrays of a saved run."""

import hashlib
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.files.plain_values import plain_value
from governor_mechanism.files.run_dataset import RunVariable, run_attributes, run_variables
from governor_mechanism.model.results.trajectory import Trajectory

FORMAT_VERSION: Final = 1
"""Version of the files of runs. It changes with what `read_netcdf` needs."""

_VERSION_NAME, _RECORD_NAME, _DIGEST_NAME = "governor_mechanism_format", "governor_mechanism_record", "governor_mechanism_sha256"
"""Attributes: version of the format, what is no array as JSON, and the digest of the file."""

_NO_DIGEST: Final = b"0" * 64
"""What stands in place of the digest while it is computed."""

_TEXT_ENCODING: Final = "utf-8"

_ATTRIBUTE_HEADER_SIZE: Final = 8
"""Bytes between name and value of an attribute in a netCDF-3 file: type and number of letters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SavedArrays:
    """What a netCDF file of a run holds.

    Attributes
    ----------
    arrays
        Arrays by the names of their variables; texts as lists.
    long_names
        Long names of the variables by name.
    record
        What is no array, in the types of JSON.
    document
        Document of the scene; empty if it has none.
    """

    arrays: Mapping[str, Any]
    long_names: Mapping[str, str]
    record: Mapping[str, Any]
    document: Mapping[str, Any]


def write_netcdf(run: Trajectory, record: Mapping[str, Any], path: Path) -> None:
    """Write all arrays of a run as netCDF-3 by the CF conventions, with units and long names.

    Variables have ASCII names, those of readings with the prefix `reading_` and of their rates `rate_`; the attribute `long_name` is the
    name of the reading. Texts are in UTF-8.
    """
    from scipy.io import netcdf_file  # slow to import

    with atomic_write(path) as temporary:
        with netcdf_file(temporary, "w", version=2) as dataset:
            for name, text in run_attributes(run).items():
                setattr(dataset, name, text.encode(_TEXT_ENCODING))
            program = record["versions"]["governor-mechanism"]
            dataset.history = f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} written by governor_mechanism {program}".encode()
            setattr(dataset, _VERSION_NAME, np.int32(FORMAT_VERSION))
            setattr(dataset, _RECORD_NAME, json.dumps(plain_value(record), allow_nan=False, ensure_ascii=False).encode(_TEXT_ENCODING))
            setattr(dataset, _DIGEST_NAME, _NO_DIGEST)
            for variable in run_variables(run):
                _write_variable(dataset, variable)
        content = temporary.read_bytes()
        at = _find_digest(content)
        with temporary.open("r+b") as stream:
            stream.seek(at)
            stream.write(hashlib.sha256(content).hexdigest().encode())


def read_netcdf(path: Path) -> SavedArrays:
    """Read the netCDF file of a saved run.

    Result: arrays and record. Raises MechanismError if the file cannot be read, is not that of a run, is
    damaged, or has another version.
    """
    from scipy.io import netcdf_file  # slow to import

    try:
        content = path.read_bytes()
    except OSError as error:
        raise MechanismError(f"cannot read {path}: {error.strerror or error}") from error
    at = _find_digest(content)
    if not content.startswith(b"CDF") or at < 0:
        raise MechanismError(
            f"{path} is no netCDF file of a run in this format; give the folder or the .nc file that `run --out` or run.save wrote, and "
            "simulate a run again that an earlier version wrote"
        )
    digest, length = content[at : at + len(_NO_DIGEST)], len(_NO_DIGEST)
    if hashlib.sha256(content[:at] + _NO_DIGEST + content[at + length :]).hexdigest().encode() != digest:
        raise MechanismError(f"{path} is damaged: its content does not match its digest; copy it again, or simulate the run again")
    with netcdf_file(io.BytesIO(content), mmap=False) as dataset:
        version = int(getattr(dataset, _VERSION_NAME))
        if version != FORMAT_VERSION:
            raise MechanismError(
                f"{path} has version {version} of the format, and this governor_mechanism reads version {FORMAT_VERSION}; open it with the "
                "governor_mechanism that wrote it, or simulate the run again"
            )
        record, document = (json.loads(getattr(dataset, name).decode(_TEXT_ENCODING)) for name in (_RECORD_NAME, "scene"))
        arrays = {name: _native_values(variable) for name, variable in dataset.variables.items()}
        long_names = {name: variable.long_name.decode(_TEXT_ENCODING) for name, variable in dataset.variables.items()}
    return SavedArrays(arrays=arrays, long_names=long_names, record=record, document=document)


def _find_digest(content: bytes) -> int:
    """Return the position of the digest in a file, or -1."""
    at = content.find(_DIGEST_NAME.encode())
    padded_length = -(-len(_DIGEST_NAME) // 4) * 4
    return -1 if at < 0 else at + padded_length + _ATTRIBUTE_HEADER_SIZE


def _write_variable(dataset: Any, variable: RunVariable) -> None:
    """Write an array; texts become characters with a dimension for their longest one."""
    values, dimensions, kind = variable.values, variable.dimensions, variable.values.dtype.char
    if kind == "O":
        texts = [text.encode(_TEXT_ENCODING) for text in values]
        length = max(1, *map(len, texts)) if texts else 1
        values = np.array(texts, dtype=f"S{length}").reshape(-1, 1).view("S1").reshape(len(texts), length)
        dimensions, kind = (*dimensions, f"{variable.name}_letters"), "c"
    for name, size in zip(dimensions, values.shape, strict=True):
        if name not in dataset.dimensions:
            dataset.createDimension(name, size)
    written = dataset.createVariable(variable.name, kind, dimensions)
    written[...] = values
    for name, value in variable.attributes.items():
        setattr(written, name, value.encode(_TEXT_ENCODING) if isinstance(value, str) else value)
    if kind == "c":
        written._Encoding = _TEXT_ENCODING.encode()


def _native_values(variable: Any) -> NDArray[Any] | list[str]:
    """Return the values of a variable in the byte order of the machine; texts as a list."""
    values: NDArray[Any] = variable.data
    if values.dtype.char in "cS":
        return [b"".join(row).rstrip(b"\0").decode(_TEXT_ENCODING) for row in values]
    return values.astype(values.dtype.newbyteorder("="))
