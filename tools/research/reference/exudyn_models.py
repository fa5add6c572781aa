"""The benchmark mechanisms in Exudyn, built from the same definitions as the FMUs.

`simulate` returns time histories under the FMU's variable names, and what the solve call cost.

    run = simulate("HeavyTop", Settings(step_size=1e-4), stop_time=1.0, sample_step=0.01)
    run.history["top.position[3]"], run.steps, run.newton_iterations, run.cpu_time

Exudyn has a fast module without range checks; a process can load only one of the two. Benchmarks ask for it with
`load_exudyn(fast=True)` before anything else, or with the environment variable EXUDYN_MODULE=fast.

Signs: Exudyn's joints constrain p_1 − p_0 = 0 (marker 1 minus marker 0) and report the multiplier λ. The equations of
motion are M q̈ + Gᵀλ = f, so the force on the body of marker 1 is −λ and on the body of marker 0 it is +λ.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from research.reference import (
    CRANK,
    CRANK_CENTRE,
    CRANK_LENGTH,
    GRAVITY,
    ROD,
    ROD_LENGTH,
    SLIDER,
    TOP,
    TOP_PIVOT,
    Body,
    History,
    Rotor,
    add_vector,
    quaternions_from_matrices,
)
from sigmafmu import SigmafmuError, _core


@dataclass(frozen=True)
class Settings:
    """How Exudyn solves.

    rotation: eulerParameters, lieGroup (rotation vector as local coordinate) or taitBryan (Rxyz).
    scheme: index3 (generalized-α), index2 (Newmark, trapezoidal rule, constraints on velocity level) or RK67 (explicit,
    only for mechanisms without constraints).
    simplified_kinematics: lieGroup only; True is the scheme of Brüls and Cardona (2010), False the σ-modified one.
    """

    step_size: float  # s, internal step h
    rotation: str = "eulerParameters"
    scheme: str = "index2"
    rho_inf: float = 0.9  # generalized-α only
    simplified_kinematics: bool = False
    modified_newton: bool = False
    sparse: bool = False  # a sparse linear solver
    relative_tolerance: float = 1e-8  # of the Newton residual; Exudyn's default
    absolute_tolerance: float = 1e-10
    contact: bool = False  # iterate on contact states, without the steps that Exudyn would then choose


@dataclass(frozen=True)
class Run:
    """Result of one simulation; `history` has one sample (the end) when no sample step was asked for."""

    history: History
    steps: int
    newton_iterations: int
    jacobians: int
    cpu_time: float  # s, of the solve call only
    wall_time: float  # s, of the solve call only
    version: str  # of Exudyn


def load_exudyn(fast: bool | None = None) -> Any:
    """Import Exudyn, silently; fast = True asks for the module without range checks, None takes what there is."""
    if fast is not None:
        if "exudyn" in sys.modules and fast != _is_fast():
            raise RuntimeError("this process has loaded the other Exudyn module already; start a new one")
        sys.exudynFast = fast  # type: ignore[attr-defined]
    with contextlib.redirect_stdout(io.StringIO()):
        import exudyn
        import exudyn.itemInterface
        import exudyn.utilities  # registers mbs.CreateRigidBody
    if fast and not _is_fast():
        raise RuntimeError("Exudyn's fast module needs a CPU with AVX2")
    exudyn.config.printToConsole = False
    return exudyn


def _is_fast() -> bool:
    return "exudyn.exudynCPPfast" in sys.modules


@dataclass(frozen=True)
class FlexibleBody:
    """Exudyn's numbers of a flexible body: node of its frame, node of its modal coordinates, object, stations.

    A station is a column prefix and the nodes of the mesh whose mean position is recorded.
    """

    frame: Any
    modal: Any
    body: Any
    stations: dict[str, range]


@dataclass
class Model:
    """An Exudyn system, and what is read from it."""

    exu: Any
    mbs: Any
    rotation: str
    bodies: dict[str, Any] = field(default_factory=dict)  # name → Exudyn body
    flexible: dict[str, FlexibleBody] = field(default_factory=dict)
    points: list[tuple[str, Any, np.ndarray]] = field(default_factory=list)  # column, Exudyn body, point in B
    forces: list[tuple[str, Any, str, float, str | None]] = field(default_factory=list)
    """Column, Exudyn joint, output variable, sign, body in whose axes Exudyn reports it (None: W)."""
    derived: Callable[[History], None] = lambda history: None  # adds the columns that follow from others

    @property
    def rotation_type(self) -> Any:
        """Exudyn's type of the nodes of rigid bodies and frames."""
        return {
            "eulerParameters": self.exu.NodeType.RotationEulerParameters,
            "lieGroup": self.exu.NodeType.RotationRotationVector,
            "taitBryan": self.exu.NodeType.RotationRxyz,
        }[self.rotation]

    def add_body(self, body: Body, gravity: np.ndarray) -> Any:
        """Add a rigid body, gravity in m/s2 in W; returns Exudyn's number of it."""
        return self.create_body(
            body.name,
            body.mass,
            np.diag(body.inertia),
            gravity,
            position=body.position,
            rotation=np.array(body.rotation),
            velocity=body.velocity,
            angular_velocity=body.angular_velocity,
        )

    def create_body(
        self,
        name: str,
        mass: float,
        inertia: np.ndarray,
        gravity: np.ndarray,
        *,
        position: Sequence[float],
        rotation: np.ndarray,
        velocity: Sequence[float],
        angular_velocity: Sequence[float],
    ) -> Any:
        """Add a rigid body: matrix of inertia in B, gravity and initial values in W; returns Exudyn's number of it."""
        number = self.mbs.CreateRigidBody(
            name=name,
            referencePosition=list(position),
            referenceRotationMatrix=rotation,
            initialVelocity=list(velocity),
            initialAngularVelocity=list(angular_velocity),
            inertia=self.exu.rigidBodyUtilities.RigidBodyInertia(mass=mass, inertiaTensor=inertia),
            gravity=list(gravity),
            nodeType=self.rotation_type,
            show=False,
        )
        self.bodies[name] = number
        return number

    def add_ground(self) -> Any:
        """Add the inertial frame W as a body."""
        return self.mbs.AddObject(self.exu.itemInterface.ObjectGround())

    def marker(self, body: Any, point: np.ndarray, axes: np.ndarray | None = None) -> Any:
        """Add a marker at a point of a body (m, in B) with the body's axes, or these (columns, in B)."""
        items = self.exu.itemInterface
        if axes is None:
            return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[float(x) for x in point]))
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = axes, point
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localHT=place))

    def node_marker(self, node: Any) -> Any:
        """Add a marker with the position and the axes of a node."""
        return self.mbs.AddMarker(self.exu.itemInterface.MarkerNodeRigid(nodeNumber=node))

    def hinge(self, first: Any, second: Any) -> Any:
        """Leave turns about z of two markers free."""
        return self.mbs.AddObject(self.exu.itemInterface.ObjectJointRevoluteZ(markerNumbers=[first, second]))

    def joint(self, first: Any, second: Any, axes: list[int]) -> Any:
        """Constrain translations and rotations of two markers; three rotations free: spherical joint."""
        items = self.exu.itemInterface
        if axes == [1, 1, 1, 0, 0, 0]:
            return self.mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[first, second]))
        return self.mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[first, second], constrainedAxes=axes))


