"""Animated glTF: the validator of its makers finds nothing, and tracks are those of the result."""

import json
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sigmafmu.view import rotations
from sigmafmu.view.gltf import Z_UP, gltf
from sigmafmu.view.subject import model_of, scene_of_fmu, to_record

from .viewer_build import viewer_build

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ROOT / "models" / "library"
VALIDATE = """
const validator = require("gltf-validator");
const data = new Uint8Array(require("fs").readFileSync(0));
validator.validateBytes(data).then((report) => console.log(JSON.stringify(report.issues)));
"""


@pytest.fixture(scope="module")
def written():
    found = {}

    def get(target):
        if target not in found:
            model = model_of(target)
            scene = scene_of_fmu(model.fmu)
            result = model.run(0.2, outputs=to_record(model, scene))
            found[target] = gltf(scene, result), result
        return found[target]

    return get


@pytest.mark.parametrize("target", ["FlexibleSliderCrank", "HighSpeedRotor", str(LIBRARY / "DoubleWishbone.yaml")])
def test_validator_finds_nothing(written, target):
    build = viewer_build()
    modules = build.NPM / "node_modules"
    if not (modules / "gltf-validator").is_dir():
        pytest.skip("npm's gltf-validator is not in build/npm: `make lint` fetches it")
    node, _, environment = build.programs()
    command = [str(node), "-e", VALIDATE]
    environment = {**environment, "NODE_PATH": str(modules)}
    done = subprocess.run(command, input=written(target)[0], capture_output=True, env=environment, check=True)
    issues = json.loads(done.stdout)
    assert issues["messages"] == []
    assert issues["numErrors"] == issues["numWarnings"] == 0


def chunks(data):
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def array(content, binary, number):
    accessor = content["accessors"][number]
    view = content["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    return np.frombuffer(binary, "<f4", accessor["count"] * width, view["byteOffset"]).reshape(-1, width)


def test_tracks_are_those_of_the_result(written):
    data, result = written("FlexibleSliderCrank")
    content, binary = chunks(data)
    animation = content["animations"][0]
    tracks = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        key = content["nodes"][channel["target"]["node"]]["name"], channel["target"]["path"]
        tracks[key] = [array(content, binary, sampler[end]) for end in ("input", "output")]
    for body in ("crank", "rod", "slider"):
        time, position = tracks[f"{body}, body", "translation"]
        rows = np.searchsorted(result.time, time[:, 0] - 1e-6)
        assert np.abs(position - result[f"{body}.position"][rows]).max() < 1e-6
    _, q = tracks["rod, body", "rotation"]
    turned = rotations.matrix(np.roll(q.astype(float), 1, axis=1))
    assert np.abs(turned - rotations.matrix(result["rod.quaternion"][rows])).max() < 1e-6
    _, weights = tracks["rod, body", "weights"]
    assert np.abs(weights.reshape(len(rows), -1) - result["rod.modal"][rows]).max() < 1e-6


def test_moving_frames_have_tracks(written, tmp_path):
    """A crate swings on a hook that rises."""
    path = tmp_path / "Hook.yaml"
    path.write_text(
        "sigmafmu: 1\nname: Hook\nbodies:\n  crate: {mass: 1, inertia: [1, 1, 1]}\njoints:\n"
        "  ring: {type: spherical, bodies: [ground, crate], frame1: {motion: hook}, frame2: {position: [0, 0, -0.5]}}\n"
        "motions:\n  hook: {position: [0, 1, 0], z: [[0, 0], [1, 2]]}\n",
        encoding="utf-8",
    )
    content, binary = chunks(written(str(path))[0])
    animation = content["animations"][0]
    names = [content["nodes"][channel["target"]["node"]]["name"] for channel in animation["channels"]]
    assert "hook, ground" in names
    for name, channel in zip(names, animation["channels"], strict=True):
        if name == "hook, ground":
            sampler = animation["samplers"][channel["sampler"]]
            time, position = (array(content, binary, sampler[end]) for end in ("input", "output"))
            np.testing.assert_allclose(position, np.array([0, 1, 0]) + 2 * time * [0, 0, 1], atol=1e-6)


def test_up_is_up():
    """The z axis of W is the y axis of glTF."""
    R = rotations.matrix(np.roll(Z_UP, 1))
    np.testing.assert_allclose(R @ [0, 0, 1], [0, 1, 0], atol=1e-15)
