"""Discrete time, python-control, files and figures."""

import json
import sys

import control
import numpy as np
import pytest
from scipy.io import loadmat
from scipy.signal import cont2discrete

import sigmafmu
from sigmafmu import SigmafmuError, _core

PNG = b"\x89PNG\r\n\x1a\n"
MATRICES = ("A", "B", "C", "D", "x0", "u0", "y0", "dx0")
NAMES = ("states", "inputs", "outputs")


@pytest.fixture(scope="module")
def linear():
    return sigmafmu.linearize(
        "HeavyTop", 0.1, u0={"top.torque[1]": 2.0}, inputs=["top.torque"], outputs=["top.position", "top.quaternion"]
    )


def test_discrete_model_is_the_exact_hold(linear):
    discrete = linear.to_discrete(1e-2)
    A, B, C, D, _ = cont2discrete((linear.A, linear.B, linear.C, linear.D), 1e-2)
    for ours, theirs in ((discrete.A, A), (discrete.B, B), (discrete.C, C), (discrete.D, D)):
        np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert discrete.sample_time == 1e-2
    for wrong in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(SigmafmuError, match="the sample time must be a positive number of seconds"):
            linear.to_discrete(wrong)
    with pytest.raises(SigmafmuError, match="is discrete already"):
        discrete.to_discrete(1e-2)


@pytest.mark.parametrize("sample_time", [None, 1e-3])
def test_python_control_takes_the_model(linear, sample_time):
    model = linear.to_discrete(sample_time) if sample_time else linear
    system = model.to_control()
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["top_torque_1", "top_torque_2", "top_torque_3"]
    assert system.output_labels[0] == "top_position_1"
    assert system.state_labels[0] == "top_rotationW_1"
    assert system.dt == (sample_time or 0)
    omega = np.array([1.0, 10.0, 100.0])
    theirs = np.moveaxis(control.frequency_response(system, omega, squeeze=False).complex, -1, 0)
    np.testing.assert_allclose(model.frequency_response(omega), theirs, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("model", _core.mechanisms())
def test_names_for_python_control_are_unique(model):
    linear = sigmafmu.linearize(model)
    system = linear.to_control()
    assert (system.nstates, system.ninputs, system.noutputs) == tuple(len(getattr(linear, kind)) for kind in NAMES)


def test_npz_holds_matrices_and_names(linear, tmp_path):
    linear.save(tmp_path / "top.npz")
    loaded = np.load(tmp_path / "top.npz")
    for key in MATRICES:
        np.testing.assert_array_equal(loaded[key], getattr(linear, key))
    for key in NAMES:
        assert tuple(loaded[key]) == getattr(linear, key)
    assert loaded["u0"].tolist() == [2.0, 0.0, 0.0]


def test_mat_holds_matrices_and_names(linear, tmp_path):
    linear.save(tmp_path / "top.mat")
    assert [path.name for path in tmp_path.iterdir()] == ["top.mat"]
    loaded = loadmat(tmp_path / "top.mat", simplify_cells=True)
    for key in MATRICES:
        np.testing.assert_array_equal(loaded[key], getattr(linear, key))
    for key in NAMES:
        assert tuple(loaded[key]) == getattr(linear, key)


def test_json_holds_matrices_and_names(linear, tmp_path):
    linear.save(tmp_path / "top.json")
    loaded = json.loads((tmp_path / "top.json").read_text())
    for key in MATRICES:
        np.testing.assert_array_equal(loaded[key], getattr(linear, key))
    for key in NAMES:
        assert tuple(loaded[key]) == getattr(linear, key)
    assert loaded["start_values"]["top.torque[1]"] == 2.0


@pytest.mark.parametrize(
    ("package", "use", "message"),
    [
        ("control", lambda m, _: m.to_control(), "control is not installed"),
        ("scipy.linalg", lambda m, _: m.to_discrete(1e-3), "scipy is not installed"),
        ("scipy.io", lambda m, path: m.save(path / "top.mat"), "scipy is not installed"),
    ],
)
def test_missing_packages_are_explained(linear, tmp_path, monkeypatch, package, use, message):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SigmafmuError, match=message + r".*pip install 'sigmafmu\[linear\]'"):
        use(linear, tmp_path)


@pytest.mark.parametrize(
    ("name", "message"), [("top.txt", "must end with .npz, .mat or .json"), ("no/top.npz", "there is no folder")]
)
def test_impossible_files_are_explained(linear, tmp_path, name, message):
    with pytest.raises(SigmafmuError, match=message):
        linear.save(tmp_path / name)


@pytest.mark.parametrize("sample_time", [None, 1e-3])
def test_figures(linear, tmp_path, sample_time):
    model = sigmafmu.linearize("SliderCrank", 0.3, inputs=["crankPivot.motorTorque"], outputs=["guide.displacement"])
    model = model.to_discrete(sample_time) if sample_time else model
    for draw in (model.bode, model.pole_map):
        path = tmp_path / f"{draw.__name__}.png"
        draw(path)
        assert path.read_bytes().startswith(PNG)
    with pytest.raises(SigmafmuError, match=r"1 to 4 inputs and 1 to 6 outputs, not 3 and 7"):
        linear.bode(tmp_path / "many.png")
