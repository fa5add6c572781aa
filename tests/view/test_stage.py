"""Meshes of the scene: closed, smooth where the solid is, and carried by the right body."""

import json

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import sigmafmu
from sigmafmu.contents import solids
from sigmafmu.contents.scene_of import scene_of
from sigmafmu.view import rotations
from sigmafmu.view.meshes import mesh_of
from sigmafmu.view.motion import motion_of
from sigmafmu.view.stage import stage_of
from sigmafmu.view.subject import model_of, scene_of_fmu, to_record


def plain(faces):
    return mesh_of(faces, np.zeros((0, *faces.shape)))


def volume(mesh):
    a, b, c = np.moveaxis(mesh.positions[mesh.triangles], 1, 0)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_triangles_enclose_the_solid():
    assert volume(plain(solids.box((1, 2, 3), (1, 2, 3)))) == pytest.approx(6, abs=1e-12)
    assert volume(plain(solids.cylinder((0, 0, 1), (0, 0, 3), 0.5, 200))) == pytest.approx(np.pi / 2, rel=1e-3)
    assert volume(plain(solids.ball((1, 0, 0), 0.5))) == pytest.approx(np.pi / 6, rel=0.02)


def test_normals_are_smooth_but_keep_edges():
    ball = plain(solids.ball((1, 2, 3), 2))
    assert np.abs(ball.normals - (ball.positions - (1, 2, 3)) / 2).max() < 0.05  # its faces are 0.2 rad wide
    box = plain(solids.box((0, 0, 0), (1, 2, 3)))
    assert len(box.positions) == 24
    assert (np.sort(np.abs(box.normals), axis=1) == (0, 0, 1)).all()


@pytest.fixture(scope="module")
def seen():
    """Function that runs a model and takes its scene apart."""
    found = {}

    def get(target, stop_time=0.5):
        if target not in found:
            model = model_of(target)
            scene = scene_of_fmu(model.fmu)
            result = model.run(stop_time, outputs=to_record(model, scene))
            found[target] = stage_of(scene, result.__contains__), motion_of(result, scene.layout, ()), result
        return found[target]

    return get


def placed(item, motion, frame):
    """Vertices of an item in W."""
    mesh, point, body = item.mesh, item.carrier.point, item.carrier.point.body
    if body < 0:
        return mesh.positions
    track = list(motion.bodies.values())[body]
    local = mesh.positions + np.einsum("fvi,f->vi", mesh.modes, track.modal[frame][: len(mesh.modes)])
    R = rotations.matrix(track.quaternion[frame]) if item.carrier.turns else np.eye(3)
    return point.path(motion)[frame] + local @ R.T


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank", "HighSpeedRotor"])
def test_at_the_start_the_scene_is_the_picture(seen, model):
    """What the viewer places at the first frame is what the picture of the documentation shows."""
    stage, motion, _ = seen(model, 0.01)
    corners = np.concatenate([s.faces.reshape(-1, 3) for s in stage.scene.solids if s.other is None])
    vertices = np.concatenate([placed(item, motion, 0) for item in stage.items if item.carrier.to is None])
    for axis in np.random.default_rng(0).normal(size=(20, 3)):
        assert (vertices @ axis).max() == pytest.approx((corners @ axis).max(), abs=1e-5 * stage.scene.layout.size)


def test_joints_stay_together(seen):
    """Arrows are at joints, which their own formulas hold: the crank's pin turns on a circle about its pivot."""
    stage, motion, _ = seen("SliderCrank")
    pin = next(arrow.point for arrow in stage.arrows if arrow.variable == "crankPin.reactionForce").path(motion)
    assert np.abs(np.linalg.norm(pin - (0, 0.1, 0.12), axis=1) - 0.08).max() < 1e-6
    guide = next(arrow.point for arrow in stage.arrows if arrow.variable == "guide.reactionForce").path(motion)
    assert np.abs(guide[:, 1:]).max() < 1e-6


def test_stations_are_where_the_result_says(seen):
    stage, motion, result = seen("FlexibleSliderCrank")
    traces = dict(stage.traces)
    rows = np.searchsorted(result.time, motion.time - 1e-12)
    assert max(np.ptp(motion.bodies["rod"].modal, axis=0)) > 1e-4
    model = sigmafmu.load("FlexibleSliderCrank")
    positions = model.run(0.5, outputs=["middle.position"])["middle.position"][rows]
    assert np.abs(traces["middle"].path(motion) - positions).max() < 1e-9


