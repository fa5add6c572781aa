"""Mechanisms as environments of Gymnasium, for reinforcement learning; the extra `gym` brings what it needs.

>>> import gymnasium
>>> env = gymnasium.make("sigmafmu.gym:sigmafmu/JeffcottRotor-v0")  # doctest: +SKIP

Its import registers the environments of `sigmafmu.gym.ids`. Gymnasium 1 looks for none by entry points.
"""

from sigmafmu import extras

extras.need("gymnasium")

from sigmafmu.gym.env import MechanismEnv  # noqa: E402
from sigmafmu.gym.ids import register  # noqa: E402

__all__ = ["MechanismEnv"]

register()
