"""What a worker does: it opens the model once, keeps a live instance in each thread, and goes back to its start."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
import threading
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Worker, WorkerPlugin

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.instance import Instance, SimulationError
from sigmafmu.result import Result
from sigmafmu.signals import Signal
from sigmafmu.sweeps.scalars import Scalar

STATUSES = ("done", "refused", "stopped", "error", "killed")
"""Of a run; its number is the place here. refused: before the start; stopped: on the way; error: in a function of the
user; killed: with its worker."""
NEEDED = ("modelDescription.xml", "binaries", "resources")
"""What of an FMU a run reads."""

Inputs = Mapping[str, Signal] | Callable[[dict[str, Any]], Mapping[str, Signal]]
"""As those of `Model.run`, or a function of what a run sets."""


@dataclass
class Chunk:
    """Some runs that follow each other, as arrays."""

    status: np.ndarray
    """(n,) places in STATUSES."""
    messages: list[str]
    values: np.ndarray
    """(n, times, outputs); not a number after a run has stopped."""
    scalars: np.ndarray
    """(n, scalars)"""


@dataclass(frozen=True)
class Task:
    """What all runs of a study share."""

    stop_time: float
    step_size: float
    times: int
    """Rows of a run."""
    recorded: tuple[str, ...]
    """Scalars that a run records: those that are kept, and those that functions and reductions look at."""
    kept: tuple[str, ...]
    scalars: tuple[Scalar, ...]
    inputs: Inputs

    def empty(self, runs: int, status: str = "done", message: str = "") -> Chunk:
        """Runs without values."""
        return Chunk(
            np.full(runs, STATUSES.index(status), dtype=np.int8),
            [message] * runs,
            np.full((runs, self.times, len(self.kept)), np.nan),
            np.full((runs, len(self.scalars)), np.nan),
        )


def packed(fmu: Fmu) -> bytes:
    """An FMU with what a run needs, the same bytes for the same content."""
    memory = BytesIO()
    with zipfile.ZipFile(memory, "w", compresslevel=1) as archive:
        for path in sorted(path for path in fmu.directory.rglob("*") if path.is_file()):
            name = path.relative_to(fmu.directory)
            if name.parts[0] in NEEDED:
                info = zipfile.ZipInfo(name.as_posix())  # of 1980, so that the same content is the same file
                info.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(info, path.read_bytes())
    return memory.getvalue()


def digest(content: bytes) -> str:
    """Name of a content."""
    return hashlib.sha256(content).hexdigest()


class Job(WorkerPlugin):
    """A study on a worker. The scheduler sends it once to each worker, and to those that come later."""

    def __init__(self, name: str, fmu: bytes, task: Task):
        self.name, self._fmu, self._task = name, fmu, task

    def setup(self, worker: Worker) -> None:
        """Open the model."""
        _open[self.name] = _Opened(self._fmu, self._task)

    def teardown(self, worker: Worker) -> None:
        """Forget it."""
        if opened := _open.pop(self.name, None):
            opened.close()


def run_chunk(job: str, settings: Sequence[dict[str, Any]]) -> Chunk:
    """Run a model with each of some settings."""
    return _open[job].run(settings)


_open: dict[str, _Opened] = {}
"""Studies of this worker."""


@dataclass
class _Live:
    instance: Instance | None = None


class _Opened:
    """A study's model in this process."""

    def __init__(self, fmu: bytes, task: Task):
        self._task, self._instances, self._local = task, list[_Live](), threading.local()
        self._columns = [task.recorded.index(name) for name in task.kept]
        folder = Path(tempfile.mkdtemp(prefix="sigmafmu-"))
        try:
            path = folder / "model.fmu"
            path.write_bytes(fmu)
            self._model = Fmu(path)
        finally:
            shutil.rmtree(folder)

    def close(self) -> None:
        """Free the instances."""
        for live in self._instances:
            if live.instance:
                live.instance.close()

    def run(self, settings: Sequence[dict[str, Any]]) -> Chunk:
        chunk = self._task.empty(len(settings))
        for i, values in enumerate(settings):
            status, chunk.messages[i] = self._run(values, chunk.values[i], chunk.scalars[i])
            chunk.status[i] = STATUSES.index(status)
        return chunk

    def _run(self, settings: dict[str, Any], values: np.ndarray, scalars: np.ndarray) -> tuple[str, str]:
        """Status and message of a run, whose numbers go into `values` and `scalars`."""
        task = self._task
        live = self._live()
        try:
            inputs = task.inputs(settings) if callable(task.inputs) else task.inputs
            if live.instance:
                live.instance.reset(settings)
            else:
                live.instance = Instance(self._model, settings)
            result = live.instance.run(task.stop_time, step_size=task.step_size, inputs=inputs, outputs=task.recorded)
        except SimulationError as error:
            self._drop(live)
            if error.result is None:
                return "refused", str(error)
            self._keep(error.result, values)
            return "stopped", str(error)
        except Exception as error:  # of a function of the user, whatever it is
            self._drop(live)
            return "error", str(error) if isinstance(error, SigmafmuError) else f"{type(error).__name__}: {error}"
        self._keep(result, values)
        for k, scalar in enumerate(task.scalars):
            try:
                scalars[k] = scalar.of(result)
            except Exception as error:
                return "error", f"{scalar.name}: {type(error).__name__}: {error}"
        return "done", ""

    def _keep(self, result: Result, values: np.ndarray) -> None:
        if self._task.kept:
            values[: len(result.time)] = result.values[:, self._columns]

    def _live(self) -> _Live:
        """The instance of this thread."""
        if not hasattr(self._local, "live"):
            self._local.live = _Live()
            self._instances.append(self._local.live)
        return self._local.live

    def _drop(self, live: _Live) -> None:
        """After an error the next run gets a new instance."""
        if live.instance:
            live.instance.close()
        live.instance = None
