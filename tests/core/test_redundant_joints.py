"""Mechanisms whose joints say some things twice run: against independent solutions, and as regular ones do."""

from functools import cache

import numpy as np
import pytest

from research.mechanisms.linkages import CRANK, DOOR_MASS, REGULAR, bricard, door, four_bar_row, planar_four_bar
from research.mechanisms.parts import SPHERICAL
from research.reference.linkage_motions import bricard_motion, four_bar_motion, four_bar_row_motion
from sigmafmu import _core

from .closed_chains import FIXED, JointPlace, mechanism
from .closed_chains import bricard as any_bricard
from .closed_chains import planar_four_bar as any_four_bar
from .helpers import (
    FORMULATIONS,
    GROUND,
    INDEX2,
    INDEX3,
    MODIFIED,
    STABILIZED,
    TANGENT_FREE,
    Rotation,
    assert_bitwise,
    copy,
    simulation,
)
from .methods import BLIEDF2, RKMK4, SE3, TIGHT

MECHANISMS = {  # and how many equations follow from others, joint by joint as many as the plane takes
    "PlanarFourBar": (planar_four_bar, 3),
    "DoubleFourBar": (lambda: four_bar_row(2), 6),
    "FourBarRow(6)": (lambda: four_bar_row(6), 18),
    "Bricard": (bricard, 1),
    "Door": (door, 3),
}
every_mechanism = pytest.mark.parametrize("name", MECHANISMS)
METHODS = {
    **{name: {"formulation": formulation} for name, formulation in FORMULATIONS.items()},
    **{f"bliedf2, {name}": {"method": BLIEDF2, "formulation": f} for name, f in FORMULATIONS.items()},
    "rkmk4": {"method": RKMK4},
    "modified": {"newton": MODIFIED},
    "tangent-free": {"jacobian": TANGENT_FREE},
    "SE3": {"group": SE3},
    "rho 0.5": {"spectral_radius": 0.5},
}
every_method = pytest.mark.parametrize("method", METHODS)
SAMPLES = 20


# --- positions against independent solutions -------------------------------------------------------------------------


@cache
def crank_centers() -> np.ndarray:
    theta, _ = four_bar_motion(np.linspace(0, 1, SAMPLES + 1))
    return CRANK / 2 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)


@cache
def bar_centers() -> np.ndarray:
    return bricard_motion(np.linspace(0, 2, SAMPLES + 1))


