"""Definitions of force elements: as text and back, variables of the FMU, what is refused."""

import json
import re

import numpy as np
import pytest

from sigmafmu import _core

from .force_models import BETWEEN, ELEMENTS, make_world
from .helpers import GROUND, property_test, seeds

ZERO = np.zeros(3)
FRAME = _core.Frame(ZERO, np.eye(3))
every_element = pytest.mark.parametrize("element", ELEMENTS)


def mechanism_of(*elements):
    mechanism = _core.Mechanism("Elements")
    for name in ("one", "two"):
        body = _core.RigidBody()
        body.name = name
        mechanism.multibody.add(body)
    mechanism.multibody.body(1).initial_position = np.array([0.4, 0.3, 0.2])
    for element in elements:
        mechanism.multibody.add(element)
    return mechanism


# --- text ------------------------------------------------------------------------------------------------------------


def content(element):
    """Members that are numbers, by name."""
    found = {}
    for name in dir(element):
        x = getattr(element, name)
        if name.startswith("_"):
            continue
        if isinstance(x, _core.Frame | _core.ContactSurface):
            found[name] = content(x)
        else:
            found[name] = np.asarray(x).tolist()
    return found


@every_element
@property_test(10, seed=seeds)
def test_written_and_read_it_is_the_same(element, seed):
    rng = np.random.default_rng(seed)
    made = make_world(rng, ELEMENTS[element], list(BETWEEN)[seed % 3]).element
    mechanism = mechanism_of(made)
    text = _core.to_json(mechanism)
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    (read,) = getattr(again.multibody, ELEMENTS[element].key)
    assert content(read) == content(made)
    assert (json.loads(text)["forces"][0].get("bodies", [None])[0] == "ground") == (getattr(read, "body1", 0) < 0)


def everything():
    spring = _core.SpringDamper("strut", GROUND, ZERO, 0, ZERO, np.ones(3), np.ones(3))
    worlds = {name: make_world(np.random.default_rng(5), model, "two bodies") for name, model in ELEMENTS.items()}
    elements = []
    for name, world in worlds.items():
        entry = json.loads(_core.to_json(mechanism_of(world.element)))["forces"][0]
        elements.append(entry | {"name": name})
    data = json.loads(_core.to_json(mechanism_of(spring)))
    data["forces"] += elements
    return data


def test_a_list_of_all_types_in_any_order():
    data = everything()
    text = _core.to_json(_core.from_json(json.dumps(data)))
    assert json.loads(text)["forces"] == data["forces"]
    data["forces"].reverse()
    assert _core.to_json(_core.from_json(json.dumps(data))) == text
    slave = _core.Slave(_core.from_json(text))
    slave.start()
    slave.do_step(0.0, 1e-3)


def test_keys_of_the_page():
    """Those that users write."""
    keys = {entry["type"]: set(entry) - {"name", "type"} for entry in everything()["forces"]}
    surface = {"modulus", "dissipation", "friction", "slip_velocity"}
    ends = {"bodies", "point1", "point2"}
    frames = {"bodies", "frame1", "frame2"}
    bushing = {"stiffness", "damping", "torsional_stiffness", "torsional_damping"}
    assert keys == {
        "spring_damper": ends | {"stiffness", "damping"},
        "line_spring": ends | {"stiffness", "damping", "free_length"},
        "table_spring": ends | {"length", "force", "rate", "rate_force"},
        "torsion_spring": frames | {"stiffness", "damping", "rest"},
        "bushing": frames | bushing | {"stiffness_coupling", "damping_coupling"},
        "bearing": frames | {"stiffness", "damping", "cross_stiffness", "cross_damping"},
        "follower_force": {"body", "point", "force", "torque"},
        "drag": {"body", "point", "coefficient", "rotational", "flow"},
        "plane_contact": {"bodies", "frame1", "point2", "radius"} | surface,
        "sphere_contact": ends | {"radius1", "radius2"} | surface,
        "cloud_contact": {"bodies", "frame1", "points2", "radius"} | surface,
    }


