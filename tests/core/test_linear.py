"""Linear models of random mechanisms with every type of joint, against differences along their own motions."""

import numpy as np
import pytest

from sigmafmu import _core
from sigmafmu.linear.linearization import Linearization
from sigmafmu.linear.point import OperatingPoint

from .helpers import derivative, property_test, random_tree, rotation_of, seeds


def linearization(tree, rng, frame):
    mechanism = _core.Mechanism()
    mechanism.name = "tree"
    mechanism.multibody = tree.definition
    system = _core.System(tree.definition)
    q = system.project_positions(tree.q)
    v = system.project_velocities(q, rng.uniform(-3, 3, system.velocity_size))
    u = rng.uniform(-1, 1, system.input_size)
    return Linearization(OperatingPoint(mechanism, q, v, u, system.coordinates(q, v)[0]), frame)


def deviations(linear, centre, neighbour):
    """ξ and η of a neighbour of the point `centre`, both (q, v), from the definitions of the coordinates."""
    (q0, v0), (q, v), all_ = centre, neighbour, linear.coordinates
    angles = all_.turned(q0, linear.point.turned)
    values = all_.values(q, angles) - all_.values(q0, angles)
    before, now = (rotation_of(x.reshape(-1, 7)) for x in (q0, q))  # of all bodies
    back = before.inv()
    vectors = {
        "rotationW": (now * back).as_rotvec(),
        "rotationB": (back * now).as_rotvec(),
        "displacementB": back.apply((q - q0).reshape(-1, 7)[:, :3]),
    }
    positions = []
    for i, coordinate in zip(linear.selection.indices, linear.chosen, strict=True):
        if coordinate.integral:
            positions.append(values[i])
            continue
        owner, _, kind = coordinate.name.rpartition(".")
        body, axis = int(owner.removeprefix("body")), int(kind[-2]) - 1
        positions.append(vectors[kind[:-3]][body, axis])
    rates = (all_.rates(q, v) - all_.rates(q0, v0))[linear.moving.indices]
    return np.concatenate([positions, rates])


@pytest.mark.parametrize("frame", ["world", "body"])
@property_test(examples=8, seed=seeds)
def test_neighbours_move_as_the_linear_model_says(frame, seed):
    """d/dt of neighbours' deviations is A times the deviations, and their outputs differ by C times these."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    if _core.System(tree.definition).constraint_size == 18:  # every joint is fixed
        return
    linear = linearization(tree, rng, frame)
    model, point, system = linear.model(None, None), linear.point, linear.system
    outputs = [linear.outputs.names.index(name) for name in model.outputs]

    def along(q, v, t):
        """Where the motion through (q, v) is after a short time t, to second order in t."""
        vdot = system.accelerations(q, v, point.u)[0]
        return system.compose(q, t * v + t * t / 2 * vdot), v + t * vdot

    x, dx, y = [], [], []
    for direction in rng.standard_normal((len(model.x0) + 2, 2, len(point.v))):

        def neighbour(s, direction=direction):
            q = system.project_positions(system.compose(point.q, s * direction[0]))
            return q, system.project_velocities(q, point.v + s * direction[1])

        def deviation(s, t, neighbour=neighbour):
            return deviations(linear, along(point.q, point.v, t), along(*neighbour(s), t))

        def speed(s, deviation=deviation):
            return derivative(lambda t: deviation(s, t), 1e-3)

        x.append(derivative(lambda s, deviation=deviation: deviation(s, 0.0)))
        dx.append(derivative(speed, 1e-3))
        y.append(
            derivative(
                lambda s, neighbour=neighbour: linear.outputs.values(*neighbour(s), point.u, point.turned)[outputs],
                1e-3,
            )
        )
    x, dx, y = (np.array(rows).T for rows in (x, dx, y))
    assert (np.abs(dx - model.A @ x) < 1e-6 * np.maximum(1.0, np.abs(model.A) @ np.abs(x))).all()
    steady = ~np.isin(outputs, linear.outputs.jumping)  # the values of others jump; the FMU's tests look at them
    assert (np.abs(y - model.C @ x) < 1e-6 * np.maximum(1.0, np.abs(model.C) @ np.abs(x)))[steady].all()
