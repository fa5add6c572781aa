"""The scripts of docs/examples run as they are, in a folder with the files beside them, and print what is true."""

import re
import runpy
import shutil
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import minimize

from .pages import ROOT, blocks

EXAMPLES = ROOT / "docs" / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


def numbers(text: str) -> list[float]:
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[-+]\d+)?", text)]


def first_fmu(lines):
    """Steps of 1e-4 s; the pivot carries at least the weight of the crank."""
    assert "2 s simulated" in lines[2]
    assert "20000 internal steps" in lines[2]
    assert numbers(lines[3])[0] > 0.12 * 9.81


def height_at_rest(stiffness):
    """Of the lower bar's centre: the least potential energy of two bars and a spring in the plane, in closed form."""

    def place(angles):
        upper, lower = (np.array([np.cos(a), -np.sin(a)]) for a in angles)
        return 0.15 * upper, 0.3 * upper + 0.1 * lower, 0.3 * upper + 0.2 * lower

    def energy(angles):
        upper, lower, end = place(angles)
        stretch = np.linalg.norm(end - [0.5, 0.3]) - 0.2
        return 9.81 * (1.2 * upper[1] + 0.8 * lower[1]) + stiffness * stretch**2 / 2

    return place(minimize(energy, [0.8, 0.2], tol=1e-12).x)[1][1]


def own_mechanism(lines):
    for line in lines[2:]:
        stiffness, height = numbers(line)
        assert height == pytest.approx(height_at_rest(stiffness), abs=6e-4), line
    assert len(lines) == 5


def robot(lines):
    """The arm is in balance: 200 (goal − now) = −m g l, with the tool a part of it."""
    (lift,) = numbers(lines[-1].partition("'lift':")[2])
    assert 200 * (-0.6 - lift) == pytest.approx(-9.81 * (2 * 0.2 + 0.5 * 0.4) * np.cos(lift), rel=1e-3)


def parameter_study(lines):
    """Faster cranks need more force; more torque makes the crank faster."""
    forces = np.array([numbers(line)[2] for line in lines[1:10]]).reshape(3, 3)
    assert (np.diff(forces, axis=1) > 0).all()
    assert (np.diff(numbers(lines[10])[1:]) > 0).all()


def regulator(lines):
    """Poles of the plant are a pair ±p, as of a pendulum upside down; all poles of the loop are stable."""
    assert max(numbers(lines[1].partition("[")[2])) < 0
    assert numbers(lines[2].partition(":")[2])[0] == pytest.approx(0.5, abs=1e-6)


def flexible_body(lines):
    """The second frequency of a cantilever is 6.267 times the first, and both planes are the same."""
    f = numbers(lines[0])
    assert f[0] == pytest.approx(f[1], rel=1e-6)
    assert f[2] / f[0] == pytest.approx(6.267, rel=0.01)


def which_settings(lines):
    """σ = 1 is better than 0; the best σ helps the rotor in both formulations, the top in index 3 alone."""
    errors = np.array([numbers(line.partition("σ = ")[2])[1] for line in lines if "σ" in line]).reshape(2, 2, 3)
    assert (errors[..., 1] < errors[..., 0]).all()
    assert (errors[..., 2] < errors[..., 1]).tolist() == [[False, True], [True, True]]


def two_fmus(lines):
    """Iterations keep the energy a thousand times better."""
    held, *_, iterated = (numbers(line)[1] for line in lines)
    assert iterated < 1e-3 * held


def reinforcement(lines):
    """Random forces leave the rotor to its housing; 1 is the most for each of 250 steps."""
    random, pd, *generations, learned = (numbers(line.partition(":")[2])[0] for line in lines[:-2])
    assert random < 150
    assert generations[-1] > generations[0]
    assert min(pd, learned) > 240
    assert max(pd, learned) <= 250


CHECKS = (
    first_fmu,
    own_mechanism,
    robot,
    parameter_study,
    regulator,
    flexible_body,
    which_settings,
    two_fmus,
    reinforcement,
)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_script(check, tmp_path, monkeypatch, capsys):
    if check is regulator and not find_spec("control"):
        pytest.skip("not installed: control")
    for file in EXAMPLES.iterdir():
        if file.suffix != ".py":
            shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / f"{check.__name__}.py"), run_name="__main__")
    check(capsys.readouterr().out.splitlines())


def test_every_script_is_run_and_every_file_is_shown_by_a_page():
    assert {path.stem for path in SCRIPTS} == {check.__name__ for check in CHECKS}
    included = {block.included for block in blocks()}
    assert {f"docs/examples/{path.name}" for path in EXAMPLES.iterdir()} == included - {""}
