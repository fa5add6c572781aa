"""Maestro, the master of INTO-CPS."""

import csv
import json
import re
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from sigmafmu.fmu import Fmu
from sigmafmu.masters import Master, Run, ToolError, Trajectory
from sigmafmu.masters.java import Artifact, java_version
from sigmafmu.masters.process import ProcessError, output_of

ARTIFACT = Artifact("org.into-cps.maestro", "maestro", "3.1.1", "jar", "jar-with-dependencies", 64)
FMU, RECORDED, DRIVEN = "{mechanism}", "recorded", "driven"


class Maestro(Master):
    """Two instances, since Maestro wants a connection: a force of the recorded one drives the other."""

    name = "Maestro"
    source = f"Maven `{ARTIFACT.coordinates}`"
    command = "java -jar maestro.jar import sg1 -output=out -i -fsp . mm.json simulation.json"
    heavy = True
    note = "Maestro reads no enumerations (its issue 410), so it got a copy whose XML declares them as Integer"

    def missing(self) -> str | None:
        return ARTIFACT.missing()

    def download(self) -> str | None:
        return ARTIFACT.download()

    def fetch(self) -> None:
        ARTIFACT.fetch()

    def version(self) -> str:
        return f"{ARTIFACT.version}, Java {java_version()}"

    def simulate(self, run: Run) -> Trajectory:
        with tempfile.TemporaryDirectory() as name:
            copy = Path(name) / run.fmu.path.name
            without_enumerations(run.fmu.path, copy)
            return self.simulate_file(run, copy)

    def simulate_file(self, run: Run, path: Path) -> Trajectory:
        """`simulate` with the file `path` as it is."""
        outputs = [*run.recorded("Real"), *run.recorded("Integer")]
        source, sink = _connection(run.fmu)
        multi_model = {
            "fmus": {FMU: path.resolve().as_uri()},
            "connections": {f"{FMU}.{RECORDED}.{source}": [f"{FMU}.{DRIVEN}.{sink}"]},
            "parameters": {f"{FMU}.{RECORDED}.{name}": value for name, value in run.parameters.items()},
            "logVariables": {f"{FMU}.{RECORDED}": outputs},
        }
        simulation = {
            "startTime": 0.0,
            "endTime": run.stop_time,
            "algorithm": {"type": "fixed-step", "size": run.H},
            "reportProgress": False,
            "loggingOn": False,
        }
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for file, content in (("mm.json", multi_model), ("simulation.json", simulation)):
                (folder / file).write_text(json.dumps(content), encoding="utf-8")
            options = ["import", "sg1", "-output=out", "-i", "-fsp", ".", "mm.json", "simulation.json"]
            try:
                output_of(["java", "-jar", ARTIFACT.path, *options], folder)
            except ProcessError as error:
                causes = re.findall(r"^Caused by: \S+: (.+)$", error.output, re.MULTILINE)
                raise ToolError(causes[-1] if causes else str(error)) from error
            with (folder / "out" / "outputs.csv").open(encoding="utf-8", newline="") as file:
                header, *rows = csv.reader(file)
        table = np.array(rows, dtype=float)[1:]  # without t = 0
        return {output: table[:, header.index(f"{FMU}.{RECORDED}.{output}")] for output in outputs}


def without_enumerations(source: Path, target: Path) -> None:
    """Copy an FMU with its enumeration variables declared as Integer, which is how their values are passed anyway."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb"<Enumeration declaredType=\"\w+\"", b"<Integer", content)
            new.writestr(name, content)


def _connection(fmu: Fmu) -> tuple[str, str]:
    """An output and an input of the same unit, for example a reaction force and a force on a body."""
    variables = fmu.description.modelVariables
    for sink in (v for v in variables if v.causality == "input" and v.type == "Real"):
        for source in (v for v in variables if v.causality == "output" and v.type == "Real"):
            if source.unit == sink.unit:
                return source.name, sink.name
    raise ToolError(f"{fmu.name} has no output that could drive one of its inputs")
