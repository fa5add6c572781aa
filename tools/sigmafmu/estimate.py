"""What a long run will take, told by a short one before it begins."""

import shutil
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from sigmafmu import SigmafmuError
from sigmafmu.instance import SimulationError
from sigmafmu.model import Model
from sigmafmu.result import CsvWriter
from sigmafmu.steps import communication_steps
from sigmafmu.variables import SettingValue, parse_settings

STEP_SIZE = "integrator.stepSize"
TRIAL_STEPS = 500
LONG = 100_000
"""Steps, internal or of communication, below which a run takes seconds and a few megabytes."""
SECONDS_TO_ASK = 600.0
BYTES_TO_ASK = 1e9
UNITS = (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0), ("seconds", 1.0))


@dataclass(frozen=True)
class Cost:
    """Of a run as a whole."""

    seconds: float
    file_size: float
    """Bytes of the CSV file; 0 without one."""

    @property
    def is_large(self) -> bool:
        """Whether a user should be asked first."""
        return self.seconds > SECONDS_TO_ASK or self.file_size > BYTES_TO_ASK

    def __str__(self) -> str:
        unit, size = next((u for u in UNITS if self.seconds >= u[1]), UNITS[-1])
        text = f"about {self.seconds / size:.2g} {unit}"
        return f"{text} and {self.file_size / 1e9:.2g} GB" if self.file_size else text


def cost(
    model: Model,
    stop_time: float | None,
    step_size: float | None,
    parameters: Mapping[str, SettingValue],
    outputs: Iterable[str],
    output: Path | None,
) -> Cost:
    """What a run with these arguments costs; raises SigmafmuError if the disk has no room for its CSV file `output`."""
    steps = communication_steps(model.fmu, stop_time, step_size)
    end, H = steps.end, steps[0][1]
    chosen = {variable.name: value for variable, value in parse_settings(model.fmu, parameters)}
    own = model.variables[STEP_SIZE].start if STEP_SIZE in model.variables else None
    h = float(chosen.get(STEP_SIZE, own or H))
    trial = TRIAL_STEPS * min(H, h)
    if end < trial * LONG / TRIAL_STEPS:
        return Cost(0.0, 0.0)

    moments: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trial.csv"
        try:
            with CsvWriter(file) as writer:
                result = model.run(
                    trial,
                    step_size=min(H, trial),
                    parameters=parameters,
                    outputs=outputs,
                    on_rows=writer.write if output else None,
                    on_time=lambda _: moments.append(perf_counter()),
                )
        except SimulationError:
            return Cost(0.0, 0.0)  # the run itself will say why
        seconds = max(result.statistics.wall_time, perf_counter() - moments[0])
        size = file.stat().st_size / writer.rows * (len(steps) + 1) if output else 0.0
    found = Cost(seconds * end / trial, size)
    if output and size > (free := shutil.disk_usage(output.absolute().parent).free):
        raise SigmafmuError(f"{output} would take {size / 1e9:.2g} GB, and {free / 1e9:.2g} GB are free there")
    return found
