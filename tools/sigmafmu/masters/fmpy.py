"""FMPy, the master that all others are compared with."""

import fmpy
from fmpy.validation import validate_fmu

from sigmafmu.fmu import Fmu
from sigmafmu.masters import Master, Run, Trajectory, Validator


class FmpyValidator(Validator):
    """The static checks of FMPy."""

    name = "FMPy, validate"
    source = "PyPI `fmpy`"
    command = "fmpy validate FMU"

    def missing(self) -> None:
        return None

    def version(self) -> str:
        return fmpy.__version__

    def validate(self, fmu: Fmu) -> list[str]:
        return validate_fmu(str(fmu.path))


class FmpyMaster(Master):
    """`fmpy.simulate_fmu`."""

    name = "FMPy"
    source = "PyPI `fmpy`"
    command = "fmpy.simulate_fmu(FMU, stop_time=T, output_interval=H, start_values=…, output=…)"

    def missing(self) -> None:
        return None

    def version(self) -> str:
        return fmpy.__version__

    def simulate(self, run: Run) -> Trajectory:
        outputs = [*run.recorded("Real"), *run.recorded("Integer")]
        result = fmpy.simulate_fmu(
            str(run.fmu.path),
            stop_time=run.stop_time,
            output_interval=run.H,
            start_values=dict(run.parameters),
            output=outputs,
        )
        return {name: result[name][1:] for name in outputs}
