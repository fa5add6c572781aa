"""Mechanisms in JSON with something else in them: read, checked, built and started, or refused with one sentence.

Damage of the text is tested beside the reader; here the text is good JSON and its content is wrong, in ways that reach
what is behind the reader: other kinds of values, numbers of any size, indices and names of what is not there, elements
that are missing or there twice. `make test-asan` runs it under sanitizers.
"""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sigmafmu import _core
from sigmafmu.mechanism_file.load import load, load_text

LIBRARY = Path(__file__).parents[2] / "models" / "library"

EVERYTHING = """
sigmafmu: 1
name: Everything
bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
  c: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}
  d: {mass: 1, inertia: [1, 1, 1], position: [3, 0, 1]}
joints:
  turn: {type: revolute, bodies: [ground, a], frame1: {}, damping: 1, friction: 0.1, limits: [-1, 1], armature: 0.1}
  bolt: {type: cylindrical, bodies: [a, b], point: [1, 0, 0], axis: [0, 0, 1], displacement_stiffness: 10}
  cross: {type: universal, bodies: [b, c], point: [2, 0, 0], axis1: [0, 1, 0], axis2: [0, 0, 1], stiffness1: 3}
  plane: {type: planar, bodies: [c, d], point: [3, 0, 1], normal: [0, 0, 1]}
  rope: {type: distance, bodies: [ground, d], point1: [0, 0, 3], point2: [3, 0, 1]}
forces:
  line: {type: line_spring, bodies: [ground, c], point1: [0, 0, 1], point2: [2, 0, 0], stiffness: 5, damping: 1}
  table: {type: table_spring, bodies: [a, d], point1: [0, 0, 0], point2: [3, 0, 1], length: [1, 2, 3], force: [0, 1, 3]}
  twist: {type: torsion_spring, bodies: [ground, b], point: [1, 0, 0], axis: [0, 0, 1], stiffness: 2}
  bush: {type: bushing, bodies: [ground, c], point: [2, 0, 0], stiffness: [1, 2, 3], torsional_damping: [1, 1, 1]}
  oil: {type: bearing, bodies: [ground, b], point: [1, 0, 0], stiffness: [1, 2, 3], cross_stiffness: [1, -1]}
  air: {type: drag, body: d, point: [3, 0, 1], coefficient: [1, 1, 1]}
  jet: {type: follower_force, body: d, point: [3, 0, 1], force: [1, 0, 0]}
  sole: {type: plane_contact, bodies: [ground, d], point: [0, 0, -9], normal: [0, 0, 1], point2: [3, 0, 0], radius: 1}
  balls: {type: sphere_contact, bodies: [a, d], point1: [0, 0, 0], point2: [3, 0, 1], radius1: 0.1, radius2: 0.1}
  s: {type: cloud_contact, bodies: [ground, a], point: [0, 0, -9], normal: [0, 0, 1], points2: [[0, 0, 0]], radius: 1}
  four: {type: spring_damper, bodies: [ground, a], point1: [1, 0, 0], point2: [0, 0, 0], stiffness: [1, 1, 1]}
loads: {push: {body: a, force: [0, 0, 1]}}
couplings:
  gear: {type: gear, joints: [turn, cross.angle1], ratio: -2}
drives: {cross.angle2: {motion: position, table: [[0, 0], [1, 1], [2, 0]]}}
motions: {deck: {z: [[0, 0], [1, 0.1], [2, 0]]}}
sensors:
  tip: {type: motion, body: d, point: [3, 0, 1], reference: a}
  chip: {type: imu, body: d, point: [3, 0, 1]}
expose: {inputs: ["*"], outputs: ["*"], parameters: ["*"]}
"""


def definitions() -> dict[str, dict]:
    """Mechanisms that start, as content of JSON files."""
    found = {
        name: load(LIBRARY / f"{name}.yaml").mechanism for name in ("StewartPlatform", "Flyball", "DoubleWishbone")
    }
    found["Everything"] = load_text(EVERYTHING, "everything.yaml").mechanism
    return {name: json.loads(_core.to_json(mechanism)) for name, mechanism in found.items()}


DEFINITIONS = definitions()

words = st.sampled_from(["ground", "a", "turn", "bolt", "revolute", "free", "index3", "input", "x", ""])
numbers = st.one_of(
    st.integers(-3, 40),
    st.sampled_from([2**31 - 1, 2**31, -(2**31), 2**63, 1e-300, -1e-9, 1e50, -1e300, 0.1, 1e308]),
    st.floats(-1e3, 1e3),
)
values = st.recursive(
    st.one_of(st.none(), st.booleans(), numbers, words),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(words, inner, max_size=3),
    max_leaves=8,
)
changes = st.lists(
    st.tuples(st.lists(st.integers(0, 60), min_size=1, max_size=7), st.sampled_from(["set", "drop", "twice"]), values),
    min_size=1,
    max_size=3,
)


def change(content, path, how, value) -> None:
    """Sets, drops or doubles what is on a path; a number of the path says which entry of a level."""
    for step in path:
        keys = list(content) if isinstance(content, dict) else range(len(content))
        if not keys:
            return
        key = list(keys)[step % len(keys)]
        if step == path[-1] or not isinstance(content[key], dict | list):
            if how == "drop":
                del content[key]
            elif how == "twice" and isinstance(content, list):
                content.insert(key, content[key])
            else:
                content[key] = value
            return
        content = content[key]


def refused_or_started(text: str) -> str:
    """The sentence, or nothing."""
    try:
        mechanism = _core.from_json(text)
        mechanism.validate()
        slave = _core.Slave(mechanism)
        slave.start()
    except (ValueError, RuntimeError) as error:
        return str(error)
    slave.outputs()
    return ""


@pytest.mark.parametrize("name", DEFINITIONS)
def test_what_is_good_starts(name):
    assert refused_or_started(json.dumps(DEFINITIONS[name])) == ""


@settings(max_examples=400, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(name=st.sampled_from(sorted(DEFINITIONS)), changed=changes)
def test_what_is_wrong_is_refused_with_a_sentence(name, changed):
    content = json.loads(json.dumps(DEFINITIONS[name]))
    for path, how, value in changed:
        change(content, path, how, value)
    said = refused_or_started(json.dumps(content))
    assert "\n" not in said
    assert not said or said.endswith(".")