def heavy_top(model: Model) -> None:
    """Heavy top: spherical joint `pivot` between the origin of W and the body `top`."""
    top = model.add_body(TOP, GRAVITY)
    origin = model.marker(model.add_ground(), np.zeros(3))
    pivot = model.joint(origin, model.marker(top, TOP_PIVOT), [1, 1, 1, 0, 0, 0])
    model.forces.append(("pivot.reactionForce", pivot, "Force", -1.0, None))


def high_speed_rotor(model: Model, rotor: Rotor | None = None) -> None:
    """High-speed rotor: no joints, two supports with stiffness and damping along the axes of W."""
    rotor = rotor or Rotor()
    items = model.exu.itemInterface
    body = model.add_body(rotor.body, np.zeros(3))
    ground = model.add_ground()
    for name, x, axes in (("leftSupport", -rotor.left, (1, 1, 1)), ("rightSupport", rotor.right, (0, 1, 1))):
        point = np.array([x, 0.0, 0.0])
        model.mbs.AddObject(
            items.ObjectConnectorCartesianSpringDamper(
                markerNumbers=[model.marker(ground, point), model.marker(body, point)],
                stiffness=[rotor.stiffness * axis for axis in axes],
                damping=[rotor.damping * axis for axis in axes],
            )
        )
        model.points.append((f"{name}.position", body, point))
    model.mbs.AddLoad(
        items.LoadTorqueVector(markerNumber=model.marker(body, np.zeros(3)), loadVector=rotor.torque.tolist())
    )


