"""Mechanisms as environments of Gymnasium: its own checks, seeds, vector environments, ends of episodes, errors."""

import subprocess
import sys
import warnings
from importlib.resources import files

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from scipy.stats import uniform

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.gym import MechanismEnv, ids

IDS = [f"sigmafmu/{name}-v0" for name in ids.ENVIRONMENTS]
MOTOR, RATE = "crankPivot.motorTorque", "crankPivot.angularRate"
CRANK = {
    "observations": {"crank.position": (-1, 1), RATE: (-100, 100)},
    "actions": {MOTOR: (-0.5, 1.5)},
    "reward": RATE,
    "H": 0.01,
}
COARSE = {"integrator.stepSize": 1e-3}


@pytest.fixture(scope="module")
def slider_crank():
    return sigmafmu.load("SliderCrank")


def crank(slider_crank, **changes):
    return MechanismEnv(slider_crank, **{**CRANK, "parameters": COARSE, **changes})


def rollout(env, seed, steps=20):
    """Observations, rewards and ends under actions that depend on the seed alone."""
    actions = np.random.default_rng(seed).uniform(-1, 1, (steps, *env.action_space.shape))
    start, info = env.reset(seed=seed)
    rows = [env.step(a)[:4] for a in actions]
    return start, info, [np.concatenate([x, [r, terminated, truncated]]) for x, r, terminated, truncated in rows]


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_finds_nothing_wrong(name):
    env = gymnasium.make(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # as Gymnasium warns
        warnings.simplefilter("error", DeprecationWarning)
        check_env(env.unwrapped)
        env.reset(seed=1)
        env.step(env.action_space.sample())  # under the checks of `make`
    env.close()


def test_an_id_imports_what_it_needs():
    """As docs/gym.md begins."""
    code = "import gymnasium; print(gymnasium.make('sigmafmu.gym:sigmafmu/JeffcottRotor-v0').reset(seed=1)[0].shape)"
    found = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", code], capture_output=True, text=True, check=True
    )
    assert found.stdout == "(4,)\n"


@pytest.mark.parametrize("name", IDS)
def test_same_seeds_make_same_bits(name):
    with gymnasium.make(name) as one, gymnasium.make(name) as two:
        one.reset(seed=7)
        one.step(one.action_space.sample())  # another past
        same = rollout(one, 3), rollout(two, 3)
        assert np.array_equal(same[0][2], same[1][2])
        assert same[0][1] == same[1][1]
        assert not np.array_equal(rollout(one, 4)[2], same[0][2])
        drawn = [one.reset()[1]["parameters"] for _ in range(3)]
        assert len({tuple(values.values()) for values in drawn}) == 3  # without a seed it goes on


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vector_environments_have_the_bits_of_single_ones(mode):
    name, count, steps = "sigmafmu/JeffcottRotor-v0", 3, 10
    actions = np.random.default_rng(1).uniform(-1, 1, (steps, count, 2))
    venv = gymnasium.make_vec(name, count, vectorization_mode=mode)
    try:
        together = [venv.reset(seed=[5, 6, 7])[0], *(venv.step(a)[0] for a in actions)]
    finally:
        venv.close()
    for i in range(count):
        with gymnasium.make(name) as env:
            alone = [env.reset(seed=5 + i)[0], *(env.step(a[i])[0] for a in actions)]
        assert np.array_equal([x[i] for x in together], alone)


def by_hand(slider_crank, parameters, actions):
    """What a new instance does with such inputs."""
    with slider_crank.instance(parameters) as m:
        rows = [m.get(["crank.position", RATE])]
        for a in actions:
            m.set(MOTOR, 0.5 + a)
            m.step(0.01)
            rows.append(m.get(["crank.position", RATE]))
    return np.array(rows)


def test_each_reset_is_a_fresh_start(slider_crank):
    """To the last bit: the state that is restored, and the start with other values."""
    actions = np.linspace(-1, 1, 15)
    fresh = by_hand(slider_crank, COARSE, actions)
    assert np.ptp(fresh[:, -1]) > 1
    env = crank(slider_crank)
    for _ in range(3):
        rows = [env.reset()[0], *(env.step([a])[0] for a in actions)]
        assert np.array_equal(rows, fresh)
    faster = {"crankPivot.initialAngularRate": 8.5}
    rows = [env.reset(options={"parameters": faster})[0], *(env.step([a])[0] for a in actions)]
    assert np.array_equal(rows, by_hand(slider_crank, COARSE | faster, actions))
    assert np.array_equal(env.reset()[0], fresh[0])  # the option was for one episode
    env.close()


