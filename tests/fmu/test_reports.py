"""What an FMU reports to a logger that formats it, in a master with another locale, and when memory runs out.

The logger of FMI is variadic like printf; a C++ master compiled here goes through every kind of report with one that
calls vsnprintf, as most do.
"""

import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest

from sigmafmu import _core

from .helpers import bodies, inputs, is_made_of_a_file, modal_files, reads_resources

SOURCE = Path(__file__).with_name("reporting_master.cpp")
FMU_SOURCES = Path(__file__).parents[2] / "fmu_src"
COMPILER = shlex.split(os.environ.get("CXX", "g++"))
SANITIZED = "asan" in os.environ.get("LD_PRELOAD", "")
REFERENCES = ("stepSize", "spectralRadius", "formulation", "maxHalvings", "steps")

pytestmark = [
    pytest.mark.skipif(shutil.which(COMPILER[0]) is None, reason="needs a C++ compiler"),
    pytest.mark.skipif(os.uname().sysname != "Linux", reason="replaces glibc's malloc"),
    pytest.mark.skipif(SANITIZED, reason="the sanitizer has its own malloc"),
]


@pytest.fixture(scope="module")
def master(tmp_path_factory) -> Path:
    program = tmp_path_factory.mktemp("master") / "reporting_master"
    headers = Path(fmpy.__file__).parent / "c-code"
    command = [*COMPILER, "-std=c++17", "-O1", "-Wall", "-Wextra", "-rdynamic", "-I", headers, SOURCE, "-o", program]
    subprocess.run([*command, "-ldl"], check=True, timeout=120)
    return program


@pytest.fixture
def run(master, fmu, model):
    """`run(mode, *bad resources, **environment)`: the lines that the master prints."""

    def run(mode: str, *bad_resources: str, **environment: str) -> list[str]:
        f = fmu(model)
        library = f.directory / "binaries" / fmpy.platform / f"{f.name}{fmpy.sharedLibraryExtension}"
        motors = [name for name in inputs(f) if name.endswith(".motorTorque")]
        torques = [name for name in inputs(f) if name.endswith(".torque[2]")]
        torque = motors[0] if motors else torques[-1]  # the first body may slide on a rail, where no torque turns it
        body = bodies(f)[0]
        others = [torque, f"{body}.initialQuaternion[1]", f"{body}.acceleration[1]"]
        references = f.references([*(f"integrator.{name}" for name in REFERENCES), *others])
        arguments = [library, f.description.guid, (f.directory / "resources").as_uri(), *references, *bad_resources]
        done = subprocess.run(
            [master, mode, *map(str, arguments)],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, f"{done.returncode} after:\n{done.stdout[-2000:]}{done.stderr}"
        return done.stdout.splitlines()

    return run


GUID = "The GUID does not fit; it must be "
MISSING = ": it cannot be opened; the FMU needs this file with the modal data of a flexible body."
MISSING_MODEL = ": it cannot be opened; the FMU is made of this file."
BAD_RESOURCES = {
    "http://100%s/%n": "The resource location is http://100%s/%n; it must be a file URI, as file:///folder.",
    "file:///x%2520%25s%25n/resources": MISSING,
    "file:///tmp/%s%00/x": "The resource location is file:///tmp/%s%00/x; %00 is not possible in a path.",
}


def test_every_report_reaches_a_logger_that_formats(run, fmu, model):
    lines = run("reports", *BAD_RESOURCES)
    reports = [tuple(line.split("|", 3)) for line in lines]
    last = len(fmu(model).variables) - 1
    files = [path.name for path in modal_files(fmu(model))]
    read = {"identity.json": MISSING_MODEL} if is_made_of_a_file(fmu(model)) else dict.fromkeys(files, MISSING)
    error, discard, warning = "logStatusError", "logStatusDiscard", "logStatusWarning"
    expected = [
        ("", "3", error, "The instance name is missing; it must not be empty."),
        ("100%s", "3", error, "This FMU is for co-simulation alone."),
        ("100%s", "3", error, f"{GUID}{fmu(model).description.guid}."),
    ]
    for name, missing in read.items():
        for text in BAD_RESOURCES.values():
            expected.append(("it", "3", error, f"/x%20%s%n/resources/{name}{missing}" if text == MISSING else text))
        first = "mechanism.json" if is_made_of_a_file(fmu(model)) else name
        expected.append(("it", "3", error, f"The resource location is missing; this FMU reads {first} from there."))
    expected += [
        ("50%s", "3", error, text)
        for text in (
            'The log category "100%s%n" is unknown.',
            f"Value reference 1234567 is unknown; this FMU has 0 to {last}.",
            "fmi2SetReal got a null pointer for 1234567 values.",
            "integrator.stepSize is -1234567.5 s; it must be finite, above 0.",
            "integrator.formulation is 1234567; it must be 1 (index3), 2 (index2) or 3 (stabilizedIndex2).",
            "integrator.steps is computed; it cannot be set.",
            "fmi2SetString: this FMU has no variables of that type.",
            "stopTime is 0 s; it must not be before startTime 1234567.5 s.",
            'fmi2DoStep is not allowed in the state "instantiated".',
        )
    ]
    text = "this information exists for asynchronous steps alone; steps here end before fmi2DoStep returns."
    expected.append(("50%s", "2", discard, f"fmi2GetStatus: {text}"))
    expected.append(("50%s", "3", error, "The bytes are no serialized FMU state of sigmafmu."))
    assert reports[: len(expected)] == expected

    rest = reports[len(expected) :]
    assert {r[0] for r in rest} == {"50%s"}
    texts = [r[3] for r in rest]
    assert re.fullmatch(r"The buffer for the serialized FMU state has 3 bytes; \d+ are needed.", texts[0])
    warnings = [r[3] for r in rest if r[2] == warning]
    index3 = "integrator.formulation index3 with integrator.spectralRadius 1 lets"
    variables = fmu(model).variables
    has_joints = any(name.endswith(".reactionForce[1]") for name in variables)
    assert any(text.startswith(index3) for text in warnings) == has_joints
    spin = "integrator.stepSize is 1234.5 s, but "
    spins = any(float(v.start or 0) for name, v in variables.items() if ".initialAngularVelocity[" in name)
    assert any(text.startswith(spin) for text in warnings) == spins
    assert "fmi2CancelStep: no step is pending; steps end before fmi2DoStep returns." in texts
    assert "The communication point is 1234567.5 s, but the FMU is at 0 s." in texts
    assert any(re.fullmatch(r"The derivative order of .* is 1234567; it must be 1 to 2.", text) for text in texts)
    if model == "HeavyTop":
        events = [r for r in rest if r[2] == "logEvents"]
        assert [r[1] for r in events] == ["0"]
        assert events[0][3].endswith("repeated internal steps with half the step size.")
    if model in _core.mechanisms():  # others may bear a step of 1234.5 s
        assert rest[-1][1:3] == ("2", discard)
        assert texts[-1].startswith("The internal step to t = ")


def test_reports_do_not_follow_the_locale_of_the_master(run, tmp_path):
    """Neither the C++ locale, with a decimal comma and digits in groups, nor C's, where the system can make one."""
    environment = {}
    if shutil.which("localedef"):
        folder = tmp_path / "de_DE.UTF-8"
        done = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder], capture_output=True)
        if done.returncode == 0:
            environment = {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(tmp_path)}
    assert run("locale", *BAD_RESOURCES, **environment) == run("reports", *BAD_RESOURCES)