def four_bar_error(h: float, **settings: object) -> float:
    """Of the crank's center during 1 s, more than a turn."""
    steps = round(1 / h)
    _, q, _, _ = simulation(planar_four_bar(), step_size=h, **TIGHT, **settings).trajectory(1.0, steps)
    return float(np.abs(q[:: steps // SAMPLES, :3] - crank_centers()).max())


def bricard_error(h: float, **settings: object) -> float:
    """Of all bars' centers during 2 s."""
    steps = round(2 / h)
    _, q, _, _ = simulation(bricard(), step_size=h, **TIGHT, **settings).trajectory(2.0, steps)
    found = q[:: steps // SAMPLES].reshape(SAMPLES + 1, 5, 7)[:, :, :3]
    return float(np.abs(found - bar_centers()).max())


ORDERS = {  # steps in the asymptotic range, and the order there
    "stabilizedIndex2": (2e-3, {}, 2),
    "index3": (2e-3, {"formulation": INDEX3}, 2),
    "index2": (2e-3, {"formulation": INDEX2}, 2),
    "bliedf2": (2.5e-4, {"method": BLIEDF2}, 2),
    "bliedf2, index3": (2.5e-4, {"method": BLIEDF2, "formulation": INDEX3}, 2),
    "rkmk4": (2e-3, {"method": RKMK4}, 4),
    "modified": (2e-3, {"newton": MODIFIED}, 2),
    "tangent-free": (2e-3, {"jacobian": TANGENT_FREE}, 2),
    "SE3": (2e-3, {"group": SE3}, 2),
    "rho 1": (2e-3, {"spectral_radius": 1.0}, 2),
}


@pytest.mark.parametrize("case", ORDERS)
def test_order_of_the_planar_four_bar(case):
    """Against m(θ) θ'' + m'(θ) θ'²/2 + V'(θ) = 0."""
    h, settings, order = ORDERS[case]
    coarse, fine = four_bar_error(h, **settings), four_bar_error(h / 2, **settings)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15 if "bliedf2" in case else 0.1), (coarse, fine)


@pytest.mark.parametrize("case", [case for case in ORDERS if case != "index2"])
def test_order_of_bricards_mechanism(case):
    """Against Gauss's principle with a pseudo-inverse; generalized-alpha has 5e-6 at h = 2e-3."""
    h, settings, order = ORDERS[case]
    coarse, fine = bricard_error(2 * h, **settings), bricard_error(h, **settings)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.1), (coarse, fine)
    assert fine <= 5.5e-6


def test_index2_drifts_into_contradictions():
    """Positions that have left the joints by h² make dependent equations disagree: that costs a multiple of the error,
    which falls faster than h²."""
    coarse, fine = bricard_error(4e-3, formulation=INDEX2), bricard_error(2e-3, formulation=INDEX2)
    assert fine <= 1e-4
    assert np.log2(coarse / fine) >= 1.9


@pytest.mark.parametrize("name", ["PlanarFourBar", "FourBarRow(6)", "Bricard"])
@pytest.mark.parametrize("formulation", [INDEX3, STABILIZED], ids=["index3", "stabilizedIndex2"])
def test_motion_is_that_of_joints_that_are_not_redundant(name, formulation):
    """A ball and a sleeve in place of two hinges at the coupler, or in place of one of Bricard's, close the same."""
    build, regular = {
        "PlanarFourBar": (planar_four_bar, REGULAR[planar_four_bar]),
        "FourBarRow(6)": (lambda *k: four_bar_row(6, *k), REGULAR[four_bar_row]),
        "Bricard": (bricard, REGULAR[bricard]),
    }[name]
    # The row passes its singular position at 0.71 s, where roundings grow.
    ends = [
        simulation(m, step_size=1e-3, formulation=formulation, **TIGHT).trajectory(0.6, 600)
        for m in (build(), build(regular))
    ]
    assert _core.System(build(regular).multibody).redundant == 0
    assert np.abs(ends[0][1] - ends[1][1]).max() <= 1e-9


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank", "FlexibleSliderCrank"])
@pytest.mark.parametrize("method", ["stabilizedIndex2", "index3", "index2", "bliedf2, index3", "rkmk4", "modified"])
def test_a_joint_that_is_there_twice_changes_nothing(model, method):
    """Also on flexible bodies, and beside joints that stay exact."""
    ends = []
    for twice in (False, True):
        m = _core.mechanism(model)
        if twice:
            joint = m.multibody.joints[min(1, len(m.multibody.joints) - 1)]
            sides = (joint.body1, joint.frame1, joint.body2, joint.frame2)
            m.multibody.add(_core.Joint("again", joint.type, *sides))
            assert _core.System(m.multibody).redundant == 3
        run = simulation(m, step_size=1e-3, **TIGHT, **METHODS[method])
        run.advance(1e-3, 200)
        assert run.state.counters.retries == 0
        ends.append(run.state)
    # Index 2 lets a soft joint creep by eps h/2 times its acceleration in every second.
    tolerance = 1e-7 if method == "index2" else 1e-9
    scale = np.abs(ends[0].v).max()
    assert np.abs(ends[0].q - ends[1].q).max() <= tolerance * max(1, scale)


# --- joints and their reactions --------------------------------------------------------------------------------------


@every_mechanism
@every_method
def test_joints_hold(name, method):
    """To 1e-11 (m, directions: 1), and velocities as well where the formulation asks for it. Index 2 drifts."""
    build, dependent = MECHANISMS[name]
    definition = build()
    system = _core.System(definition.multibody)
    assert system.redundant == dependent
    run = simulation(definition, step_size=1e-3, **METHODS[method])
    _, q, v, _ = run.trajectory(0.6, 600)
    assert run.state.counters.retries == 0
    phi, rate = (
        max(np.abs(system.constraints(*row)[k]).max() for row in zip(q[::10], v[::10], strict=True)) for k in (0, 1)
    )
    if "index2" not in method:
        assert phi <= 1e-11
    if "index3" not in method:
        # Index 2 lets its velocities yield by eps h/2 lambda over a mass, and drift makes a lambda of its own.
        assert rate <= (3e-7 if "index2" in method else 1e-9)


@every_mechanism
def test_projections_are_exact(name):
    """From somewhere near: to 1e-12 of the mechanism's coordinates."""
    system = _core.System(MECHANISMS[name][0]().multibody)
    q, v = _core.assemble(MECHANISMS[name][0]().multibody)
    rng = np.random.default_rng(1)
    q = system.project_positions(system.compose(q, 1e-3 * rng.uniform(-1, 1, len(v))))
    v = system.project_velocities(q, rng.uniform(-1, 1, len(v)))
    phi, rate, _, _ = system.constraints(q, v)
    assert np.abs(phi).max() <= 1e-12 * (1 + np.abs(q).max())
    assert np.abs(rate).max() <= 1e-12
    vdot, _ = system.accelerations(q, v, np.zeros(system.input_size))
    _, _, B, Z = system.constraints(q, v)
    assert np.abs(B @ vdot + Z @ v).max() <= 1e-11 * np.abs(vdot).max()


@every_mechanism
@pytest.mark.parametrize("method", ["stabilizedIndex2", "index3", "rkmk4"])
def test_reactions_are_smooth(name, method):
    """Fourth differences over 1 ms, small for what is smooth, 16 times as large as noise.

    The multipliers are those of the outputs, from the index-1 equations. Those of index 3 show that its velocities are
    off the joints by h², on which dependent equations do not agree.
    """
    definition = MECHANISMS[name][0]()
    system = _core.System(definition.multibody)
    run = simulation(definition, step_size=1e-3, **METHODS[method])
    _, q, v, _ = run.trajectory(0.6, 600)  # the row passes its singular position at 0.71 s
    found = np.array([system.accelerations(*row, np.zeros(system.input_size))[1] for row in zip(q, v, strict=True)])
    smooth = 1e-4 if name == "PlanarFourBar" else 1e-3 if (name, method) == ("Bricard", "index3") else 1e-6
    assert np.abs(np.diff(found[10:], 4, axis=0)).max() <= smooth * np.abs(found).max()


@pytest.mark.parametrize("method", ["stabilizedIndex2", "index3", "index2", "bliedf2, stabilizedIndex2", "rkmk4"])
def test_hinge_and_ball_share_the_weight_of_a_door(method):
    """What equilibrium demands is exact; what it leaves open is shared equally, up to rounding over the compliance."""
    definition = door()
    system = _core.System(definition.multibody)
    run = simulation(definition, step_size=1e-3, **METHODS[method])
    _, q, v, multipliers = run.trajectory(1.0, 1000)
    weight = 9.81 * DOOR_MASS
    for index1 in (True, False):
        up = []
        for row in zip(q[::20], v[::20], multipliers[::20], strict=True):
            reactions = system.accelerations(row[0], row[1], np.zeros(system.input_size))[1] if index1 else row[2]
            up.append([system.reaction(row[0], row[1], reactions, joint)[0][2] for joint in (0, 1)])
        up = np.array(up)
        assert np.abs(up.sum(axis=1) - weight).max() <= 1e-6 * weight
        assert np.abs(up - weight / 2).max() <= (1e-6 if index1 else 1e-3) * weight


@pytest.mark.parametrize("name", ["PlanarFourBar", "Bricard"])
def test_energy_is_conserved_to_the_order(name):
    def drift(h: float) -> float:
        definition = MECHANISMS[name][0]()
        system = _core.System(definition.multibody)
        _, q, v, _ = simulation(definition, step_size=h, **TIGHT).trajectory(2.0, round(2 / h))
        found = np.array([system.energy(*row) for row in zip(q, v, strict=True)])
        return float(np.abs(found - found[0]).max() / np.ptp([9.81 * row[1::7].sum() for row in q]))

    coarse, fine = drift(2e-3), drift(1e-3)
    assert fine <= 1e-3
    assert np.log2(coarse / fine) >= 1.8


# --- any geometry, steps and states ----------------------------------------------------------------------------------


@every_mechanism
@every_method
def test_steps_of_any_length(name, method):
    """Positions after steps that change by up to 1000 stay near those of equal ones as long as the longest."""
    settings, longest, count = METHODS[method], 1e-3, 200
    lengths = np.random.default_rng(1).choice([1.0, 1e-3, 0.3, 0.05], count)
    stop = longest * lengths.sum()
    run = simulation(MECHANISMS[name][0](), step_size=longest, **settings)
    for length in longest * lengths:
        run.advance(length, 1)
    equal = simulation(MECHANISMS[name][0](), step_size=longest, **settings)
    equal.run(stop, int(np.ceil(stop / longest)))
    fine = simulation(MECHANISMS[name][0](), step_size=longest, method=RKMK4)
    fine.run(stop, 4 * int(np.ceil(stop / longest)))
    allowed = 2 * np.abs(equal.state.q - fine.state.q).max() + 1e-7
    assert np.abs(run.state.q - fine.state.q).max() <= allowed


@every_mechanism
@every_method
def test_runs_are_repeated_to_the_bit(name, method):
    """From a state that was saved, and by another simulation of the same definition."""
    run, other = (simulation(MECHANISMS[name][0](), step_size=1e-3, **METHODS[method]) for _ in range(2))
    run.advance(1e-3, 20)
    saved = copy(run.state)
    run.advance(1e-3, 20)
    end = copy(run.state)
    run.state = saved
    run.advance(1e-3, 20)
    assert_bitwise(run.state, end)
    other.advance(1e-3, 40)
    assert_bitwise(other.state, end)


@pytest.mark.parametrize("build", [any_bricard, any_four_bar], ids=["Bricard", "RRRR"])
@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0], ids=lambda size: f"{size:g} m")
def test_any_geometry_runs(build, size):
    """Falls for 50 steps, each as long for its size as 1 ms is for 1 m: joints yield by 1e-7 s g, and not more than a
    few times that where levers are long."""
    h = 1e-3 * np.sqrt(size)
    for seed in range(30):
        chain = build(np.random.default_rng(seed), size=size)
        chain.multibody.gravity = np.array([0, 0, -9.81])
        system = _core.System(chain.multibody)
        run = simulation(chain, step_size=h)
        run.advance(h, 50)
        assert run.state.counters.retries == 0
        assert np.abs(system.constraints(run.state.q, run.state.v)[0]).max() <= 1e-11 * max(1, size), seed


