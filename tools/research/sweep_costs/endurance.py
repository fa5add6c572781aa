"""Many runs by the command, which is killed in the middle and goes on: rate, memory, size, cost of each process."""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil

from research.sweep_costs import HIGH, LOW, MODEL, OUTPUTS, PEAK, SEED, SETTINGS, STEP_SIZE, STOP_TIME, Use, used_by
from sigmafmu.sweeps.study import read

LOOK = 0.25  # s
CHUNK = 50


@dataclass
class Stretch:
    """A process of the command, from its first finished chunk to its last or to its end."""

    began: tuple[float, int] = (0.0, 0)
    """Time [s] and finished runs."""
    ended: tuple[float, int] = (0.0, 0)
    start: float = 0.0
    """Seconds until the first chunk was finished."""
    close: float = 0.0
    """Seconds from the last chunk to the end."""
    first: dict[str, Use] = field(default_factory=dict)
    last: dict[str, Use] = field(default_factory=dict)
    """By role."""
    peak: dict[str, float] = field(default_factory=dict)
    """Largest memory by role [MB]; that of all workers together."""

    @property
    def runs(self) -> int:
        """Finished between the two times."""
        return self.ended[1] - self.began[1]

    @property
    def rate(self) -> float:
        """Runs per second."""
        return self.runs / (self.ended[0] - self.began[0])

    def cost(self, role: str) -> float:
        """Seconds of processors for each run."""
        return (self.last[role].seconds - self.first[role].seconds) / self.runs


@dataclass(frozen=True)
class Endurance:
    """The whole."""

    runs: int
    before: Stretch
    after: Stretch
    lost: int
    """Finished runs that were not there any more."""
    gone: float
    """Seconds until the killed study's workers were gone."""
    size: float
    """Of the file [MB]."""
    raw: float
    """Of its numbers [MB]."""
    failed: int


def endure(runs: int, workers: int) -> Endurance:
    """Do it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        before, family = _stretch(folder, runs, workers, runs // 2)
        killed = time.perf_counter()
        psutil.wait_procs(family, timeout=60)
        gone = time.perf_counter() - killed
        there = _finished(folder)
        after, _ = _stretch(folder, runs, workers, None)
        with read(folder / "study.nc") as data:
            failed = int(np.count_nonzero(data["status"].values))
            raw = sum(variable.nbytes for variable in data.variables.values()) / 1e6
        size = (folder / "study.nc").stat().st_size / 1e6
        return Endurance(runs, before, after, max(before.ended[1] - there, 0), gone, size, raw, failed)


def plain(runs: int, workers: int) -> Stretch:
    """A study that nobody kills."""
    with tempfile.TemporaryDirectory() as name:
        return _stretch(Path(name), runs, workers, None)[0]


def _command(runs: int, workers: int) -> list[str]:
    options = ["--sample", f"crank.mass~U({LOW},{HIGH})", "--runs", runs, "--seed", SEED, "--stop-time", STOP_TIME]
    options += ["--step-size", STEP_SIZE, "--scalar", PEAK, "--workers", workers, "--chunk", CHUNK, "--resume"]
    options += [word for output in OUTPUTS for word in ("--variables", output)]
    options += [word for name, value in SETTINGS.items() for word in ("--set", f"{name}={value}")]
    return [str(Path(sys.executable).with_name("sigmafmu")), "sweep", MODEL, *map(str, options)]


def _finished(folder: Path) -> int:
    return CHUNK * len(list((folder / "study.nc.parts").glob("*.npz")))


def _stretch(folder: Path, runs: int, workers: int, kill_at: int | None) -> tuple[Stretch, list[psutil.Process]]:
    """The command until its end, or until so many runs are finished; what belonged to it then."""
    told, begun, there = Stretch(), time.perf_counter(), _finished(folder)
    with subprocess.Popen(
        _command(runs, workers), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        observed, family = psutil.Process(process.pid), []
        while process.poll() is None:
            now, finished = time.perf_counter(), _finished(folder)
            roles = _roles(observed)
            for role, use in roles.items():
                told.peak[role] = max(told.peak.get(role, 0.0), use.memory)
            if finished > there and not told.first:
                told.began, told.first, told.start = (now, finished), roles, now - begun
            if finished > told.ended[1]:
                told.ended, told.last = (now, finished), roles
            if kill_at and finished >= kill_at:
                family = observed.children(recursive=True)
                os.kill(process.pid, 9)
                break
            time.sleep(LOOK)
        told.close = time.perf_counter() - told.ended[0]
    return told, family


def _roles(process: psutil.Process) -> dict[str, Use]:
    """The client, the process with the scheduler, and all workers together."""
    uses = used_by(process)
    scheduler = {child.pid for child in process.children()} if process.is_running() else set()
    groups: dict[str, list[Use]] = {"client": [], "scheduler": [], "workers": []}
    for pid, use in uses.items():
        groups["client" if pid == process.pid else "scheduler" if pid in scheduler else "workers"].append(use)
    return {role: Use(sum(u.seconds for u in us), sum(u.memory for u in us)) for role, us in groups.items()}
