"""Flexible mechanisms: accuracy against tests/references, and their modal data in the FMU's resources.

The references sum over all nodes in minimal coordinates; they share no code with the FMUs and are better than every
figure asked for here by three orders of magnitude.
"""

import json
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from research.reference import History, differences
from research.reference.clouds import SpinUp, conrod_cloud, pendulum_cloud
from sigmafmu.compare import read_reference
from sigmafmu.fmu import Fmu, LogMessage

from .helpers import EPS, Instance, assert_same_bits, inputs, modal_files, orders

REFERENCES = Path(__file__).resolve().parents[1] / "references"
FLEXIBLE = ("FlexiblePendulum", "FlexibleSliderCrank", "SpinUpBeam")
SPIN_UP = SpinUp()

flexible_models = pytest.mark.parametrize("model", FLEXIBLE)


@cache
def reference(model: str) -> History:
    return read_reference(REFERENCES / f"{model}.csv")[1]


def drive(instance: Instance, t: float) -> None:
    """The torque of the spin-up manoeuvre, J dΩ/dt, with two derivatives: a parabola over the next step."""
    rise, peak = SPIN_UP.rise_time, SPIN_UP.inertia * SPIN_UP.final_speed / SPIN_UP.rise_time
    on, wave = t < rise - 1e-9, 2 * np.pi / rise
    instance.set({"hubPivot.motorTorque": peak * (1 - np.cos(wave * t)) * on})
    instance.set_input_derivatives(1, {"hubPivot.motorTorque": peak * wave * np.sin(wave * t) * on})
    instance.set_input_derivatives(2, {"hubPivot.motorTorque": peak * wave**2 * np.cos(wave * t) * on})


def errors(instance: Instance, settings: dict, stop_time: float) -> dict[str, float]:
    """Largest differences from the reference per kind of quantity, up to stop_time."""
    model = instance.fmu.name
    times = reference(model)["time"]
    count = int(np.searchsorted(times, stop_time + 1e-9))
    other = {name: values[:count] for name, values in reference(model).items() if ".quaternion[" not in name}
    columns = [name for name in other if name != "time"]
    instance.start(settings)
    rows = [instance.reals(columns)]
    parts = 5 if model == "SpinUpBeam" else 1  # what parabolas miss of the torque is then 1e-10 rad/s
    for t in times[: count - 1]:
        for k in range(parts):
            if model == "SpinUpBeam":
                drive(instance, t + k * times[1] / parts)
            instance.step(times[1] / parts)
        rows.append(instance.reals(columns))
    return differences({"time": other["time"], **dict(zip(columns, np.array(rows).T, strict=True))}, other)


ACCURACY = {  # s, largest errors with the default step: m, m, rad/s
    "FlexiblePendulum": (2.0, {"position": 3e-6, "modal": 5e-5, "angularVelocity": 3e-3}),
    "FlexibleSliderCrank": (2.0, {"position": 1e-5, "modal": 1e-5, "angularVelocity": 1e-2}),
    "SpinUpBeam": (20.0, {"position": 4e-6, "modal": 1e-6, "angularVelocity": 6e-8}),
}


@pytest.mark.parametrize("model", ACCURACY)
def test_accuracy_with_default_settings(new, model):
    stop_time, allowed = ACCURACY[model]
    found = errors(new(model), {}, stop_time)
    assert {kind: found[kind] for kind, limit in allowed.items() if not found[kind] <= limit} == {}


CONVERGENCE = {"FlexiblePendulum": (0.5, 5e-4), "FlexibleSliderCrank": (0.3, 2e-4), "SpinUpBeam": (10.0, 1e-2)}  # s, s


@pytest.mark.parametrize("formulation", ["index3", "index2", "stabilizedIndex2"])
@pytest.mark.parametrize("model", CONVERGENCE)
def test_second_order(new, model, formulation):
    stop_time, h = CONVERGENCE[model]
    found = [
        errors(new(model), {"integrator.stepSize": step, "integrator.formulation": formulation}, stop_time)
        for step in (h, h / 2, h / 4)
    ]
    for kind in ("position", "modal", "modalRate"):
        assert orders([f[kind] for f in found])[-1] == pytest.approx(2.0, abs=0.15), (kind, [f[kind] for f in found])


@pytest.mark.parametrize("sigma", [0.0, 1.0, 1.7])
@pytest.mark.parametrize("model", ["FlexiblePendulum", "FlexibleSliderCrank"])
def test_second_order_for_every_sigma(new, model, sigma):
    stop_time, h = CONVERGENCE[model]
    found = [
        errors(new(model), {"integrator.stepSize": step, "integrator.sigma": sigma}, stop_time)["modal"]
        for step in (h, h / 2, h / 4)
    ]
    assert orders(found)[-1] == pytest.approx(2.0, abs=0.15), found


