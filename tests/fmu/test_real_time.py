"""No heap allocation, lock or system call in a communication step, nor in what masters do around it: writing inputs,
reading outputs, setting tunable parameters, going back to an earlier state.

They cost an unknown time, which a real-time loop does not have. A small C++ master counts the first two from outside,
in the whole process, and has the kernel kill it at the third.
"""

import os
import shlex
import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest

import sigmafmu
from sigmafmu.fmu import Fmu

from .helpers import inputs, integrator_combinations, parameters, real_outputs

SOURCE = Path(__file__).with_name("real_time_master.cpp")
LIBRARY = Path(__file__).parents[2] / "models" / "library"
COMPILER = shlex.split(os.environ.get("CXX", "g++"))

pytestmark = [
    pytest.mark.skipif(shutil.which(COMPILER[0]) is None, reason="needs a C++ compiler"),
    pytest.mark.skipif(os.uname().sysname != "Linux", reason="replaces glibc's malloc"),
    pytest.mark.skipif("asan" in os.environ.get("LD_PRELOAD", ""), reason="the sanitizer has its own malloc"),
]


@pytest.fixture(scope="module")
def master(tmp_path_factory) -> Path:
    program = tmp_path_factory.mktemp("master") / "real_time_master"
    headers = Path(fmpy.__file__).parent / "c-code"
    command = [*COMPILER, "-std=c++17", "-O1", "-Wall", "-Wextra", "-rdynamic", "-I", headers, SOURCE, "-o", program]
    subprocess.run([*command, "-ldl"], check=True, timeout=120)
    return program


def count(master: Path, fmu: Fmu, settings: dict, steps: int = 1000) -> dict[str, int]:
    """Allocations by kind of call."""
    library = fmu.directory / "binaries" / fmpy.platform / f"{fmu.name}{fmpy.sharedLibraryExtension}"
    h = float(fmu.variables["integrator.stepSize"].start)
    tunable = [v.name for v in parameters(fmu, "tunable")]
    references = [",".join(map(str, fmu.references(names))) for names in (inputs(fmu), real_outputs(fmu), tunable)]
    options = []
    for name, item in settings.items():
        variable = fmu.variables[name]
        value = next(i.value for i in variable.declaredType.items if i.name == item)
        options.append(f"{variable.valueReference}={value}")
    resources = (fmu.directory / "resources").as_uri()
    moments = [float(v.start) for name, v in fmu.variables.items() if name.endswith((".xx", ".yy", ".zz"))]
    load = 0.05 * min([1.0, *(moment / 1e-5 for moment in moments)])  # a slender bar is not spun beyond all bounds
    run = [repr(2.5 * h), str(steps), *references, repr(load)]
    arguments = [str(library), fmu.description.guid, resources, *run, *options]
    result = subprocess.run([master, *arguments], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return {name: int(number) for name, number in (line.split() for line in result.stdout.splitlines())}


@pytest.mark.parametrize("settings", integrator_combinations(), ids=lambda s: "-".join(s.values()))
def test_steps_are_fit_for_real_time(master, fmu, model, settings):
    counted = count(master, fmu(model), settings)
    assert counted.pop("instantiate") > 100, "allocations are counted"
    assert counted == {"set": 0, "doStep": 0, "get": 0, "tune": 0, "restore": 0, "locks": 0}


FORMULATIONS = ("index3", "index2", "stabilizedIndex2")


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_steps_of_rolling_disks_are_fit_for_real_time(master, formulation):
    model = sigmafmu.load(LIBRARY / "Bicycle.yaml")
    counted = count(master, model.fmu, {"integrator.formulation": formulation})
    assert counted.pop("instantiate") > 100, "allocations are counted"
    assert counted == {"set": 0, "doStep": 0, "get": 0, "tune": 0, "restore": 0, "locks": 0}
