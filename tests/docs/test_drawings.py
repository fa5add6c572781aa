"""Figures and icons of mechanisms: those of the FMUs, and others that no one has posed for a picture."""

import json
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sigmafmu import _core
from sigmafmu.contents import draw, scene_of, solids, symbols
from sigmafmu.contents.layout import Layout

from . import drawn

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).parent


OTHERS = {
    "tree 0": drawn.random_tree(0),
    "tree 1": drawn.random_tree(1),
    "chain": drawn.chain(50),
    "free body": drawn.free_body(),
    "turns about its centre": drawn.wheel(),
    "block on a rail": drawn.block_on_a_rail(),
}


def resources(model):
    return ROOT / "models" / "resources" / model


@pytest.fixture(scope="module")
def picture():
    """Function that draws a model of the package or one of OTHERS; each is drawn once."""
    drawings = {}

    def get(name):
        if name not in drawings:
            mechanism = OTHERS[name] if name in OTHERS else json.loads(_core.to_json(_core.mechanism(name)))
            drawings[name] = mechanism, draw.draw_figure(mechanism, resources(name))
        return drawings[name]

    return get


def overlapping(texts):
    """Pairs of texts whose boxes have a place in common."""
    return [
        (a.text, b.text)
        for i, a in enumerate(texts)
        for b in texts[:i]
        if (np.abs(a.centre - b.centre) < (a.size + b.size) / 2).all()
    ]


def check(mechanism, picture, folder):
    camera = picture.camera
    covered = picture.pixels[..., 3] > 0
    assert 0.005 < covered.mean() < 0.8
    assert covered.shape == (camera.height, camera.width)

    names = [text.name for text in picture.texts]
    for kind in ("bodies", "joints", "forces", "sensors"):
        for entry in mechanism.get(kind, []):
            assert names.count(entry["name"]) == 1, f"{entry['name']} has no label"
    for text in picture.texts:
        for corner in (text.centre - text.size / 2, text.centre + text.size / 2, text.anchor):
            assert (corner >= 0).all(), text.text
            assert (corner <= (camera.width, camera.height)).all(), text.text

    layout = Layout(mechanism, folder)
    pixels = camera.project(layout.points)
    assert (pixels >= 0).all()
    assert (pixels <= (camera.width, camera.height)).all()
    for body in layout.bodies.values():
        column, row = camera.project(body.centre).astype(int)
        assert covered[-row - 1, column], f"nothing is drawn at the centre of {body.name}"


def test_every_model(picture, model):
    mechanism, drawing = picture(model)
    check(mechanism, drawing, resources(model))
    assert overlapping(drawing.texts) == []


@pytest.mark.parametrize("name", OTHERS)
def test_other_mechanisms(picture, name, tmp_path):
    mechanism, drawing = picture(name)
    check(mechanism, drawing, tmp_path)
    assert overlapping(drawing.texts) == []


@pytest.mark.parametrize("name", ["SliderCrank", "chain"])
def test_same_mechanism_is_the_same_file(name, picture, tmp_path):
    mechanism, drawing = picture(name)
    drawing.save(tmp_path / "first.png")
    draw.draw_figure(mechanism, resources(name)).save(tmp_path / "second.png")
    assert (tmp_path / "first.png").read_bytes() == (tmp_path / "second.png").read_bytes()


@pytest.mark.parametrize("name", ["HighSpeedRotor", *OTHERS])
def test_icon_shows_something_and_is_transparent_around(name, picture, tmp_path):
    draw.draw_icon(picture(name)[0], resources(name), tmp_path / "icon.png")
    pixels = np.asarray(Image.open(tmp_path / "icon.png"))
    assert pixels.shape == (draw.ICON, draw.ICON, 4)
    rows, columns = np.nonzero(pixels[..., 3])
    assert max(np.ptp(rows), np.ptp(columns)) > 0.9 * draw.ICON
    assert min(rows.min(), columns.min()) > 0
    assert (pixels[..., 3] == 0).mean() > 0.1


def test_symbols_of_all_joint_types_differ():
    """Each type has its own solid; a type that is not known is a ball, a free joint nothing."""
    shapes = {}
    for kind in drawn.TYPES:
        entry = drawn.joint("j", kind, ("ground", "b"), (0, 0, 0.5), (0, 0, 0))
        layout = Layout({"bodies": [drawn.body("b", (0, 0, 0.5))], "joints": [entry]}, HERE)
        parts = [part.faces for part in symbols.joint(layout.joints[0], 0.01)]
        shapes[kind] = np.concatenate(parts) if parts else np.zeros(0)
    assert len({shape.tobytes() for shape in shapes.values()}) == len(drawn.TYPES)
    assert shapes["ratchet"].shape == solids.ball((0, 0, 0.5), 0.01).shape


def test_symbols_of_forces_differ():
    """A coil for what acts along a line, and a symbol of its own for every other."""
    bodies = [drawn.body(name, place) for name, place in (("a", (0, 0, 0)), ("b", (0.5, 0.2, 0)))]
    layout = Layout({"bodies": bodies, "forces": drawn.forces_of_all_types("a", "b")}, HERE)
    shapes = {}
    for link in layout.forces:
        faces = np.concatenate([part.faces for part in symbols.force(link, 0.01, np.array([0, 0, -1.0]))])
        shapes[link.type] = faces.tobytes()
    assert shapes["line_spring"] == shapes["table_spring"]
    assert shapes["plane_contact"] == shapes["cloud_contact"]
    assert len(shapes) == 8
    assert len(set(shapes.values())) == 6
    _, jet = layout.followers
    assert jet.point == pytest.approx([0.5, 0.3, 0.0])


