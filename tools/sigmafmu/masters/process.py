"""Tools run in a process of their own: a crash there is a finding, not our end."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

TIMEOUT = 300.0  # s


class ProcessError(Exception):
    """A program ended with an error; the text holds the end of what it printed."""

    def __init__(self, program: str, result: str, output: str):
        lines = [line.strip() for line in output.splitlines() if line.strip()]
        super().__init__(": ".join([f"{program} {result}", *lines[-1:]]))
        self.output = output


def output_of(command: Sequence[str | Path], folder: Path) -> str:
    """Run `command` in `folder`; returns what it printed, raises ProcessError unless it succeeds."""
    program = Path(command[0]).name
    try:
        result = subprocess.run(
            list(map(str, command)),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired as error:
        raise ProcessError(program, f"did not end within {TIMEOUT:g} s", "") from error
    if result.returncode < 0:
        raise ProcessError(program, f"crashed with signal {-result.returncode}", result.stdout)
    if result.returncode > 0:
        raise ProcessError(program, f"failed with exit code {result.returncode}", result.stdout)
    return result.stdout


def call_script(module: str, job: dict[str, Any]) -> dict[str, np.ndarray]:
    """Let `python -m module` do `job`; its last lines must call `script(work)`."""
    return call([sys.executable, "-m", module], job)


def call(program: Sequence[str | Path], job: dict[str, Any]) -> dict[str, np.ndarray]:
    """Let `program FOLDER` do what is in `job.json` of the folder; it writes the arrays of `result.npz` there."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
        output_of([*program, folder], folder)
        with np.load(folder / "result.npz") as result:
            return dict(result)


def script(work: Callable[..., dict[str, np.ndarray]]) -> None:
    """The other end of `call_script`: reads the job, writes what `work(**job)` returns."""
    folder = Path(sys.argv[1])
    result = work(**json.loads((folder / "job.json").read_text(encoding="utf-8")))
    np.savez(folder / "result.npz", **result)
    sys.stdout.flush()
    os._exit(0)  # not through the tool's static destructors: they do not belong to the simulation
