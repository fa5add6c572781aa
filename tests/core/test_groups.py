"""R³×SO(3) and SE(3), their coordinate maps, and the two kinds of absolute coordinates in the integrator."""

from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    EPS,
    FORMULATIONS,
    FULL,
    INCREMENTAL,
    INDEX2,
    INDEX3,
    MODIFIED,
    RESIDUAL,
    TANGENT_FREE,
    assert_close,
    copy,
    simulation,
)
from .methods import (
    BLIEDF2,
    EXP,
    FIXED_STEPS,
    GENERALIZED_ALPHA,
    GROUPS,
    MAPS,
    METHODS,
    PROBLEMS,
    QUATERNION,
    R3XSO3,
    RKMK54,
    ROTATION_VECTOR,
    SE3,
    TIGHT,
    assert_order,
    lgt,
    observed_orders,
)

every_map = pytest.mark.parametrize("local", MAPS.values(), ids=MAPS)
every_formulation = pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
OTHERS = {name: chosen for name, chosen in lgt().items() if name != "R3xSO3 exp"}
"""All but the default, which test_scheme.py and test_order.py examine."""
DEFAULT = _core.AlphaParameters(0.9)
SIGMAS = {"geom1": 0.0, "optimal": DEFAULT.gamma / (3 * DEFAULT.beta), "1": 1.0}


# --- the modified generalized-alpha method on all of them ------------------------------------------------------------


@pytest.mark.parametrize("chosen", OTHERS.values(), ids=OTHERS)
@pytest.mark.parametrize("sigma", SIGMAS.values(), ids=SIGMAS)
@pytest.mark.parametrize("corrector", [RESIDUAL, INCREMENTAL], ids=["residual", "incremental"])
@every_formulation
def test_order_for_every_sigma_corrector_and_formulation(chosen, sigma, corrector, formulation):
    """That all approach the same independent solution is also their agreement.

    Index 3 gives the multipliers a start-up error of first order (its start values satisfy Φ' = 0 exactly), which is
    their largest one in the first samples; on SE(3) there is none, for Φ = 0 is kept without multipliers.
    """
    found = observed_orders(
        "HeavyTop", GENERALIZED_ALPHA, sigma=sigma, corrector=corrector, formulation=formulation, **chosen
    )
    if formulation == INDEX3 and chosen["group"] == R3XSO3:
        del found["reaction"]
    assert_order(found, 2)


@pytest.mark.parametrize("group", ["R3xSO3 cayley", "SE3 exp"])
@pytest.mark.parametrize("sigma", SIGMAS.values(), ids=SIGMAS)
@every_formulation
def test_order_in_a_closed_loop(group, sigma, formulation):
    found = observed_orders("SliderCrank", GENERALIZED_ALPHA, sigma=sigma, formulation=formulation, **lgt()[group])
    if formulation == INDEX3:
        del found["reaction"]
    assert_order(found, 2)


# --- Newton's method -------------------------------------------------------------------------------------------------


def iterations(model: str, h: float, steps: int, **settings) -> float:
    """Per step, to rounding; no step is repeated."""
    run = simulation(model, step_size=h, **{**TIGHT, **settings})
    run.run(steps * h, steps)
    assert run.state.counters.retries == 0
    return run.state.counters.newton_iterations / steps


METHOD_AND_SIGMA = {"geom1": (GENERALIZED_ALPHA, 0.0), "sigma 1": (GENERALIZED_ALPHA, 1.0), "bliedf2": (BLIEDF2, 1.0)}


@pytest.mark.parametrize(("model", "h"), [("HeavyTop", 4e-3), ("SliderCrank", 1e-2)])
@pytest.mark.parametrize(("method", "sigma"), METHOD_AND_SIGMA.values(), ids=METHOD_AND_SIGMA)
@every_formulation
@every_map
def test_newton_converges_on_se3_as_on_r3xso3(model, h, method, sigma, formulation, local):
    """At steps as large as hω = 0.6: every part of the derivative is there, with the turning of the body's axes."""
    settings = {"method": method, "sigma": sigma, "formulation": formulation, "local_coordinates": local}
    needed = {group: iterations(model, h, 50, group=group, **settings) for group in GROUPS.values()}
    # The heavy top needs the same number in every step, which may just be enough on one group and not on the other.
    allowed = 1.0 if model == "HeavyTop" else 0.2
    assert needed[SE3] <= min(4.0, needed[R3XSO3] + allowed)