TYPES = (
    "spring_damper, line_spring, table_spring, torsion_spring, bushing, bearing, follower_force, drag, plane_contact, "
    "sphere_contact"
)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"type": "rope"}, f'forces[1].type is "rope"; it must be {TYPES} or cloud_contact.'),
        ({"free_lenght": 1}, "forces[1].free_lenght is unknown; the keys here are name, type, bodies, point1, point2,"),
        ({"type": None}, "forces[1].type is null; it must be spring_damper,"),
        ({"bodies": ["one"]}, "forces[1].bodies has 1 entries; it must have 2."),
        ({"stiffness": [1, 2, 3]}, "forces[1].stiffness is [1,2,3]; it must be a number."),
    ],
)
def test_text_that_is_refused(change, message):
    spring = _core.SpringDamper("strut", GROUND, ZERO, 0, ZERO, np.ones(3), np.ones(3))
    data = json.loads(_core.to_json(mechanism_of(spring, _core.LineSpring("leg", 0, ZERO, 1, ZERO, 1.0))))
    data["forces"][1].update(change)
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        _core.from_json(json.dumps(data))


def test_a_list_has_its_keys_once_in_messages():
    data = json.loads(_core.to_json(mechanism_of()))
    data["forcess"] = []
    with pytest.raises(ValueError, match=r"^forcess is unknown; the keys here are .*\.$") as caught:
        _core.from_json(json.dumps(data))
    assert str(caught.value).count("forces,") == 1


# --- variables -------------------------------------------------------------------------------------------------------

SURFACE = "modulus dissipation friction slipVelocity"
VARIABLES = {
    "LineSpring": "length rate force actuatorForce stiffness damping freeLength energy power",
    "TableSpring": "length rate force actuatorForce energy power",
    "TorsionSpring": "angle angularRate torque actuatorTorque stiffness damping rest energy power",
    "Bushing": "displacement* rotation* force* torque* stiffness* damping* torsionalStiffness* torsionalDamping* "
    "energy power",
    "Bearing": "displacement* force* stiffness* damping* crossStiffness+ crossDamping+ energy power",
    "Drag": "force* coefficient* rotational* flow* power",
    "CloudContact": f"gap normalForce force* {SURFACE} energy power",
    "FollowerForce": "position* force* torque* actuatorForce* actuatorTorque* power",
    "PlaneContact": f"gap normalForce force* {SURFACE} energy power",
    "SphereContact": f"gap normalForce force* {SURFACE} energy power",
}


@every_element
def test_variables(element):
    made = make_world(np.random.default_rng(1), ELEMENTS[element], "two bodies").element
    names = [name for name in _core.Slave(mechanism_of(made)).names if name.startswith("element.")]
    expected = []
    for name in VARIABLES[element].split():
        size = {"*": 3, "+": 2}.get(name[-1], 0)
        expected += [f"element.{name[:-1]}[{i + 1}]" for i in range(size)] if size else [f"element.{name}"]
    assert sorted(names) == sorted(expected)


@every_element
def test_names_of_variables_are_no_names_of_elements(element):
    made = make_world(np.random.default_rng(1), ELEMENTS[element], "two bodies").element
    for name in re.sub(r"[*+]", "", VARIABLES[element]).split():
        mechanism = mechanism_of(made, _core.Load(f"element.{name}", 0, ZERO, ZERO))
        with pytest.raises(ValueError, match=f"^element.{name} is the name of a load; variables of element may have"):
            mechanism.validate()


def test_parameters_are_tunable():
    """The tension follows the free length from one step to the next."""
    mechanism = mechanism_of(_core.LineSpring("leg", 0, ZERO, 1, ZERO, 10.0, free_length=0.1))
    slave = _core.Slave(mechanism)
    slave.start()
    length = slave.get("leg.length")
    assert length == pytest.approx(np.sqrt(0.29), rel=1e-15)
    assert slave.get("leg.force") == pytest.approx(10 * (length - 0.1), rel=1e-15)
    slave.set("leg.freeLength", 0.3)
    assert slave.get("leg.force") == pytest.approx(10 * (length - 0.3), rel=1e-15)
    mechanism.set("leg.stiffness", 3.0)
    assert mechanism.multibody.line_springs[0].stiffness == 3.0


