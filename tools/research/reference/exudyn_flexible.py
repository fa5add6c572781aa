"""The flexible mechanisms in Exudyn: its ObjectFFRFreducedOrder from the masses, stiffness and modes of a cloud.

    run = exudyn_models.simulate("FlexiblePendulum", settings, 2.0, 0.01, build=flexible_pendulum)

Exudyn takes a finite element model with the mass and stiffness matrices of all nodes and a mode basis Ψ. The mass
matrix of a cloud is diagonal. For the stiffness any matrix with Ψᵀ 𝐊 Ψ = K will do: Ψ⁺ᵀ K Ψ⁺, Ψ⁺ the pseudo-inverse.

Two things of Exudyn 1.13.6 that are avoided here. The weight as LoadMassProportional acts at the undeformed centre of
mass: its moment lacks the deflection. As a force on the mean of all nodes, weighted with their masses, it is complete.
With Tait-Bryan angles the object does not converge to the solution, with Euler parameters and rotation vectors it does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from research.reference import (
    CRANK,
    CRANK_CENTRE,
    CRANK_LENGTH,
    GRAVITY,
    ROD,
    ROD_LENGTH,
    SLIDER,
    Body,
)
from research.reference.clouds import PENDULUM_ANGULAR_VELOCITY, Cloud, SpinUp, conrod_cloud, pendulum_cloud
from research.reference.exudyn_models import FlexibleBody, Model, slider_crank_coordinates


class _FiniteElements:
    """What ObjectFFRFreducedOrderInterface asks of a finite element model."""

    def __init__(self, cloud: Cloud) -> None:
        self.nodes = cloud.nodes
        basis = cloud.modes.reshape(3 * len(cloud.nodes), -1)
        inverse = np.linalg.pinv(basis)
        self.modeBasis = {"matrix": basis}
        self.postProcessingModes: dict[str, Any] = {}
        self.mass = csr_matrix(np.diag(np.repeat(cloud.masses, 3)))
        self.stiffness = csr_matrix(inverse.T @ cloud.stiffness @ inverse)

    def GetNodePositionsAsArray(self) -> np.ndarray:
        return self.nodes

    def GetSurfaceTriangles(self) -> list:
        return []

    GetSurfaceTriangles6 = GetSurfaceTriangles

    def GetMassMatrix(self, sparse: bool = True) -> csr_matrix:
        return self.mass

    def GetStiffnessMatrix(self, sparse: bool = True) -> csr_matrix:
        return self.stiffness


def add_flexible_body(
    model: Model,
    name: str,
    cloud: Cloud,
    position: np.ndarray,
    rotation: np.ndarray,
    velocity: np.ndarray,
    angular_velocity: np.ndarray,
    stations: dict[str, int],
    gravity: np.ndarray = GRAVITY,
) -> FlexibleBody:
    """Add the cloud as an ObjectFFRFreducedOrder, undeformed; initial velocities and gravity in W.

    `stations`: column prefix → section whose centre is recorded.
    """
    from exudyn.FEM import ObjectFFRFreducedOrderInterface

    interface = ObjectFFRFreducedOrderInterface(
        _FiniteElements(cloud), rigidBodyNodeType=model.rotation_type, roundMassMatrix=0.0, roundStiffnessMatrix=0.0
    )
    added = interface.AddObjectFFRFreducedOrder(
        model.mbs,
        positionRef=position.tolist(),
        rotationMatrixRef=rotation,
        initialVelocity=velocity.tolist(),
        initialAngularVelocity=angular_velocity.tolist(),
        name=name,
    )
    weight = model.mbs.AddMarker(
        model.exu.itemInterface.MarkerSuperElementPosition(
            bodyNumber=added["oFFRFreducedOrder"],
            meshNodeNumbers=list(range(len(cloud.nodes))),
            weightingFactors=(cloud.masses / cloud.mass).tolist(),
        )
    )
    model.mbs.AddLoad(
        model.exu.itemInterface.LoadForceVector(markerNumber=weight, loadVector=(cloud.mass * gravity).tolist())
    )
    body = FlexibleBody(
        added["nRigidBody"],
        added["nGenericODE2"],
        added["oFFRFreducedOrder"],
        {station: range(len(cloud.nodes))[cloud.section(section)] for station, section in stations.items()},
    )
    model.flexible[name] = body
    return body


def flexible_pendulum(model: Model) -> None:
    """FlexiblePendulum: spherical joint between the origin of W and the floating frame."""
    zero = np.zeros(3)
    beam = add_flexible_body(
        model, "beam", pendulum_cloud(), zero, np.eye(3), zero, PENDULUM_ANGULAR_VELOCITY, {"tip": -1}
    )
    origin = model.marker(model.add_ground(), zero)
    model.joint(origin, model.node_marker(beam.frame), [1, 1, 1, 0, 0, 0])


def flexible_slider_crank(model: Model) -> None:
    """FlexibleSliderCrank: the joints of the slider-crank, those of the rod on its floating frame."""
    crank, slider = (model.add_body(body, GRAVITY) for body in (CRANK, SLIDER))
    ground, zero = model.add_ground(), np.zeros(3)
    along_crank = np.array([0.0, 0.0, 0.5 * CRANK_LENGTH])
    omega, rotation = np.array(ROD.angular_velocity), np.array(ROD.rotation)
    to_origin = -0.5 * ROD_LENGTH * rotation[:, 0]  # from the rigid rod's COM to B
    rod = add_flexible_body(
        model,
        "rod",
        conrod_cloud(ROD_LENGTH, ROD.mass),
        ROD.position + to_origin,
        rotation,
        ROD.velocity + np.cross(omega, to_origin),
        omega,
        {"middle": 5},
    )
    # the rod's end: a point from the mesh (the modes leave its centre in place), the axes from the frame's node
    end = model.mbs.AddMarker(
        model.exu.itemInterface.MarkerSuperElementPosition(
            bodyNumber=rod.body, meshNodeNumbers=[40, 41, 42, 43], weightingFactors=[0.25] * 4
        )
    )
    frame = model.node_marker(rod.frame)
    model.joint(model.marker(ground, CRANK_CENTRE), model.marker(crank, -along_crank), [1, 1, 1, 0, 1, 1])
    model.joint(model.marker(crank, along_crank), frame, [1, 1, 1, 0, 0, 0])
    model.joint(model.marker(slider, zero), end, [1, 1, 1, 0, 0, 0])
    model.joint(model.marker(slider, zero), frame, [0, 0, 0, 0, 0, 1])
    model.joint(model.marker(ground, zero), model.marker(slider, zero), [0, 1, 1, 1, 1, 1])
    model.derived = slider_crank_coordinates


def spin_up_beam(model: Model, spin_up: SpinUp | None = None) -> None:
    """SpinUpBeam: hub on a revolute joint about W z, the floating frame fixed to it, torque on the hub."""
    spin_up = spin_up or SpinUp()
    zero, inertia = np.zeros(3), spin_up.inertia
    # the joint leaves the hub's mass and its other moments without effect
    hub = model.add_body(Body("hub", 1.0, (spin_up.hub_inertia,) * 3, (0.0,) * 3, (0.0,) * 3, (0.0,) * 3), zero)
    beam = add_flexible_body(model, "beam", spin_up.cloud, zero, np.eye(3), zero, zero, {"tip": -1}, zero)
    ground, shaft = model.marker(model.add_ground(), zero), model.marker(hub, zero)
    model.joint(ground, shaft, [1, 1, 1, 1, 1, 0])
    model.joint(shaft, model.node_marker(beam.frame), [1, 1, 1, 1, 1, 1])

    def torque(_mbs: Any, t: float, _load: Any) -> list[float]:
        return [0.0, 0.0, inertia * float(spin_up.acceleration(t))]

    model.mbs.AddLoad(
        model.exu.itemInterface.LoadTorqueVector(
            markerNumber=shaft, loadVector=[0.0, 0.0, 0.0], loadVectorUserFunction=torque
        )
    )
