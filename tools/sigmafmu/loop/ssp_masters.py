"""Run an SSP system of `sigmafmu.loop.ssp` by other people's masters, each in a process of its own.

All of them step every FMU from t_n to t_n + H before they exchange values, so that what a law answers to y_n reaches
the plant one period later: delay = 1 in `run_closed_loop`. They differ at the start:

- libcosim and Ecos give the laws y_0 at t_0, as `run_closed_loop(delay=1)` does: the same trajectory. libcosim applies
  the parameter bindings, Ecos does not.
- FMPy gives the laws zeros at t_0. It also ignores parameter bindings and labels a row with the beginning of the step
  that it is the end of; the label is put right here.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from sigmafmu.loop.loops import Loop
from sigmafmu.loop.ssp import PLANT
from sigmafmu.masters import Trajectory
from sigmafmu.masters.ecos import Ecos
from sigmafmu.masters.process import call_script, script


def simulate(master: str, path: Path | str, loop: Loop, H: float, steps: int) -> Trajectory:
    """Outputs of the plant at H, 2 H, … if `master`, a name in MASTERS, runs the SSP of `loop`."""
    job = {"master": master, "path": str(Path(path).resolve()), "names": loop.outputs, "H": H, "steps": steps}
    return call_script(__name__, job)


def _libcosim(path: str, names: list[str], H: float, steps: int) -> Trajectory:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(path, round(H * 1e9))  # its time is in whole nanoseconds
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    plant = execution.slave_index_from_instance_name(PLANT)
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(plant)}
    wanted = [references[name] for name in names]
    rows = []
    for i in range(steps):
        if not execution.step():
            raise RuntimeError(f"step {i} failed: {execution.status()}")
        rows.append(observer.last_real_values(plant, wanted))
    return dict(zip(names, np.array(rows).T, strict=True))


def _fmpy(path: str, names: list[str], H: float, steps: int) -> Trajectory:
    from fmpy.ssp.simulation import simulate_ssp

    rows = simulate_ssp(path, stop_time=(steps - 0.5) * H, step_size=H)  # it adds up its time until that is passed
    return {name: rows[f"{PLANT}.{name}"] for name in names}


def _ecos(path: str, names: list[str], H: float, steps: int) -> Trajectory:
    if reason := Ecos().missing():  # also loads the library that it needs
        raise RuntimeError(reason)
    from ecospy.EcosSimulation import EcosLib, EcosSimulation

    EcosLib.set_log_level("err")
    simulation = EcosSimulation(H, ssp_path=path)
    if not simulation.init():
        raise RuntimeError(f"Ecos cannot start: {EcosLib.get_last_error()}")
    rows = []
    for _ in range(steps):
        simulation.step()
        rows.append([simulation.get_real(f"{PLANT}::{name}") for name in names])
    return dict(zip(names, np.array(rows).T, strict=True))


MASTERS: dict[str, Callable[..., Trajectory]] = {"libcosim": _libcosim, "fmpy": _fmpy, "ecos": _ecos}


def _work(master: str, **job) -> Trajectory:
    return MASTERS[master](**job)


if __name__ == "__main__":
    script(_work)
