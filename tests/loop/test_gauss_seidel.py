"""Masters that repeat communication steps: against closed forms, and two FMUs tied by a spring against one ODE."""

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from research.reference.minimal_coordinates import heavy_top
from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.loop import coupling_cli, studies, tied_tops
from sigmafmu.loop.gauss_seidel import (
    EXTRAPOLATED,
    HOLD,
    ITERATED,
    LINEAR,
    MEAN,
    Aitken,
    CouplingError,
    FixedPoint,
    QuasiNewton,
    run,
)

TOLERANCE = 1e-8  # of the masters, relative to the force
MASS = 15 + 0.234375  # kg: a top's inertia about its pivot over (1 m)², what the spring feels across the arm
KINETIC = 0.5 * (MASS * 4.61538**2 + 0.46875 * 150**2)  # J, of the spinning top at the start


class Oscillators:
    """Unit masses, each on a spring of its own; the force is the interface signal and the motion exact."""

    def __init__(self, omega: np.ndarray):
        self.omega, self.state = omega, np.array([np.ones_like(omega), np.zeros_like(omega)])

    def signals(self) -> np.ndarray:
        return -(self.omega**2) * self.state[0]

    def step(self, t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
        x, v = self.state
        self.state = np.array([x + H * v + H * H * (begin / 3 + end / 6), v + H * (begin + end) / 2])

    def save(self) -> None:
        self.saved = self.state

    def restore(self) -> None:
        self.state = self.saved


@pytest.mark.parametrize(("scheme", "beta"), [(LINEAR, 1 / 6), (MEAN, 1 / 4)])
@pytest.mark.parametrize("solver", [FixedPoint, Aitken, QuasiNewton])
def test_the_iterated_masters_are_newmarks_method(scheme, beta, solver):
    """x ← x + H v + H² ((½ − β) a + β a₊), v ← v + H (a + a₊) / 2 with a₊ = −ω² x₊: linear or mean acceleration."""
    H, steps, omega = 0.1, 50, np.array([3.0, 10.0]) if solver is not Aitken else np.array([10.0])
    loop = Oscillators(omega)
    run(loop, H, steps, scheme, solver(), tolerance=1e-13)
    x, v = np.ones_like(omega), np.zeros_like(omega)
    for _ in range(steps):
        a = -(omega**2) * x
        x_new = (x + H * v + H * H * (0.5 - beta) * a) / (1 + beta * (H * omega) ** 2)
        v += H * (a - omega**2 * x_new) / 2
        x = x_new
    # each step is solved to 1e-13 of the largest force (100 N); errors add up over the steps, at worst with the
    # factor H² of force to position and H to velocity, which neither master amplifies
    np.testing.assert_allclose(loop.state, [x, v], rtol=0, atol=steps * H * 1e-13 * 100)


def test_quasi_newton_keeps_what_it_learned():
    """The Jacobian of a linear loop is found by differences, once; then a step needs one correction."""
    omega = np.array([3.0, 30.0, 300.0])
    counts = run(Oscillators(omega), 0.1, 20, MEAN)
    assert counts[0] <= 1 + len(omega) + 3, "differences, then as below"
    assert counts[1:].max() <= 3, "a check, a correction, and one more for the rounding of the differences"
    with pytest.raises(CouplingError, match="no convergence in 50 iterations"):
        run(Oscillators(omega), 0.1, 1, MEAN, FixedPoint())


def test_unknown_scheme_is_named():
    with pytest.raises(SigmafmuError, match="no scheme 'cubic'; choose one of hold, extrapolated, linear, mean"):
        run(Oscillators(np.ones(1)), 0.1, 1, "cubic")


# --- two heavy tops --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def soft() -> dict[str, list[studies.SpringRun]]:
    """A spring of 1e4 N/m (ω H = 0.14, 0.07, 0.04), by scheme."""
    runs = studies.spring_runs([1e4], [4e-3, 2e-3, 1e-3])
    return {scheme: [r for r in runs if r.scheme == scheme] for scheme in studies.SCHEMES}


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.divide(errors[:-1], errors[1:]))


def test_the_reference_without_a_spring_is_the_heavy_top():
    """Made from other code; both have tolerances of 1e-12 or less for each of some hundred steps."""
    times = np.linspace(0.0, 0.5, 6)
    alone = heavy_top(times)
    expected = np.column_stack([alone[f"top.position[{i}]"] for i in (1, 2, 3)])
    np.testing.assert_allclose(tied_tops.monolithic(tied_tops.Spring(0.0), 0.5)(times)[:, :3], expected, atol=1e-9)


@pytest.mark.parametrize(("scheme", "order"), [(EXTRAPOLATED, 2.0), (LINEAR, 2.0), (MEAN, 2.0)])
def test_error_against_one_ode_falls_with_the_order(soft, scheme, order):
    assert orders([r.error.max() for r in soft[scheme]]) == pytest.approx([order] * 2, abs=0.1)


