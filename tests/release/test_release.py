"""The FMUs that are given away: platforms, what they ask of a system, and results that do not depend on the compiler.

They are those of the folder `dist`, which `make release` fills.
"""

import re
import shutil
import zipfile
from pathlib import Path

import pytest

import sigmafmu

from .running import assert_same_motion, binary, poses, run

DIST = Path(__file__).parents[2] / "dist"
OLDEST_GLIBC = (2, 17)

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


def test_old_linux_binary_computes_what_the_new_one_does(unpacked, runner, fmu, model):
    program = runner("linux64")
    released = poses([program], binary(unpacked(model), "linux64"))
    assert_same_motion(released, poses([program], binary(fmu(model).directory, "linux64")))


def test_windows_binary_computes_what_the_one_of_linux_does(unpacked, runner, fmu, model):
    wine = shutil.which("wine") or shutil.which("wine64")
    if not wine:
        pytest.skip("wine is not installed")
    released = poses([wine, runner("win64")], binary(unpacked(model), "win64"))
    assert_same_motion(released, poses([runner("linux64")], binary(fmu(model).directory, "linux64")))
