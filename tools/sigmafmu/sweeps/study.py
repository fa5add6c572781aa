"""A study: many runs of a model with other parameters, whose results become one dataset."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import sigmafmu
from sigmafmu import SigmafmuError, extras
from sigmafmu.fmu import Fmu
from sigmafmu.model import Model, load
from sigmafmu.recorder import check_memory
from sigmafmu.signals import Signals
from sigmafmu.steps import CommunicationSteps, communication_steps
from sigmafmu.sweeps.plan import Plan, Varied, plan
from sigmafmu.sweeps.scalars import Function, read_scalars
from sigmafmu.variables import outputs as all_outputs
from sigmafmu.variables import recorded_variables

if TYPE_CHECKING:
    import xarray
    from distributed import Client

    from sigmafmu.sweeps.job import Inputs, Task
    from sigmafmu.sweeps.parts import Parts

CHUNK_BYTES = 4 << 20
CHUNK_RUNS = 50
CHUNKS = 32
"""A chunk has at most so many bytes and runs; a study has at least so many chunks, if it has that many runs."""
ENDINGS = (".nc", ".zarr")


def sweep(
    model: str | Path | Model,
    parameters: Mapping[str | tuple[str, ...], Varied] | None = None,
    *,
    runs: int | None = None,
    sampling: str = "random",
    seed: int = 0,
    inputs: Inputs | None = None,
    outputs: Iterable[str] | None = None,
    scalars: Iterable[str] | Mapping[str, str | Function] = (),
    stop_time: float | None = None,
    step_size: float | None = None,
    output: Path | str | None = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    chunk: int | None = None,
    on_progress: Callable[[int, int, int], None] | None = None,
) -> xarray.Dataset:
    """Run a model with every combination of `parameters`, in processes of this machine or on a Dask cluster.

    `parameters` are constants, sequences of values (for a vector: of vectors) that are crossed, or distributions of
    scipy.stats, of which `runs` samples are drawn by `sampling` (`random`, `latin`, `sobol`) from `seed`. A tuple of
    names varies them together: its value has a row for each run. `inputs` are as those of `Model.run`, or a function
    of a run's parameters that gives them. `outputs` are recorded over time: names, vectors or patterns; default: all,
    or none if there are `scalars`. These are texts such as `max(guide.reactionForce)` or, by name, such texts or
    functions of a `Result`, which the worker calls. Times are those of `Model.run`.

    The Dataset has the dimensions run × time, parameters as coordinates, `status` and `message` of each run: one that
    fails is a row without values. It is in memory, or read from `output` (.nc, .zarr) when it is used; in the folder
    `<output>.parts` are finished runs until then, which `resume` takes up. It does not depend on `workers` (processes;
    default: one for each core), `scheduler` (address or client of Dask) and `chunk` (runs of a task).
    `on_progress(finished, runs, failed)` is called after each chunk. Raises SigmafmuError before anything runs.
    """
    need()
    model = model if isinstance(model, Model) else load(model)
    chosen = plan(model.fmu, parameters or {}, runs, sampling, seed)
    steps = communication_steps(model.fmu, stop_time, step_size)
    task = _task(model.fmu, steps, inputs or {}, outputs, scalars)
    if twice := next((name for name in task.kept if name in chosen.columns), None):
        raise SigmafmuError(f"'{twice}' is varied, so it is a coordinate; it cannot be an output too")
    with ExitStack() as stack:
        if output is None:
            check_memory(chosen.runs * task.times, len(task.kept))
            file = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="sweep-"))) / "study.nc"
        else:
            file = _writable(output)
        _execute(model, chosen, steps, task, file, resume, workers, scheduler, chunk, on_progress)
        return read(file).load() if output is None else read(file)


def need() -> None:
    """Raise SigmafmuError with what to install if a package of the extra is missing."""
    for module in ("distributed", "xarray", "h5netcdf", "scipy"):
        extras.need(module, "sweep")


def read(path: Path | str) -> xarray.Dataset:
    """A study that was written; values are read when they are used."""
    xarray = extras.need("xarray", "sweep")
    if Path(path).suffix == ".zarr":
        return xarray.open_zarr(path)
    return xarray.open_dataset(path, engine="h5netcdf")


def _writable(output: Path | str) -> Path:
    target = Path(output)
    if target.suffix not in ENDINGS:
        raise SigmafmuError(f"cannot write {target}: the name must end with {' or '.join(ENDINGS)}")
    if target.suffix == ".zarr":
        extras.need("zarr")
    if not target.absolute().parent.is_dir():
        raise SigmafmuError(f"cannot write {target}: there is no folder {target.parent}")
    return target


def _task(fmu: Fmu, steps: CommunicationSteps, inputs: Inputs, outputs: Any, wanted: Any) -> Task:
    """What all runs share; raises SigmafmuError for names that are wrong."""
    from sigmafmu.sweeps.job import Task

    if not callable(inputs):
        Signals(fmu, inputs)
    numbers = read_scalars(fmu, wanted)
    if outputs is None:
        kept = () if numbers else tuple(v.name for v in all_outputs(fmu))
    else:
        kept = tuple(v.name for v in recorded_variables(fmu, outputs))
    recorded = dict.fromkeys(kept)
    for number in numbers:  # a function sees all outputs
        recorded |= dict.fromkeys(v.name for v in recorded_variables(fmu, [number.variable] if number.variable else ()))
    taken = {*fmu.variables, "run", "time", "status", "message"}
    if wrong := next((number.name for number in numbers if number.name in taken or "/" in number.name), None):
        raise SigmafmuError(f"a scalar cannot have the name '{wrong}'; give it another")
    return Task(steps.end, steps.step_size, len(steps) + 1, tuple(recorded), kept, tuple(numbers), inputs)


def _execute(
    model: Model,
    plan: Plan,
    steps: CommunicationSteps,
    task: Task,
    target: Path,
    resume: bool,
    workers: int | None,
    scheduler: str | Client | None,
    chunk: int | None,
    on_progress: Callable[[int, int, int], None] | None,
) -> None:
    """Run what is not there yet, and write `target`."""
    from sigmafmu.sweeps import dataset
    from sigmafmu.sweeps.fingerprint import fingerprint
    from sigmafmu.sweeps.job import digest, packed
    from sigmafmu.sweeps.parts import Parts

    fmu = packed(model.fmu)
    mark = fingerprint(digest(fmu), plan, task)
    if resume and target.exists() and read(target).attrs.get("fingerprint") == mark:
        return
    if chunk is not None and chunk < 1:
        raise SigmafmuError(f"a chunk has 1 run or more, not {chunk}")
    size = chunk or _chunk(plan.runs, 8 * task.times * len(task.kept))
    folder = target.with_name(f"{target.name}.parts")
    parts = Parts(folder, mark, plan.runs, size, resume=resume)
    _run(parts, plan, task, fmu, workers, scheduler, on_progress or (lambda *_: None))
    times = np.array([0.0, *(start + length for start, length in steps)])
    units = {name: variable.unit or "" for name, variable in model.fmu.variables.items()}
    about = {
        "model": model.name,
        "sigmafmu": sigmafmu.__version__,
        "fingerprint": mark,
        "constants": ", ".join(f"{name}={value}" for name, value in plan.constants.items()),
    }
    dataset.write(target, task, times, plan.columns, parts, units, about)
    parts.remove()


def _chunk(runs: int, run_bytes: int) -> int:
    """Runs of a task: many, so that a scheduler has little to do; few, so that memory is bounded and all have work."""
    return max(1, min(CHUNK_RUNS, runs // CHUNKS, CHUNK_BYTES // max(run_bytes, 1)))


def _run(
    parts: Parts,
    plan: Plan,
    task: Task,
    fmu: bytes,
    workers: int | None,
    scheduler: str | Client | None,
    on_progress: Callable[[int, int, int], None],
) -> None:
    from sigmafmu.sweeps.cluster import Crew, connected
    from sigmafmu.sweeps.job import Chunk

    missing = [start for start in parts.starts if not parts.has(start)]
    finished, failed = plan.runs - sum(map(parts.length, missing)), 0
    on_progress(finished, plan.runs, failed)
    if not missing:
        return

    def settings(start: int) -> list[dict[str, Any]]:
        return [plan.settings(run) for run in range(start, start + parts.length(start))]

    def take(start: int, chunk: Chunk) -> None:
        nonlocal finished, failed
        parts.save(start, chunk)
        finished += len(chunk.status)
        failed += int(np.count_nonzero(chunk.status))
        on_progress(finished, plan.runs, failed)

    with connected(scheduler, workers) as client, Crew(client, fmu, task) as crew:
        crew.run(iter(missing), settings, take)
