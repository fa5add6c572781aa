"""Does the cells of chapters in parallel, keeps their results on disk, and writes the report.

A kept result is used again when nothing it depends on has changed: the function's module and arguments, the core, the
FMUs, the references and Exudyn.
"""

import hashlib
import inspect
import json
import multiprocessing
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

import research
import sigmafmu
from research import bench
from research.study.chapter import Cell, Chapter, Results
from sigmafmu import SigmafmuError, _core

CELLS = ".cells"
"""Folder of the kept results, inside the results folder."""

Job = tuple[Chapter, str, Cell]  # with the mechanism


def jobs(chapters: Iterable[Chapter], mechanisms: Sequence[str], quick: bool) -> list[Job]:
    """All the work; the cells of a chapter and mechanism must have different keys."""
    result: list[Job] = []
    for chapter in chapters:
        for mechanism in mechanisms:
            if mechanism not in chapter.mechanisms:
                continue
            cells = chapter.cells(mechanism, quick)
            keys = [cell.key for cell in cells]
            if len(set(keys)) < len(keys):
                raise ValueError(f"chapter {chapter.name}, {mechanism}: two cells have the same key")
            result += [(chapter, mechanism, cell) for cell in cells]
    return result


def rounds(job: Job, passes: int) -> int:
    """How often a cell is done: those that are timed once in every pass, so that a slow minute of the machine is not
    taken for a slow method."""
    return passes if job[2].alone else 1


def run(
    work: Sequence[Job], folder: Path, workers: int, advance: Callable[[], None], passes: int = 1
) -> dict[str, Results]:
    """Results by chapter; `advance` is called `rounds` times for every cell.

    What has to run alone comes last, one after the other, all of it once in each pass.
    """
    store = _Store(folder)
    results: dict[str, dict[str, dict[str, Any]]] = {}
    for chapter, mechanism, _ in work:
        results.setdefault(chapter.name, {}).setdefault(mechanism, {})

    def finish(job: Job, result: dict[str, Any]) -> None:
        chapter, mechanism, cell = job
        results[chapter.name][mechanism][cell.key] = result
        advance()

    missing: dict[bool, list[list[Job]]] = {alone: [[] for _ in range(passes)] for alone in (False, True)}
    for job in work:
        kept, done = store.load(job)
        for _ in range(min(done, rounds(job, passes))):
            finish(job, kept)
        for number in range(done, rounds(job, passes)):
            missing[job[2].alone][number].append(job)
    for alone, processes in ((False, workers), (True, 1)):
        for number, part in enumerate(missing[alone]):
            for job, result in _work_off(part, processes):
                before, _ = store.load(job) if number else (result, 0)
                finish(job, store.save(job, _faster(before, result), number + 1))
    return {  # in the order of the cells, however they finished
        name: {
            mechanism: {c.key: found[c.key] for chapter, m, c in work if (chapter.name, m) == (name, mechanism)}
            for mechanism, found in by_mechanism.items()
        }
        for name, by_mechanism in results.items()
    }


def write_report(chapters: Iterable[Chapter], results: dict[str, Results], folder: Path, command: str) -> Path:
    """Every chapter's files, and README.md with all sections."""
    parts = [
        "# Study of the integration methods\n\n"
        f"Written by `{command}` on {bench.machine()}. Errors are against independent solutions in minimal coordinates "
        "(`research.reference.minimal_coordinates`, `research.reference.flexible`). The story is in `docs/study.md`, "
        "`docs/methods.md` and `docs/flexible.md`.\n"
    ]
    for chapter in chapters:
        if chapter.name in results:
            parts.append(f"\n## {chapter.title}\n\n{chapter.report(results[chapter.name], folder).strip()}\n")
    path = folder / "README.md"
    path.write_text("".join(parts), encoding="utf-8")
    return path


def _faster(before: Any, now: Any) -> Any:
    """The result before, with the smaller `seconds` of both, at any depth."""
    if isinstance(before, dict) and isinstance(now, dict):
        result = {key: _faster(value, now.get(key)) for key, value in before.items()}
        if "seconds" in before and "seconds" in now:
            result["seconds"] = min(before["seconds"], now["seconds"])
        return result
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return [_faster(*pair) for pair in zip(before, now, strict=True)]
    return before


def _work_off(part: Sequence[Job], processes: int) -> Iterable[tuple[Job, dict[str, Any]]]:
    if not part:
        return
    # spawned, not forked: what this process has loaded (Exudyn has two modules) does not matter
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context, initializer=_start_worker) as pool:
        running: dict[Future, Job] = {pool.submit(job[2].function, *job[2].arguments): job for job in part}
        try:
            for future in as_completed(running):
                chapter, mechanism, cell = job = running[future]
                try:
                    yield job, future.result()
                except Exception as error:
                    raise RuntimeError(f"study, {chapter.name}, {mechanism}, {cell.key}: {error}") from error
        finally:
            pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    """Silence Exudyn, which prints from C++, and load its fast module where the processor has AVX2."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        from research.reference.exudyn_models import load_exudyn

        load_exudyn(fast=True)
    except (ModuleNotFoundError, RuntimeError):
        pass


class _Store:
    """One JSON file for each cell, with a fingerprint of what its result depends on."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / CELLS
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / ".gitignore").write_text("*\n", encoding="utf-8")
        except OSError as error:
            raise SigmafmuError(f"cannot write {folder}: {error.strerror}") from error

    def _path(self, job: Job) -> Path:
        chapter, mechanism, cell = job
        readable = "".join(c if c.isalnum() or c in "-_." else "_" for c in cell.key)[:60]
        name = f"{readable}-{hashlib.sha256(cell.key.encode()).hexdigest()[:8]}.json"
        return self.folder / chapter.name / mechanism / name

    def load(self, job: Job) -> tuple[dict[str, Any], int]:
        """The kept result and how many passes it is of; none if there is none that is still valid."""
        try:
            kept = json.loads(self._path(job).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}, 0
        return (kept["result"], kept.get("passes", 1)) if kept.get("fingerprint") == fingerprint(job[2]) else ({}, 0)

    def save(self, job: Job, result: dict[str, Any], passes: int) -> dict[str, Any]:
        """Keep the result; returns it as it would be loaded."""
        kept = {"fingerprint": fingerprint(job[2]), "passes": passes, "result": result}
        text = json.dumps(kept, default=_plain)
        path = self._path(job)
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(".new")
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(path)
        return json.loads(text)["result"]


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a cell returned a {type(value).__name__}, which JSON cannot hold")


def fingerprint(cell: Cell) -> str:
    """Changes with whatever a cell's result depends on."""
    module = inspect.getmodule(cell.function)
    own = Path(module.__file__).read_bytes() if module and module.__file__ else b""
    parts = (_environment(), own, cell.function.__qualname__, repr(cell.arguments))
    return _digest(*(part if isinstance(part, bytes) else part.encode() for part in parts))


@lru_cache(maxsize=1)
def _environment() -> str:
    try:
        peer = version("exudyn")
    except PackageNotFoundError:
        peer = "none"
    package = Path(research.__file__).parent
    files = [Path(_core.__file__), *(sigmafmu.fmu_path(model) for model in sigmafmu.models())]
    files += [*sorted((package / "reference").glob("*.py")), package / "measure.py", package / "study" / "runs.py"]
    return _digest(sigmafmu.__version__.encode(), peer.encode(), *(Path(file).read_bytes() for file in files))


def _digest(*parts: bytes) -> str:
    result = hashlib.sha256()
    for part in parts:
        result.update(len(part).to_bytes(8, "little"))
        result.update(part)
    return result.hexdigest()
