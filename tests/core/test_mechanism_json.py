"""A mechanism as text and back: the same numbers, the same variables, the same run, bit by bit."""

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st

import sigmafmu
from sigmafmu import _core

from .helpers import GROUND, MODELS, property_test, random_tree, seeds

RESOURCES = Path(sigmafmu.__file__).parent / "resources"
Type = _core.JointType
ZERO, FRAME = np.zeros(3), _core.Frame(np.zeros(3), np.eye(3))
every_model = pytest.mark.parametrize("model", MODELS)


def bits(x):
    """Of a number, text, array or list of them; every nan is the same."""
    if isinstance(x, str | int) or x is None:
        return x
    if isinstance(x, float):
        return struct.pack("d", float("nan") if x != x else x)
    if isinstance(x, np.ndarray):
        return x.tobytes(), x.shape
    return [bits(each) for each in x]


MEMBERS = {
    _core.Mechanism: "name description multibody integrator stop_time communication_step stations",
    _core.Multibody: "gravity bodies joints spring_dampers loads",
    _core.RigidBody: "name description mass inertia inertia_products initial_position initial_quaternion "
    "initial_velocity initial_angular_velocity modal",
    _core.Modal: "file modes mass_damping stiffness_damping",
    _core.Joint: "name body1 frame1 body2 frame2 initial_coordinates initial_rates length",
    _core.Frame: "origin axes node",
    _core.SpringDamper: "name body1 point1 node1 body2 point2 node2 stiffness damping",
    _core.Load: "name description body force torque",
    _core.Station: "name description body nodes deflection_axes",
    _core.IntegratorSettings: "step_size spectral_radius sigma absolute_tolerance relative_tolerance "
    "max_newton_iterations max_halvings method group local_coordinates absolute_coordinates formulation corrector "
    "jacobian newton sigma_mode step_control error_tolerance",
}


def content(x):
    """All that a definition says, by the names of its members."""
    if isinstance(x, list):
        return [content(each) for each in x]
    if type(x) not in MEMBERS:
        return str(x) if isinstance(x, Type) else bits(x)
    found = {name: content(getattr(x, name)) for name in MEMBERS[type(x)].split()}
    return found | ({"type": str(x.type)} if isinstance(x, _core.Joint) else {})


def loaded(text, model=None):
    mechanism = _core.from_json(text)
    if model:
        _core.load_modal_files(mechanism, str(RESOURCES / model))
    return mechanism


def run(mechanism, steps=20):
    """Variables with their start values, and all outputs after each step."""
    slave = _core.Slave(mechanism)
    names = slave.names
    slave.start()
    rows = [[slave.get(name) for name in names]]
    for i in range(steps):
        slave.do_step(i * mechanism.communication_step, mechanism.communication_step)
        rows.append(slave.outputs())
    return names, bits(rows)


# --- the same mechanism ----------------------------------------------------------------------------------------------


@every_model
def test_a_mechanism_written_and_read_runs_as_the_same_bits(model):
    mechanism = _core.mechanism(model)
    text = _core.to_json(mechanism)
    again = loaded(text, model)
    assert _core.to_json(again) == text
    assert content(again) == content(mechanism)
    assert run(again) == run(mechanism)


@every_model
def test_what_is_not_set_stays_unset(model):
    """Without the joints' initial values, which a slave finds by itself, nothing changes."""
    data = json.loads(_core.to_json(_core.mechanism(model)))
    for joint in data["joints"]:
        for key in [key for key in joint if key.startswith(("coordinate", "rate"))]:
            del joint[key]
    again = loaded(json.dumps(data), model)
    assert all(np.isnan([*j.initial_coordinates, *j.initial_rates]).all() for j in again.multibody.joints)
    assert run(again) == run(_core.mechanism(model))


