"""Records variables of an FMU at communication points: straight from the FMU into rows of an array."""

import ctypes
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave, fmi2ValueReference
from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError

CHUNK_ROWS = 1024
"""Rows that are recorded before they go on to whoever takes them."""
MEMORY_SHARE = 0.5
"""The part of the machine's memory that the rows of a run may take."""

TakeRows = Callable[[Sequence[str], np.ndarray], None]
"""Gets the names of the columns (the first is time) and some rows, which are reused afterwards."""


def check_memory(rows: int, columns: int) -> None:
    """Raise SigmafmuError if such a table takes too much of this machine's memory."""
    needed = rows * columns * np.dtype(float).itemsize
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > MEMORY_SHARE * installed:
        raise SigmafmuError(
            f"{rows} rows of {columns} columns take {needed / 1e9:.3g} GB, and this machine has {installed / 1e9:.3g} "
            "GB of memory; record fewer variables, take longer communication steps, or keep every n-th row"
        )


class _Block:
    """Variables of one FMI type; the FMU writes their values straight into the rows of an array."""

    def __init__(self, slave: FMU2Slave, getter: Callable[..., Any], c_type: Any, references: list[int], rows: int):
        self.values = np.zeros((rows, len(references)), dtype=c_type)
        self._slave, self._getter = slave, getter
        self._references = (fmi2ValueReference * len(references))(*references)
        self._row_type = c_type * len(references)

    def record(self, row: int) -> None:
        target = self._row_type.from_buffer(self.values, row * self.values.strides[0])
        self._getter(self._slave.component, self._references, len(self._references), target)


class Reader:
    """Reads chosen variables of an FMU; it has room for some rows."""

    def __init__(self, slave: FMU2Slave, variables: Sequence[ModelVariable], rows: int = 1):
        self._blocks: list[tuple[list[int], _Block]] = []
        self._columns = len(variables)
        for types, getter, c_type in (
            ({"Real"}, slave.fmi2GetReal, ctypes.c_double),
            ({"Integer", "Enumeration"}, slave.fmi2GetInteger, ctypes.c_int),
            ({"Boolean"}, slave.fmi2GetBoolean, ctypes.c_int),
        ):
            columns = [i for i, v in enumerate(variables) if v.type in types]
            if columns:
                references = [variables[i].valueReference for i in columns]
                self._blocks.append((columns, _Block(slave, getter, c_type, references, rows)))

    def read(self, row: int = 0) -> None:
        """Read the present values into a row."""
        for _, block in self._blocks:
            block.record(row)

    def rows(self, count: int = 1) -> np.ndarray:
        """The first rows, as a new array (count, variables)."""
        result = np.empty((count, self._columns))
        for columns, block in self._blocks:
            result[:, columns] = block.values[:count]
        return result


class Recorder:
    """Values of chosen variables at the communication points, in chunks; keeps every `keep_every`-th row and the last.

    A chunk that is full goes to `on_rows`, so that a run of any length takes no more memory than what is kept of it.
    """

    def __init__(
        self,
        slave: FMU2Slave,
        variables: Sequence[ModelVariable],
        keep_every: int = 1,
        on_rows: TakeRows | None = None,
    ):
        self.names = tuple(v.name for v in variables)
        self._reader = Reader(slave, variables, CHUNK_ROWS)
        self._keep_every, self._on_rows = keep_every, on_rows
        self._times = np.zeros(CHUNK_ROWS)
        self._filled, self._flushed = 0, 0  # rows of the chunk, and before it
        self._kept: list[np.ndarray] = []
        self._last: np.ndarray = np.empty((0, len(variables) + 1))

    def record(self, now: float) -> None:
        """Add a row with the present values."""
        if self._filled == CHUNK_ROWS:
            self._flush()
        self._reader.read(self._filled)
        self._times[self._filled] = now
        self._filled += 1

    def _flush(self) -> None:
        rows = np.column_stack((self._times[: self._filled], self._reader.rows(self._filled)))
        self._kept.append(rows[-self._flushed % self._keep_every :: self._keep_every].copy())
        self._last = rows[-1:]
        if self._on_rows:
            self._on_rows(("time", *self.names), rows)
        self._flushed += self._filled
        self._filled = 0

    def finish(self) -> tuple[np.ndarray, int]:
        """Kept rows, time first, and how many rows there were."""
        if self._filled:
            self._flush()
        if (self._flushed - 1) % self._keep_every:
            self._kept.append(self._last)
        return np.concatenate(self._kept), self._flushed
