"""Every integration method on every group, coordinate map and kind of absolute coordinates: observed orders.

Errors are differences to solutions in minimal coordinates or in closed form. What is special to the groups is in
test_groups.py, to the Munthe-Kaas methods in test_munthe_kaas.py, to the generalized-alpha method in
test_scheme.py and test_order.py.
"""

import numpy as np
import pytest

from .helpers import FORMULATIONS, INDEX2, INDEX3, assert_bitwise, copy, simulation
from .methods import (
    BLIEDF2,
    CAYLEY,
    GENERALIZED_ALPHA,
    METHODS,
    PROBLEMS,
    RKMK4,
    RKMK54,
    SAMPLES,
    TIGHT,
    assert_order,
    lgt,
    observed_orders,
    orders,
)

every_problem = pytest.mark.parametrize("problem", PROBLEMS)
every_group = pytest.mark.parametrize("chosen", lgt().values(), ids=lgt())
every_lgt = pytest.mark.parametrize("chosen", lgt("absolute").values(), ids=lgt("absolute"))
every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


# --- equal steps -----------------------------------------------------------------------------------------------------


@every_problem
@every_group
@pytest.mark.parametrize("rho", [1.0, 0.65])
def test_order_of_generalized_alpha(problem, chosen, rho):
    """Positions, velocities and reactions."""
    assert_order(observed_orders(problem, GENERALIZED_ALPHA, spectral_radius=rho, **chosen), 2)


@every_problem
@every_lgt
def test_order_of_generalized_alpha_with_the_default_spectral_radius(problem, chosen):
    assert_order(observed_orders(problem, GENERALIZED_ALPHA, **chosen), 2)


@every_problem
@every_group
def test_order_of_bliedf(problem, chosen):
    assert_order(observed_orders(problem, BLIEDF2, **chosen), 2)


