"""The mechanisms that tests and benchmarks share."""

import json

import numpy as np
import pytest

from research.mechanisms import FAMILIES, LARGEST, MECHANISMS, WRITTEN, named, robots, write
from sigmafmu import SigmafmuError, _core

from .helpers import simulation

SMALL = [*(name for name in MECHANISMS if name != "Humanoid"), *(f"{family}7" for family in FAMILIES)]
FREEDOMS = {
    "FreeBody": 6,
    "PlanarFourBar": 1,
    "DoubleFourBar": 1,
    "Bricard": 1,
    "RevoluteArm7": 7,
    "Chain7": 21,
    "RevoluteChain7": 7,
    "RandomTree7": 7,
    "FourBarRow7": 1,
}


@pytest.mark.parametrize("name", SMALL)
def test_freedom(name):
    assert _core.freedom(named(name).multibody).degrees == FREEDOMS[name]


@pytest.mark.parametrize("name", SMALL)
def test_initial_values_fit_the_joints(name):
    """Assembly moves nothing: the four-bar's rates come from differences, accurate to 1e-8."""
    multibody = named(name).multibody
    q, v = _core.assemble(multibody)
    start = np.concatenate([np.concatenate([b.initial_position, b.initial_quaternion]) for b in multibody.bodies])
    rates = [np.concatenate([b.initial_velocity, b.initial_angular_velocity]) for b in multibody.bodies]
    assert np.abs(q - start).max() <= 1e-15 * (1 + np.abs(start).max())
    assert np.abs(v - np.concatenate(rates)).max() <= (1e-8 if name == "PlanarFourBar" else 1e-14)


@pytest.mark.parametrize("name", SMALL)
def test_energy_is_kept(name):
    mechanism = named(name)
    system = _core.System(mechanism.multibody)
    _, q, v, _ = simulation(mechanism, step_size=1e-3).trajectory(0.5, 500)
    energies = np.array([system.energy(*row) for row in zip(q, v, strict=True)])
    scale = system.energy(q[-1], v[-1]) - system.energy(q[-1], 0 * v[-1])  # kinetic
    assert np.abs(energies - energies[0]).max() <= 1e-3 * scale


def test_files_are_read_back(tmp_path):
    (path,) = write(("RevoluteArm7",), tmp_path / "new")
    assert json.loads(path.read_text(encoding="utf-8"))["name"] == path.stem == "RevoluteArm7"
    assert _core.to_json(_core.from_json(path.read_text(encoding="utf-8"))) == path.read_text(encoding="utf-8")


def test_every_name_is_a_model_identifier():
    for name in WRITTEN:
        if not name.endswith("00"):
            assert named(name).name == ("DoubleFourBar" if name == "FourBarRow2" else name)


def test_a_large_mechanism_has_the_variables_of_its_ends():
    names = _core.Slave(named("Chain101")).names
    assert {name.partition(".")[0].partition("[")[0] for name in names} == {
        "link101",
        "joint1",
        "energy",
        "constraint",
        "gravity",
        "integrator",
    }


@pytest.mark.parametrize("name", ["Chain", "Chain0", f"Chain{LARGEST + 1}", "Bricard2", "RevoluteArm8", ""])
def test_unknown_names(name):
    with pytest.raises(SigmafmuError, match=f"no such mechanism: {name}; there are FreeBody, "):
        named(name)


# --- against Pinocchio -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("free", [True, False], ids=["free base", "fixed base"])
def test_humanoid_accelerates_as_in_pinocchio(free):
    """All bodies' accelerations equal those of the articulated-body algorithm, at random states and torques."""
    pin = pytest.importorskip("pinocchio", reason="needs Pinocchio; `make bench` installs it")
    try:
        model = robots.humanoid_model(free)
    except SigmafmuError as error:
        pytest.skip(str(error))
    data, rng = model.createData(), np.random.default_rng(7)
    for _ in range(5):
        q = pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq))
        q[:3] = rng.normal(size=3) if free else q[:3]
        v, torque = rng.normal(size=(2, model.nv))
        torque[: 6 if free else 0] = 0
        mechanism = robots.from_pinocchio(model, q, v, "Humanoid")
        system = _core.System(mechanism.multibody)
        u = np.zeros(system.input_size)
        hinges = torque[6:] if free else torque
        u[[system.motor_index(j) for j in range(len(hinges))]] = hinges
        found = system.accelerations(*_core.assemble(mechanism.multibody), u)[0].reshape(-1, 6)
        pin.forwardKinematics(model, data, q, v, pin.aba(model, data, q, v, torque))
        scale = np.abs(found).max()
        for i in range(1, model.njoints):
            R, lever, a, w = data.oMi[i].rotation, model.inertias[i].lever, data.a[i], data.v[i].angular
            center = a.linear + np.cross(w, data.v[i].linear)  # of the joint's origin, not of the field
            center = center + np.cross(a.angular, lever) + np.cross(w, np.cross(w, lever))
            assert np.abs(found[i - 1, :3] - R @ center).max() <= 1e-9 * scale
            assert np.abs(found[i - 1, 3:] - a.angular).max() <= 1e-9 * scale
