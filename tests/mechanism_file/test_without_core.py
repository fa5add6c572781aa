"""Mechanism files and FMUs need no compiled Python module: the wheel for all platforms has none."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest

from sigmafmu import _core
from sigmafmu.mechanism_file.rotations import axes_with_z

WITHOUT_CORE = "import sys; sys.modules['sigmafmu._core'] = None\n"  # importing it is a ModuleNotFoundError


def run(code: str, folder) -> str:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_CORE + textwrap.dedent(code)], cwd=folder, text=True, capture_output=True
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def command(*arguments: str) -> str:
    return f"from sigmafmu.cli import app; app({list(arguments)!r}, standalone_mode=False)"


def test_a_mechanism_file_is_checked_built_and_run(tmp_path):
    run(command("init", "Pendulum"), tmp_path)
    checked = run(command("check", "Pendulum.yaml", "--plot", "figure.png"), tmp_path)
    assert "degrees of freedom: 4 (12 velocities, 8 independent joint equations)" in checked
    assert "; together 2" in checked
    assert (tmp_path / "figure.png").stat().st_size > 1000
    run(command("build", "Pendulum.yaml"), tmp_path)
    run(command("run", "Pendulum.fmu", "--stop-time", "0.1", "--output", "fmu.csv"), tmp_path)
    run(command("run", "Pendulum.yaml", "--stop-time", "0.1", "--output", "file.csv"), tmp_path)
    assert (tmp_path / "fmu.csv").read_text() == (tmp_path / "file.csv").read_text()


@pytest.mark.parametrize(
    "code",
    ["sigmafmu.load('HeavyTop').linearize()", "sigmafmu.trim(sigmafmu.load('HeavyTop'))", "import sigmafmu.realtime"],
)
def test_what_needs_the_compiled_module_says_so_in_one_sentence(code, tmp_path):
    said = run(
        f"""
        import sigmafmu
        try:
            {code}
        except sigmafmu.SigmafmuError as error:
            print(error)
        """,
        tmp_path,
    )
    assert said == (
        "this needs sigmafmu's compiled module, which the wheel for all platforms has not; "
        "`pip install --no-binary sigmafmu sigmafmu` compiles it and needs a C++ compiler\n"
    )


def test_frames_along_an_axis_are_the_cores_to_the_bit():
    random = np.random.default_rng(1)
    axes = random.normal(size=(500, 3)) * 10 ** random.uniform(-3, 3, size=(500, 1))
    axes[::7, 1] = 0
    for z in [*axes, *np.eye(3), *-np.eye(3), np.ones(3), np.array([1.0, 1, 0])]:
        np.testing.assert_array_equal(axes_with_z(z), _core.axes_with_z(z))
