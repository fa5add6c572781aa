"""A body moved by each force element alone, against SciPy's DOP853 on the model in NumPy: order 2."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .force_models import ELEMENTS, make_world, rigid_motion
from .helpers import INDEX3, rotation_of

DURATION = {"PlaneContact": 0.04, "SphereContact": 0.04, "CloudContact": 0.04, "TableSpring": 0.2}
"""Within one contact and between the points of a table; else 0.5 s."""


def exact(world, gravity, stop):
    """Place of the body at the end."""
    body = world.definition.bodies[0]
    inertia = np.diag(body.inertia)
    inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = body.inertia_products
    inverse = np.linalg.inv(inertia)
    own = np.zeros(world.model.inputs)

    def rate(_, y):
        place, twist = y[:7] / np.r_[1, 1, 1, np.full(4, np.linalg.norm(y[3:7]))], y[7:]
        a, b = (rigid_motion(place, twist, end) for end in world.ends)
        force, torque = world.model.wrench(world.element, a, b, own)
        moment = rotation_of(place).inv().apply(torque + np.cross(b.o - place[:3], force))
        w = twist[3:]
        x, y_, z = w
        matrix = np.array([[0, -x, -y_, -z], [x, 0, z, -y_], [y_, -z, 0, x], [z, y_, -x, 0]])
        return np.concatenate(
            [
                twist[:3],
                0.5 * matrix @ place[3:],
                force / body.mass + gravity,
                inverse @ (moment - np.cross(w, inertia @ w)),
            ]
        )

    start = np.concatenate([world.q[:7], world.v[:6]])
    y = solve_ivp(rate, (0.0, stop), start, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    return y[:7] / np.r_[1, 1, 1, np.full(4, np.linalg.norm(y[3:7]))]


@pytest.mark.parametrize("radius", [0.9, 0.5])
@pytest.mark.parametrize("element", ELEMENTS)
def test_order_in_time(element, radius):
    world = make_world(np.random.default_rng(7), ELEMENTS[element], "ground and body")
    stop, gravity = DURATION.get(element, 0.5), np.array([0.3, -0.4, -2.0])
    reference = exact(world, gravity, stop)
    mechanism = _core.Mechanism("Order")
    mechanism.multibody = world.definition
    mechanism.multibody.gravity = gravity
    body = mechanism.multibody.body(0)
    body.initial_position, body.initial_quaternion = world.q[:3], world.q[3:7]
    body.initial_velocity, body.initial_angular_velocity = world.v[:3], world.v[3:6]
    mechanism.integrator.formulation, mechanism.integrator.spectral_radius = INDEX3, radius
    mechanism.integrator.relative_tolerance = mechanism.integrator.absolute_tolerance = 1e-13
    errors = []
    for steps in (80, 160):
        run = _core.Simulation(mechanism)
        run.advance(stop / steps, steps)
        turn = (rotation_of(reference).inv() * rotation_of(run.state.q[:7])).as_rotvec()
        errors.append(np.linalg.norm(np.concatenate([run.state.q[:3] - reference[:3], turn])))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1), errors
    assert errors[1] < 2e-4
