"""fmi-sim, the command line of rust-fmi."""

import csv
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sigmafmu.masters import Master, Run, ToolError, Trajectory
from sigmafmu.masters.process import ProcessError, output_of

FOLDER = Path.home() / ".cargo" / "bin"
"""Where cargo puts programs, which need not be in the path."""


class FmiSim(Master):
    """`fmi-sim co-simulation`."""

    name = "fmi-sim"
    source = "crates.io `fmi-sim` (`cargo install fmi-sim`, minutes; its build needs libclang)"
    command = "fmi-sim --model FMU -o r.csv co-simulation --output-interval H -f T --init-values NAME=VALUE"
    heavy = True
    records = ("Real",)
    note = "fmi-sim records outputs alone, so not the counters"

    @property
    def _program(self) -> str | None:
        return shutil.which("fmi-sim") or shutil.which("fmi-sim", path=str(FOLDER))

    def missing(self) -> str | None:
        return None if self._program else "not installed"

    def version(self) -> str:
        shown = subprocess.run([self._program, "--version"], capture_output=True, text=True, check=False)  # an "error"
        found = re.search(r"fmi-sim (\d\S*)", shown.stdout + shown.stderr)
        return found[1] if found else "unknown"

    def simulate(self, run: Run) -> Trajectory:
        values = [option for name, value in run.parameters.items() for option in ("--init-values", f"{name}={value!r}")]
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            common = ["--output-interval", repr(run.H), "-s", "0", "-f", repr(run.stop_time)]
            command = [self._program, "--model", run.fmu.path.resolve(), "-o", "result.csv", "co-simulation"]
            try:
                output_of([*command, *common, *values], folder)
            except ProcessError as error:
                raise ToolError(str(error)) from error
            with (folder / "result.csv").open(encoding="utf-8", newline="") as file:
                header, *rows = csv.reader(file)
        columns = dict(zip(header, np.array(rows).T, strict=True))
        return {name: columns[name][1:].astype(float) for name in run.recorded("Real")}  # without t = 0
