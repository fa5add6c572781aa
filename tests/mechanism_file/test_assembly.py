"""Loops close from rough places, whatever way bodies are turned; those that cannot are told with what they miss."""

import json

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from sigmafmu import _core
from sigmafmu.mechanism_file.load import load, load_text
from sigmafmu.mechanism_file.tree_starts import change, tree_starts

from .helpers import LIBRARY, complaint

LOOPS = ("PlanarFourBar", "DoubleFourBar", "Bricard", "StewartPlatform", "AndrewsSqueezer", "DoubleWishbone", "Flyball")


def in_frames(definition: dict, move) -> dict:
    """The content of a mechanism file of the same bodies and joints by frames, bodies where `move` has them."""
    bodies, joints = {}, {}
    for body in definition["bodies"]:
        bodies[body["name"]] = {"mass": body["mass"], "inertia": body["inertia"]} | move(body)
    for joint in definition["joints"]:
        frames = {}
        for key in ("frame1", "frame2"):
            q = Rotation.from_matrix(joint[key]["orientation"]["matrix"]).as_quat(scalar_first=True)
            frames[key] = {"position": joint[key]["position"], "orientation": {"quaternion": q.tolist()}}
        joints[joint["name"]] = {"type": joint["type"], "bodies": joint["bodies"], **frames}
    return {"sigmafmu": 1, "name": "Rough", "bodies": bodies, "joints": joints}


def roughly(definition: dict, seed: int, turn: float, shift: float):
    """Moves bodies by a turn [rad] and a shift, of the mechanism's size."""
    rng = np.random.default_rng(seed)
    size = np.ptp([body["position"] for body in definition["bodies"]])

    def move(body):
        turned = Rotation.from_rotvec(turn * rng.normal(size=3) / np.sqrt(3))
        old = Rotation.from_quat(body["orientation"]["quaternion"], scalar_first=True)
        position = np.array(body["position"]) + shift * size * rng.normal(size=3) / np.sqrt(3)
        return {
            "position": position.tolist(),
            "orientation": {"quaternion": (turned * old).as_quat(scalar_first=True).tolist()},
        }

    return move


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(("turn", "shift"), [(0.3, 0.2), (3, 2)])
@pytest.mark.parametrize("name", LOOPS)
def test_loops_close_from_rough_places(name, turn, shift, seed):
    definition = load(LIBRARY / f"{name}.yaml").definition
    found = load_text(json.dumps(in_frames(definition, roughly(definition, seed, turn, shift))), "rough.yaml")
    q, v = _core.assemble(found.mechanism.multibody)
    phi = _core.System(found.mechanism.multibody).constraints(q, v)[0]
    assert np.abs(phi).max() < 1e-11 * (1 + np.abs(q).max())
    assert found.moves


@pytest.mark.parametrize("name", LOOPS)
def test_loops_close_from_where_bodies_hang(name):
    definition = load(LIBRARY / f"{name}.yaml").definition
    load_text(json.dumps(in_frames(definition, lambda _: {})), "hung.yaml")


@pytest.mark.parametrize("name", LOOPS)
def test_a_tree_hangs_where_a_closed_mechanism_is(name):
    """Nothing has to move then, whichever joints make the tree."""
    file = load(LIBRARY / f"{name}.yaml")
    q, _ = _core.assemble(file.mechanism.multibody)
    closed = json.loads(json.dumps(file.definition))
    for i, body in enumerate(closed["bodies"]):
        body["position"], body["orientation"] = (
            q[7 * i : 7 * i + 3].tolist(),
            {"quaternion": q[7 * i + 3 : 7 * i + 7].tolist()},
        )
    records = {name: _Record(joint) for name, joint in ((j["name"], j) for j in closed["joints"])}
    mass = sum(body["mass"] for body in closed["bodies"])
    for start in list(tree_starts(closed, records))[:3]:
        assert change(closed, start) < 1e-20 * mass


class _Record(dict):
    """A joint of a definition as a file would have it, without coordinates."""

    def __init__(self, joint: dict):
        super().__init__(type=joint["type"], bodies=joint["bodies"])


def test_the_change_is_that_of_kinetic_energy_in_a_second():
    """Twice the kinetic energy of a body that moves and turns so at constant rate."""
    v, w, J = np.array([0.1, 0.2, -0.3]), np.array([0.3, -0.2, 0.4]), np.diag([1.0, 2.0, 2.5])
    body = {"mass": 3.0, "inertia": {"xx": 1.0, "yy": 2.0, "zz": 2.5, "xy": 0.0, "xz": 0.0, "yz": 0.0}}
    turned = Rotation.from_rotvec(w).as_quat(scalar_first=True).tolist()
    start = {"bodies": [body | {"position": [0, 0, 0], "orientation": {"quaternion": [1, 0, 0, 0]}}]}
    end = {"bodies": [body | {"position": v.tolist(), "orientation": {"quaternion": turned}}]}
    assert change(start, end) == pytest.approx(3 * v @ v + w @ J @ w, rel=1e-12)


