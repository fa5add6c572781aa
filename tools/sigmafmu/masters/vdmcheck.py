"""VDMCheck2: the rules of the FMI standard as a formal model."""

import tempfile
import zipfile
from pathlib import Path

from sigmafmu.fmu import Fmu
from sigmafmu.masters import Validator
from sigmafmu.masters.java import Artifact, java_version
from sigmafmu.masters.process import ProcessError, output_of

ARTIFACT = Artifact("org.into-cps.vdmcheck.fmi2", "vdmcheck2", "1.1.3", "zip", "distribution-rules", 3)


class VdmCheck(Validator):
    """`VDMCheck2.sh`."""

    name = "VDMCheck2"
    source = f"Maven `{ARTIFACT.coordinates}`"
    command = "bash VDMCheck2.sh FMU"
    heavy = True

    def missing(self) -> str | None:
        return ARTIFACT.missing()

    def download(self) -> str | None:
        return ARTIFACT.download()

    def fetch(self) -> None:
        ARTIFACT.fetch()

    def version(self) -> str:
        return f"{ARTIFACT.version}, Java {java_version()}"

    def validate(self, fmu: Fmu) -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            with zipfile.ZipFile(ARTIFACT.path) as archive:
                archive.extractall(folder)
            (script,) = Path(folder).glob("*/VDMCheck2.sh")
            script.chmod(0o755)  # it looks for itself with `which`
            try:
                report = output_of(["bash", script, fmu.path.resolve()], Path(folder))
            except ProcessError as error:
                report = error.output or str(error)
        lines = [line.strip() for line in report.splitlines() if line.strip()]
        return [] if lines == ["No errors found."] else lines or ["no report"]
