"""Newton's matrix of the study: its entries by differences, its condition in 60 digits, its growth as theory says."""

import mpmath as mp
import numpy as np
import pytest

from research.measure import FORMULATION_NAMES, INDEX2, INDEX3, MULTIPLIERS, STABILIZED
from research.study import conditioning
from research.study.conditioning import conditions, exponent, newton_matrix, noise
from research.study.runs import simulation
from sigmafmu import _core

EPS = float(np.finfo(float).eps)
every_formulation = pytest.mark.parametrize("formulation", FORMULATION_NAMES)
JOINTED = pytest.mark.parametrize("mechanism", [m for m in conditioning.LARGEST_STEPS if MULTIPLIERS[m]])


class Step:
    """The equations (11)-(20) of one step in the residual form, as a function of motion, λ and η."""

    def __init__(self, mechanism, formulation, h, rho, sigma):
        run = simulation(mechanism, h, formulation=formulation, spectral_radius=rho, sigma=sigma)
        self.q0, self.v0, self.vdot0, self.a0 = (np.array(getattr(run.state, name)) for name in ("q", "v", "vdot", "a"))
        run.run(h, 1)
        self.q, self.multipliers = np.array(run.state.q), np.array(run.state.lambda_)
        self.h, self.sigma, self.formulation = h, sigma, formulation
        self.alpha = _core.AlphaParameters(rho)
        self.gamma_prime = self.alpha.gamma / (h * self.alpha.beta)
        self.system = _core.System(_core.mechanism(mechanism).multibody)
        self.B0 = self.system.constraints(self.q0, self.v0)[2]
        self.eta = np.zeros(len(self.multipliers))
        if formulation == STABILIZED:  # what v of the step leaves for it
            across = self.B0 @ self.B0.T
            defect = self.P(self.motion(self.q)) @ np.array(run.state.v) - self.velocity_side(self.motion(self.q))
            self.eta = np.linalg.solve(across, self.B0 @ defect)

    def motion(self, q):
        theta = np.zeros(len(self.v0))
        for i in range(len(theta) // 6):
            theta[6 * i : 6 * i + 3] = q[7 * i : 7 * i + 3] - self.q0[7 * i : 7 * i + 3]
            turn = (_core.lie.rotation_matrix(x[7 * i + 3 : 7 * i + 7]) for x in (self.q0, q))
            first, second = turn
            relative = first.T @ second
            axis = np.array(
                [relative[2, 1] - relative[1, 2], relative[0, 2] - relative[2, 0], relative[1, 0] - relative[0, 1]]
            )
            sine = np.linalg.norm(axis) / 2
            angle = np.arctan2(sine, (np.trace(relative) - 1) / 2)
            theta[6 * i + 3 : 6 * i + 6] = axis / 2 * (angle / sine if sine > 0 else 1.0)
        return theta

    def T(self, theta):
        result = np.eye(len(theta))
        for i in range(len(theta) // 6):
            part = slice(6 * i + 3, 6 * i + 6)
            result[part, part] = _core.lie.tangent(theta[part])
        return result

    def P(self, theta):
        return self.sigma * np.eye(len(theta)) + (1 - self.sigma) * self.T(theta)

    def velocity_side(self, theta):
        """γ' (θ − T c)."""
        ratio = self.alpha.beta / self.alpha.gamma
        c = self.h * (1 - ratio) * self.v0 + self.h**2 * (0.5 - ratio) * self.a0
        return self.gamma_prime * (theta - self.T(theta) @ c)

    def __call__(self, x):
        n, m = len(self.v0), len(self.multipliers)
        q = self.system.compose(self.q, x[:n])
        theta, al = self.motion(q), self.alpha
        eta = self.eta + (x[n + m :] if self.formulation == STABILIZED else 0.0)
        v = np.linalg.solve(self.P(theta), self.velocity_side(theta) + self.B0.T @ eta)
        a = (v - self.v0) / (self.h * al.gamma) - (1 - al.gamma) / al.gamma * self.a0
        vdot = ((1 - al.alpha_m) * a + al.alpha_m * self.a0 - al.alpha_f * self.vdot0) / (1 - al.alpha_f)
        r = self.system.residual(q, v, vdot, self.multipliers + x[n : n + m], np.zeros(self.system.input_size))
        phi, phidot, _, _ = self.system.constraints(q, v)
        return np.concatenate({INDEX3: (r, phi), INDEX2: (r, phidot), STABILIZED: (r, phi, phidot)}[self.formulation])


@JOINTED
@every_formulation
@pytest.mark.parametrize("sigma", [0.0, 1.0, 1.7])
def test_the_matrix_is_the_derivative_of_the_step(mechanism, formulation, sigma):
    """Central differences in scaled unknowns: truncation δ², rounding ε/δ, so 1e-9 and less of the largest entries."""
    h, rho, delta = 5e-4, 0.8, 1e-5
    left, matrix, right = newton_matrix(mechanism, formulation, h, rho, sigma)
    step = Step(mechanism, formulation, h, rho, sigma)
    unit = np.linalg.inv(right)
    columns = [(step(unit @ e * delta) - step(unit @ e * -delta)) / (2 * delta) for e in np.eye(len(matrix))]
    found = np.linalg.solve(left, np.array(columns).T)
    np.testing.assert_allclose(found, matrix, rtol=0, atol=1e-6 * np.abs(matrix).max())


@every_formulation
def test_the_step_is_solved_where_the_matrix_is_taken(formulation):
    """So that the differences are taken at a solution; r in N, scaled with the multipliers' size."""
    step = Step("HeavyTop", formulation, 5e-4, 0.8, 0.5)
    n, m = len(step.v0), len(step.multipliers)
    size = n + m + (m if formulation == STABILIZED else 0)
    assert np.abs(step(np.zeros(size))).max() < 1e-6 * np.abs(step.multipliers).max()


@every_formulation
def test_condition_in_60_digits(formulation):
    h = 1e-6
    left, matrix, right = (mp.matrix(x.tolist()) for x in newton_matrix("HeavyTop", formulation, h, 0.9))
    with mp.workdps(60):
        values = mp.svd_r(left * matrix * right, compute_uv=False)
        expected = float(max(values) / min(values))
    assert conditions("HeavyTop", formulation, (h,))["printed"][0] == pytest.approx(expected, rel=1e-8)


@JOINTED
@pytest.mark.parametrize(("formulation", "growth"), [(INDEX3, -4), (INDEX2, -3), (STABILIZED, -3)])
def test_growth(mechanism, formulation, growth):
    h = (1e-5, 1e-6, 1e-7, 1e-8)
    found = conditions(mechanism, formulation, h)
    assert exponent(h, found["printed"]) == pytest.approx(growth, abs=0.01)
    assert exponent(h, found["scaled"]) == pytest.approx(0.0, abs=1e-3)
    assert max(found["scaled"]) < 1e4  # of masses in kg, inertias in kg m² and lengths in m, not of h


def test_without_joints_scaling_changes_nothing():
    found = conditions("HighSpeedRotor", INDEX3, (1e-6, 1e-8))
    np.testing.assert_allclose(found["printed"], found["scaled"], rtol=1e3 * EPS * found["scaled"][0])


def test_rounding_of_the_multipliers():
    """ε|q|M/(βh²) in index 3; ε|v|M/h where the velocities settle λ; within a factor 100 of several operations."""
    h, mass = 1e-8, 15.0
    alpha = _core.AlphaParameters(conditioning.RHO_INF)
    weight = mass * 9.81
    position, velocity = EPS * mass / (alpha.beta * h**2) / weight, EPS * 4.6 * mass / h / weight
    index3, index2, stabilized = (noise("HeavyTop", f, (h,))["error"][0] for f in (INDEX3, INDEX2, STABILIZED))
    assert 0.01 * position < index3 < 100 * position
    assert index2 < 100 * velocity
    assert stabilized < 100 * velocity


def test_report(tmp_path):
    """Powers of h in place of measurements."""
    cells = conditioning.CHAPTER.cells("HeavyTop", quick=True)
    found = {}
    for cell in cells:
        h = np.array(cell.arguments[-1])
        values = {"condition": {"printed": h**-4, "scaled": h**0.0}, "noise": {"error": h, "iterations": h**0.0}}
        found[cell.key] = {"h": h.tolist(), **{k: v.tolist() for k, v in values[cell.key.split("/")[0]].items()}}
    text = conditioning.CHAPTER.report({"HeavyTop": found}, tmp_path)
    assert "| HeavyTop | index 3 | 1.0e+32 | -4.0 | 1.0e+00 | 0.0 | 1e-08 | 1e-08 |" in text
    assert (tmp_path / "conditioning.csv").read_text().startswith("mechanism,formulation,h,printed,scaled,error")
    assert (tmp_path / "conditioning.png").stat().st_size < 150_000
