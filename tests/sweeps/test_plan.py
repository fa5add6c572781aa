"""Which runs a study has, and numbers made of a run: no processes."""

import numpy as np
import pytest
import scipy.stats

import sigmafmu
from sigmafmu import Result, SigmafmuError
from sigmafmu.sweeps.cli import values
from sigmafmu.sweeps.plan import plan
from sigmafmu.sweeps.sampling import SAMPLINGS, distribution
from sigmafmu.sweeps.scalars import read_scalars

MASS, SIGMA, FORMULATION = "crank.mass", "integrator.sigma", "integrator.formulation"


@pytest.fixture(scope="module")
def crank():
    return sigmafmu.load("SliderCrank").fmu


def test_sequences_are_crossed_the_first_slowest(crank):
    runs = plan(crank, {MASS: [0.1, 0.2], FORMULATION: ["index3", "stabilizedIndex2"], SIGMA: 1})
    assert runs.runs == 4
    assert runs.constants == {SIGMA: 1.0}
    assert [runs.settings(i) for i in range(4)] == [
        {SIGMA: 1.0, MASS: mass, FORMULATION: name} for mass in (0.1, 0.2) for name in ("index3", "stabilizedIndex2")
    ]


def test_a_tuple_of_names_varies_together(crank):
    runs = plan(crank, {(MASS, SIGMA): [(0.1, 1.0), (0.2, 1.5)], "rod.mass": np.array([0.5, 0.6, 0.7])})
    assert runs.runs == 6
    assert runs.columns[MASS].tolist() == [0.1] * 3 + [0.2] * 3
    assert runs.columns[SIGMA].tolist() == [1.0] * 3 + [1.5] * 3
    assert runs.columns["rod.mass"].tolist() == [0.5, 0.6, 0.7] * 2


def test_a_vector_is_constant_and_a_sequence_of_them_varies(crank):
    assert plan(crank, {"gravity": [0, 0, -1.62]}).runs == 1
    moons = plan(crank, {"gravity": [[0, 0, -1.62], [0, 0, -9.81]]})
    assert moons.columns["gravity[3]"].tolist() == [-1.62, -9.81]
    assert plan(crank, {"gravity": values("0,0,-1.62;0,0,-9.81")}).columns["gravity[3]"].tolist() == [-1.62, -9.81]
    assert plan(crank, {MASS: values("0.1:0.2:11")}).runs == 11


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_samples_have_their_distribution_and_come_from_the_seed(crank, sampling):
    wanted = {MASS: scipy.stats.uniform(0.1, 0.2), "rod.mass": distribution("N(0.5,0.01)")}
    runs = plan(crank, wanted, 512, sampling, 3)
    for name, dist in wanted.items():
        assert scipy.stats.kstest(runs.columns[name], dist.cdf).pvalue > 0.01
    assert abs(np.corrcoef(runs.columns[MASS], runs.columns["rod.mass"])[0, 1]) < 0.12  # 2.7 deviations of random ones
    again, other = (plan(crank, wanted, 512, sampling, seed) for seed in (3, 4))
    np.testing.assert_array_equal(runs.columns[MASS], again.columns[MASS])
    assert not np.array_equal(runs.columns[MASS], other.columns[MASS])


def test_latin_and_sobol_samples_fill_every_part_once(crank):
    for sampling in ("latin", "sobol"):
        masses = plan(crank, {MASS: scipy.stats.uniform(0, 1)}, 64, sampling, 1).columns[MASS]
        assert sorted((64 * masses).astype(int)) == list(range(64))


def test_samples_are_crossed_with_sequences(crank):
    runs = plan(crank, {MASS: distribution("U(0.1,0.2)"), SIGMA: [1.0, 1.5]}, 3)
    assert runs.columns[SIGMA].tolist() == [1.0] * 3 + [1.5] * 3
    assert runs.columns[MASS][:3].tolist() == runs.columns[MASS][3:].tolist()


@pytest.mark.parametrize(
    ("text", "mean", "deviation"),
    [
        ("N(2,3)", 2, 3),
        ("U(1,3)", 2, 2 / 12**0.5),
        ("T(0,1,2)", 1, 1 / 6**0.5),
        ("LN(1,0.5)", np.exp(0.125), np.sqrt((np.exp(0.25) - 1) * np.exp(0.25))),
    ],
)
def test_distributions_by_text(text, mean, deviation):
    assert distribution(text).mean() == pytest.approx(mean)
    assert distribution(text).std() == pytest.approx(deviation)


@pytest.mark.parametrize(
    ("parameters", "runs", "message"),
    [
        ({"crank.mas": [1, 2]}, None, r"has no variable 'crank\.mas'; did you mean crank\.mass"),
        ({MASS: [0.1, "heavy"]}, None, r"'crank\.mass' needs a number, not 'heavy'"),
        ({"guide.rate": [1.0]}, None, "of causality output"),
        ({MASS: []}, None, "'crank.mass' has no values"),
        ({MASS: [1.0], (MASS, SIGMA): [(1, 2)]}, None, "'crank.mass' is set twice"),
        ({(MASS, SIGMA): [(1, 2, 3)]}, None, r"each run needs 2 values, not \(1, 2, 3\)"),
        ({MASS: scipy.stats.norm()}, None, "crank.mass is sampled: give the number of runs"),
        ({MASS: scipy.stats.norm()}, 0, "must be 1 or more, not 0"),
        ({MASS: [1.0]}, 5, "no parameter has a distribution"),
        ({FORMULATION: scipy.stats.norm()}, 5, "only real scalars are sampled"),
        ({"gravity": scipy.stats.norm()}, 5, "only real scalars are sampled"),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(crank, parameters, runs, message):
    with pytest.raises(SigmafmuError, match=message):
        plan(crank, parameters, runs)


@pytest.mark.parametrize("text", ["N(1)", "N(1,2", "X(1,2)", "N(a,b)"])
def test_texts_that_are_no_distribution(text):
    with pytest.raises(SigmafmuError, match="is no distribution; write N"):
        distribution(text)


@pytest.mark.parametrize("text", ["N(1,0)", "U(2,1)", "T(0,3,2)", "LN(-1,1)", "N(1,inf)"])
def test_distributions_without_spread(text):
    with pytest.raises(SigmafmuError, match="has no spread"):
        distribution(text)


def test_scalars_of_a_known_curve(crank):
    t = np.linspace(0, 1, 10_001)
    curves = np.column_stack((np.sin(2 * np.pi * t), 3 * t, 4 * t, 0 * t))
    names = ("guide.rate", "slider.position[1]", "slider.position[2]", "slider.position[3]")
    result = Result("known", t, names, curves, None)
    wanted = {
        "max(guide.rate)": 1.0,
        "min(guide.rate)": -1.0,
        "maxabs(guide.rate)": 1.0,
        "argmax(guide.rate)": 0.25,
        "mean(guide.rate)": 0.0,
        "rms(guide.rate)": 0.5**0.5,
        "final(slider.position)": 5.0,  # the length of (3, 4, 0)
        "max(slider.position[2])": 4.0,
    }
    for scalar in read_scalars(crank, list(wanted)):
        assert scalar.of(result) == pytest.approx(wanted[scalar.name], abs=1e-7), scalar
        assert scalar.units == ("s" if scalar.kind == "argmax" else "m/s" if "rate" in scalar.name else "m")
    with pytest.raises(SigmafmuError, match=r"'guide\.rate' is no scalar; write max"):
        read_scalars(crank, ["guide.rate"])
    with pytest.raises(SigmafmuError, match=r"did you mean guide\.rate"):
        read_scalars(crank, ["max(guide.rat)"])