SHIP = """
sigmafmu: 1
name: Ship
gravity: [0, 0, -9.81]
bodies:
  crane: { mass: 2, inertia: [0.1, 0.1, 0.1] }
joints:
  slew:
    type: revolute
    bodies: [ground, crane]
    frame1: { motion: deck, position: [0, 0.5, 0] }
    frame2: { position: [-0.5, 0, -0.5] }
forces:
  stay:
    type: line_spring
    bodies: [ground, crane]
    frame1: { motion: deck, position: [-1, 0.5, 0] }
    frame2: { position: [0, 0, 0.2] }
    stiffness: 100
motions:
  deck: { position: [0.5, 0, 1], orientation: { rpy: [0, 0, 90 deg] }, MOTION }
experiment: { stop_time: 0.6, step_size: 0.01 }
"""
TIMES, HEAVE, ROLL = [0, 0.2, 0.4, 0.6], [0.1, 0.3, -0.1, 0.2], [0.0, 0.4, -0.2, 0.3]


def ship(folder, motion):
    path = folder / "Ship.yaml"
    path.write_text(SHIP.replace("MOTION", motion), encoding="utf-8")
    model = model_of(str(path))
    return model, scene_of_fmu(model.fmu)


def rolled(angle):
    """The deck's axes: turned by 90° about z, then about their own x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def assert_on_deck(stage, motion, heave, roll):
    """What belongs to the deck: feet of the joint, and the end of the spring."""
    ends = {(item.layer, item.carrier.to is not None): item for item in stage.items if item.carrier.point.body == 1}
    assert {("ground", False), ("force", True)} <= set(ends)
    feet, spring = ends["ground", False], ends["force", True]
    at_start = feet.mesh.positions.mean(axis=0)
    for i in range(0, len(motion.time), 7):
        place, R = np.array([0.5, 0, 1 + heave(motion.time[i])]), rolled(roll(motion.time[i]))
        found = placed(feet, motion, i).mean(axis=0)
        np.testing.assert_allclose(found, place + R @ at_start, atol=1e-6)
        np.testing.assert_allclose(spring.carrier.point.path(motion)[i], place + R @ [-1, 0.5, 0], atol=1e-9)


def table(values):
    return f"[{', '.join(f'[{t}, {x}]' for t, x in zip(TIMES, values, strict=True))}]"


def test_what_is_on_a_moving_frame_moves_with_it(tmp_path):
    model, scene = ship(tmp_path, f"z: {table(HEAVE)}, rx: {table(ROLL)}")
    splines = [CubicSpline(TIMES, values, bc_type="natural") for values in (HEAVE, ROLL)]
    # in the picture of the start, too
    (slew,) = scene.layout.joints
    np.testing.assert_allclose(slew.points[0], [0, 0, 1.1], atol=1e-12)
    result = model.run(outputs=to_record(model, scene))
    assert_on_deck(stage_of(scene, result.__contains__), motion_of(result, scene.layout, ()), *splines)


def test_a_frame_that_inputs_move(tmp_path):
    model, scene = ship(tmp_path, "input: true")
    heave, roll = (lambda t: 0.5 * t), (lambda t: 0.7 * t)  # between communication points inputs are straight lines
    inputs = {"deck.displacement[3]": heave, "deck.rotation[1]": roll}
    result = model.run(inputs=inputs, outputs=to_record(model, scene))
    assert_on_deck(stage_of(scene, result.__contains__), motion_of(result, scene.layout, ()), heave, roll)
    without = model.run(0.1, inputs=inputs, outputs=["crane.*"])
    still = motion_of(without, scene.layout, ()).bodies["deck"]
    assert (still.position == [0.5, 0, 1]).all(), "inputs that were not recorded leave it at rest"


def test_sections_of_a_beam_turn_as_its_nodes_do(tmp_path):
    """Modes that move nodes as a rigid body move the drawn bands in the same way."""
    x = np.linspace(0, 1, 9)
    nodes = np.array([(a, b, c) for a in x for b in (-0.02, 0.02) for c in (-0.02, 0.02)])
    shift, turn = np.array([0.1, 0.2, -0.3]), np.array([0.3, -0.2, 0.5])
    modes = np.stack([np.tile(shift, (len(nodes), 1)), np.cross(turn, nodes)], axis=2)
    (tmp_path / "beam.json").write_text(json.dumps({"X": nodes.tolist(), "Phi": modes.tolist()}))
    scene = scene_of({"bodies": [{"name": "beam", "flexible": {"file": "beam.json"}}]}, tmp_path)
    bands = [solid for solid in scene.solids if solid.layer == "body"]
    assert bands
    for band in bands:
        np.testing.assert_allclose(band.modes[0], np.broadcast_to(shift, band.faces.shape), atol=1e-12)
        np.testing.assert_allclose(band.modes[1], np.cross(turn, band.faces), atol=1e-12)