def test_solids_face_outward():
    """The volume within faces is positive: a solid inside out would not be seen."""
    path = np.column_stack([np.linspace(0, 1, 5), np.zeros(5), np.zeros(5)])
    volumes = {
        "cylinder": (solids.cylinder((1, 2, 3), (1, 2, 5), 0.5, 200), np.pi * 0.25 * 2),
        "ball": (solids.ball((1, 2, 3), 0.5), np.pi / 6),
        "box": (solids.box((1, 2, 3), (1, 2, 3)), 6.0),
        "turned box": (solids.box((1, 2, 3), (1, 2, 3), drawn.rotation(np.array([0.5, 0.5, -0.5, 0.5]))), 6.0),
        "tube": (solids.tube(path, 0.1, 100), np.pi * 0.01),
    }
    for name, (faces, volume) in volumes.items():
        a, b, c, d = np.moveaxis(faces - (1, 2, 3), 1, 0)
        inside = (np.einsum("fi,fi", a, np.cross(b, c)) + np.einsum("fi,fi", a, np.cross(c, d))) / 6
        assert inside == pytest.approx(volume, rel=0.03), name


def test_a_rail_goes_on_beyond_the_block_on_it():
    layout = Layout(drawn.block_on_a_rail(), HERE)
    block, _ = scene_of.equal_solid(layout.bodies["block"], layout.thickness, layout.size)
    rail = np.concatenate([part.faces for part in symbols.joint(layout.joints[0], layout.thickness)])
    assert np.ptp(rail.reshape(-1, 3) @ layout.joints[0].axes[0][:, 2]) > 1.5 * np.ptp(block[..., 0])
    assert np.abs(block[..., 2]).max() == pytest.approx(0.035), "the hook is on the block's surface"


def test_joints_at_a_node_are_where_the_node_is():
    mechanism = json.loads(_core.to_json(_core.mechanism("FlexiblePendulum")))
    mechanism["joints"][0]["frame2"]["node"] = 43
    (joint,) = Layout(mechanism, resources("FlexiblePendulum")).joints
    assert joint.points[1] == pytest.approx([1.0, -0.02, -0.02])


def test_a_disk_has_the_inertia_of_its_body():
    """The top is a thin disk: 15 kg with radius 0.25 m."""
    mechanism = json.loads(_core.to_json(_core.mechanism("HeavyTop")))
    layout = Layout(mechanism, HERE)
    faces, axis = scene_of.equal_solid(layout.bodies["top"], layout.thickness, layout.size)
    assert np.abs(axis) == pytest.approx([0, 1, 0])
    assert np.ptp(faces[..., 0]) == pytest.approx(0.5, rel=1e-3)
    assert np.ptp(faces[..., 1]) < 0.05


@pytest.mark.parametrize(("rate", "told"), [(5.0, "2 kg, 5 rad/s"), (0.02, "2 kg, 0.02 rad/s"), (1.75e-29, "2 kg")])
def test_what_rounding_leaves_of_a_rate_is_no_spin(rate, told):
    mechanism = drawn.wheel()
    mechanism["bodies"][0]["angular_velocity"] = [0.0, 0.0, rate]
    scene = scene_of.scene_of(mechanism, HERE)
    assert scene.labels[0].detail == told
    arrows = [solid for solid in scene.solids if solid.layer == "body" and solid.color == scene_of.RED]
    assert len(arrows) == ("rad/s" in told)


def test_drawing_is_quick(picture):
    mechanism, _ = picture("chain")

    def takes() -> float:
        start = time.process_time()  # other tests run meanwhile
        draw.draw_figure(mechanism, HERE)
        return time.process_time() - start

    assert any(takes() < 3.0 for _ in range(3))


def test_a_large_mechanism_has_no_names():
    """They would hide it, and finding places for them takes minutes."""
    drawing = draw.draw_figure(drawn.chain(draw.UNNAMED // 2 + 1), HERE)
    assert [text.name for text in drawing.texts if "link" in text.name or "pin" in text.name] == []
    assert (drawing.pixels[..., 3] > 0).mean() > 0.005


def test_a_curved_flexible_body_is_drawn_along_its_nodes(tmp_path):
    angles = np.linspace(0, np.pi, 60)
    nodes = [(np.cos(a), np.sin(a), z) for a in angles for z in (-0.01, 0.01)]
    (tmp_path / "bow.json").write_text(json.dumps({"X": nodes}), encoding="utf-8")
    bow = {"name": "bow", "flexible": {"file": "bow.json", "modes": 1}}
    mechanism = {"bodies": [bow], "joints": [drawn.joint("pin", "spherical", ("ground", "bow"), (1, 0, 0), (1, 0, 0))]}
    drawing = draw.draw_figure(mechanism, tmp_path)
    camera, covered = drawing.camera, drawing.pixels[..., 3] > 0
    for point, drawn_there in (((0, 1, 0), True), ((0.6, 0.8, 0), True), ((0, 0.5, 0), False)):
        column, row = camera.project(np.array(point)).astype(int)
        assert covered[-row - 1, column] == drawn_there
    drawing.save(tmp_path / "bow.png")
