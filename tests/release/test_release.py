"""The FMUs that are given away: platforms, what they ask of a system, and results that do not depend on the compiler.

They are those of the folder `dist`, which `make release` fills.
"""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

import sigmafmu

ROOT = Path(__file__).parents[2]
DIST = ROOT / "dist"
ZIG_CACHE = ROOT / "build" / "cross" / "zig-cache"  # of tools/release.py: has the C library by now
OLDEST_GLIBC = (2, 17)
STEPS = 50
POSE = 7  # position and quaternion of the first body have the value references 0 to 6

pytestmark = pytest.mark.release


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """Function that unpacks the released FMU of a model."""
    folder = tmp_path_factory.mktemp("dist")

    def unpack(model: str) -> Path:
        with zipfile.ZipFile(DIST / f"{model}.fmu") as archive:
            archive.extractall(folder / model)
        return folder / model

    return unpack


def binary(tree: Path, platform: str) -> Path:
    (file,) = (tree / "binaries" / platform).iterdir()
    return file


def run(*command: str | Path, **environment: str) -> str:
    done = subprocess.run(list(map(str, command)), text=True, capture_output=True, env=os.environ | environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_model_is_released_for_every_platform(models):
    assert sorted(path.stem for path in DIST.glob("*.fmu")) == models
    for model in models:
        with zipfile.ZipFile(DIST / f"{model}.fmu") as released, zipfile.ZipFile(sigmafmu.fmu_path(model)) as built:
            names = set(released.namelist())
            assert {f"binaries/linux64/{model}.so", f"binaries/win64/{model}.dll"} <= names
            rest = {name for name in built.namelist() if not name.startswith("binaries/") and not name.endswith("/")}
            assert rest <= names
            for name in rest:
                assert released.read(name) == built.read(name), name


def test_linux_binary_runs_on_old_distributions(unpacked, model):
    listing = run("objdump", "-p", "-T", binary(unpacked(model), "linux64"))
    versions = {tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_([\d.]+)", listing)}
    assert versions
    assert max(versions) <= OLDEST_GLIBC
    needed = set(re.findall(r"NEEDED\s+(\S+)", listing))
    assert needed <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "ld-linux-x86-64.so.2"}
    assert "GLIBCXX" not in listing
    exported = {line.split()[-1] for line in listing.splitlines() if re.search(r"\sg\s+DF\s+\.text", line)}
    assert exported
    assert all(name.startswith("fmi2") for name in exported)


def test_windows_binary_needs_windows_alone(unpacked, model):
    listing = run("objdump", "-p", binary(unpacked(model), "win64"))
    needed = set(re.findall(r"DLL Name: (\S+)", listing))
    system = re.compile(r"(api-ms-win-crt-.*|kernel32|ntdll|ucrtbase)\.dll", re.IGNORECASE)
    assert [name for name in needed if not system.fullmatch(name)] == []
    table = listing.split("[Ordinal/Name Pointer] Table")[1].split("\n\n")[0]
    exported = re.findall(r"\[\s*\d+\].*?\b(\w+)$", table, re.MULTILINE)
    assert len(exported) == 34  # all functions of FMI 2.0 for co-simulation
    assert all(name.startswith("fmi2") for name in exported)


def poses(program: list[str | Path], library: str | Path, model: str) -> np.ndarray:
    """Pose of the first body after each of some default communication steps, as the program run_fmu prints it.

    A torque about its z axis acts on the body: not every mechanism moves by itself.
    """
    description = fmpy.read_model_description(DIST / f"{model}.fmu")
    H = description.defaultExperiment.stepSize
    torque = next(v.valueReference for v in description.modelVariables if v.name.endswith(".torque[3]"))
    resources = (Path(library).parents[2] / "resources").as_uri()
    if "win" in Path(library).parent.name:
        resources = resources.replace("file:///", "file:///Z:/")  # wine's drive for /
    arguments = map(str, [description.guid, resources, STEPS, H, POSE, torque])
    text = run(*program, library, *arguments, WINEDEBUG="-all")
    return np.array([line.split() for line in text.splitlines()], dtype=float)


@pytest.fixture(scope="module")
def runner(tmp_path_factory):
    """Function that compiles run_fmu.c."""
    folder = tmp_path_factory.mktemp("runner")
    source = Path(__file__).with_name("run_fmu.c")
    headers = Path(fmpy.__file__).parent / "c-code"

    def compile_for(name: str, compiler: list[str], *libraries: str) -> Path:
        program = folder / name
        command = [*compiler, "-std=c11", "-I", headers, source, *libraries, "-o", program]
        run(*command, ZIG_GLOBAL_CACHE_DIR=str(ZIG_CACHE))
        return program

    return compile_for


def assert_same_motion(a: np.ndarray, b: np.ndarray) -> None:
    """Compilers order sums differently: roundings of 1e-16 that grow over the steps, far below the scheme's error."""
    assert a.shape == b.shape == (STEPS, POSE)
    assert np.ptp(a, axis=0).max() > 1e-6, "the body must move"
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-10)


def test_old_linux_binary_computes_what_the_new_one_does(unpacked, runner, fmu, model):
    program = runner("run_fmu", [os.environ.get("CXX", "g++"), "-x", "c"], "-ldl")
    released = poses([program], binary(unpacked(model), "linux64"), model)
    assert_same_motion(released, poses([program], binary(fmu(model).directory, "linux64"), model))


def test_windows_binary_computes_what_the_one_of_linux_does(unpacked, runner, fmu, model):
    wine = shutil.which("wine") or shutil.which("wine64")
    if not wine:
        pytest.skip("wine is not installed")
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu"]
    windows = runner("run_fmu.exe", [*zig, "-O3", "-s"])  # the flags of the FMUs: Zig compiles its libraries for each
    linux = runner("run_fmu", [os.environ.get("CXX", "g++"), "-x", "c"], "-ldl")
    released = poses([wine, windows], binary(unpacked(model), "win64"), model)
    assert_same_motion(released, poses([linux], binary(fmu(model).directory, "linux64"), model))
