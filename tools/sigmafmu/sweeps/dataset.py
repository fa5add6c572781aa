"""The finished study as one file that xarray reads: NetCDF 4, or a Zarr store made of it, chunk by chunk."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sigmafmu import SigmafmuError, extras
from sigmafmu.sweeps.job import STATUSES, Chunk, Task
from sigmafmu.sweeps.parts import Parts
from sigmafmu.variables import split_element, vectors

STORED_BYTES = 1 << 19
"""Of the pieces in which a variable is compressed; HDF5 keeps 1 MB of each in memory."""
PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def write(
    path: Path,
    task: Task,
    times: np.ndarray,
    columns: Mapping[str, np.ndarray],
    parts: Parts,
    units: Mapping[str, str],
    attributes: Mapping[str, Any],
) -> None:
    """Put the parts together; the file is there when it is complete."""
    netcdf = parts.folder / "study.nc"
    try:
        _write_netcdf(netcdf, task, times, columns, parts, units, attributes)
        if path.suffix == ".zarr":
            with extras.need("xarray").open_dataset(netcdf, engine="h5netcdf", chunks={}) as data:
                data.to_zarr(path, mode="w", zarr_format=2, consolidated=True)  # 3 has no strings yet
        else:
            netcdf.replace(path)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror or error}") from error


def _write_netcdf(
    path: Path,
    task: Task,
    times: np.ndarray,
    columns: Mapping[str, np.ndarray],
    parts: Parts,
    units: Mapping[str, str],
    attributes: Mapping[str, Any],
) -> None:
    import h5netcdf
    import h5py

    text = h5py.string_dtype()
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"run": parts.runs, "time": len(times)}
        file.attrs.update({**attributes, "coordinates": " ".join(columns)} if columns else attributes)
        file.create_variable("run", ("run",), data=np.arange(parts.runs))
        file.create_variable("time", ("time",), data=times).attrs["units"] = "s"
        for name, column in columns.items():
            kind = text if column.dtype.kind == "U" else column.dtype
            variable = file.create_variable(name, ("run",), kind)
            variable[:] = column.astype(object) if kind is text else column
            variable.attrs["units"] = units[name]

        status = file.create_variable("status", ("run",), np.int8)
        status.attrs["flag_values"] = np.arange(len(STATUSES), dtype=np.int8)
        status.attrs["flag_meanings"] = " ".join(STATUSES)
        message = file.create_variable("message", ("run",), text)
        numbers = []
        for scalar in task.scalars:
            numbers.append(file.create_variable(scalar.name, ("run",), float))
            numbers[-1].attrs["units"] = scalar.units
        curves = []
        for base, elements in vectors(task.kept).items():
            places = [task.kept.index(name) for name in elements]
            dimensions: tuple[str, ...] = ("run", "time")
            if elements != [base]:
                dimensions += (f"{base}_",)
                file.dimensions[f"{base}_"] = len(elements)
                file.create_variable(f"{base}_", (f"{base}_",), data=np.array([_number(name) for name in elements]))
            shape = _piece(parts.runs, len(times), *([len(elements)] if elements != [base] else []))
            variable = file.create_variable(base, dimensions, float, chunks=shape, **PACKED)
            variable.attrs["units"] = units[elements[0]]
            curves.append((variable, places if elements != [base] else places[0]))

        for start, chunk in parts:
            runs = slice(start, start + len(chunk.status))
            _write_chunk(runs, chunk, status, message, numbers, curves)


def _write_chunk(runs: slice, chunk: Chunk, status: Any, message: Any, numbers: list[Any], curves: list[Any]) -> None:
    status[runs] = chunk.status
    message[runs] = np.array(chunk.messages, dtype=object)
    for k, variable in enumerate(numbers):
        variable[runs] = chunk.scalars[:, k]
    for variable, places in curves:
        variable[runs] = chunk.values[:, :, places]


def _number(element: str) -> int:
    split = split_element(element)
    assert split
    return split[1]


def _piece(runs: int, times: int, *elements: int) -> tuple[int, ...]:
    """Shape of a compressed piece: whole runs if they are short, parts of one if they are long."""
    row = 8 * int(np.prod(elements))
    rows = min(times, max(1, STORED_BYTES // row))
    return (min(runs, max(1, STORED_BYTES // (row * rows))), rows, *elements)