def slider_crank(model: Model) -> None:
    """Spatial slider-crank: revolute, spherical, universal and prismatic joint, 17 independent equations.

    A generic joint that constrains one rotation (its third) requires t_x0 · t_y1 = 0, where t_x0 is the x axis of its
    first and t_y1 the y axis of its second marker. With the slider first and the rod second that is the universal joint
    of the definition: slider e_x ⟂ rod e_y.
    """
    crank, rod, slider = (model.add_body(body, GRAVITY) for body in (CRANK, ROD, SLIDER))
    ground = model.add_ground()
    along_crank = np.array([0.0, 0.0, 0.5 * CRANK_LENGTH])
    along_rod = np.array([0.5 * ROD_LENGTH, 0.0, 0.0])
    crank_pivot = model.joint(model.marker(ground, CRANK_CENTRE), model.marker(crank, -along_crank), [1, 1, 1, 0, 1, 1])
    crank_pin = model.joint(model.marker(crank, along_crank), model.marker(rod, -along_rod), [1, 1, 1, 0, 0, 0])
    wrist_pin = model.joint(model.marker(slider, np.zeros(3)), model.marker(rod, along_rod), [1, 1, 1, 0, 0, 1])
    guide = model.joint(model.marker(ground, np.zeros(3)), model.marker(slider, np.zeros(3)), [0, 1, 1, 1, 1, 1])
    # A joint with three constrained translations has its multipliers in W but reports them in the first marker's axes.
    model.forces += [
        ("crankPivot.reactionForce", crank_pivot, "ForceLocal", -1.0, None),
        ("crankPin.reactionForce", crank_pin, "Force", -1.0, None),
        ("wristPin.reactionForce", wrist_pin, "ForceLocal", 1.0, "slider"),
        ("guide.reactionForce", guide, "ForceLocal", -1.0, None),
    ]
    model.derived = slider_crank_coordinates


def of_definition(definition: _core.Multibody) -> Callable[[Model], None]:
    """Builder of rigid bodies on spherical, revolute and cylindrical joints, with our definition's initial values.

    SigmafmuError: it has anything else.
    """

    def build(model: Model) -> None:
        q, v = _core.assemble(definition)
        ground = model.add_ground()
        for body, pose, rates in zip(definition.bodies, q.reshape(-1, 7), v.reshape(-1, 6), strict=True):
            R = Rotation.from_quat(pose[3:], scalar_first=True).as_matrix()
            products = body.inertia_products
            inertia = np.diag(body.inertia)
            inertia[np.triu_indices(3, 1)] = inertia.T[np.triu_indices(3, 1)] = products
            model.create_body(
                body.name,
                body.mass,
                inertia,
                definition.gravity,
                position=pose[:3],
                rotation=R,
                velocity=rates[:3],
                angular_velocity=R @ rates[3:],
            )
        numbers = [*model.bodies.values()]
        for joint in definition.joints:
            ball = joint.type == _core.JointType.spherical
            markers = [
                model.marker(
                    ground if body == _core.GROUND else numbers[body], frame.origin, None if ball else frame.axes
                )
                for body, frame in ((joint.body1, joint.frame1), (joint.body2, joint.frame2))
            ]
            if joint.type == _core.JointType.revolute:
                model.hinge(*markers)
            else:
                model.joint(*markers, [1, 1, 1, 0, 0, 0] if ball else [1, 1, 0, 1, 1, 0])

    kinds = _core.JointType.spherical, _core.JointType.revolute, _core.JointType.cylindrical
    others = [joint.name for joint in definition.joints if joint.type not in kinds]
    others += [force.name for force in (*definition.spring_dampers, *definition.loads)]
    others += [body.name for body in definition.bodies if body.modal]
    if others or definition.joint_springs or definition.drives:
        raise SigmafmuError(
            f"the mechanism has {', '.join(others) or 'joint springs or drives'}; "
            "Exudyn gets rigid bodies on spherical, revolute and cylindrical joints alone"
        )
    return build