def test_hold_is_of_first_order(soft):
    """From above: its growth of energy, exp(ω² H t / 2), is no small number yet."""
    found = orders([r.error.max() for r in soft[HOLD]])
    assert found[1] == pytest.approx(1.0, abs=0.15)
    assert found[0] > found[1]


def test_iterated_masters_are_more_accurate(soft):
    for i in range(3):
        assert soft[LINEAR][i].error.max() < soft[MEAN][i].error.max() < soft[EXTRAPOLATED][i].error.max()
        assert soft[EXTRAPOLATED][i].error.max() < soft[HOLD][i].error.max()


@pytest.mark.parametrize("scheme", ITERATED)
def test_energy_error_of_iterated_masters_is_of_second_order(soft, scheme):
    assert orders([np.abs(r.energy).max() for r in soft[scheme]]) == pytest.approx([2.0] * 2, abs=0.1)


@pytest.fixture(scope="module")
def stiff() -> dict[str, studies.SpringRun]:
    """A spring of 1e6 N/m with H = 2 ms (ω H = 0.7), by scheme."""
    return {r.scheme: r for r in studies.spring_runs([1e6], [2e-3])}


@pytest.mark.parametrize("scheme", [HOLD, EXTRAPOLATED])
def test_explicit_masters_diverge(stiff, scheme):
    """An error of the size of the arm (1 m) is no solution at all; the run may also have failed (NaN)."""
    assert not stiff[scheme].error.max() < 0.5
    assert not np.abs(stiff[scheme].energy).max() < 1e6


@pytest.mark.parametrize("scheme", ITERATED)
def test_iterated_masters_converge_where_explicit_ones_diverge(stiff, scheme):
    """They err by no more than the spring oscillates, which they follow for 29 periods with an error of their phase.

    Their energy errs by no more than 1e-5 of the kinetic energy, and does not feed on itself: in the second half of the
    run it is at most what a constant loss in the tops' integrators makes of it, twice that of the first half.
    """
    exact = tied_tops.monolithic(tied_tops.Spring(1e6), studies.SPRING_STOP_TIME)(stiff[scheme].time)
    oscillation = np.linalg.norm(exact[:, :3] - exact[:, 3:], axis=1).max()
    assert stiff[scheme].error.max() < oscillation
    first, second = (np.abs(part).max() for part in np.array_split(stiff[scheme].energy, 2))
    assert max(first, second) < 1e-5 * KINETIC
    assert second < 2.5 * first


def energy_error(top: Fmu, k: float, H: float, scheme: str) -> float:
    """Largest over 0.2 s in J; infinite if a step cannot be taken."""
    with tied_tops.tied_tops(top, tied_tops.Spring(k), H / studies.REFINEMENT) as loop:
        recorder = tied_tops.Recorder(loop)
        recorder(0.0)
        try:
            run(loop, H, int(0.2 / H), scheme, observe=recorder)
        except CouplingError:
            return np.inf
    return np.abs(np.array(recorder.energy) - recorder.energy[0]).max()


def test_hold_feeds_a_spring_as_the_theory_says(fmu):
    """A force that is late by H / 2 on average is a damper of −k H / 2: the energy grows as exp(ω² H t / 2)."""
    k, H = 1e6, 2.5e-4
    with tied_tops.tied_tops(fmu("HeavyTop"), tied_tops.Spring(k), H / 2) as loop:
        recorder = tied_tops.Recorder(loop)
        recorder(0.0)
        run(loop, H, 1600, HOLD, observe=recorder)
    time, energy = np.array(recorder.time), np.array(recorder.energy) - recorder.energy[0]
    grown = time > 0.2
    rate = np.polyfit(time[grown], np.log(energy[grown]), 1)[0]
    # corrections: of the order ω H = 0.09, and the axis of the spin adds to the inertia in one of two directions
    assert rate == pytest.approx(2 * k / MASS * H / 2, rel=0.1)


def test_linear_is_stable_up_to_newmarks_limit_and_mean_beyond(fmu):
    """β = 1/6 is stable for ω H < 2 √3, β = 1/4 always; ω² = 2 k / m of the tops against each other."""
    k, top = 1e7, fmu("HeavyTop")
    limit = 2 * np.sqrt(3) / np.sqrt(2 * k / MASS)
    assert energy_error(top, k, 0.95 * limit, LINEAR) < 1e-4 * KINETIC
    assert energy_error(top, k, 1.05 * limit, LINEAR) > KINETIC
    assert energy_error(top, k, 1.05 * limit, MEAN) < 1e-4 * KINETIC
    assert energy_error(top, k, 3 * limit, MEAN) < 1e-3 * KINETIC  # the internal steps are larger as well


