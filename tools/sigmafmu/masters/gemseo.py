"""GEMSEO's plugin for FMUs, from an environment of its own: it wants an older FMPy than ours."""

import os
import shutil
from pathlib import Path

from sigmafmu.masters import Master, Run, ToolError, Trajectory
from sigmafmu.masters.process import ProcessError, call, output_of

PYTHON_VARIABLE = "SIGMAFMU_GEMSEO_PYTHON"
"""Environment variable with the Python that has gemseo-fmu."""
WORKER = Path(__file__).with_name("workers") / "gemseo_run.py"


class Gemseo(Master):
    """`FMUDiscipline` over the whole run."""

    name = "gemseo-fmu"
    source = f"PyPI `gemseo-fmu` in a virtual environment, whose Python `{PYTHON_VARIABLE}` names"
    command = "FMUDiscipline(FMU, input_names=…, output_names=…, final_time=T, time_step=H).execute({name: value})"
    heavy = True
    records = ("Real",)
    note = (
        "gemseo-fmu sets its inputs again when the run has started, which FMI forbids for fixed parameters: these were "
        "set on `FMUDiscipline.model` (docs/fmi.md); it reads Real variables alone"
    )

    @property
    def _python(self) -> str | None:
        return shutil.which(os.environ.get(PYTHON_VARIABLE, ""))

    def missing(self) -> str | None:
        return None if self._python else f"not installed ({PYTHON_VARIABLE} names no Python)"

    def version(self) -> str:
        program = "from importlib.metadata import version; print(version('gemseo-fmu'))"
        return output_of([self._python, "-c", program], Path.cwd()).strip()

    def simulate(self, run: Run) -> Trajectory:
        job = {
            "path": str(run.fmu.path),
            "H": run.H,
            "steps": run.steps,
            "parameters": dict(run.parameters),
            "fixed": [n for n in run.parameters if run.fmu.variables[n].variability == "fixed"],
            "outputs": run.recorded("Real"),
        }
        try:
            return call([self._python, WORKER], job)
        except ProcessError as error:
            raise ToolError(str(error)) from error