def slider_crank_coordinates(history: History) -> None:
    """θ from the crank's quaternion (cos θ/2, sin θ/2, 0, 0), unwrapped, and s = x_C."""
    half = np.arctan2(history["crank.quaternion[2]"], history["crank.quaternion[1]"])
    history["crankPivot.angle"] = np.unwrap(2.0 * half)
    history["guide.displacement"] = history["slider.position[1]"].copy()


BUILDERS: dict[str, Callable[[Model], None]] = {
    "HeavyTop": heavy_top,
    "HighSpeedRotor": high_speed_rotor,
    "SliderCrank": slider_crank,
}


def simulate(
    name: str,
    settings: Settings,
    stop_time: float,
    sample_step: float | None = None,
    fast: bool | None = None,
    build: Callable[[Model], None] | None = None,
) -> Run:
    """Build the mechanism `name` (or what `build` builds), solve it from 0 to stop_time and sample every sample_step.

    Without a sample step nothing is stored during the run (for timing) and the history holds the last state only.
    Raises exudyn.SolverError when Exudyn does not reach the end.
    """
    exu = load_exudyn(fast)
    container = exu.SystemContainer()
    model = Model(exu, container.AddSystem(), settings.rotation)
    (build or BUILDERS[name])(model)
    probes = _probes(model)
    sensors = [_sensor(model, *probe[1:]) for probe in probes] if sample_step else []
    model.mbs.Assemble()

    steps = max(1, round(stop_time / settings.step_size))
    if abs(steps * settings.step_size - stop_time) > 1e-9 * stop_time:
        raise ValueError(f"the stop time {stop_time} s is no multiple of the step {settings.step_size} s")
    simulation = _simulation_settings(exu, settings, stop_time, steps, sample_step)
    wall, cpu = time.perf_counter(), time.process_time()
    model.mbs.SolveDynamic(simulation)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu

    if sample_step:
        samples = [model.mbs.GetSensorStoredData(sensor) for sensor in sensors]
        expected = np.arange(round(stop_time / sample_step) + 1) * sample_step
        if samples[0].shape[0] != len(expected) or np.abs(samples[0][:, 0] - expected).max() > 1e-9 * stop_time:
            raise ValueError("Exudyn did not store the samples asked for: is sample_step a multiple of step_size?")
        values = {probe[0]: table[:, 1:] for probe, table in zip(probes, samples, strict=True)}
    else:
        expected = np.array([stop_time])
        values = {probe[0]: _read(model, *probe[1:])[None, :] for probe in probes}
    it = model.mbs.sys["dynamicSolver"].it  # its step index counts from 1
    if it.currentStepIndex != steps + 1:
        raise RuntimeError(f"Exudyn took {it.currentStepIndex - 1} steps instead of {steps}")
    explicit = settings.scheme == "RK67"
    return Run(
        history=_history(model, expected, values),
        steps=steps,
        newton_iterations=0 if explicit else it.newtonStepsCount,
        jacobians=0 if explicit else it.newtonJacobiCount,
        cpu_time=cpu,
        wall_time=wall,
        version=exu.__version__,
    )


def _probes(model: Model) -> list[tuple[str, str, Any, str, Any]]:
    """All that is read from Exudyn: (column, kind, Exudyn number, output variable, place).

    Kinds: body (place: point in B), node, mesh (of a flexible body; place: number of the mesh node), joint.
    """
    motion = (
        ("position", "Position"),
        ("rotation", "RotationMatrix"),
        ("velocity", "Velocity"),
        ("angularVelocity", "AngularVelocityLocal"),
    )
    probes: list[tuple[str, str, Any, str, Any]] = []
    for name, body in model.bodies.items():
        probes += [(f"{name}.{column}", "body", body, variable, np.zeros(3)) for column, variable in motion]
    for name, flexible in model.flexible.items():
        probes += [(f"{name}.{column}", "node", flexible.frame, variable, None) for column, variable in motion]
        probes.append((f"{name}.modal", "node", flexible.modal, "Coordinates", None))
        probes.append((f"{name}.modalRate", "node", flexible.modal, "Coordinates_t", None))
        for station, nodes in flexible.stations.items():
            probes += [(f"{station}.{node}", "mesh", flexible.body, "Position", node) for node in nodes]
    probes += [(column, "body", body, "Position", point) for column, body, point in model.points]
    probes += [(column, "joint", joint, variable, None) for column, joint, variable, _, _ in model.forces]
    return probes


