"""The commands `linearize` and `trim`: what they print and write, and that every mistake gets one clear line."""

import json

import numpy as np
import pytest

import sigmafmu
from sigmafmu import _core
from sigmafmu.model import Model

from ..command_line import fail, run


def succeed(command):
    result = run(command)
    assert result.exit_code == 0, result.output
    return result


def test_linearize_prints_the_point_and_poles_and_writes_matrices(tmp_path):
    file = tmp_path / "crank.npz"
    names = "--input crankPivot.motorTorque --output guide.rate"
    result = succeed(f"linearize SliderCrank --at 0.1 {names} --file {file}")
    assert "SliderCrank at t = 0.1 s: 2 states, 1 input, 1 output" in result.stdout
    assert "crankPivot.angularRate" in result.stdout
    assert "warning: no equilibrium: rates change with up to" in result.stderr
    assert all(len(line) <= 80 for line in result.stdout.splitlines() if "wrote" not in line)
    matrices = np.load(file)
    assert matrices["A"].shape == (2, 2)
    assert list(matrices["states"]) == ["crankPivot.angle", "crankPivot.angularRate"]
    assert list(matrices["outputs"]) == ["guide.rate"]


@pytest.mark.parametrize("model", _core.mechanisms())
def test_every_model_fits_80_columns(model):
    result = succeed(f"linearize {model} --at 0.01")
    assert all(len(line) <= 80 for line in result.stdout.splitlines())


def test_settings_are_those_of_run(tmp_path):
    """Vectors, enumerations by name and inputs, as `run` takes them; the model is that of `linearize`."""
    file = tmp_path / "crank.npz"
    settings = {"gravity": "0,0,-1", "integrator.formulation": "index3", "crankPivot.motorTorque": "0.1"}
    options = " ".join(f"--set {name}={value}" for name, value in settings.items())
    assert "crankPivot.motorTorque = 0.1" in succeed(f"linearize SliderCrank --at 0.1 {options} --file {file}").stdout
    expected = sigmafmu.linearize("SliderCrank", 0.1, parameters=settings)
    np.testing.assert_array_equal(np.load(file)["A"], expected.A)
    assert not np.allclose(expected.A, sigmafmu.linearize("SliderCrank", 0.1).A)


def test_a_spinning_body_is_told_with_its_frame():
    assert "top turns: its rotation is measured in axes of W" in succeed("linearize HeavyTop").stderr
    assert "in axes of the body" in succeed("linearize HeavyTop --frame body").stderr
    assert "turns" not in succeed("linearize HeavyTop --trim").stderr


def test_linearize_at_rest_with_figures_and_samples(tmp_path):
    options = "--free crankPivot.motorTorque --hold crankPivot.angle=0.5 --sample-time 1e-3"
    names = "--input crankPivot.motorTorque --output crankPivot.angle"
    files = {name: tmp_path / name for name in ("bode.png", "poles.png", "crank.mat", "crank.json")}
    figures = f"--bode {files['bode.png']} --pole-map {files['poles.png']}"
    for file in ("crank.mat", "crank.json"):
        result = succeed(f"linearize SliderCrank {options} {names} {figures} --file {files[file]}")
    assert "SliderCrank at rest, sampled with 0.001 s: 2 states, 1 input, 1 output" in result.stdout
    assert "warning" not in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(files)
    assert files["bode.png"].read_bytes().startswith(b"\x89PNG")


def test_trim_writes_what_starts_the_fmu_at_rest(fmu, tmp_path):
    file = tmp_path / "start.json"
    result = succeed(f"trim SliderCrank --free crankPivot.motorTorque --hold crankPivot.angle=0.5 --file {file}")
    assert "SliderCrank at rest" in result.stdout
    assert "crankPivot.motorTorque = -0.116638" in result.stdout
    assert "unstable: neighbours leave with 5.426 1/s" in result.stdout
    run = Model(fmu("SliderCrank")).run(stop_time=0.1, parameters=json.loads(file.read_text()))
    np.testing.assert_allclose(run["crankPivot.angle"], 0.5, atol=1e-9)


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("linearize SliderCrank --at inf", "the time must be a finite number of seconds, at least 0, not inf"),
        ("linearize SliderCrank --at nan", "at least 0, not nan"),
        ("linearize SliderCrank --at -1", "at least 0, not -1"),
        ("linearize SlideCrank", "unknown model 'SlideCrank'"),
        ("linearize SliderCrank --input x", "no input 'x'"),
        ("linearize SliderCrank --output crankPivot.angel", "did you mean crankPivot.angle"),
        ("linearize SliderCrank --set crank.masss=1", "no variable 'crank.masss'; did you mean crank.mass"),
        ("linearize SliderCrank --set crank.mass=0", "crank.mass is 0 kg; it must be"),
        ("linearize SliderCrank --set gravity", "write it as NAME=VALUE"),
        ("linearize SliderCrank --file x.csv", "its name must end with .npz, .mat or .json"),
        ("linearize SliderCrank --file no/x.npz", "there is no folder no"),
        ("linearize SliderCrank --sample-time 0", "the sample time must be a positive number"),
        ("linearize SliderCrank --bode x.png", "choose them with --input and --output"),
        ("linearize SliderCrank --coordinate x", "no coordinate 'x'"),
        ("trim SliderCrank --hold crankPivot.angle", "write it as NAME=NUMBER"),
        ("trim SliderCrank --hold crankPivot.angle=x", "write it as NAME=NUMBER"),
        ("trim SliderCrank --free crank.mass", "no input 'crank.mass'"),
        ("trim SliderCrank --at 0.1 --hold crankPivot.angle=0.5", "found no equilibrium of SliderCrank"),
        ("trim SliderCrank --file no/x.json", "cannot write no/x.json"),
    ],
)
def test_mistakes_are_explained_in_one_line(command, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert message in fail(command)
    assert not list(tmp_path.iterdir())
