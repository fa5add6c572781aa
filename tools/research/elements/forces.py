"""Forces between bodies beside those of Exudyn and MuJoCo."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.interpolate import PchipInterpolator

from research.bench.trees import mujoco_model, text
from research.elements import Case, Peer
from research.elements.parts import AXES, add_first, frame_in, frame_markers, mechanism, pair, point_markers
from research.mechanisms.parts import GROUND, add_body
from research.reference.exudyn_models import Model
from sigmafmu import _core

ENDS = (0, np.array([0.1, 0.05, 0.0]), 1, np.array([-0.1, 0.0, 0.1]))
"""Points of both bodies."""


def _with(element: Any) -> _core.Mechanism:
    m = pair()
    m.multibody.add(element)
    return m


def _add(model: Model, item: Any, **values: Any) -> None:
    model.mbs.AddObject(item(**values))


def _sites(root: ElementTree.Element, *places: tuple[str, np.ndarray]) -> None:
    for name, point in places:
        body = root.find(f".//body[@name='{name}']")
        assert body is not None
        ElementTree.SubElement(body, "site", name=name, pos=text(point))


# --- along W, along a line -------------------------------------------------------------------------------------------


def spring_damper() -> _core.Mechanism:
    """Between both bodies."""
    return _with(_core.SpringDamper("s", *ENDS, np.array([300.0, 200, 100]), np.array([3.0, 2, 1])))


def _exudyn_spring_damper(model: Model, d: _core.Multibody) -> None:
    (s,) = d.spring_dampers
    constants = {"stiffness": list(s.stiffness), "damping": list(s.damping)}
    item = model.exu.itemInterface.ObjectConnectorCartesianSpringDamper
    _add(model, item, markerNumbers=point_markers(model, s), **constants)


def line_spring() -> _core.Mechanism:
    """Between both bodies."""
    return _with(_core.LineSpring("s", *ENDS, 200.0, 4.0, 0.3))


def _exudyn_line_spring(model: Model, d: _core.Multibody) -> None:
    (s,) = d.line_springs
    item = model.exu.itemInterface.ObjectConnectorSpringDamper
    constants = {"stiffness": s.stiffness, "damping": s.damping, "referenceLength": s.free_length}
    _add(model, item, markerNumbers=point_markers(model, s), **constants)


def _mujoco_line_spring(d: _core.Multibody) -> Any:
    (s,) = d.line_springs

    def edit(root: ElementTree.Element) -> None:
        _sites(root, ("a", s.point1), ("b", s.point2))
        constants = {"stiffness": s.stiffness, "damping": s.damping, "springlength": s.free_length}
        tendon = ElementTree.SubElement(ElementTree.SubElement(root, "tendon"), "spatial")
        tendon.attrib.update({key: repr(value) for key, value in constants.items()})
        for name in "ab":
            ElementTree.SubElement(tendon, "site", site=name)

    return mujoco_model(d, edit)


LENGTHS, TENSIONS = [0.2, 0.3, 0.45, 0.6, 0.8], [-60.0, 0.0, 20.0, 25.0, 80.0]


def table_spring() -> _core.Mechanism:
    """Between both bodies."""
    return _with(_core.TableSpring("s", *ENDS, LENGTHS, TENSIONS, [-1.0, 0.0, 2.0], [-3.0, 0.0, 4.0]))


def _exudyn_table_spring(model: Model, d: _core.Multibody) -> None:
    (s,) = d.table_springs
    tables = PchipInterpolator(s.length, s.force), PchipInterpolator(s.rate, s.rate_force)

    def value(table: PchipInterpolator, x: float) -> float:
        """With straight lines beyond its ends."""
        inside = np.clip(x, table.x[0], table.x[-1])
        return float(table(inside) + table(inside, 1) * (x - inside))

    def law(mbs, t, number, stretch, rate, stiffness, damping, force):
        return value(tables[0], stretch) + value(tables[1], rate)

    item = model.exu.itemInterface.ObjectConnectorSpringDamper
    _add(model, item, markerNumbers=point_markers(model, s), springForceUserFunction=law)


# --- between frames --------------------------------------------------------------------------------------------------


def _frames(m: _core.Mechanism, one: int, two: int, point: np.ndarray) -> tuple:
    sides = []
    for body in (one, two):
        sides += [body, frame_in(m.multibody, body, point, AXES)]
    return tuple(sides)


PLACE = np.array([0.3, 0.0, 0.1])


def torsion_spring() -> _core.Mechanism:
    """On a hinge of the first body."""
    m = mechanism()
    sides = _frames(m, GROUND, add_first(m, 0.0), PLACE)
    m.multibody.add(_core.Joint("hinge", _core.JointType.revolute, *sides))
    m.multibody.add(_core.TorsionSpring("s", *sides, 6.0, 0.2, 0.5))
    return m


def _exudyn_torsion_spring(model: Model, d: _core.Multibody) -> None:
    (s,) = d.torsion_springs
    markers = frame_markers(model, s)
    model.hinge(*markers)
    constants = {"stiffness": s.stiffness, "damping": s.damping, "offset": s.rest}
    _add(model, model.exu.itemInterface.ObjectConnectorTorsionalSpringDamper, markerNumbers=markers, **constants)


def _mujoco_torsion_spring(d: _core.Multibody) -> Any:
    (s,) = d.torsion_springs

    def edit(root: ElementTree.Element) -> None:
        (hinge,) = root.iter("joint")
        hinge.attrib |= {"stiffness": repr(s.stiffness), "damping": repr(s.damping), "springref": repr(s.rest)}

    return mujoco_model(d, edit)


def bushing(part: float = 1.0) -> _core.Mechanism:
    """Holds the first body, which starts with that part of its velocity; without gravity."""
    m = mechanism(np.zeros(3))
    sides = _frames(m, GROUND, add_first(m, part), PLACE)
    along, about = np.array([900.0, 600, 400]), np.array([30.0, 20, 10])
    m.multibody.add(_core.Bushing("s", *sides, along, 0.01 * along, about, 0.01 * about))
    return m


def _diagonal(one: np.ndarray, two: np.ndarray) -> list[list[float]]:
    return np.diag(np.concatenate([one, two])).tolist()


def _exudyn_bushing(intrinsic: bool) -> Any:
    def add(model: Model, d: _core.Multibody) -> None:
        (s,) = d.bushings
        constants = {
            "stiffness": _diagonal(s.stiffness, s.torsional_stiffness),
            "damping": _diagonal(s.damping, s.torsional_damping),
            "useIntrinsicFormulation": intrinsic,
        }
        item = model.exu.itemInterface.ObjectConnectorRigidBodySpringDamper
        _add(model, item, markerNumbers=frame_markers(model, s), **constants)

    return add


def bearing() -> _core.Mechanism:
    """Holds the first body, with cross-coupling; axes of the ground."""
    m = mechanism()
    sides = _frames(m, GROUND, add_first(m), PLACE)
    crosses = np.array([80.0, -60.0]), np.array([3.0, -2.0])
    m.multibody.add(_core.Bearing("s", *sides, np.array([500.0, 600, 300]), np.array([5.0, 4, 3]), *crosses))
    return m


def _exudyn_bearing(model: Model, d: _core.Multibody) -> None:
    (s,) = d.bearings
    matrices = {}
    for key, diagonal, cross in (
        ("stiffness", s.stiffness, s.cross_stiffness),
        ("damping", s.damping, s.cross_damping),
    ):
        matrix = np.diag(np.concatenate([diagonal, np.zeros(3)]))
        matrix[0, 1], matrix[1, 0] = cross
        matrices[key] = matrix.tolist()
    item = model.exu.itemInterface.ObjectConnectorRigidBodySpringDamper
    _add(model, item, markerNumbers=frame_markers(model, s), **matrices)


# --- on one body -----------------------------------------------------------------------------------------------------

AT = np.array([0.1, 0.0, -0.05])


def follower_force() -> _core.Mechanism:
    """On the first body."""
    m = mechanism()
    m.multibody.add(_core.FollowerForce("s", add_first(m), AT, np.array([3.0, 4, 20]), np.array([0.2, -0.1, 0.3])))
    return m


def _exudyn_follower_force(model: Model, d: _core.Multibody) -> None:
    (s,) = d.follower_forces
    marker, items = model.marker(model.bodies["a"], s.point), model.exu.itemInterface
    model.mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=list(s.force), bodyFixed=True))
    model.mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=list(s.torque), bodyFixed=True))


def _mujoco_follower_force(d: _core.Multibody) -> Any:
    (s,) = d.follower_forces

    def edit(root: ElementTree.Element) -> None:
        _sites(root, ("a", s.point))
        gear = text([*s.force, *s.torque])
        ElementTree.SubElement(ElementTree.SubElement(root, "actuator"), "motor", site="a", gear=gear)

    return *mujoco_model(d, edit), np.ones(1)


DENSITY, WIND = 800.0, 0.7
"""Of a medium that rises [kg/m³], [m/s]."""


def drag() -> _core.Mechanism:
    """On a box that falls along one of its axes, by the area across."""
    m = mechanism()
    inertia = np.array([0.03, 0.04, 0.05])
    body = add_body(m.multibody, "a", 2.0, inertia, np.zeros(3))
    edges = np.sqrt(6 * (inertia.sum() - 2 * inertia) / 2.0)  # of the box with these moments
    coefficient = 0.5 * DENSITY * np.array([edges[1] * edges[2], edges[2] * edges[0], edges[0] * edges[1]])
    m.multibody.add(_core.Drag("s", body, np.zeros(3), coefficient, flow=np.array([0.0, 0.0, WIND])))
    return m


def _mujoco_drag(d: _core.Multibody) -> Any:
    def edit(root: ElementTree.Element) -> None:
        option = root.find("option")
        assert option is not None
        option.attrib |= {"density": repr(DENSITY), "wind": f"0 0 {WIND}"}

    return mujoco_model(d, edit)


def load() -> _core.Mechanism:
    """Force and torque in W, on the first body."""
    m = mechanism()
    m.multibody.add(_core.Load("s", add_first(m), np.array([3.0, 4, 20]), np.array([0.2, -0.1, 0.3])))
    return m


def _exudyn_load(model: Model, d: _core.Multibody) -> None:
    (s,) = d.loads
    marker, items = model.marker(model.bodies["a"], np.zeros(3)), model.exu.itemInterface
    model.mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=list(s.force)))
    model.mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=list(s.torque)))


# --- contact ---------------------------------------------------------------------------------------------------------

RADII, MODULUS, SPEED, RETURN = (0.2, 0.3), 1e6, 2.0, 0.8


SLIPPING = 1e-4
"""Velocity that regularises friction, far below those that occur [m/s]: its laws differ there."""
FRICTION = 0.03


def sphere_contact(dissipation: float = 0.0, friction: float = 0.0, modulus: float = MODULUS) -> _core.Mechanism:
    """Two balls without gravity, one of which hits the other, which rests, off its middle."""
    m = mechanism(np.zeros(3))
    J = np.full(3, 0.02)
    add_body(m.multibody, "a", 1.0, J, np.zeros(3))
    velocity = np.array([-SPEED, 0.0, 0.0])
    add_body(m.multibody, "b", 1.5, J, np.array([0.6, 0.2, 0.0]), velocity=velocity)
    surface = _core.ContactSurface(modulus, dissipation, friction, SLIPPING)
    m.multibody.add(_core.SphereContact("s", 0, np.zeros(3), RADII[0], 1, np.zeros(3), RADII[1], surface))
    return m


APPROACH = SPEED * np.sqrt(0.5**2 - 0.2**2) / 0.5
"""With which the balls meet, along their common normal [m/s]."""


def plane_contact() -> _core.Mechanism:
    """A ball that bounces along an inclined plane."""
    m = mechanism()
    normal = AXES[:, 2]
    velocity = 2.0 * AXES[:, 0]
    body = add_body(m.multibody, "a", 1.0, np.full(3, 0.004), (RADII[0] + 0.02) * normal, velocity=velocity)
    surface = _core.ContactSurface(MODULUS)
    plane = _core.Frame(np.zeros(3), AXES)
    m.multibody.add(_core.PlaneContact("s", GROUND, plane, body, np.zeros(3), RADII[0], surface))
    return m


def _hertz(model: Model, surface: _core.ContactSurface, curvature: float) -> dict[str, Any]:
    """Exudyn's constants of the law, and the node that it wants."""
    items = model.exu.itemInterface
    node = model.mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.1, 0, 0, 0], numberOfDataCoordinates=4))
    stiffness = 4 / 3 * surface.modulus * np.sqrt(curvature)
    return {
        "nodeNumber": node,
        "contactStiffness": stiffness,
        "contactStiffnessExponent": 1.5,
        "dynamicFriction": surface.friction,
        "frictionProportionalZone": surface.slip_velocity,
    }


