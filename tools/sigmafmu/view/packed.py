"""Numbers for the page, small: integers that differ little from their neighbours, compressed, as text.

A column of floats becomes bias + step · integers, the integers become differences, their four bytes four streams. The
page (tools/viewer/src/packed.js) undoes it.
"""

import base64
import zlib

import numpy as np

FINE = 1 / 65535
"""Step of a column, as a part of its range, where nothing else is asked for."""


class Packed:
    """Collects arrays; each gets a ticket with which the page finds it."""

    def __init__(self):
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: np.ndarray, step: float | None = None) -> dict[str, object]:
        """Put in an array (n or n × k) to within half a step; by default `FINE` of each column's range.

        The ticket has the first byte, rows, and the biases and steps of all columns.
        """
        columns = np.asarray(values, dtype=float).reshape(len(values), -1).T
        low = columns.min(axis=1, initial=np.inf) if columns.shape[1] else np.zeros(len(columns))
        span = columns.max(axis=1, initial=-np.inf) - low if columns.shape[1] else np.zeros(len(columns))
        steps = np.maximum(span * FINE, 1e-300) if step is None else np.maximum(step, span / 2.0**30)
        whole = np.round((columns - low[:, None]) / steps[:, None]).astype(np.int32)
        differences = np.diff(whole, axis=1, prepend=0).astype("<i4")
        # small numbers of both signs become small positive ones
        zigzag = ((differences << 1) ^ (differences >> 31)).astype("<u4")
        part = zigzag.ravel().view(np.uint8).reshape(-1, 4).T.tobytes()
        ticket = {"at": self._size, "n": columns.shape[1], "bias": low.tolist(), "step": steps.tolist()}
        self._parts.append(part)
        self._size += len(part)
        return ticket

    def text(self) -> str:
        """All arrays in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode()
