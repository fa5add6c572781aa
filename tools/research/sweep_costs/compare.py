"""The same runs by FMPy's `simulate_fmu`, by FMPy's own Dask way, and by a sweep, on processes that are there."""

import shutil
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from dask import bag
from fmpy.fmi2 import FMU2Slave

import sigmafmu
from research.sweep_costs import (
    HIGH,
    LOW,
    MODEL,
    OUTPUT_SCALARS,
    OUTPUTS,
    SETTINGS,
    SHORT,
    STEP_SIZE,
    STOP_TIME,
    own_seconds,
)
from sigmafmu.sweeps.cluster import connected

PROCESSES = 2
Way = Callable[[np.ndarray, float], np.ndarray]
"""Masses (n,) and the stop time → values (n, times, outputs)."""


@dataclass(frozen=True)
class Measured:
    """A way to do the runs."""

    way: str
    processes: int
    stop_time: float  # s
    runs: int
    wall: float  # s
    cpu: float  # s, of all its processes

    @property
    def per_core(self) -> float:
        """Runs per second of a core."""
        return self.runs / self.cpu


def compare(runs: int, slow_runs: int) -> list[Measured]:
    """All ways; those that open the FMU for each run do fewer. Raises AssertionError if they give other values."""
    masses, found, values = np.linspace(LOW, HIGH, runs), [], defaultdict(list)
    for name, processes, number, make in (
        ("`simulate_fmu` of a file", 1, slow_runs, _simulate_file),
        ("`simulate_fmu`, unpacked, instance kept", 1, runs, _simulate_kept),
        ("FMPy's example: Dask bag, reset", PROCESSES, runs, _bag),
        ("`sigmafmu.sweep`", 1, runs, partial(_sweep, 1)),
        ("`sigmafmu.sweep`", PROCESSES, runs, partial(_sweep, PROCESSES)),
    ):
        with make() as way:
            way(masses[:PROCESSES], SHORT)  # starts and opens what stays
            for stop_time in (STOP_TIME, SHORT):
                cpu, wall = own_seconds(), time.perf_counter()
                values[stop_time].append(way(masses[:number], stop_time))
                wall, cpu = time.perf_counter() - wall, own_seconds() - cpu
                found.append(Measured(name, processes, stop_time, number, wall, cpu))
    for same in values.values():
        for other in same:  # FMPy adds up communication points, which rounds them
            np.testing.assert_allclose(other, same[-1][: len(other)], rtol=1e-9, atol=1e-9)
    return found


@contextmanager
def _simulate_file() -> Iterator[Way]:
    yield lambda masses, end: np.array([_simulated(sigmafmu.fmu_path(MODEL), mass, end) for mass in masses])


def _simulated(fmu: Any, mass: float, stop_time: float, **more: Any) -> np.ndarray:
    result = fmpy.simulate_fmu(
        fmu,
        stop_time=stop_time,
        output_interval=STEP_SIZE,
        start_values={"crank.mass": mass, **SETTINGS},
        output=OUTPUT_SCALARS,
        **more,
    )
    return np.column_stack([result[name] for name in OUTPUT_SCALARS])


@contextmanager
def _unpacked() -> Iterator[tuple[str, Any]]:
    folder = fmpy.extract(sigmafmu.fmu_path(MODEL))
    try:
        yield folder, fmpy.read_model_description(folder)
    finally:
        shutil.rmtree(folder)


@contextmanager
def _simulate_kept() -> Iterator[Way]:
    with _unpacked() as (folder, description):
        instance = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")

        def way(masses: np.ndarray, stop_time: float) -> np.ndarray:
            found = []
            for mass in masses:
                instance.reset()
                found.append(_simulated(folder, mass, stop_time, model_description=description, fmu_instance=instance))
            return np.array(found)

        yield way
        instance.freeInstance()


def _partition(masses: Any, stop_time: float, folder: str, description: Any) -> list[np.ndarray]:
    """As fmpy/examples/parameter_variation.py does it."""
    references = {v.name: v.valueReference for v in description.modelVariables}
    arguments = {
        "guid": description.guid,
        "modelIdentifier": description.coSimulation.modelIdentifier,
        "unzipDirectory": folder,
    }
    slave = FMU2Slave(**arguments)
    slave.instantiate()
    outputs = [references[name] for name in OUTPUT_SCALARS]
    found = []
    for mass in masses:
        slave.reset()
        slave.setupExperiment()
        slave.setReal([references[name] for name in ("crank.mass", *SETTINGS)], [mass, *SETTINGS.values()])
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        rows = [slave.getReal(outputs)]
        for step in range(round(stop_time / STEP_SIZE)):
            slave.doStep(currentCommunicationPoint=step * STEP_SIZE, communicationStepSize=STEP_SIZE)
            rows.append(slave.getReal(outputs))
        found.append(np.array(rows))
    slave.terminate()
    slave.freeInstance()
    return found


@contextmanager
def _bag() -> Iterator[Way]:
    with _unpacked() as (folder, description), ProcessPoolExecutor(PROCESSES) as pool:

        def way(masses: np.ndarray, stop_time: float) -> np.ndarray:
            parts = bag.from_sequence(masses.tolist(), npartitions=min(10, len(masses)))
            return np.array(
                parts.map_partitions(_partition, stop_time, folder, description).compute(
                    scheduler="processes", pool=pool
                )
            )

        yield way


@contextmanager
def _sweep(workers: int) -> Iterator[Way]:
    model = sigmafmu.load(MODEL)
    with connected(None, workers) as client, tempfile.TemporaryDirectory() as folder:

        def way(masses: np.ndarray, stop_time: float) -> np.ndarray:
            data = sigmafmu.sweep(
                model,
                {"crank.mass": masses, **SETTINGS},
                outputs=OUTPUTS,
                stop_time=stop_time,
                step_size=STEP_SIZE,
                scheduler=client,
                output=Path(folder) / "study.nc",
            )
            with data:
                first, others = (data[name].values for name in OUTPUTS)
            return np.concatenate((first[..., np.newaxis], others), axis=2)

        yield way
