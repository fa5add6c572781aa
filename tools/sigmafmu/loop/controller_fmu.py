"""Makes an FMU of a law with PythonFMU."""

import hashlib
import inspect
import shutil
import sys
import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from sigmafmu import SigmafmuError, extras
from sigmafmu.loop.controllers import Law
from sigmafmu.loop.units import exponents
from sigmafmu.masters.process import ProcessError, output_of

SCRIPT = """\
from {slave} import LawSlave
from {module} import {law}


class {law}Slave(LawSlave):
    law = {law}
    start_values = {values!r}
    base_units = {base_units!r}
    stop_time = {stop_time!r}
    step_size = {step_size!r}
"""


def build(
    law: type[Law],
    folder: Path,
    *,
    step_size: float,
    stop_time: float,
    values: Mapping[str, float] | None = None,
) -> Path:
    """Write `<folder>/<Law>.fmu`, with `values` as start values of its parameters; times of its experiment in s.

    The class must be at the top of a file of its own that imports the standard library only: this file goes into the
    FMU, which runs in every master on a machine with Python, without sigmafmu.
    """
    if not find_spec("pythonfmu"):
        raise SigmafmuError(extras.missing("pythonfmu"))
    try:
        source = Path(inspect.getsourcefile(law))
    except (OSError, TypeError) as error:
        raise SigmafmuError(f"{law.__name__} must be in a Python file to become an FMU: {error}") from error
    values = {name: float(value) for name, value in (values or {}).items()}
    unknown = sorted(values.keys() - law.parameters.keys())
    if unknown:
        raise SigmafmuError(f"{law.__name__} has no parameter '{unknown[0]}'; it has {', '.join(law.parameters)}")
    # all files get names of their own: other modules and other FMUs of the same law may be loaded in the same process
    files = (source, Path(__file__).with_name("fmu_slave.py"))
    units = sorted({unit for table in (law.inputs, law.outputs, law.parameters) for _, unit, _ in table.values()})
    settings = {
        "law": law.__name__,
        "values": values,
        "base_units": {unit: exponents(unit) for unit in units if exponents(unit) is not None},
        "stop_time": float(stop_time),
        "step_size": float(step_size),
    }
    contents = b"".join(file.read_bytes() for file in files) + repr(settings).encode()
    mark = hashlib.sha256(contents).hexdigest()[:12]
    module, slave = (f"{file.stem}_{mark}" for file in files)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        script = work / f"{law.__name__}Slave_{mark}.py"
        script.write_text(SCRIPT.format(module=module, slave=slave, **settings), encoding="utf-8")
        own = [f"{module}.py", f"{slave}.py"]
        for file, copy in zip(files, own, strict=True):
            shutil.copy(file, work / copy)
        # in a process of its own: PythonFMU imports the script and leaves it and its folder in sys.modules and sys.path
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", script.name, "-d", folder.resolve(), *own]
        try:
            output_of(command, work)
        except ProcessError as error:
            raise SigmafmuError(f"PythonFMU cannot make an FMU of {law.__name__}: {error}") from error
    return folder / f"{law.__name__}.fmu"