def places(bodies: list, q: np.ndarray) -> dict:
    """A definition with its bodies at q, as far as `change` reads it."""
    found = []
    for i, body in enumerate(bodies):
        position, quaternion = q[7 * i : 7 * i + 3].tolist(), q[7 * i + 3 : 7 * i + 7].tolist()
        found.append(body | {"position": position, "orientation": {"quaternion": quaternion}})
    return {"bodies": found}


def test_a_hinge_moves_its_bar_by_the_least():
    """m |p - (c cos a, c sin a)|^2 + J (a - a0)^2 is the least: a is a root of its derivative."""
    m, J, c, p, a0 = 2.0, 0.3, 0.5, np.array([0.7, 0.4, 0.0]), 0.2
    file = load_text(
        f"sigmafmu: 1\nname: Bar\nbodies:\n  bar: {{mass: {m}, inertia: [0.1, 0.3, {J}], "
        f"position: {p.tolist()}, orientation: {{rotation_vector: [0, 0, {a0}]}}}}\n"
        "joints:\n  hinge: {type: revolute, bodies: [ground, bar], frame1: {}, "
        f"frame2: {{position: [{-c}, 0, 0]}}}}\n",
        "bar.yaml",
    )
    slope = lambda a: m * c * (p[0] * np.sin(a) - p[1] * np.cos(a)) + J * (a - a0)  # noqa: E731
    expected = brentq(slope, 0, 1, xtol=1e-14)
    q, _ = _core.assemble(file.mechanism.multibody)
    np.testing.assert_allclose(q[:3], [c * np.cos(expected), c * np.sin(expected), 0], atol=1e-9)


@pytest.mark.parametrize("name", LOOPS)
def test_loops_move_by_the_least(name):
    """No way that the joints allow makes the change smaller."""
    definition = load(LIBRARY / f"{name}.yaml").definition
    rough = roughly(definition, 0, 0.1, 0.05)
    q0 = []
    for body in definition["bodies"]:
        place = rough(body)  # in the order in which in_frames asks
        q0 += [*place["position"], *place["orientation"]["quaternion"]]
    file = load_text(json.dumps(in_frames(definition, roughly(definition, 0, 0.1, 0.05))), "rough.yaml")
    system = _core.System(file.mechanism.multibody)
    q, v = _core.assemble(file.mechanism.multibody)
    start = places(definition["bodies"], np.array(q0))
    least = change(start, places(definition["bodies"], q))
    _, values, rows = np.linalg.svd(system.constraints(q, 0 * v)[2])
    free = rows[np.sum(values > 1e-7 * values[0]) :]
    assert len(free) > 0
    for direction in free:
        for way in (1e-3, -1e-3):
            moved = system.project_positions(system.compose(q, way * direction))
            assert change(start, places(definition["bodies"], moved)) > least * (1 - 1e-7)


def bars(*lengths: float) -> str:
    """Bars in a row between the origin and the point (1, 0, 0), with hinges about z."""
    names = [f"bar{i + 1}" for i in range(len(lengths))]
    text = "sigmafmu: 1\nname: Bars\nbodies:\n"
    for name, length in zip(names, lengths, strict=True):
        text += f"  {name}: {{mass: 1, inertia: [0.01, 0.1, 0.1], center_of_mass: [{length / 2}, 0, 0]}}\n"
    text += "joints:\n"
    for i, (before, after) in enumerate(zip(["ground", *names], [*names, "ground"], strict=True)):
        at = f"frame1: {{position: [{lengths[i - 1] if i else 0}, 0, 0]}}"
        end = ", frame2: {position: [1, 0, 0]}" if after == "ground" else ""
        text += f"  hinge{i + 1}: {{type: revolute, bodies: [{before}, {after}], {at}{end}}}\n"
    return text


def test_what_cannot_close_is_told_with_what_it_misses():
    found = complaint(bars(0.3, 0.3))
    assert "joints hinge1, hinge2 and hinge3 cannot be closed together, they miss by 0.4 m" in found
    found = complaint(bars(0.2, 1.7, 0.1))
    assert "cannot be closed together, they miss by 0.4 m" in found
    assert all(f"hinge{i}" in found for i in (1, 2, 3, 4))
    load_text(bars(0.6, 0.6), "bars.yaml")


def test_a_disk_is_put_on_its_plane_without_rolling():
    """The least change lifts and leans it: what rolling without slip ties to a lean is no matter of positions."""
    text = (LIBRARY / "RollingCoin.yaml").read_text(encoding="utf-8")
    rough, radius, mass, inertia, lean = 0.05, 0.1, 1.0, 2.5e-3, np.radians(30)
    found = load_text(text.replace("0.08660254037844387]", f"{rough}]", 1), "coin.yaml")
    (coin,) = found.definition["bodies"]

    def slope(turn):  # of m (r cos(lean + turn) - z)^2 / 2 + J turn^2 / 2
        return -mass * (radius * np.cos(lean + turn) - rough) * radius * np.sin(lean + turn) + inertia * turn

    turn = brentq(slope, 0.0, 1.0, xtol=1e-14)
    assert coin["position"] == pytest.approx([0, 0, radius * np.cos(lean + turn)], abs=1e-9)
    vector = Rotation.from_quat(coin["orientation"]["quaternion"], scalar_first=True).as_rotvec()
    assert vector == pytest.approx([lean + turn, 0, 0], abs=1e-9)
