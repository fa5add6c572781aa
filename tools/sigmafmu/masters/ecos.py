"""Ecos through its Python interface."""

import contextlib
import ctypes
from importlib.metadata import PackageNotFoundError, files, version
from importlib.util import find_spec

import numpy as np

from sigmafmu.masters import Master, Run, ToolError, Trajectory
from sigmafmu.masters.process import ProcessError, call_script, script

TBB = "libtbb.so.12"
"""The library that Ecos needs and does not bring along: PyPI `tbb` or Debian `libtbb12`."""


class Ecos(Master):
    """`EcosSimulation` with one model."""

    name = "Ecos"
    source = "PyPI `ecospy` and `tbb` (or Debian `libtbb12`)"
    command = "EcosSimulation(H, structure=…), init(parameter_set=…), step() (the same as `ecos simulate --path FMU …`)"

    def missing(self) -> str | None:
        if not find_spec("ecospy"):
            return "not installed"
        return None if _tbb() else f"{TBB} is not installed (Debian libtbb12 or PyPI tbb)"

    def version(self) -> str:
        return version("ecospy")

    def simulate(self, run: Run) -> Trajectory:
        job = {
            "path": str(run.fmu.path),
            "H": run.H,
            "steps": run.steps,
            "parameters": dict(run.parameters),
            "reals": run.recorded("Real"),
            "integers": run.recorded("Integer"),
        }
        try:
            return call_script(__name__, job)
        except ProcessError as error:
            raise ToolError(str(error)) from error


def _tbb() -> ctypes.CDLL | None:
    """The library, from the system or from the package `tbb`; once loaded, Ecos finds it."""
    candidates = [TBB]
    with contextlib.suppress(PackageNotFoundError):
        candidates += [str(file.locate().resolve()) for file in files("tbb") or () if file.name == TBB]
    for candidate in candidates:
        try:
            return ctypes.CDLL(candidate, mode=ctypes.RTLD_GLOBAL)
        except OSError:
            continue
    return None


def _work(
    path: str, H: float, steps: int, parameters: dict[str, float], reals: list[str], integers: list[str]
) -> Trajectory:
    _tbb()
    from ecospy.EcosSimulation import EcosLib, EcosSimulation
    from ecospy.EcosSimulationStructure import EcosSimulationStructure

    EcosLib.set_log_level("err")
    structure = EcosSimulationStructure()
    structure.add_model("mechanism", path)
    structure.add_parameter_set("given", {f"mechanism::{name}": float(value) for name, value in parameters.items()})
    simulation = EcosSimulation(H, structure=structure)
    if not simulation.init(parameter_set="given"):
        raise RuntimeError(f"Ecos cannot start: {EcosLib.get_last_error()}")
    rows = []
    for i in range(steps):
        simulation.step()
        if not abs(simulation.get_time() - (i + 1) * H) < 1e-9 * H * steps:
            raise RuntimeError(f"step {i} failed: {EcosLib.get_last_error()}")
        rows.append(
            [
                *(simulation.get_real(f"mechanism::{name}") for name in reals),
                *(simulation.get_integer(f"mechanism::{name}") for name in integers),
            ]
        )
    return dict(zip([*reals, *integers], np.array(rows).T, strict=True))


if __name__ == "__main__":
    script(_work)