JSON_ENDS = "the JSON library allocates where it frees its data, and ends the process if it cannot"


@pytest.mark.parametrize("mode", ["allocation", "memory"])
def test_nothing_is_thrown_when_memory_runs_out(run, fmu, model, mode):
    """Whichever allocation fails, alone or with all after it: a null pointer or a status, a message, and no crash."""
    if reads_resources(fmu(model)):
        pytest.skip(JSON_ENDS)
    *reports, count = run(mode)
    assert "There is not enough memory." in reports
    assert "" not in reports, "nothing fails without a report"
    assert int(count.removeprefix("allocations: ")) > 100


@pytest.mark.parametrize("mode", ["allocation-calls", "memory-calls"])
def test_no_function_throws_when_memory_runs_out(run, fmu, model, mode):
    """Whichever allocation of a call fails, and whether the call would have succeeded or been refused: an error or a
    discard, one message, and an instance as if the call had not been made."""
    if is_made_of_a_file(fmu(model)):  # also to tell that the GUID does not fit
        pytest.skip(JSON_ENDS)
    allocations = dict(line.split("|") for line in run(mode))
    assert len(allocations) > 50
    assert len([name for name, count in allocations.items() if int(count) > 0]) > 30


def test_texts_are_made_in_one_place():
    """Other streams and printf would follow the locale."""
    users = {
        path.relative_to(FMU_SOURCES).as_posix()
        for path in FMU_SOURCES.rglob("*.*")
        if re.search(r"std::o?stringstream(?! \w+ = text_stream\()|printf\(", path.read_text())
    }
    assert users <= {"text/text.h"}
