"""The sources inside an FMU: complete, listed where tools look for them, and good for a binary that does the same."""

import os
import shutil
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.model_description import read_build_description
from fmpy.util import create_zip_archive

from .helpers import Instance


@pytest.fixture
def tree(fmu, model, tmp_path) -> Path:
    """The whole FMU, unzipped."""
    with zipfile.ZipFile(fmu(model).path) as archive:
        archive.extractall(tmp_path / model)
    return tmp_path / model


@pytest.fixture(autouse=True)
def tools(monkeypatch):
    """Compile with both cores, and with cmake from the environment that runs the tests."""
    monkeypatch.setenv("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
    monkeypatch.delenv("LD_PRELOAD", raising=False)
    if not shutil.which("cmake"):
        import cmake

        monkeypatch.setenv("PATH", cmake.CMAKE_BIN_DIR, prepend=os.pathsep)


def test_every_source_is_listed_and_there(tree, model):
    files = {path.relative_to(tree / "sources").as_posix() for path in (tree / "sources").rglob("*.cpp")}
    (configuration,) = read_build_description(tree)  # validates it against FMI's schema
    (file_set,) = configuration.sourceFileSets
    assert configuration.modelIdentifier == model
    assert file_set.language == "C++17"
    assert set(file_set.sourceFiles) == files
    listed = ElementTree.parse(tree / "modelDescription.xml").iterfind("CoSimulation/SourceFiles/File")
    assert {file.get("name") for file in listed} == files


def test_nothing_but_the_sources_and_the_system_is_included(tree, model):
    """With no other include path than the folder itself, and none of the packages that this build found."""
    sources = tree / "sources"
    compiler = os.environ.get("CXX", "g++")
    command = [
        compiler,
        "-std=c++17",
        "-M",
        "-I",
        sources,
        *([f"models/{model}.cpp", "model.cpp"] if (sources / "model.cpp").exists() else ["fmi/model_of_file.cpp"]),
        "fmi/fmi2_functions.cpp",
    ]
    done = subprocess.run(command, cwd=sources, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    used = {Path(word) for word in done.stdout.replace("\\\n", " ").split() if word.endswith(".h")}
    outside = [path for path in used if path.is_absolute() and not path.is_relative_to("/usr")]
    assert [path for path in outside if not path.is_relative_to(sources) and "gcc" not in path.parts] == []


def assert_same_motion(rebuilt: Path, fmu, model: str) -> None:
    """Not optimized, sums have other roundings of 1e-16 that grow over the steps, far below the scheme's error."""
    H, n = 1e-3, 50
    there, here = (Instance(f).start() for f in (type(fmu(model))(rebuilt), fmu(model)))
    try:
        a, b = there.trajectory(H, n), here.trajectory(H, n)
        scale = np.maximum(1.0, np.abs(b).max(axis=0))
        assert np.abs(b).max() > 0
        assert (np.abs(a - b) / scale).max() < 1e-9
    finally:
        there.free()
        here.free()


@pytest.mark.release
@pytest.mark.parametrize("model", ["HeavyTop"])
def test_fmpy_rebuilds_the_binary(tree, fmu, model, tmp_path):
    """What `fmpy compile` does."""
    shutil.rmtree(tree / "binaries")
    build_platform_binary(tree, configuration="Debug")
    create_zip_archive(tmp_path / "rebuilt.fmu", tree)
    assert_same_motion(tmp_path / "rebuilt.fmu", fmu, model)


@pytest.mark.release
@pytest.mark.parametrize("model", ["SliderCrank"])
def test_cmake_rebuilds_the_binary(tree, fmu, model, tmp_path):
    """As the head of sources/CMakeLists.txt says; the binary shows nothing but fmi2*."""
    shutil.rmtree(tree / "binaries")
    build = tmp_path / "build"
    for command in (
        ["cmake", "-S", tree / "sources", "-B", build, "-DCMAKE_BUILD_TYPE=Debug"],
        ["cmake", "--build", build, "--target", "install"],
    ):
        done = subprocess.run(command, text=True, capture_output=True)
        assert done.returncode == 0, done.stdout + done.stderr
    (binary,) = (tree / "binaries" / fmpy.platform).iterdir()
    assert binary.name == model + fmpy.sharedLibraryExtension
    symbols = subprocess.run(["nm", "-D", "--defined-only", binary], text=True, capture_output=True, check=True).stdout
    assert all(line.split()[-1].startswith("fmi2") for line in symbols.splitlines())
    create_zip_archive(tmp_path / "rebuilt.fmu", tree)
    assert_same_motion(tmp_path / "rebuilt.fmu", fmu, model)
