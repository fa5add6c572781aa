"""Runs binaries of any platform with run_fmu.c, without FMPy."""

import os
import subprocess
from pathlib import Path

import fmpy
import numpy as np

STEPS = 50
POSE = 7  # position and quaternion of the first body have the value references 0 to 6


def binary(tree: Path, platform: str) -> Path:
    """The binary of an unpacked FMU."""
    (file,) = (tree / "binaries" / platform).iterdir()
    return file


def run(*command: str | Path, **environment: str) -> str:
    """What a command prints; it must not fail."""
    done = subprocess.run(list(map(str, command)), text=True, capture_output=True, env=os.environ | environment)
    assert done.returncode == 0, (done.stdout + done.stderr)[-8000:]
    return done.stdout


def poses(program: list[str | Path], library: Path) -> np.ndarray:
    """Pose of the first body after each of some default communication steps, as the program run_fmu prints it.

    A torque about its z axis acts on the body: not every mechanism moves by itself.
    """
    tree = library.parents[2]
    description = fmpy.read_model_description(tree)
    H = description.defaultExperiment.stepSize
    torque = next(v.valueReference for v in description.modelVariables if v.name.endswith(".torque[3]"))
    resources = (tree / "resources").as_uri()
    if library.parent.name == "win64":
        resources = resources.replace("file:///", "file:///Z:/")  # wine's drive for /
    arguments = map(str, [description.guid, resources, STEPS, H, POSE, torque])
    text = run(*program, library, *arguments, WINEDEBUG="-all")
    return np.array([line.split() for line in text.splitlines()], dtype=float)


def assert_same_motion(a: np.ndarray, b: np.ndarray) -> None:
    """Compilers order sums differently: roundings of 1e-16 that grow over the steps, far below the scheme's error."""
    assert a.shape == b.shape == (STEPS, POSE)
    assert np.ptp(a, axis=0).max() > 1e-6, "the body must move"
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-10)