# --- drives, masses, words -------------------------------------------------------------------------------------------


def test_two_drives_that_say_the_same():
    """Both outer cranks of the row are turned at one rate: seven equations too many, and nothing left to move."""
    m = four_bar_row(2)
    for pivot in (0, 2):
        m.multibody.add(_core.Drive(pivot, _core.Motion.rate, -1.0))
    system = _core.System(m.multibody)
    assert system.redundant == 7
    run = simulation(m, step_size=1e-3)
    run.advance(1e-3, 500)
    assert run.state.counters.retries == 0
    _, v = run.state.q, run.state.v.reshape(-1, 6)
    assert np.abs(v[:3, 5] + 1).max() <= 1e-9
    assert np.abs(v[3:, 5]).max() <= 1e-9


def test_the_joints_are_named_at_the_start_and_counted():
    slave = _core.Slave(planar_four_bar())
    slave.start()
    assert slave.messages == [
        "Joint equations are dependent: 3 of the 20 equations of joints hinge1, hinge2, hinge3 and hinge4 follow from "
        "the others; the reactions of these joints are one choice of many that fit the motion."
    ]
    assert slave.get("joints.redundant") == 3
    slave.do_step(0.0, 0.01)
    assert slave.get("constraint.positionResidual") <= 1e-11
    assert "joints.redundant" not in _core.Slave(_core.mechanism("SliderCrank")).names


