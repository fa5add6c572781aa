"""libcosim, the master of the Open Simulation Platform, through its Python interface."""

from importlib.metadata import version
from importlib.util import find_spec

import numpy as np

from sigmafmu.masters import Master, Run, ToolError, Trajectory
from sigmafmu.masters.process import ProcessError, call_script, script


class Libcosim(Master):
    """`CosimExecution` with fixed steps."""

    name = "libcosim"
    source = "PyPI `libcosimpy`"
    command = "CosimExecution.from_step_size(H), add_local_slave(CosimLocalSlave(FMU, …)), real_initial_value, step()"

    def missing(self) -> str | None:
        return None if find_spec("libcosimpy") else "not installed"

    def version(self) -> str:
        return version("libcosimpy")

    def simulate(self, run: Run) -> Trajectory:
        references = {name: v.valueReference for name, v in run.fmu.variables.items()}
        job = {
            "path": str(run.fmu.path),
            "H": run.H,
            "steps": run.steps,
            "parameters": [(references[name], value) for name, value in run.parameters.items()],
            "reals": {name: references[name] for name in run.recorded("Real")},
            "integers": {name: references[name] for name in run.recorded("Integer")},
        }
        try:
            return call_script(__name__, job)
        except ProcessError as error:
            raise ToolError(str(error)) from error


def _work(
    path: str,
    H: float,
    steps: int,
    parameters: list[tuple[int, float]],
    reals: dict[str, int],
    integers: dict[str, int],
) -> Trajectory:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(round(H * 1e9))  # its time is in whole nanoseconds
    slave = CosimLocalSlave(fmu_path=path, instance_name="mechanism")
    index = execution.add_local_slave(slave)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for reference, value in parameters:
        if not execution.real_initial_value(index, reference, value):
            raise RuntimeError(f"libcosim does not set variable {reference}")
    rows = []
    for i in range(steps):
        if not execution.step():
            raise RuntimeError(f"step {i} failed: {execution.status()}")
        rows.append(
            [
                *observer.last_real_values(index, list(reals.values())),
                *observer.last_integer_values(index, list(integers.values())),
            ]
        )
    return dict(zip([*reals, *integers], np.array(rows).T, strict=True))


if __name__ == "__main__":
    script(_work)