def test_starts_are_drawn_from_distributions(slider_crank):
    """By a text as in sweeps, or a distribution of SciPy; as many draws as there are resets."""
    parameters = COARSE | {"crankPivot.initialAngularRate": "U(4,12)", "slider.mass": uniform(0.1, 0.2)}
    env = crank(slider_crank, parameters=parameters)
    found = []
    for seed in range(40):
        x, info = env.reset(seed=seed)
        drawn = info["parameters"]
        shares = np.random.default_rng(seed).random(2)
        assert drawn["crankPivot.initialAngularRate"] == pytest.approx(4 + 8 * shares[0], rel=1e-12)
        assert drawn["slider.mass"] == pytest.approx(0.1 + 0.2 * shares[1], rel=1e-12)
        assert x[-1] == pytest.approx(drawn["crankPivot.initialAngularRate"], rel=1e-9)
        found.append(x[-1])
    assert 4 < min(found) < 5.5
    assert 10.5 < max(found) < 12
    env.close()


def test_actions_are_shares_of_their_bounds(slider_crank):
    """-1 and 1 are the bounds, and what is outside is at the nearest of them."""
    seen = []
    env = crank(slider_crank, reward=lambda outputs, u: seen.append((u.item(), outputs[MOTOR])) or 0.0, outputs=[MOTOR])
    env.reset()
    for action in (-1.0, 0.0, 1.0, -3.0, 7.0):
        env.step(np.array([action], dtype=np.float32))
    assert seen == [(-0.5, -0.5), (0.5, 0.5), (1.5, 1.5), (-0.5, -0.5), (1.5, 1.5)]
    env.close()


def test_rewards_see_outputs_by_name(slider_crank):
    def reward(outputs, action):
        assert outputs["crank.position"].shape == (3,)
        assert outputs["crank.position"][1] == outputs["crank.position[2]"]
        return outputs["guide.rate"] + 10 * outputs["time"] + action[0]

    env = crank(slider_crank, reward=reward, outputs=["guide.*"])
    env.reset()
    for k in (1, 2):
        _, value, *_ = env.step([0.25])
        with slider_crank.instance(COARSE) as m:
            m.start()
            m.set(MOTOR, 0.75)
            m.step(0.01)
            if k == 2:
                m.step(0.01)
            assert value == m.get("guide.rate") + 10 * m.time + 0.75
    env.close()
    env = crank(slider_crank, reward="energy.total")
    env.reset()
    assert env.observation_space.shape == (4,)  # what only the reward sees is no observation
    assert env.step([0.0])[1] > 0
    env.close()


def test_episodes_end(slider_crank):
    """After max_steps, at the stop time, where the function says so, or never."""

    def ends(**changes):
        env = crank(slider_crank, **changes)
        env.reset()
        steps, terminated, truncated = 0, False, False
        while steps < 30 and not (terminated or truncated):
            _, _, terminated, truncated, _ = env.step([0.0])
            steps += 1
        env.close()
        return steps, terminated, truncated

    assert ends(max_steps=7) == (7, False, True)
    assert ends(stop_time=0.12) == (12, False, True)
    assert ends(stop_time=0.125) == (13, False, True)
    assert ends(stop_time=float("inf")) == (30, False, False)
    assert ends(terminated=lambda outputs: outputs["time"] > 0.045) == (5, True, False)
    with gymnasium.make(IDS[1]) as env:
        env.reset(seed=1)
        assert [env.step([0.0])[3] for _ in range(200)] == 199 * [False] + [True]


def test_bounds_come_from_the_model(slider_crank):
    """Where it tells any; without, observations are unbounded."""
    env = crank(slider_crank, observations=["crankPivot.angle", "crank.mass"])
    assert env.observation_space.low.tolist() == [-np.inf, 0.0]
    env.close()