def test_too_small_an_inertia_is_called_that_here_as_well():
    m = planar_four_bar()
    m.multibody.body(1).mass = 1e-18
    m.multibody.body(1).inertia = np.full(3, 1e-20)
    with pytest.raises(RuntimeError, match=r"The mass or inertia of body coupler is too small for this mechanism"):
        _core.Simulation(m)


def test_joints_that_contradict_each_other_are_named():
    """A body that is fixed to the ground twice, at places 0.1 m apart."""
    rng = np.random.default_rng(5)
    up = np.array([0.0, 0, 1])
    near = mechanism(rng, 1, [JointPlace(FIXED, GROUND, 0, np.ones(3), up)] * 2).multibody
    far = _core.Mechanism()
    far.multibody.add(near.bodies[0])
    far.multibody.add(near.joints[0])
    second = near.joints[1]
    moved = _core.Frame(second.frame1.origin + np.array([0.1, 0, 0]), second.frame1.axes)
    far.multibody.add(_core.Joint("second", FIXED, GROUND, moved, 0, second.frame2))
    with pytest.raises(RuntimeError, match=r"joints joint1 and second cannot be closed together, they miss by 0\.1 m"):
        _core.Simulation(far)


def test_only_the_joints_that_depend_yield():
    """A door beside a chain on ball joints, whose joints hold to rounding."""
    m = door()
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "plumb", 1.0, np.full(3, 0.1)
    body.initial_position = np.array([1.8, 0.0, 1.0])
    m.multibody.add(body)
    end = _core.Frame(np.array([0.4, 0.0, 0.0]), np.eye(3))
    m.multibody.add(_core.Joint("link", SPHERICAL, 0, end, 1, _core.Frame(np.array([-1.0, 0, 0]), np.eye(3))))
    system = _core.System(m.multibody)
    run = simulation(m, step_size=1e-3, **TIGHT)
    run.advance(1e-3, 500)
    phi = np.abs(system.constraints(run.state.q, run.state.v)[0])
    assert phi[:8].max() >= 1e-13  # 1e-7 β h² times loads over 20 kg
    assert phi[8:].max() <= 1e-15


def test_four_bar_rows_are_as_far_as_their_cranks():
    """Twenty loops of one freedom each, coupled: against the solution for all cranks alike."""
    count, stop = 20, 0.5
    run = simulation(four_bar_row(count), step_size=1e-3)
    run.advance(1e-3, 500)
    theta, _ = four_bar_row_motion(count, np.array([0.0, stop]))
    turn = Rotation.from_quat(run.state.q.reshape(-1, 7)[: count + 1, 3:], scalar_first=True).as_rotvec()[:, 2]
    assert np.abs(turn - theta[-1]).max() <= 2e-6
