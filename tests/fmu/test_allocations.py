"""No heap allocation in a communication step, nor in writing inputs and reading outputs around it.

Allocation in a real-time loop costs an unknown time. A small C++ master counts them from outside, in the whole process.
"""

import os
import shlex
import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest

from sigmafmu.fmu import Fmu

from .helpers import inputs, integrator_combinations, real_outputs

SOURCE = Path(__file__).with_name("allocation_counter.cpp")
COMPILER = shlex.split(os.environ.get("CXX", "g++"))

pytestmark = [
    pytest.mark.skipif(shutil.which(COMPILER[0]) is None, reason="needs a C++ compiler"),
    pytest.mark.skipif(os.uname().sysname != "Linux", reason="replaces glibc's malloc"),
    pytest.mark.skipif("asan" in os.environ.get("LD_PRELOAD", ""), reason="the sanitizer has its own malloc"),
]


@pytest.fixture(scope="module")
def counter(tmp_path_factory) -> Path:
    program = tmp_path_factory.mktemp("allocations") / "counter"
    headers = Path(fmpy.__file__).parent / "c-code"
    command = [*COMPILER, "-std=c++17", "-O1", "-Wall", "-Wextra", "-rdynamic", "-I", headers, SOURCE, "-o", program]
    subprocess.run([*command, "-ldl"], check=True, timeout=120)
    return program


def count(counter: Path, fmu: Fmu, settings: dict, steps: int = 1000) -> dict[str, int]:
    """Allocations by kind of call."""
    library = fmu.directory / "binaries" / fmpy.platform / f"{fmu.name}{fmpy.sharedLibraryExtension}"
    h = float(fmu.variables["integrator.stepSize"].start)
    references = [",".join(map(str, fmu.references(names))) for names in (inputs(fmu), real_outputs(fmu))]
    options = []
    for name, item in settings.items():
        variable = fmu.variables[name]
        value = next(i.value for i in variable.declaredType.items if i.name == item)
        options.append(f"{variable.valueReference}={value}")
    arguments = [str(library), fmu.description.guid, repr(2.5 * h), str(steps), *references, *options]
    result = subprocess.run([counter, *arguments], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return {name: int(number) for name, number in (line.split() for line in result.stdout.splitlines())}


@pytest.mark.parametrize("settings", integrator_combinations(), ids=lambda s: "-".join(s.values()))
def test_steps_allocate_nothing(counter, fmu, model, settings):
    counted = count(counter, fmu(model), settings)
    assert counted["instantiate"] > 100, "the counter counts"
    assert (counted["set"], counted["doStep"], counted["get"]) == (0, 0, 0)