def test_values_that_were_set_are_held_after_reading():
    mechanism = _core.mechanism("SliderCrank")
    mechanism.set("crankPivot.initialAngle", 0.25)
    mechanism.set("slider.initialVelocity[1]", 0.5)
    again = _core.from_json(_core.to_json(mechanism))
    assert set(json.loads(_core.to_json(again))["held"]) == {"crankPivot.initialAngle", "slider.initialVelocity[1]"}
    assert run(again) == run(mechanism)
    for each in (mechanism, again):  # back to what the definition came with
        each.set("slider.initialVelocity[1]", _core.mechanism("SliderCrank").multibody.bodies[2].initial_velocity[0])
    assert set(json.loads(_core.to_json(again))["held"]) == {"crankPivot.initialAngle"}
    assert _core.to_json(again) == _core.to_json(mechanism)


def test_a_value_held_before_the_joints_had_theirs():
    data = json.loads(_core.to_json(_core.mechanism("SliderCrank")))
    for joint in data["joints"]:
        for key in [key for key in joint if key.startswith(("coordinate", "rate"))]:
            del joint[key]
    mechanism = _core.from_json(json.dumps(data))
    mechanism.set("crankPivot.initialAngle", 0.25)
    text = _core.to_json(mechanism)
    assert json.loads(text)["held"] == {"crankPivot.initialAngle": None}
    assert _core.to_json(_core.from_json(text)) == text


def test_damping_and_initial_values_of_a_flexible_body_are_its_own():
    mechanism = _core.mechanism("FlexiblePendulum")
    for name, value in {"massDamping": 0.5, "stiffnessDamping": 1e-3, "initialModal[2]": 0.01}.items():
        mechanism.set(f"beam.{name}", value)
    again = loaded(_core.to_json(mechanism), "FlexiblePendulum")
    assert again.multibody.bodies[0].modal.mass_damping == 0.5
    assert run(again) == run(mechanism)


numbers = st.floats(allow_nan=False, allow_infinity=False)
triples = st.tuples(numbers, numbers, numbers).map(np.array)


@property_test(seed=seeds, values=st.lists(triples, min_size=6, max_size=6), bodies=st.integers(1, 5))
def test_random_mechanisms_round_trip_exactly(seed, values, bodies):
    """Any finite numbers, subnormal ones and -0 included, whether they make sense or not."""
    rng = np.random.default_rng(seed)
    mechanism = _core.Mechanism("Any")
    mechanism.description = 'quotes " \\ and ünïcode \u2028 \U0001f680'
    mechanism.multibody = random_tree(rng, bodies).definition
    d = mechanism.multibody
    d.gravity = values[0]
    body = d.body(int(rng.integers(bodies)))
    body.mass, body.inertia, body.inertia_products = float(values[1][0]), values[1], values[2]
    body.initial_position, body.initial_quaternion = values[3], np.append(values[3], values[4][0])
    body.initial_velocity, body.initial_angular_velocity = values[4], values[5]
    joint = _core.Joint(
        "odd", Type.prismatic, 0, _core.Frame(values[0], np.outer(values[1], [1, 0, 1]), 3), GROUND, FRAME
    )
    joint.initial_rates = [float(values[5][2]), np.nan, np.nan]
    d.add(joint)
    d.add(_core.SpringDamper("stiff", GROUND, values[1], 0, values[2], values[3], values[4], -1, 7))
    mechanism.add(_core.Station("eye", 0, [int(i) for i in rng.integers(0, 2**31, 4)], values[:2]))
    mechanism.integrator.sigma, mechanism.stop_time = float(values[2][1]), float(values[2][2])
    for name in ("method", "formulation", "local_coordinates"):
        setattr(mechanism.integrator, name, int(rng.integers(1, 4)))
    text = _core.to_json(mechanism)
    assert content(_core.from_json(text)) == content(mechanism)
    assert _core.to_json(_core.from_json(text)) == text
    assert json.loads(text)["description"] == mechanism.description


def test_numbers_are_shortest():
    text = _core.to_json(_core.mechanism("HeavyTop"))
    assert '"stepSize": 0.00025,' in text
    assert "[0.0, 0.0, -9.81]" in text