# --- what is refused -------------------------------------------------------------------------------------------------


def line(**more):
    return _core.LineSpring("leg", 0, ZERO, 1, np.ones(3), **{"stiffness": 1.0} | more)


def table(**tables):
    return _core.TableSpring("leg", 0, ZERO, 1, np.ones(3), **tables)


def bushing(stiffness=(1, 1, 1), torsional=(1, 1, 1), coupling=()):
    made = _core.Bushing("pad", 0, FRAME, 1, FRAME, np.array(stiffness, float), ZERO, np.array(torsional, float))
    matrix = np.zeros((6, 6))
    for i, j, x in coupling:
        matrix[i - 1, j - 1] = x
    made.stiffness_coupling = matrix
    return made


def plane(radius=0.1, frame=FRAME, **surface):
    return _core.PlaneContact("floor", GROUND, frame, 0, ZERO, radius, _core.ContactSurface(**surface))


def cloud(points):
    return _core.CloudContact("hull", GROUND, FRAME, 0, points, 0.1, _core.ContactSurface())


def spheres(*radii):
    return _core.SphereContact("hit", 0, ZERO, radii[0], 1, ZERO, radii[1], _core.ContactSurface())


SKEW = _core.Frame(ZERO, 2 * np.eye(3))
REFUSED = {
    "no such body": (_core.LineSpring("leg", 0, ZERO, 2, ZERO, 1.0), "leg refers to body 2; allowed are -1 (ground)"),
    "itself": (_core.LineSpring("leg", 1, ZERO, 1, ZERO, 1.0), "leg connects two with itself; it must connect two"),
    "node of a rigid body": (line(node1=3), "leg attaches to node 3 of one, which is not flexible; allowed is -1"),
    "stiffness": (line(stiffness=-1.0), "leg.stiffness is -1 N/m; it must not be negative."),
    "free length": (line(free_length=-0.1), "leg.freeLength is -0.10000000000000001 m; it must not be negative."),
    "point": (
        _core.LineSpring("leg", 0, np.array([0, np.nan, 0]), 1, ZERO, 1.0),
        "leg.point1[2] is nan m; it must be finite.",
    ),
    "no table": (table(), "leg has no table; it must have one of length or of rate."),
    "table of one": (
        table(length=[1.0], force=[1.0]),
        "leg.length has 1 value; a table must have at least 2, or none.",
    ),
    "table of two sizes": (
        table(rate=[1.0, 2.0], rate_force=[1.0]),
        "leg.rate has 2 values and leg.rateForce has 1; they must have the same number.",
    ),
    "table goes back": (
        table(length=[0.0, 2.0, 1.0], force=[0.0, 1.0, 2.0]),
        "leg.length[3] is 1 after 2; the values must increase.",
    ),
    "table stands": (
        table(length=[0.0, 0.0], force=[0.0, 1.0]),
        "leg.length[2] is 0 after 0; the values must increase.",
    ),
    "table of nan": (
        table(length=[0.0, 1.0], force=[0.0, np.nan]),
        "leg.force[2] is nan; it must be finite.",
    ),
    "axes": (
        _core.TorsionSpring("coil", 0, SKEW, 1, FRAME, 1.0),
        "coil.frame1.axes are (2, 0, 0), (0, 2, 0), (0, 0, 2); they must be orthonormal and right-handed.",
    ),
    "torsion": (
        _core.TorsionSpring("coil", 0, FRAME, 1, FRAME, -1.0),
        "coil.stiffness is -1 N.m/rad; it must not be negative.",
    ),
    "bushing": (bushing(torsional=(1, -1, 1)), "pad.torsionalStiffness[2] is -1 N.m/rad; it must not be negative."),
    "diagonal of a coupling": (
        bushing(coupling=[(2, 2, 1)]),
        "pad.stiffnessCoupling[2, 2] is 1; the diagonal must be zero.",
    ),
    "coupling one way": (
        bushing(coupling=[(2, 1, 0.5)]),
        "pad.stiffnessCoupling[1, 2] is 0 but [2, 1] is 0.5; it must be symmetric.",
    ),
    "coupling nan": (
        bushing(coupling=[(1, 5, np.nan), (5, 1, np.nan)]),
        "pad.stiffnessCoupling[1, 5] is nan; it must be finite.",
    ),
    "too much coupling": (
        bushing(coupling=[(1, 5, 2), (5, 1, 2)]),
        "The stiffness of pad has, scaled to a diagonal of ones, the eigenvalue -",
    ),
    "coupling of nothing": (
        bushing(stiffness=(0, 1, 1), coupling=[(1, 5, 0.5), (5, 1, 0.5)]),
        "The stiffness of pad couples direction 1, which has none of its own; it must be positive semidefinite.",
    ),
    "follower on the ground": (
        _core.FollowerForce("jet", GROUND, ZERO),
        "jet acts on body -1; allowed are 0 to 1.",
    ),
    "follower": (
        _core.FollowerForce("jet", 0, ZERO, np.array([0, 0, np.inf])),
        "jet.force[3] is inf N; it must be finite.",
    ),
    "radius": (plane(radius=0.0), "floor.radius is 0 m; it must be positive and finite."),
    "modulus": (plane(modulus=-1.0), "floor.modulus is -1 Pa; it must not be negative."),
    "slip velocity": (plane(slip_velocity=0.0), "floor.slipVelocity is 0 m/s; it must be positive and finite."),
    "plane": (plane(frame=SKEW), "floor.frame1.axes are (2, 0, 0), (0, 2, 0), (0, 0, 2); they must be orthonormal"),
    "cross-coupling": (
        _core.Bearing("seal", 0, FRAME, 1, FRAME, ZERO, ZERO, np.array([0.0, np.nan])),
        "seal.crossStiffness[2] is nan N/m; it must be finite.",
    ),
    "bearing": (_core.Bearing("seal", 0, FRAME, 1, FRAME, -np.ones(3)), "seal.stiffness[1] is -1 N/m; it must not be"),
    "drag": (_core.Drag("air", 0, ZERO, -np.ones(3)), "air.coefficient[1] is -1 kg/m; it must not be negative."),
    "drag of the ground": (_core.Drag("air", GROUND, ZERO, np.ones(3)), "air acts on body -1; allowed are 0 to 1."),
    "no points": (cloud([]), "hull has no points; it must have at least one."),
    "point of a cloud": (
        cloud([ZERO, np.array([0, 0, np.inf])]),
        "hull.points2[2][3] is inf m; it must be finite.",
    ),
    "second radius": (spheres(1.0, -1.0), "hit.radius2 is -1 m; it must be positive and finite."),
}


@pytest.mark.parametrize(("element", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_definitions_are_refused_with_one_sentence(element, message):
    mechanism = mechanism_of(element)
    for use in (mechanism.validate, lambda: _core.Slave(mechanism), lambda: _core.System(mechanism.multibody)):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
            use()


def test_rigid_elements_that_are_degenerate_stay_finite():
    """Points that coincide have no direction, concentric spheres neither: no force along nothing, and a run."""
    mechanism = mechanism_of(_core.LineSpring("leg", 0, ZERO, 1, ZERO, 1.0, 0.1, 0.5), spheres(0.1, 0.2))
    mechanism.multibody.body(1).initial_position = ZERO
    slave = _core.Slave(mechanism)
    slave.start()
    assert slave.get("two.acceleration[1]") == slave.get("two.acceleration[2]") == 0.0
    slave.do_step(0.0, 1e-5)
    assert np.isfinite(slave.outputs()).all()