@pytest.mark.parametrize("model", ["FlexiblePendulum", "FlexibleSliderCrank"])
def test_energy_is_conserved(new, model):
    """No damping; the energy of the deformation belongs to it. What the method loses is of second order or better."""
    worst = []
    h = float(new(model).fmu.variables["integrator.stepSize"].start)
    for step in (h, h / 2):
        instance = new(model).start({"integrator.stepSize": step})
        first, values = instance.get("energy.total"), []
        for _ in range(50):
            instance.step(0.01)
            values.append(instance.get("energy.total"))
        worst.append(np.abs(np.array(values) - first).max())
    assert worst[0] <= 1e-3 * new(model).start().get("energy.kinetic")
    assert orders(worst)[0] >= 1.85


def test_rayleigh_damping_takes_energy(new):
    """As much as M and K say: dE/dt = −ζ̇ᵀ (a M + b K) ζ̇, with the matrices of the cloud."""
    cloud = pendulum_cloud()
    a, b = 0.3, 2e-3
    D = a * cloud.modal_mass + b * cloud.stiffness
    instance = new("FlexiblePendulum").start({"beam.massDamping": a, "beam.stiffnessDamping": b})
    for _ in range(10):
        instance.step(0.02)
        rate = instance.get("beam.modalRate")
        found = instance.output_derivatives(["energy.total"])[0]
        assert found == pytest.approx(-rate @ D @ rate, rel=1e-5)
    instance.set({"beam.massDamping": 0.0, "beam.stiffnessDamping": 0.0})  # tunable
    assert abs(instance.output_derivatives(["energy.total"])[0]) <= 1e-5 * (rate @ D @ rate)