def _exudyn_plane_contact(model: Model, d: _core.Multibody) -> None:
    (s,) = d.plane_contacts
    markers = [model.marker(model.bodies["a"], s.point2), model.marker(model.add_ground(), s.frame1.origin, AXES)]
    item = model.exu.itemInterface.ObjectContactSphereTriangle
    corners = model.exu.Vector3DList([[-10.0, -10.0, 0.0], [20.0, -10.0, 0.0], [-10.0, 20.0, 0.0]])
    constants = {"sphereRadius": s.radius, "trianglePoints": corners} | _hertz(model, s.surface, s.radius)
    _add(model, item, markerNumbers=markers, **constants)


def _exudyn_sphere_contact(**more: Any) -> Any:
    def add(model: Model, d: _core.Multibody) -> None:
        (s,) = d.sphere_contacts
        curvature = 1 / (1 / s.radius1 + 1 / s.radius2)
        items = model.exu.itemInterface
        constants = {"spheresRadii": [s.radius1, s.radius2]} | _hertz(model, s.surface, curvature)
        markers = point_markers(model, s)
        _add(model, items.ObjectContactSphereSphere, markerNumbers=markers, **constants, **more)

    return add


BUSHINGS = {
    "RigidBodySpringDamper": "Its torques are a matrix times Tait-Bryan angles, which differs from ours by the square "
    "of the rotation: a tenth of the motion leaves a hundredth of the difference.",
    "RigidBodySpringDamper, intrinsic": "Its axes are midway between the frames, and the displacement is that of a "
    "screw: again the square of it.",
}
"""Exudyn's → why it differs."""
HUNT_CROSSLEY = {"impactModel": 1, "restitutionCoefficient": RETURN}
LEVER = (
    "Friction has another lever there, by a part of the penetration: a contact ten times as stiff, which penetrates "
    "0.4 times as far, leaves 0.4 of the difference."
)