def test_mean_exchanges_exactly_the_energy_of_a_linear_spring(fmu):
    """f̄ · Δx = −ΔV for f̄ = (f + f₊) / 2 = −k (x + x₊) / 2, up to the tolerance of the iteration."""
    spring, H = tied_tops.Spring(1e6), 2e-3
    with tied_tops.tied_tops(fmu("HeavyTop"), spring, H / 4) as loop:
        deflections, forces = [loop.deflection()[0]], []
        step = loop.step

        def watched(t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
            assert begin.tobytes() == end.tobytes()
            forces.append(begin)
            step(t, H, begin, end)

        loop.step = watched
        accepted = []

        def observe(t: float) -> None:
            deflections.append(loop.deflection()[0])
            accepted.append(forces[-1])

        run(loop, H, 50, MEAN, tolerance=TOLERANCE, observe=observe)
    moved = np.diff(deflections, axis=0)
    work = np.sum(np.array(accepted) * moved, axis=1)
    gained = np.diff(spring.energy(np.array(deflections)))
    allowed = TOLERANCE * np.linalg.norm(accepted, axis=1).max() * np.linalg.norm(moved, axis=1).max()
    np.testing.assert_allclose(gained, -work, rtol=0, atol=allowed)
    assert np.abs(gained).max() > 1e3 * allowed, "there is an exchange to speak of"


def test_trial_steps_leave_no_trace(fmu):
    """The accepted forces alone, without iterations, give the same bits."""
    spring, H = tied_tops.Spring(1e5), 2e-3
    with (
        tied_tops.tied_tops(fmu("HeavyTop"), spring, H / 4) as loop,
        tied_tops.tied_tops(fmu("HeavyTop"), spring, H / 4) as other,
    ):
        step, last = loop.step, []

        def watched(*arguments) -> None:
            last[:] = arguments
            step(*arguments)

        loop.step = watched
        counts = run(loop, H, 30, LINEAR, observe=lambda t: other.step(*last))
        assert counts.min() > 1
        for top, copy in zip(loop.tops, other.tops, strict=True):
            assert top.outputs().tobytes() == copy.outputs().tobytes()


def test_a_stiff_spring_needs_more_than_a_fixed_point():
    """The fixed point multiplies an error by k H² / (4 m) for each top: 5 together at 4 ms."""
    stiffness, H = 1e7, 4e-3
    assert 2 * stiffness * H**2 / (4 * MASS) == pytest.approx(5.25, rel=1e-3)
    assert np.isnan(studies.solver_trials(stiffness, H, MEAN, FixedPoint()))
    found = [studies.solver_trials(stiffness, H, MEAN, solver) for solver in (QuasiNewton(), Aitken())]
    assert found[0] < found[1] < 10


# --- command ---------------------------------------------------------------------------------------------------------


def command(line: str) -> object:
    app = typer.Typer()
    app.command()(coupling_cli.couple)
    app.command()(coupling_cli.sampling)
    return CliRunner().invoke(app, line.split())


def test_couple_writes_its_part_of_a_page_and_a_figure(tmp_path):
    page, plot = tmp_path / "page.md", tmp_path / "plot.png"
    page.write_text("above\n<!-- couple -->\nstale\n<!-- end of couple -->\nbelow\n")
    sizes = "--step-size 4e-3 --step-size 2e-3"
    result = command(f"couple --stiffness 1e4 {sizes} --output {page} --plot {plot}")
    assert result.exit_code == 0, result.output
    text = page.read_text()
    assert text.startswith("above\n<!-- couple -->\nWritten by `sigmafmu couple`")
    assert text.endswith("<!-- end of couple -->\nbelow\n")
    assert "stale" not in text
    assert "| k [N/m] | scheme | H = 4 ms | H = 2 ms | order |" in text
    assert plot.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--stiffness -1", "the stiffness is -1 N/m, but must be positive"),
        ("--stiffness nan", "the stiffness is nan N/m, but must be positive"),
        ("--stiffness 1e4 --step-size 0", "the step size is 0 s, but must be positive and at most 0.25 s"),
        ("--stiffness 1e4 --step-size 1", "the step size is 1 s, but must be positive and at most 0.25 s"),
    ],
)
def test_mistakes_are_named(options, message):
    error = command(f"couple {options}").exception
    assert isinstance(error, SigmafmuError)
    assert str(error) == message


def test_a_page_without_marks_is_left_alone(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("nothing here\n")
    with pytest.raises(SigmafmuError, match="has no lines '<!-- couple -->' and '<!-- end of couple -->'"):
        coupling_cli.rewrite_part(page, "couple", "text\n")
    assert page.read_text() == "nothing here\n"