def test_initial_modal_values_are_taken(new):
    modal, rate = (0.01, -0.02, 0.03, 0.004), (0.1, 0.2, -0.3, 0.4)
    instance = new("FlexiblePendulum").start({"beam.initialModal": modal, "beam.initialModalRate": rate})
    np.testing.assert_allclose(instance.get("beam.modal"), modal, rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(instance.get("beam.modalRate"), rate, rtol=0, atol=64 * EPS)
    # ξ², ξ³ in y and in z; R = I
    for name, xi in (("tip", 1.0), ("beam.station2", 0.4)):
        y, z = (modal[k] * xi**2 + modal[k + 1] * xi**3 for k in (0, 2))
        np.testing.assert_allclose(instance.get(f"{name}.position"), [xi, y, z], rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(
        instance.get("tip.deflection"), [0.0, modal[0] + modal[1], modal[2] + modal[3]], rtol=0, atol=8 * EPS
    )


def test_spin_up_beam_stays_at_rest_without_torque(new):
    instance = new("SpinUpBeam").start()
    first = instance.reals(instance.all_outputs[0])
    instance.steps(0.1, 20)
    assert_same_bits(instance.reals(instance.all_outputs[0]), first)


# --- resources -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "cloud"),
    [
        ("FlexiblePendulum/beam", pendulum_cloud()),
        ("FlexibleSliderCrank/rod", conrod_cloud(0.3, 0.5)),
        ("SpinUpBeam/beam", SPIN_UP.cloud),
    ],
    ids=FLEXIBLE,
)
def test_resources_are_the_clouds_of_the_definition(fmu, file, cloud):
    model, _, body = file.partition("/")
    data = json.loads((fmu(model).directory / "resources" / f"{body}.json").read_text())
    for key, expected in (("X", cloud.nodes), ("m", cloud.masses), ("Phi", cloud.modes), ("K", cloud.stiffness)):
        np.testing.assert_allclose(data[key], expected, rtol=8 * EPS, atol=8 * EPS, err_msg=key)


@pytest.fixture
def unpacked(fmu) -> Callable[[str], tuple[Fmu, Path]]:
    """Function that unzips an FMU anew: it, and its file of modal data."""

    def unpack(model: str) -> tuple[Fmu, Path]:
        own = Fmu(fmu(model).path)
        (path,) = modal_files(own)
        return own, path

    return unpack


def edit(path: Path, change: Callable[[dict], None]) -> None:
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


def refusal(fmu: Fmu, resources: str | None = None) -> str:
    """The one message of an instantiation that fails."""
    messages: list[LogMessage] = []
    with pytest.raises(Exception, match="nstantiate"):
        fmu.instantiate(messages.append)
    assert len(messages) == 1, [str(m) for m in messages]
    assert (messages[0].status, messages[0].category) == ("error", "logStatusError")
    return messages[0].text


def drop(key: str) -> Callable[[dict], None]:
    return lambda data: data.pop(key)


def put(key: str, value) -> Callable[[dict], None]:
    return lambda data: data.update({key: value})


def without_last_mode(data: dict) -> None:
    data["K"] = [row[:-1] for row in data["K"][:-1]]
    data["Phi"] = [[row[:-1] for row in node] for node in data["Phi"]]


def without_last_section(data: dict) -> None:
    for key in ("X", "m", "Phi", "Theta"):
        data[key] = data[key][:-4]


MISTAKES = {
    "missing key": (drop("K"), "the key K is missing; X, Phi, K and m or M are needed."),
    "no mass": (drop("m"), "there must be either m (a mass for each node) or M (a mass matrix)."),
    "unknown key": (put("k", 1), "the key k is unknown."),
    "other format": (put("format", "something"), 'format is "something"; it must be "sigmafmu modes".'),
    "number of modes": (without_last_mode, "it has 3 modes (rows of K); this mechanism has variables for 4."),
    "number of nodes": (without_last_section, "it has 40 nodes; tip is at node 40 (counted from 0)."),
    "length": (lambda d: d["m"].pop(), "m has 43 entries; it must have 44."),
    "no number": (lambda d: d["X"][3].__setitem__(1, "a"), 'X[3][1] is "a"; it must be a number.'),
    "negative mass": (lambda d: d["m"].__setitem__(0, -1.0), "beam.modal.masses[1] is -1 kg; it must not be negative."),
    "indefinite": (lambda d: d["K"][0].__setitem__(0, -4.0), "beam.modal.stiffness has the eigenvalue"),
    "not symmetric": (lambda d: d["K"][0].__setitem__(1, 0.0), "it must be symmetric."),
    "sparse": (put("M", 1), "there must be either m (a mass for each node) or M (a mass matrix)."),
}


@pytest.mark.parametrize(("change", "text"), MISTAKES.values(), ids=MISTAKES)
def test_bad_modal_data_are_refused_by_name(unpacked, change, text):
    fmu, path = unpacked("FlexiblePendulum")
    edit(path, change)
    message = refusal(fmu)
    assert message.startswith(f"{path}: ")
    assert text in message


def test_a_file_that_is_missing_or_no_json_is_refused_by_name(unpacked):
    fmu, path = unpacked("FlexiblePendulum")
    path.write_text("{")
    assert refusal(fmu).startswith(f"{path}: it is no JSON file: ")
    path.unlink()
    assert refusal(fmu).startswith(f"{path}: it cannot be opened; ")


def test_rigid_models_never_look_at_their_resources(fmu):
    own = Fmu(fmu("HeavyTop").path)
    shutil.rmtree(own.directory / "resources")
    Instance(own).free()


def test_other_modal_data_make_another_model(unpacked, new):
    """A beam of twice the stiffness: that of the reference solved for it."""
    fmu, path = unpacked("FlexiblePendulum")
    edit(path, lambda d: d.update(K=(2 * np.array(d["K"])).tolist()))
    stiff, usual = Instance(fmu), new("FlexiblePendulum")
    for instance in (stiff, usual):
        instance.start()
        instance.steps(1e-3, 100)
    bent = [np.abs(i.get("beam.modal")).max() for i in (stiff, usual)]
    stiff.free()
    assert bent[0] < 0.9 * bent[1]


@pytest.mark.parametrize("form", ["dense", "sparse"])
def test_mass_matrix_in_place_of_masses(unpacked, new, form):
    """The same masses as a diagonal matrix: the same motion to rounding."""
    fmu, path = unpacked("FlexiblePendulum")

    def change(data: dict) -> None:
        masses = data.pop("m")
        n = list(range(len(masses)))
        data["M"] = np.diag(masses).tolist() if form == "dense" else {"rows": n, "columns": n, "values": masses}

    edit(path, change)
    instance, usual = Instance(fmu).start(), new("FlexiblePendulum").start()
    found, expected = (i.trajectory(1e-3, 50)[-1] for i in (instance, usual))
    instance.free()
    names = usual.all_outputs[0] + usual.all_outputs[1]
    for name, a, b in zip(names, found, expected, strict=True):
        assert a == pytest.approx(b, rel=1e-9, abs=1e-9), name


def test_the_folder_of_the_resources_may_have_any_name(fmu, tmp_path):
    """Percent-encoded in the URI."""
    folder = tmp_path / "a folder, 100% ünïcode #1"
    shutil.copytree(fmu("FlexiblePendulum").directory, folder)
    copy = Fmu(fmu("FlexiblePendulum").path)
    copy.directory = folder
    Instance(copy).free()


@flexible_models
def test_no_file_is_read_after_instantiation(unpacked, new, model):
    fmu, path = unpacked(model)
    instance = Instance(fmu)
    path.unlink()
    usual = new(model).start()
    instance.start()
    for each in (instance, usual):
        each.steps(1e-2, 5)
    assert_same_bits(instance.outputs(), usual.outputs())
    instance.reset().start()
    instance.steps(1e-2, 5)
    assert_same_bits(instance.outputs(), usual.outputs())
    instance.free()


@flexible_models
def test_instances_share_nothing(new, model):
    """Two of them in turns, one with loads, move as if each were alone."""
    a, b, alone = (new(model).start() for _ in range(3))
    b.set(dict.fromkeys(inputs(b.fmu), 0.1))
    for _ in range(10):
        a.step(1e-2)
        b.step(1e-2)
        alone.step(1e-2)
    assert_same_bits(a.outputs(), alone.outputs())
    assert not np.array_equal(a.outputs(), b.outputs())
