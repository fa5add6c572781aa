"""A magnetic bearing learns to hold a rotor that whirls out to its housing: the cross-entropy method, in NumPy."""

import gymnasium
import numpy as np

env = gymnasium.make("sigmafmu.gym:sigmafmu/JeffcottRotor-v0")
scale = np.array([2e-3, 2e-3, 0.2, 0.2])  # m, m, m/s, m/s: what observations are like


def episode(policy, seed):
    """Sum of the rewards, at most 1 for each of 250 steps."""
    x, _ = env.reset(seed=seed)
    total, ended = 0.0, False
    while not ended:
        x, reward, terminated, truncated, _ = env.step(policy(x))
        total, ended = total + reward, terminated or truncated
    return total


def mean(policy):
    """Over starts that learning does not see."""
    return np.mean([episode(policy, seed) for seed in range(100, 110)])


env.action_space.seed(1)
print(f"random: {mean(lambda x: env.action_space.sample()):.0f}")
print(f"PD: {mean(lambda x: -0.4 * (x / scale)[:2] - 0.5 * (x / scale)[2:]):.0f}")

# A linear policy: action = W x. Of 16 W around a mean, the best four are the next mean and spread.
rng = np.random.default_rng(1)
W, spread = np.zeros((2, 4)), 0.5
for generation in range(5):
    tried = W + spread * rng.standard_normal((16, 2, 4))
    scores = [episode(lambda x, W=W: W @ (x / scale), generation) for W in tried]
    best = tried[np.argsort(scores)[-4:]]
    W, spread = best.mean(axis=0), best.std(axis=0) + 0.05
    print(f"generation {generation}: {np.mean(scores):.0f}, best {max(scores):.0f}")
print(f"learned: {mean(lambda x: W @ (x / scale)):.0f}")
print(W.round(1))