CASES = (
    Case("spring_damper", spring_damper, exudyn=Peer("CartesianSpringDamper", _exudyn_spring_damper, 2)),
    Case(
        "line_spring",
        line_spring,
        exudyn=Peer("SpringDamper", _exudyn_line_spring, 2),
        mujoco=Peer("spatial tendon", _mujoco_line_spring, 4),
    ),
    Case(
        "table_spring",
        table_spring,
        exudyn=Peer("SpringDamper with SciPy's PCHIP as user function", _exudyn_table_spring, 2),
    ),
    Case(
        "torsion_spring",
        torsion_spring,
        exudyn=Peer("TorsionalSpringDamper", _exudyn_torsion_spring, 2),
        mujoco=Peer("stiffness of a hinge", _mujoco_torsion_spring, 4),
    ),
    *(
        Case(
            name,
            lambda part=part: bushing(part),
            exudyn=Peer(peer, _exudyn_bushing(peer.endswith("intrinsic")), 2, note),
        )
        for name, part in (("bushing", 1.0), ("bushing, a tenth of the motion", 0.1))
        for peer, note in BUSHINGS.items()
    ),
    Case("bearing", bearing, exudyn=Peer("RigidBodySpringDamper", _exudyn_bearing, 2)),
    Case(
        "follower_force",
        follower_force,
        exudyn=Peer("body-fixed loads", _exudyn_follower_force, 2),
        mujoco=Peer("motor at a site", _mujoco_follower_force, 4),
    ),
    Case("drag, along one axis", drag, mujoco=Peer("density, wind", _mujoco_drag, 4)),
    Case("load", load, exudyn=Peer("loads", _exudyn_load, 2)),
    Case(
        "sphere_contact",
        sphere_contact,
        steps=8000,
        contact=True,
        exudyn=Peer("ContactSphereSphere", _exudyn_sphere_contact(), 2),
    ),
    Case(
        "sphere_contact, dissipation",
        lambda: sphere_contact((1 - RETURN) / APPROACH),
        steps=8000,
        contact=True,
        exudyn=Peer(
            "ContactSphereSphere, Hunt-Crossley",
            _exudyn_sphere_contact(impactModel=1, restitutionCoefficient=RETURN),
            2,
        ),
    ),
    *(
        Case(
            name,
            lambda modulus=modulus: sphere_contact(friction=FRICTION, modulus=modulus),
            steps=8000,
            contact=True,
            exudyn=Peer("ContactSphereSphere", _exudyn_sphere_contact(), 2, LEVER),
        )
        for name, modulus in (
            ("sphere_contact, friction", MODULUS),
            ("sphere_contact, friction, ten times as stiff", 10 * MODULUS),
        )
    ),
    Case(
        "plane_contact",
        plane_contact,
        steps=8000,
        contact=True,
        exudyn=Peer("ContactSphereTriangle", _exudyn_plane_contact, 2),
    ),
)