def test_what_is_left_out_has_the_default_of_the_definition():
    body = {"name": "bob", "mass": 2, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    short = {"sigmafmu": 1, "name": "Short", "bodies": [body]}
    joint = {"name": "pin", "type": "spherical", "bodies": ["bob", "ground"]}
    mechanism = _core.from_json(json.dumps(short | {"joints": [joint]}))
    expected = _core.Mechanism("Short")
    bob = _core.RigidBody()
    bob.name, bob.mass = "bob", 2.0
    expected.multibody.add(bob)
    expected.multibody.add(_core.Joint("pin", Type.spherical, 0, FRAME, GROUND, FRAME))
    assert content(mechanism) == content(expected)


# --- what is refused -------------------------------------------------------------------------------------------------


def change(*path, to):
    def apply(data):
        for key in path[:-1]:
            data = data[key]
        data[path[-1]] = to

    return apply


def drop(*path):
    def apply(data):
        for key in path[:-1]:
            data = data[key]
        del data[path[-1]]

    return apply


TYPES = (
    "spherical, revolute, universal, prismatic, fixed, cylindrical, planar, distance, point_on_line, free, screw, "
    "constant_velocity, point_in_plane or rolling_disk"
)
WRONG = {
    "no object": (lambda d: [], "The mechanism is []; it must be an object."),
    "no version": (drop("sigmafmu"), "sigmafmu is missing."),
    "other version": (change("sigmafmu", to=2), "sigmafmu is 2; it must be 1."),
    "version as text": (change("sigmafmu", to="1"), 'sigmafmu is "1"; it must be 1.'),
    "no name": (drop("name"), "name is missing."),
    "name is a number": (change("name", to=5), "name is 5; it must be a text."),
    "unknown key": (
        change("colour", to=1),
        "colour is unknown; the keys here are sigmafmu, name, description, gravity, ",
    ),
    "unknown key of a body": (
        change("bodies", 2, "masss", to=1),
        "bodies[2].masss is unknown; the keys here are name, description, flexible, mass, inertia, position, ",
    ),
    "unknown key of a frame": (
        change("joints", 1, "frame2", "origin", to=[0, 0, 0]),
        "joints[1].frame2.origin is unknown; the keys here are position, orientation, node.",
    ),
    "no mass": (drop("bodies", 0, "mass"), "bodies[0].mass is missing."),
    "mass as text": (change("bodies", 0, "mass", to="1 kg"), 'bodies[0].mass is "1 kg"; it must be a number.'),
    "mass null": (change("bodies", 0, "mass", to=None), "bodies[0].mass is null; it must be a number."),
    "no moment": (drop("bodies", 0, "inertia", "yy"), "bodies[0].inertia.yy is missing."),
    "body is a list": (change("bodies", 1, to=[1, 2]), "bodies[1] is [1,2]; it must be an object."),
    "bodies by name": (change("bodies", to={}), "bodies must be a list."),
    "two numbers": (change("gravity", to=[0, 1]), "gravity has 2 entries; it must have 3."),
    "vector as number": (change("gravity", to=9.81), "gravity must be a list."),
    "entry": (change("bodies", 1, "position", 2, to=[]), "bodies[1].position[2] is []; it must be a number."),
    "unknown body": (
        change("joints", 2, "bodies", 1, to="sliderr"),
        'joints[2].bodies[1] is "sliderr"; it must be the name of a body or ground.',
    ),
    "body by number": (change("joints", 3, "bodies", 0, to=-1), "joints[3].bodies[0] is -1; it must be a text."),
    "three bodies": (
        change("joints", 0, "bodies", to=["ground", "crank", "rod"]),
        "joints[0].bodies has 3 entries; it must have 2.",
    ),
    "no bodies": (drop("joints", 0, "bodies"), "joints[0].bodies is missing."),
    "unknown type": (change("joints", 0, "type", to="ball"), f'joints[0].type is "ball"; it must be {TYPES}.'),
    "type as number": (change("joints", 0, "type", to=1), f"joints[0].type is 1; it must be {TYPES}."),
    "node": (change("joints", 0, "frame1", "node", to=1.5), "joints[0].frame1.node is 1.5; it must be a whole number."),
    "large node": (
        change("joints", 0, "frame1", "node", to=2**40),
        "joints[0].frame1.node is 1099511627776; it must be a whole number.",
    ),
    "rows": (
        change("joints", 0, "frame1", "orientation", "matrix", to=[[1, 0, 0], [0, 1], [0, 0, 1]]),
        "joints[0].frame1.orientation.matrix[1] has 2 entries; it must have 3.",
    ),
    "type of a force": (
        change("forces", to=[{"name": "s", "type": "spring", "bodies": ["rod", "ground"]}]),
        'forces[0].type is "spring"; it must be spring_damper, line_spring, table_spring, torsion_spring, bushing, '
        "bearing, follower_force, drag, plane_contact, sphere_contact or cloud_contact.",
    ),
    "load": (change("loads", to=[{"name": "w"}]), "loads[0].body is missing."),
    "setting": (
        change("integrator", "step_size", to=1),
        "integrator.step_size is unknown; the keys here are stepSize, ",
    ),
    "setting by number": (
        change("integrator", "corrector", to=1),
        "integrator.corrector is 1; it must be residual or incremental.",
    ),
    "experiment": (change("experiment", to=3), "experiment is 3; it must be an object."),
    "held": (
        change("held", to={"crank.initialMass": 1}),
        "held has crank.initialMass, which is no initial value of the mechanism.",
    ),
    "held text": (
        change("held", to={"crank.initialPosition[1]": "x"}),
        'held.crank.initialPosition[1] is "x"; it must be a number.',
    ),
    "long value": (
        change("bodies", 0, "mass", to="ü" * 100),
        f'bodies[0].mass is "{"ü" * 19}; it must be a number.',
    ),
}


@pytest.mark.parametrize(("spoil", "message"), WRONG.values(), ids=WRONG)
def test_wrong_text_is_refused_with_the_path_of_what_is_wrong(spoil, message):
    data = json.loads(_core.to_json(_core.mechanism("SliderCrank")))
    replaced = spoil(data)
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        _core.from_json(json.dumps(data if replaced is None else replaced, ensure_ascii=False))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "The mechanism is no JSON: "),
        ("{", "The mechanism is no JSON: "),
        ('{"name": 1e999}', "The mechanism is no JSON: "),
        ('{"a": NaN}', "The mechanism is no JSON: "),
        ('{"name": "A", "name": "B"}', "The mechanism is no JSON: the key name is there twice."),
        ("[" * 100_000, "The mechanism is no JSON: its lists are nested deeper than 16."),
        ('{"a":' * 17 + "1" + "}" * 17, "The mechanism is no JSON: its lists are nested deeper than 16."),
        ("null", "The mechanism is null; it must be an object."),
    ],
)
def test_text_that_is_no_mechanism_is_refused(text, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        _core.from_json(text)


@property_test(cut=st.integers(0, 4000), put=st.text(max_size=3))
def test_no_damage_does_more_than_raise_one_error(cut, put):
    text = _core.to_json(_core.mechanism("SliderCrank"))
    cut %= len(text)
    try:
        mechanism = _core.from_json(text[:cut] + put + text[cut + len(put) :])
        mechanism.validate()
    except ValueError:
        return
    _core.Slave(mechanism)


def unwritable(change_it, message):
    mechanism = _core.mechanism("SliderCrank")
    change_it(mechanism)
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        _core.to_json(mechanism)


def test_what_json_cannot_hold_is_refused():
    def modal(m):
        m.multibody.body(1).modal = _core.Modal()

    unwritable(lambda m: setattr(m.multibody.body(1), "mass", np.inf), "bodies[1].mass is inf; it must be finite.")
    unwritable(
        lambda m: m.multibody.add(_core.Load("l", 0, np.array([0, np.nan, 0]), ZERO)),
        "loads[0].force[1] is nan; it must be finite.",
    )
    unwritable(
        lambda m: m.multibody.add(_core.Joint("j", Type.fixed, 0, FRAME, 7, FRAME)),
        "joints[4].bodies[1] is body 7; the mechanism has no such body.",
    )
    unwritable(modal, "bodies[1].flexible has modal data of no file; they must be in one.")
    unwritable(lambda m: setattr(m.integrator, "method", 9), "integrator.method is 9, which has no name.")
