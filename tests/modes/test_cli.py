"""`sigmafmu modes`: what it prints and writes, and one line for every mistake."""

import subprocess
import sys

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from sigmafmu.modes import beam, cli, data, read, reduction, shapes

from ..command_line import fail, succeed
from .hexahedra import block

BEAM = "modes beam --length 1 --rectangle 0.02,0.03"
SINE = "modes shapes sine --length 0.3 --mass 0.5 --stiffness 4,6 --half-size 0.02,0.02"


@pytest.fixture(scope="session")
def fe_files(tmp_path_factory) -> str:
    """The options that name the three files."""
    folder = tmp_path_factory.mktemp("fe")
    K, M, X = block((1.0, 0.1, 0.15), (6, 1, 1), E=210e9, nu=0.3, density=7850.0)
    scipy.io.mmwrite(folder / "K.mtx", sp.coo_matrix(K), symmetry="symmetric", precision=17)
    sp.save_npz(folder / "M.npz", M)
    np.savetxt(folder / "nodes.csv", X, delimiter=",")
    return f"--stiffness {folder / 'K.mtx'} --mass {folder / 'M.npz'} --nodes {folder / 'nodes.csv'}"


def test_other_commands_need_no_scipy():
    code = "import sys; sys.modules['scipy'] = None; from sigmafmu.cli import app; app(['path', 'HeavyTop'])"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_without_scipy_the_extra_is_named():
    code = "import sys; sys.modules['scipy'] = None; from sigmafmu.cli import app; app(['modes', 'check', 'a.json'])"
    result = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert result.returncode == 1
    assert result.stderr.strip() == "Error: scipy is not installed; pip install 'sigmafmu[modes]' brings it"


@pytest.mark.parametrize(
    ("choices", "allowed"),
    [
        (cli.Theory, beam.THEORIES),
        (cli.Boundary, beam.BOUNDARIES),
        (cli.Shape, shapes.SHAPES),
        (cli.Frame, reduction.FRAMES),
        (cli.Scale, data.SCALES),
    ],
)
def test_choices_are_those_of_the_library(choices, allowed):
    assert [choice.value for choice in choices] == list(allowed)


@pytest.mark.parametrize("command", ["", "beam", "shapes", "fe", "check"])
def test_every_help_has_an_example(command):
    assert "Example: sigmafmu modes" in succeed(f"modes {command} --help")


def test_beam_prints_writes_draws_and_checks(tmp_path):
    file, png = tmp_path / "beam.json", tmp_path / "beam.png"
    output = succeed(f"{BEAM} --bending 2,1 --torsion 1 --axial 1 --damping 1,1e-6 --output {file} --plot {png}")
    data = read(file)
    assert data.names == ("bending y 1", "bending y 2", "bending z 1", "torsion 1", "axial 1")
    assert all(name in output for name in data.names)
    assert f"{data.frequencies[0]:.5g}" in output
    assert png.read_bytes().startswith(b"\x89PNG")
    np.testing.assert_allclose(data.D, np.eye(5) + 1e-6 * data.K, atol=1e-9)
    checked = succeed(f"modes check {file}")
    assert checked.splitlines()[:9] == output.splitlines()[:9]


def test_shapes_come_as_they_are_unless_scaled(tmp_path):
    file = tmp_path / "rod.json"
    succeed(f"{SINE} --output {file}")
    assert np.abs(read(file).modal_mass - np.eye(4)).max() > 0.5
    succeed(f"{SINE} --scale mass --output {file}")
    np.testing.assert_allclose(read(file).modal_mass, np.eye(4), atol=1e-12)


@pytest.mark.parametrize(
    ("options", "modes"),
    [
        ("--modes 3", 3),
        ("--method fixed --interface 0-3 --modes 4", 4),
        ("--method craig-bampton --interface 0-3 --interface 24,25,26-27 --modes 2", 14),
        ("--method craig-bampton --interface 0-3 --interface 24-27 --rigid-interfaces --modes 2", 8),
        ("--method craig-bampton --interface 0-3 --interface 24-27 --rigid-interfaces --frame free --modes 2", 8),
    ],
)
def test_finite_elements(tmp_path, fe_files, options, modes):
    file = tmp_path / "body.json"
    succeed(f"modes fe {fe_files} {options} --output {file}")
    data = read(file)
    assert data.modes == modes
    assert sp.issparse(data.mass)
    np.testing.assert_allclose(data.modal_mass, np.eye(modes), atol=1e-7)


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("modes beam --length 1", "the section is missing or given twice; give either --rectangle Y,Z or --diameter"),
        (f"{BEAM} --diameter 0.1", "the section is missing or given twice"),
        ("modes beam --length 1 --rectangle 0.02", "--rectangle 0.02: write two numbers with a comma between them"),
        (f"{BEAM} --bending 2.5,1", "--bending 2.5,1: write two whole numbers with a comma between them"),
        (f"{BEAM} --damping -1,0", "--damping -1,0: both numbers must not be negative"),
        (f"{BEAM} --plot beam.nonsense", "cannot write beam.nonsense"),
        (f"{BEAM} --output no/such/beam.json", "cannot write no/such/beam.json"),
        ("modes check none.json", "cannot read none.json"),
        ("modes fe FILES --interface 0-3", "free modes have no interface"),
        ("modes fe FILES --method fixed --interface a", "--interface a: write nodes as 0-8,12"),
        ("modes fe FILES --method fixed", "there are no interface nodes; give them with --interface"),
    ],
)
def test_mistakes_are_explained_in_one_line(command, message, fe_files, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert message in fail(command.replace("FILES", fe_files))