@pytest.mark.parametrize("group", lgt())
@pytest.mark.parametrize(("model", "h"), [("HeavyTop", 1e-3), ("SliderCrank", 2e-3)])
@pytest.mark.parametrize("jacobian", [FULL, TANGENT_FREE], ids=["full", "tangentFree"])
@pytest.mark.parametrize("newton", [FULL, MODIFIED], ids=["full", "modified"])
def test_every_iteration_comes_to_the_same_end(group, model, h, jacobian, newton):
    """Newton's method converges quadratically, the others linearly; all without a repeated step. Each of the 100 steps
    may leave a few times 1e-13 |v| and the rounding 8 ε γ' of the angles, here 2e-11 rad/s."""
    ends = []
    for chosen in ({}, {"jacobian": jacobian, "newton": newton}):
        run = simulation(model, step_size=h, **lgt()[group], **TIGHT, **chosen)
        run.run(100 * h, 100)
        ends.append(copy(run.state))
        assert run.state.counters.retries == 0
    assert_close(ends[1].q, ends[0].q, 1e-9)
    assert_close(ends[1].v, ends[0].v, 2e-10)
    assert_close(ends[1].lambda_, ends[0].lambda_, 1e-8)
    if newton == MODIFIED:
        assert run.state.counters.jacobian_evaluations <= 150
        assert run.state.counters.newton_iterations > 500


# --- lower pairs to the ground ---------------------------------------------------------------------------------------

JOINT_EQUATIONS = {"HeavyTop": {"pivot": 3}, "SliderCrank": {"crankPivot": 5, "crankPin": 3, "wristPin": 4, "guide": 5}}
LONG = {"HeavyTop": (1e-3, 2000), "SliderCrank": (2e-3, 2500)}


@cache
def drift(model: str, **settings) -> dict[str, float]:
    """Largest |Φ| per joint over a long run, in m or as a product of unit vectors."""
    h, steps = LONG[model]
    run = simulation(model, step_size=h, **settings, **TIGHT)
    _, q, v, _ = run.trajectory(steps * h, steps)
    system = _core.System(_core.mechanism(model).multibody)
    worst = np.abs([system.constraints(*row)[0] for row in zip(q[::10], v[::10], strict=True)]).max(axis=0)
    ends = np.cumsum(list(JOINT_EQUATIONS[model].values()))
    parts = np.split(worst, ends[:-1])
    return {joint: float(part.max()) for joint, part in zip(JOINT_EQUATIONS[model], parts, strict=True)}


@pytest.mark.parametrize("method", [GENERALIZED_ALPHA, BLIEDF2], ids=["generalizedAlpha", "bliedf2"])
@pytest.mark.parametrize("absolute", [QUATERNION, ROTATION_VECTOR], ids=["quaternion", "rotationVector"])
@every_map
def test_se3_keeps_lower_pairs_to_the_ground(method, absolute, local):
    """Index 2 imposes velocities alone. Those that a spherical or revolute joint to the ground allows are an algebra:
    on SE(3) a step with one of them keeps the joint, but for rounding, some ulps a step. The joints between moving
    bodies drift on both groups."""
    chosen = {"method": method, "formulation": INDEX2, "local_coordinates": local, "absolute_coordinates": absolute}
    for model, joint, drifted in (("HeavyTop", "pivot", 1e-4), ("SliderCrank", "crankPivot", 1e-5)):
        rounding = 4 * EPS * LONG[model][1]
        kept, lost = (drift(model, group=group, **chosen) for group in (SE3, R3XSO3))
        assert kept[joint] <= rounding
        assert lost[joint] >= drifted
        if model == "SliderCrank":
            for group in (kept, lost):
                assert group["guide"] <= rounding  # a straight line is kept by either group
                assert min(group["crankPin"], group["wristPin"]) >= 2e-5