@pytest.mark.parametrize("problem", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize("group", ["R3xSO3 exp", "SE3 exp", "SE3 cayley"])
@pytest.mark.parametrize("formulation", [INDEX3, INDEX2], ids=["index3", "index2"])
def test_order_of_bliedf_in_the_other_formulations(problem, group, formulation):
    """Index 3 gives the multipliers a start-up error of first order, since its start values satisfy Φ' = 0 exactly;
    BLieDF damps it, but it is the largest error of the first samples."""
    found = observed_orders(problem, BLIEDF2, formulation=formulation, **lgt()[group])
    if formulation == INDEX3:
        del found["reaction"]
    assert_order(found, 2)


@every_problem
@every_group
def test_order_of_rkmk4(problem, chosen):
    assert_order(observed_orders(problem, RKMK4, **chosen), 4)


@every_problem
@every_group
def test_order_of_rkmk54(problem, chosen):
    """Equal steps by tolerances that nothing exceeds.

    Rodrigues parameters of a pure spin are tan(ωt/2): there the fifth-order term vanishes, and a spin is most of the
    orientation of FreeBody and of the rotor.
    """
    found = observed_orders(problem, RKMK54, **chosen)
    if problem in ("FreeBody", "rotor") and chosen["local_coordinates"] == CAYLEY:
        assert found.pop("orientation") > 5.8
    assert_order(found, 5)


# --- steps of varying size -------------------------------------------------------------------------------------------


def alternating_errors(name: str, thirds: int, **settings) -> dict[str, float]:
    """Steps h, 2h, h, 2h, …, `thirds` pairs between two of the samples."""
    problem = PROBLEMS[name]
    stop, _ = problem.ranges[GENERALIZED_ALPHA]
    run = simulation(problem.make(), step_size=stop / SAMPLES / thirds, **settings)
    rows = [copy(run.state)]
    for i in range(SAMPLES):
        for k in range(1, 3 * thirds + 1):
            if k % 3 != 2:  # ends at 1, 3, 4, 6, … thirds
                run.run(stop * (i + k / (3 * thirds)) / SAMPLES, 1)
        rows.append(copy(run.state))
    assert run.state.counters.steps == 2 * thirds * SAMPLES
    truth = problem.solution(stop, SAMPLES)
    return problem.errors(truth, *(np.array([getattr(s, x) for s in rows]) for x in ("q", "v", "lambda_")))


@every_problem
@pytest.mark.parametrize("group", ["R3xSO3 exp", "SE3 exp", "SE3 cayley"])
@pytest.mark.parametrize(
    ("method", "thirds", "expected"),
    [(GENERALIZED_ALPHA, 80, 2), (BLIEDF2, 80, 2), (RKMK4, 8, 4)],
    ids=["α", "BDF", "RK"],
)
def test_order_with_varying_steps(problem, group, method, thirds, expected):
    """What a method carries from step to step is fit for any step size.

    ρ∞ = 0.65: nearer to 1 this rhythm drives an oscillation of the multipliers, which is damped slowly.
    """
    settings = {"method": method, "spectral_radius": 0.65, **lgt()[group], **TIGHT}
    found = orders(*(alternating_errors(problem, n, **settings) for n in (thirds, 2 * thirds)))
    if problem == "FreeBody" and group.startswith("R3xSO3"):
        found = {kind: found[kind] for kind in ("orientation", "angularVelocity")}  # the translation is exact
    assert_order(found, expected)


# --- determinism -----------------------------------------------------------------------------------------------------


@every_method
@pytest.mark.parametrize("group", ["R3xSO3 exp rotationVector", "SE3 cayley quaternion", "SE3 exp rotationVector"])
@pytest.mark.parametrize("problem", ["HeavyTop", "SliderCrank"])
def test_a_copied_state_continues_bitwise(problem, method, group):
    """In another instance: all that a method remembers is in the state. Steps of rkmk54 are subdivided here."""
    settings = {"method": method, "step_size": 1e-2, "newton": 2, **lgt("absolute")[group]}
    settings |= {"relative_tolerance": 1e-9, "absolute_tolerance": 1e-9}
    one, two = (simulation(PROBLEMS[problem].make(), **settings) for _ in range(2))
    one.run(0.037, 5)  # not a multiple of what follows
    saved = copy(one.state)
    one.run(0.117, 8)
    for _ in range(2):
        two.state = copy(saved)
        two.run(0.117, 8)
        assert_bitwise(two.state, one.state)


@pytest.mark.parametrize("method", [RKMK4, BLIEDF2], ids=["rkmk4", "bliedf2"])
def test_a_failed_step_leaves_no_trace(method):
    """Two steps that are too large, then on as if nothing had happened."""
    one, two = (simulation("HeavyTop", step_size=1e-3, method=method, max_halvings=0) for _ in range(2))
    for run in (one, two):
        run.run(0.02, 20)
    before = copy(two.state)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="step failed at t = "):
            two.run(1.0, 1)
        for name in ("time", "q", "v", "vdot", "a", "lambda_", "turned"):
            np.testing.assert_array_equal(getattr(two.state, name), getattr(before, name))
    for run in (one, two):
        run.run(0.04, 20)
    for name in ("q", "v", "vdot", "lambda_"):
        np.testing.assert_array_equal(getattr(two.state, name), getattr(one.state, name))


@pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
@pytest.mark.parametrize("setting", [{"jacobian": 2}, {"newton": 2}], ids=["tangent-free", "modified"])
@pytest.mark.parametrize("group", lgt())
def test_bliedf_does_not_depend_on_its_iteration(formulation, setting, group):
    """100 steps to the same end; a linearly convergent iteration may keep a few tolerances in every step."""
    ends = []
    for chosen in ({}, setting):
        run = simulation(
            "SliderCrank", method=BLIEDF2, step_size=2e-3, formulation=formulation, relative_tolerance=1e-12,
            absolute_tolerance=1e-13, **lgt()[group], **chosen,
        )  # fmt: skip
        run.run(0.2, 100)
        assert run.state.counters.retries == 0
        ends.append(copy(run.state))
    np.testing.assert_allclose(ends[1].q, ends[0].q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ends[1].v, ends[0].v, rtol=0, atol=1e-9)