def _sensor(model: Model, kind: str, number: Any, variable: str, place: Any) -> Any:
    items = model.exu.itemInterface
    common = {"outputVariableType": getattr(model.exu.OutputVariableType, variable), "storeInternal": True}
    if kind == "body":
        sensor = items.SensorBody(bodyNumber=number, localPosition=list(place), **common)
    elif kind == "node":
        sensor = items.SensorNode(nodeNumber=number, **common)
    elif kind == "mesh":
        sensor = items.SensorSuperElement(bodyNumber=number, meshNodeNumber=place, **common)
    else:
        sensor = items.SensorObject(objectNumber=number, **common)
    return model.mbs.AddSensor(sensor)


def _read(model: Model, kind: str, number: Any, variable: str, place: Any) -> np.ndarray:
    output = getattr(model.exu.OutputVariableType, variable)
    if kind == "body":
        value = model.mbs.GetObjectOutputBody(number, output, localPosition=list(place))
    elif kind == "node":
        value = model.mbs.GetNodeOutput(number, output)
    elif kind == "mesh":
        value = model.mbs.GetObjectOutputSuperElement(number, output, place)
    else:
        value = model.mbs.GetObjectOutput(number, output)
    return np.asarray(value, dtype=float).reshape(-1)


def _simulation_settings(exu: Any, settings: Settings, stop_time: float, steps: int, sample_step: float | None) -> Any:
    simulation = exu.SimulationSettings()
    simulation.solution.file.write = False
    simulation.solution.sensors.active = sample_step is not None
    if sample_step:
        simulation.solution.sensors.writePeriod = sample_step
    if settings.sparse:
        simulation.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    integration = simulation.timeIntegration
    integration.endTime = stop_time
    integration.numberOfSteps = steps
    integration.verboseMode = 0
    integration.adaptiveStep = False  # a step that fails ends the run: the step size is what it says
    integration.automaticStepSize = False
    integration.newton.useModifiedNewton = settings.modified_newton
    integration.newton.relativeTolerance = settings.relative_tolerance
    integration.newton.absoluteTolerance = settings.absolute_tolerance
    if settings.contact:
        integration.discontinuous.iterationTolerance = 1.0
        integration.discontinuous.maxIterations = 5
        integration.discontinuous.ignoreMaxIterations = True
        integration.discontinuous.useRecommendedStepSize = False
    alpha = integration.generalizedAlpha
    alpha.spectralRadius = settings.rho_inf
    alpha.lieGroupSimplifiedKinematicRelations = settings.simplified_kinematics
    if settings.scheme == "RK67":
        integration.solverType = exu.DynamicSolverType.RK67
    elif settings.scheme == "index2":
        alpha.useIndex2Constraints = True
        alpha.useNewmark = True
    elif settings.scheme != "index3":
        raise ValueError(f"unknown scheme {settings.scheme!r}: index3, index2 or RK67")
    return simulation


def _history(model: Model, times: np.ndarray, values: dict[str, np.ndarray]) -> History:
    """Exudyn's values under the FMU's names, in the FMU's axes and signs."""
    history: History = {"time": times}
    bodies = [*model.bodies, *model.flexible]
    rotations = {name: values[f"{name}.rotation"].reshape(-1, 3, 3) for name in bodies}
    for name in bodies:
        add_vector(history, f"{name}.position", values[f"{name}.position"])
        add_vector(history, f"{name}.quaternion", quaternions_from_matrices(rotations[name]))
        add_vector(history, f"{name}.velocity", values[f"{name}.velocity"])
        add_vector(history, f"{name}.angularVelocity", values[f"{name}.angularVelocity"])
    for name, flexible in model.flexible.items():
        add_vector(history, f"{name}.modal", values[f"{name}.modal"])
        add_vector(history, f"{name}.modalRate", values[f"{name}.modalRate"])
        for station, nodes in flexible.stations.items():
            mean = np.mean([values[f"{station}.{node}"] for node in nodes], axis=0)
            add_vector(history, f"{station}.position", mean)
    for column, _, _ in model.points:
        add_vector(history, column, values[column])
    for column, _, _, sign, axes in model.forces:
        force = sign * values[column] + 0.0  # no negative zeros
        add_vector(history, column, force if axes is None else np.einsum("nij,nj->ni", rotations[axes], force))
    model.derived(history)
    return history
