"""What a mechanism may be: all is refused with one sentence before anything is built from it."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .clouds import flexible_body, random_cloud
from .helpers import GROUND, MODELS, random_body, random_frame

Type = _core.JointType
FRAME = _core.Frame(np.zeros(3), np.eye(3))
ZERO = np.zeros(3)
CLOUD = random_cloud(np.random.default_rng(7), modes=2, lumped=True)
NODES = len(CLOUD.nodes)


def good() -> _core.Mechanism:
    """A rod that is flexible, a bob that is not, a joint, a spring, a load and a point of the rod."""
    rng = np.random.default_rng(3)
    mechanism = _core.Mechanism()
    mechanism.name = "Good"
    d = mechanism.multibody
    d.add(flexible_body(CLOUD, "rod", as_matrix=False))
    d.add(random_body(rng, "bob"))
    d.add(_core.Joint("hinge", Type.revolute, GROUND, FRAME, 0, FRAME))
    d.add(_core.Joint("pin", Type.spherical, 0, _core.Frame(ZERO, np.eye(3), 2), 1, random_frame(rng)))
    d.add(_core.SpringDamper("spring", 0, ZERO, 1, ZERO, np.ones(3), np.ones(3)))
    d.add(_core.Load("weight", 1, np.ones(3), ZERO))
    mechanism.add(_core.Station("tip", 0, [0, NODES - 1], [np.array([0.0, 0.0, 1.0])]))
    return mechanism


def body(name):
    return lambda m: m.multibody.add(random_body(np.random.default_rng(1), name))


def joint(name, one=0, two=1, kind=Type.spherical, frame1=FRAME, frame2=FRAME, **values):
    def change(m):
        added = _core.Joint(name, kind, one, frame1, two, frame2)
        for key, value in values.items():
            setattr(added, key, value)
        m.multibody.add(added)

    return change


def spring(name, one=0, two=1, node1=-1, node2=-1):
    return lambda m: m.multibody.add(_core.SpringDamper(name, one, ZERO, two, ZERO, ZERO, ZERO, node1, node2))


def load(name, on=1):
    return lambda m: m.multibody.add(_core.Load(name, on, ZERO, ZERO))


def station(name, of=0, nodes=(0,), axes=()):
    return lambda m: m.add(_core.Station(name, of, list(nodes), list(axes)))


def modal(**values):
    def change(m):
        for key, value in values.items():
            setattr(m.multibody.body(0).modal, key, value)

    return change


def integrator(**values):
    def change(m):
        for key, value in values.items():
            setattr(m.integrator, key, value)

    return change


def own(**values):
    def change(m):
        for key, value in values.items():
            setattr(m, key, value)

    return change


def unloaded(m):
    data = _core.Modal()
    data.file, data.modes = "rod.json", 2
    m.multibody.body(0).modal = data


LETTERS = "allowed are letters, digits and _, no digit first, and dots between such words."
TURNED = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
WHOLE = {"angularMomentum", "centerOfMass", "constraint", "energy", "gravity", "integrator", "momentum"}
"""Beginnings of the names of variables of the whole mechanism."""

NAMES = {
    "two bodies": (body("bob"), "bob is the name of a body and of a body; every element needs its own."),
    "body and joint": (joint("rod"), "rod is the name of a body and of a joint; every element needs its own."),
    "two joints": (joint("pin"), "pin is the name of a joint and of a joint; every element needs its own."),
    "joint and spring": (
        spring("pin"),
        "pin is the name of a joint and of a spring-damper; every element needs its own.",
    ),
    "spring and load": (
        load("spring"),
        "spring is the name of a load and of a spring-damper; every element needs its own.",
    ),
    "load and station": (
        station("weight"),
        "weight is the name of a load and of a station; every element needs its own.",
    ),
    "two stations": (station("tip"), "tip is the name of a station and of a station; every element needs its own."),
    "no name of a body": (body(""), "The name of body 2 is empty; every element must have one."),
    "no name of a joint": (joint(""), "The name of joint 2 is empty; every element must have one."),
    "no name of a load": (load(""), "The name of load 1 is empty; every element must have one."),
    "space": (body("left wheel"), f'"left wheel" is the name of a body; {LETTERS}'),
    "digit first": (joint("2nd"), f'"2nd" is the name of a joint; {LETTERS}'),
    "index": (spring("strut[1]"), f'"strut[1]" is the name of a spring-damper; {LETTERS}'),
    "dot first": (load(".wind"), f'".wind" is the name of a load; {LETTERS}'),
    "dot last": (load("wind."), f'"wind." is the name of a load; {LETTERS}'),
    "umlaut": (body("Läufer"), f'"Läufer" is the name of a body; {LETTERS}'),
    "variable of a body": (
        station("rod.position"),
        "rod.position is the name of a station; variables of rod may have that name.",
    ),
    "variable of a joint": (
        station("pin.angle.at"),
        "pin.angle.at is the name of a station; variables of pin may have that name.",
    ),
    **{
        word: (body(word), f"{word} is the name of a body; {word} is reserved for what every mechanism has.")
        for word in (*sorted(WHOLE), "ground", "joints", "time")
    },
    "below integrator": (
        station("integrator.point"),
        "integrator.point is the name of a station; integrator is reserved for what every mechanism has.",
    ),
}
REFERENCES = {
    "joint to an unknown body": (joint("hook", 0, 7), "hook refers to body 7; allowed are -1 (ground) to 1."),
    "joint below the ground": (joint("hook", -2, 0), "hook refers to body -2; allowed are -1 (ground) to 1."),
    "joint to itself": (joint("hook", 1, 1), "hook connects bob with itself; it must connect two bodies."),
    "joint of the ground": (joint("hook", -1, -1), "hook connects the ground with itself; it must connect two bodies."),
    "spring to an unknown body": (spring("wire", 5, 0), "wire refers to body 5; allowed are -1 (ground) to 1."),
    "spring to itself": (spring("wire", 0, 0, 1, 2), "wire connects rod with itself; it must connect two bodies."),
    "spring at an unknown node": (
        spring("wire", 0, 1, NODES),
        f"wire attaches to node {NODES} of rod; allowed are -1 (floating frame) to {NODES - 1}.",
    ),
    "spring at a node of the ground": (
        spring("wire", -1, 0, 3),
        "wire attaches to node 3 of the ground, which is not flexible; allowed is -1 (no node).",
    ),
    "load on an unknown body": (load("push", 2), "push acts on body 2; allowed are 0 to 1."),
    "load on the ground": (load("push", GROUND), "push acts on body -1; allowed are 0 to 1."),
    "station of an unknown body": (station("eye", 9), "eye is a point of body 9; allowed are 0 to 1."),
    "station of the ground": (station("eye", GROUND), "eye is a point of body -1; allowed are 0 to 1."),
    "station of a rigid body": (station("eye", 1), "eye is a point of bob; it must be one of a flexible body."),
    "station at no node": (station("eye", 0, []), "eye has no nodes of rod; there must be at least one."),
    "station at an unknown node": (
        station("eye", 0, [0, NODES]),
        f"eye is at node {NODES} of rod; allowed are 0 to {NODES - 1}.",
    ),
    "station below the nodes": (station("eye", 0, [-1]), f"eye is at node -1 of rod; allowed are 0 to {NODES - 1}."),
    "modal data not read": (unloaded, "rod.modal lacks its data; rod.json must be read before the mechanism is used."),
    "another number of modes": (
        modal(file="rod.json", modes=3),
        "rod.modal.modes is 3, and its data have 2 modes; the two must be the same.",
    ),
    "file elsewhere": (
        modal(file="../rod.json", modes=2),
        "rod.modal.file is ../rod.json; it must be the name of a file in the folder of the resources.",
    ),
    "negative modes": (modal(file="rod.json", modes=-1), "rod.modal.modes is -1; it must not be negative."),
}
VALUES = {
    "left-handed frame": (
        joint("hook", frame2=_core.Frame(ZERO, np.diag([1.0, 1.0, -1.0]))),
        "hook.frame2.axes are (1, 0, 0), (0, 1, 0), (0, 0, -1); they must be orthonormal and right-handed.",
    ),
    "frame nan": (
        joint("hook", frame1=_core.Frame(ZERO, np.diag([np.nan, 1.0, 1.0]))),
        "hook.frame1.axes are (nan, 0, 0), (0, 1, 0), (0, 0, 1); they must be orthonormal and right-handed.",
    ),
    "scaled frame": (
        joint("hook", frame1=_core.Frame(ZERO, 2 * TURNED)),
        "hook.frame1.axes are (0, 2, 0), (-2, 0, 0), (0, 0, 2); they must be orthonormal and right-handed.",
    ),
    "angle of a ball": (
        joint("hook", initial_coordinates=[0.5, np.nan, np.nan]),
        "hook has the initial value 0.5; joints of its type must not have one.",
    ),
    "infinite rate": (
        joint("hook", kind=Type.prismatic, initial_rates=[np.inf, np.nan, np.nan]),
        "hook has the initial value inf; it must be finite.",
    ),
    "length of an axis": (
        station("eye", axes=[np.array([0.0, 2.0, 0.0])]),
        "eye.deflectionAxes[1] has the length 2; it must be 1.",
    ),
    "axis nan": (station("eye", axes=[np.full(3, np.nan)]), "eye.deflectionAxes[1] has the length nan; it must be 1."),
    "name of the mechanism": (
        own(name="My mechanism"),
        'The name of the mechanism is "My mechanism"; allowed are letters, digits and _, no digit first.',
    ),
    "no name of the mechanism": (
        own(name=""),
        'The name of the mechanism is ""; allowed are letters, digits and _, no digit first.',
    ),
    "stop time": (own(stop_time=0.0), "The stop time of the experiment is 0 s; it must be positive and finite."),
    "communication step": (
        own(communication_step=np.nan),
        "The communication step of the experiment is nan s; it must be positive and finite.",
    ),
    "step size": (integrator(step_size=0.0), "integrator.stepSize is 0; it must be finite, above 0."),
    "sigma": (integrator(sigma=np.nan), "integrator.sigma is nan; it must be finite."),
    "spectral radius": (
        integrator(spectral_radius=1.5),
        "integrator.spectralRadius is 1.5; it must be finite, at least 0, at most 1.",
    ),
    "method": (integrator(method=9), "integrator.method is 9; it must be 1 to 4."),
    "halvings": (integrator(max_halvings=-1), "integrator.maxHalvings is -1; it must be 0 to 20."),
}
REFUSED = NAMES | REFERENCES | VALUES


def test_the_mechanism_that_the_next_tests_spoil_is_good():
    good().validate()
    _core.Slave(good()).start()


@pytest.mark.parametrize(("spoil", "message"), REFUSED.values(), ids=REFUSED)
def test_a_bad_mechanism_is_refused_before_anything_is_built(spoil, message):
    """By validate() and by the slave alike, which would index what is not there."""
    mechanism = good()
    spoil(mechanism)
    for use in (mechanism.validate, lambda: _core.Slave(mechanism)):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
            use()


@pytest.mark.parametrize(("spoil", "message"), REFERENCES.values(), ids=REFERENCES)
def test_every_way_to_use_a_mechanism_looks_first(spoil, message):
    """A system, a simulation, outputs, the assembly, a parameter by name."""
    mechanism = good()
    spoil(mechanism)
    d = mechanism.multibody
    uses = [lambda: _core.Outputs(mechanism)]
    if not message.startswith("eye"):  # these know no stations
        uses += [lambda: _core.Simulation(mechanism), lambda: _core.System(d), lambda: _core.assemble(d)]
        uses += [lambda: mechanism.set("gravity[1]", 0.0)]
    for use in uses:
        with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
            use()


def words_after(owner, names):
    """What the variables of an element are called: `position`, `inertia`."""
    return {re.split(r"[.\[]", name[len(owner) + 1 :])[0] for name in names if name.startswith(f"{owner}.")}


def every_mechanism():
    yield from (_core.mechanism(model) for model in MODELS)
    mechanism = good()
    joint("rail", 0, 1, Type.prismatic)(mechanism)
    yield mechanism


def test_no_element_may_be_called_like_a_variable_of_another():
    """Whatever variables there are: a name that continues an element's name with one of theirs is refused."""
    known = set()
    for mechanism in every_mechanism():
        d = mechanism.multibody
        names = _core.Slave(mechanism).names
        elements = [e.name for e in (*d.bodies, *d.joints, *d.spring_dampers, *d.loads, *mechanism.stations)]
        for name in elements:
            known |= words_after(name, names) - words_after(name, elements)
        globals_ = {re.split(r"[.\[]", name)[0] for name in names} - {re.split(r"\.", e)[0] for e in elements}
        assert globals_ <= WHOLE
    assert {"position", "reactionForce", "motorTorque", "actuatorForce", "stiffness", "deflection", "modal"} <= known
    for word in known:
        mechanism = good()
        station(f"rod.{word}")(mechanism)
        with pytest.raises(ValueError, match=rf"^rod\.{word} is the name of a station; "):
            mechanism.validate()


@pytest.mark.parametrize("name", ["rod.station1", "bob.left.end", "_x", "Time", "integratorRod", "other.position"])
def test_other_names_are_good(name):
    mechanism = good()
    station(name)(mechanism)
    assert f"{name}.position[1]" in _core.Slave(mechanism).names