@pytest.mark.parametrize("method", [m for m in METHODS if m.startswith("rkmk")])
@every_map
def test_projection_has_nothing_to_do_for_a_joint_that_se3_keeps(method, local):
    """Munthe-Kaas methods project positions after each step: on SE(3) the heavy top's pivot needs it almost never (when
    rounding has added up), on R³×SO(3) at every step."""
    count = {}
    for group in GROUPS.values():
        settings = {"method": METHODS[method], "group": group, "local_coordinates": local, **FIXED_STEPS}
        run = simulation("HeavyTop", step_size=1e-3, **settings)
        run.run(2.0, 2000)
        count[group] = run.state.counters.newton_iterations
    assert count[SE3] <= 20
    assert count[R3XSO3] >= 2000


# --- absolute coordinates --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize(("group", "local"), list(product(GROUPS.values(), MAPS.values())))
@pytest.mark.parametrize(("problem", "h"), [("HeavyTop", 1e-3), ("rotor", 1e-3)])
def test_absolute_coordinates_do_not_change_the_motion(problem, h, method, group, local):
    """A thousand steps and two dozen turns or more; each rounds the pose once more, and velocities answer to it."""
    steps, rows = 1000, []
    for absolute in (QUATERNION, ROTATION_VECTOR):
        run = simulation(
            PROBLEMS[problem].make(), step_size=h, method=method, group=group, local_coordinates=local,
            absolute_coordinates=absolute, **(FIXED_STEPS if method == RKMK54 else TIGHT),
        )  # fmt: skip
        rows.append(run.trajectory(steps * h, steps))
    (_, q, v, _), (_, other_q, other_v, _) = rows
    assert not np.array_equal(q, other_q), "they are rounded differently"
    np.testing.assert_allclose(other_q, q, rtol=0, atol=8 * EPS * steps)
    np.testing.assert_allclose(other_v, v, rtol=0, atol=8 * EPS * steps * np.abs(v).max())
    quaternions = other_q[:, 3:7]
    assert all(a @ b > 0.9 for a, b in pairwise(quaternions)), "no jump to the negative quaternion"
    assert (quaternions[:, 0] < -0.9).any(), "nor back to the first of the two after a turn"
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, rtol=0, atol=4 * EPS)


@pytest.mark.parametrize("absolute", [QUATERNION, ROTATION_VECTOR], ids=["quaternion", "rotationVector"])
@pytest.mark.parametrize("method", ["generalizedAlpha", "rkmk4"])
def test_quaternions_stay_unit_over_100_000_steps(method, absolute):
    """They are products of a hundred thousand unit quaternions, each of them rounded."""
    settings = {"method": METHODS[method], "absolute_coordinates": absolute, "local_coordinates": EXP, "group": SE3}
    run = simulation(PROBLEMS["FreeBody"].make(), step_size=1e-2, **settings, **FIXED_STEPS)
    run.run(1000.0, 100_000)
    assert abs(np.linalg.norm(run.state.q[3:]) - 1.0) <= 4 * EPS


@pytest.mark.parametrize("sigma", [0.0, 1.0, 2.0, None], ids=["geom1", "1", "2", "gamma/(3 beta)"])
@pytest.mark.parametrize(
    ("local_coordinates", "part"), [(MAPS["cayley"], 1.0), (MAPS["cayley2"], 0.25)], ids=["cayley", "cayley2"]
)
def test_lag_of_a_steady_spin_with_cayley_maps(local_coordinates, part, sigma):
    """(12) says it: (1/12 - σβ/(4γ)) (hω)³ per step for Cayley, a quarter for Cayley2, none for σ = γ/(3β)."""
    h, steps, spin = 1e-5, 100, 20944.0
    alpha = _core.AlphaParameters(0.9)
    sigma = alpha.gamma / (3 * alpha.beta) if sigma is None else sigma
    run = simulation("HighSpeedRotor", step_size=h, local_coordinates=local_coordinates, sigma=sigma, **TIGHT)
    run.run(steps * h, steps)
    angle = 2 * np.arctan2(run.state.q[4], run.state.q[3])
    lag = np.angle(np.exp(1j * (spin * steps * h - angle))) / steps
    phi = h * spin
    expected = part * (1 / 12 - sigma * alpha.beta / (4 * alpha.gamma)) * phi**3
    assert abs(lag - expected) <= 0.1 * phi**5  # the next term
