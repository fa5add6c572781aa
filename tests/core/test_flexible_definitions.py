"""Definitions of flexible bodies, and of joints and springs at their nodes, that are refused with one sentence."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .clouds import FLOATING, flexible_body, random_cloud
from .helpers import GROUND, random_body

Type = _core.JointType
FRAME = _core.Frame(np.zeros(3), np.eye(3))


def with_modal(**values):
    def change(definition):
        for name, value in values.items():
            setattr(definition.body(0).modal, name, value)

    return change


def changed(array, index, value):
    result = np.array(array)
    result[index] = value
    return result


def good():
    definition = _core.Multibody()
    definition.add(flexible_body(GOOD, "rod", as_matrix=False))
    definition.add(random_body(np.random.default_rng(1), "bob"))
    definition.add(_core.Joint("pin", Type.spherical, 0, _core.Frame(np.zeros(3), np.eye(3), 5), 1, FRAME))
    return definition


def joint_at(body1, node1, body2=1, node2=FLOATING):
    frames = [_core.Frame(np.zeros(3), np.eye(3), node) for node in (node1, node2)]
    return lambda definition: definition.add(_core.Joint("hook", Type.spherical, body1, frames[0], body2, frames[1]))


def spring_at(node1, node2):
    zero = np.zeros(3)
    return lambda definition: definition.add(_core.SpringDamper("wire", 0, zero, 1, zero, zero, zero, node1, node2))


GOOD = random_cloud(np.random.default_rng(7), modes=2, lumped=True)
NODES, SHAPES = len(GOOD.nodes), GOOD.shapes.reshape(-1, 2)
MASSES = np.diag(GOOD.mass)
LINE = np.outer(np.arange(NODES), [1.0, 0.0, 0.0])
TRANSLATION = np.tile(np.eye(3)[:, :1], (NODES, 1))
REFUSED = {
    "no nodes": (with_modal(nodes=np.zeros((0, 3))), "rod.modal.nodes has no rows; there must be at least one node."),
    "plane nodes": (
        with_modal(nodes=np.zeros((6, 2))),
        "rod.modal.nodes is 6 x 2; it must be 6 x 3 (one row per node).",
    ),
    "shapes of other nodes": (
        with_modal(shapes=SHAPES[:-3]),
        "rod.modal.shapes is 15 x 2; it must be 18 x 2 (three rows per node, one column per mode).",
    ),
    "rotations of other nodes": (
        with_modal(rotations=SHAPES[:-3]),
        "rod.modal.rotations is 15 x 2; it must be 18 x 2 (three rows per node, one column per mode).",
    ),
    "stiffness of other modes": (
        with_modal(stiffness=np.eye(3)),
        "rod.modal.stiffness is 3 x 3; it must be 2 x 2 (modes by modes).",
    ),
    "damping of other modes": (
        with_modal(damping=np.eye(1)),
        "rod.modal.damping is 1 x 1; it must be 2 x 2 (modes by modes).",
    ),
    "masses of other nodes": (
        with_modal(masses=np.ones(5)),
        "rod.modal.masses is 5 x 1; it must be 6 x 1 (one per node).",
    ),
    "mass matrix of other nodes": (
        with_modal(masses=np.zeros(0), mass_matrix=np.eye(5)),
        "rod.modal.massMatrix is 5 x 5; it must be 6 x 6 (nodes by nodes).",
    ),
    "two kinds of mass": (
        with_modal(mass_matrix=np.eye(6)),
        "rod.modal has masses and a massMatrix; it must have one of them.",
    ),
    "initial values of other modes": (
        with_modal(initial_coordinates=np.zeros(3)),
        "rod.modal.initialCoordinates is 3 x 1; it must be 2 x 1 (one per mode).",
    ),
    "initial rates not finite": (
        with_modal(initial_rates=np.array([0.0, np.nan])),
        "rod.modal.initialRates[2, 1] is nan; it must be finite.",
    ),
    "nodes not finite": (
        with_modal(nodes=changed(GOOD.nodes, (1, 2), np.inf)),
        "rod.modal.nodes[2, 3] is inf; it must be finite.",
    ),
    "shapes not finite": (
        with_modal(shapes=changed(SHAPES, (3, 1), np.nan)),
        "rod.modal.shapes[4, 2] is nan; it must be finite.",
    ),
    "stiffness not finite": (
        with_modal(stiffness=np.diag([np.nan, 1.0])),
        "rod.modal.stiffness[1, 1] is nan; it must be finite.",
    ),
    "stiffness not symmetric": (
        with_modal(stiffness=np.array([[2.0, 1.0], [0.5, 2.0]])),
        "rod.modal.stiffness has 0.5 at [2, 1] and 1 at [1, 2]; it must be symmetric.",
    ),
    "negative stiffness": (
        with_modal(stiffness=np.diag([2.0, -1.0])),
        "rod.modal.stiffness has the eigenvalue -1; it must be positive semidefinite.",
    ),
    "negative damping": (
        with_modal(damping=np.diag([-2.0, 1.0])),
        "rod.modal.damping has the eigenvalue -2; it must be positive semidefinite.",
    ),
    "negative Rayleigh damping": (
        with_modal(mass_damping=-0.5),
        "rod.modal.massDamping is -0.5 1/s; it must be finite and not negative.",
    ),
    "infinite Rayleigh damping": (
        with_modal(stiffness_damping=np.inf),
        "rod.modal.stiffnessDamping is inf s; it must be finite and not negative.",
    ),
    "negative mass": (
        with_modal(masses=changed(MASSES, 3, -0.25)),
        "rod.modal.masses[4] is -0.25 kg; it must not be negative.",
    ),
    "no mass": (with_modal(masses=np.zeros(NODES)), "rod.modal has the mass 0 kg; it must be positive."),
    "mass on a line": (
        with_modal(nodes=LINE),
        "rod.modal has all its mass on one line; the nodes must have moments of inertia about every axis.",
    ),
    "the same mode twice": (
        with_modal(shapes=SHAPES[:, [0, 0]]),
        "rod.modal.shapes gives a singular modal mass matrix; the modes must be independent and move mass.",
    ),
    "a mode that moves nothing": (
        with_modal(shapes=changed(SHAPES, (slice(None), 1), 0.0)),
        "rod.modal.shapes gives a singular modal mass matrix; the modes must be independent and move mass.",
    ),
    "a rigid motion as mode": (
        with_modal(shapes=np.hstack([SHAPES[:, :1], TRANSLATION])),
        "rod.modal.shapes contains a rigid motion; the modes must be independent of the motions of the floating frame.",
    ),
    "a node too far": (
        joint_at(0, NODES),
        "hook attaches to node 6 of rod; allowed are -1 (floating frame) to 5.",
    ),
    "a node below the frame": (
        joint_at(0, -2),
        "hook attaches to node -2 of rod; allowed are -1 (floating frame) to 5.",
    ),
    "a node of a rigid body": (
        joint_at(0, 0, 1, 3),
        "hook attaches to node 3 of bob, which is not flexible; allowed is -1 (no node).",
    ),
    "a node of the ground": (
        joint_at(GROUND, 0),
        "hook attaches to node 0 of the ground, which is not flexible; allowed is -1 (no node).",
    ),
    "a spring too far": (
        spring_at(9, FLOATING),
        "wire attaches to node 9 of rod; allowed are -1 (floating frame) to 5.",
    ),
    "a spring on no node": (
        spring_at(0, 1),
        "wire attaches to node 1 of bob, which is not flexible; allowed is -1 (no node).",
    ),
}


def test_the_definition_that_the_next_test_spoils_is_good():
    good().validate()


@pytest.mark.parametrize(("spoil", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_definitions_are_refused_with_one_sentence(spoil, message):
    definition = good()
    spoil(definition)
    for use in (definition.validate, lambda: _core.System(definition)):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
            use()


def test_mass_that_is_not_semidefinite_is_refused():
    matrix = np.eye(NODES)
    matrix[0, 1] = matrix[1, 0] = 3.0
    definition = good()
    with_modal(masses=np.zeros(0), mass_matrix=matrix)(definition)
    with pytest.raises(ValueError, match=r"^rod\.modal\.massMatrix has the eigenvalue -\S+; it must be positive semi"):
        definition.validate()
