"""Finished runs on the disk while a study goes on: a file for each chunk, whole or not there at all."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.sweeps.job import Chunk

PLAN = "plan.json"


class Parts:
    """The folder of a study's chunks. A process that is killed leaves what was finished."""

    def __init__(self, folder: Path, fingerprint: str, runs: int, chunk: int, *, resume: bool):
        """Open the folder; raises SigmafmuError if another study is in it, or one that is not to `resume`."""
        self.folder, self.runs, self.size = folder, runs, chunk
        plan = folder / PLAN
        if plan.is_file():
            there = json.loads(plan.read_text(encoding="utf-8"))
            if not resume:
                raise SigmafmuError(f"a study was stopped here: go on with resume, or delete the folder {folder}")
            if there["fingerprint"] != fingerprint:
                raise SigmafmuError(
                    f"{folder} belongs to a study of another model, or with other parameters or outputs"
                )
            self.size = there["chunk"]
        else:
            try:
                folder.mkdir(parents=True, exist_ok=True)
                self._write(plan, json.dumps({"fingerprint": fingerprint, "runs": runs, "chunk": chunk}).encode())
            except OSError as error:
                raise SigmafmuError(f"cannot write {folder}: {error.strerror}") from error

    @property
    def starts(self) -> range:
        """First runs of all chunks."""
        return range(0, self.runs, self.size)

    def length(self, start: int) -> int:
        """Runs of the chunk that begins there."""
        return min(self.size, self.runs - start)

    def has(self, start: int) -> bool:
        """Whether that chunk is finished."""
        return self._path(start).is_file()

    def save(self, start: int, chunk: Chunk) -> None:
        """Keep a chunk."""
        path = self._path(start)
        part = path.with_suffix(".part")
        try:
            with part.open("wb") as file:
                np.savez(
                    file,
                    status=chunk.status,
                    messages=np.array(chunk.messages),
                    values=chunk.values,
                    scalars=chunk.scalars,
                )
            part.replace(path)
        except OSError as error:
            raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error

    def load(self, start: int) -> Chunk:
        """A finished chunk."""
        with np.load(self._path(start)) as file:
            return Chunk(file["status"], file["messages"].tolist(), file["values"], file["scalars"])

    def __iter__(self) -> Iterator[tuple[int, Chunk]]:
        return ((start, self.load(start)) for start in self.starts)

    def remove(self) -> None:
        """Delete the folder."""
        shutil.rmtree(self.folder)

    def _path(self, start: int) -> Path:
        return self.folder / f"{start:09d}.npz"

    def _write(self, path: Path, content: bytes) -> None:
        part = path.with_suffix(".part")
        part.write_bytes(content)
        part.replace(path)
