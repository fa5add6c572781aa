"""The checks of the FMU Manipulation Toolbox."""

import shutil
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from sigmafmu.fmu import Fmu
from sigmafmu.masters import Validator
from sigmafmu.masters.process import ProcessError, output_of


class FmuManipulationToolbox(Validator):
    """`fmutool -check`: the XML schema and a few semantic rules."""

    name = "FMU Manipulation Toolbox"
    source = "PyPI `fmu-manipulation-toolbox`"
    command = "fmutool -input FMU -check"

    @property
    def _program(self) -> str | None:
        return shutil.which("fmutool", path=str(Path(sys.executable).parent)) or shutil.which("fmutool")

    def missing(self) -> str | None:
        return None if self._program else "not installed"

    def version(self) -> str:
        return version("fmu-manipulation-toolbox")

    def validate(self, fmu: Fmu) -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            try:
                report = output_of([self._program, "-input", fmu.path, "-check"], Path(folder))
            except ProcessError as error:
                return [str(error)]
        findings = [line for line in report.splitlines() if line.startswith(("WARNING", "ERROR", "CRITICAL", "FATAL"))]
        expected = ("compliant with FMI-2.0", "No semantic error")
        return findings + [f"the report does not say '{text}'" for text in expected if text not in report]