def test_a_model_that_stops_ends_the_episode():
    """With its own sentence; the next reset goes on."""
    file = files("sigmafmu") / "library" / "PlanarFourBar.yaml"
    env = MechanismEnv(
        file,
        observations=["energy.total"],
        actions={"hinge1.motorTorque": (-1e12, 1e12)},
        reward="energy.total",
        parameters={"integrator.maxHalvings": 0, "integrator.maxNewtonIterations": 2},
        H=0.05,
    )
    start, _ = env.reset()
    last, reward, terminated, truncated, info = env.step([1.0])
    assert (terminated, truncated, reward) == (False, True, 0.0)
    assert np.array_equal(last, start)
    assert "stopped at t =" in info["error"]
    assert np.array_equal(env.reset()[0], start)
    assert "error" not in env.step([0.0])[4]
    env.close()


ERRORS = [
    ({"observations": ["crank.speed"]}, "SliderCrank has no variable 'crank.speed'"),
    ({"observations": []}, "an environment needs one observation or more"),
    ({"observations": ["crank.position", "crank.position[2]"]}, r"'crank.position\[2\]' is named twice"),
    ({"observations": {"crank.position": (0, 1, 2)}}, "the bounds of 'crank.position' must be a pair"),
    ({"actions": ["guide.rate"]}, "'guide.rate' is no input of SliderCrank; it is of causality output"),
    ({"actions": []}, "an environment needs one action or more"),
    ({"actions": [MOTOR]}, rf"'{MOTOR}' needs finite bounds: actions="),
    ({"actions": {MOTOR: (1, -1)}}, f"the lower bound of '{MOTOR}' must be below the upper one"),
    ({"reward": "crank.happiness"}, "SliderCrank has no variable 'crank.happiness'"),
    ({"parameters": {"crank.mass": "U(2,1)"}}, "has no spread"),
    ({"parameters": {"crank.mass": "V(2,1)"}}, "is no distribution"),
    ({"parameters": {"gravity": "U(0,1)"}}, "only real scalars are sampled"),
    ({"parameters": {"crank.weight": 1}}, "SliderCrank has no variable 'crank.weight'"),
    ({"H": 0}, "the step size must be a positive number of seconds, not 0"),
    ({"max_steps": 0}, "max_steps must be a positive integer, not 0"),
    ({"max_steps": 5, "stop_time": 1}, "give one of them"),
    ({"stop_time": -1}, "the stop time must be a positive number of seconds, not -1"),
]


@pytest.mark.parametrize(("changes", "sentence"), ERRORS)
def test_errors_are_one_sentence(slider_crank, changes, sentence):
    with pytest.raises(SigmafmuError, match=sentence) as told:
        crank(slider_crank, **changes)
    assert "\n" not in str(told.value)


def test_errors_of_calls(slider_crank):
    env = crank(slider_crank, reward=lambda outputs, _: outputs["guide.rate"])
    with pytest.raises(SigmafmuError, match=r"call reset\(\)"):
        env.step([0.0])
    env.reset()
    for action in ([0.0, 0.0], 0.0, [np.nan]):
        with pytest.raises(SigmafmuError, match="an action is 1 finite numbers from -1 to 1"):
            env.step(action)
    with pytest.raises(SigmafmuError, match=r"does not read 'guide\.rate'; name it in `outputs`"):
        env.step([0.0])
    with pytest.raises(SigmafmuError, match="reset has no option 'mass'"):
        env.reset(options={"mass": 1})
    with pytest.raises(SigmafmuError, match="SliderCrank has no variable 'mass'"):
        env.reset(options={"parameters": {"mass": 1}})
    with pytest.raises(SigmafmuError, match=r"SliderCrank refuses: crank\.mass is -1 kg"):
        env.reset(options={"parameters": {"crank.mass": -1}})
    env.reset()
    env.close()
    with pytest.raises(SigmafmuError, match=r"call reset\(\)"):
        env.step([0.0])


def test_the_extra_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "gymnasium" or ".gym" in name]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(SigmafmuError, match=r"^gymnasium is not installed; pip install 'sigmafmu\[gym\]' brings it$"):
        import sigmafmu.gym  # noqa: F401
