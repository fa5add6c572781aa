"""Open chains and trees of any number of bodies."""

import numpy as np

from research.mechanisms.parts import GROUND, MANY, REVOLUTE, SPHERICAL, add_body, add_joint, expose_ends
from sigmafmu import _core

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s2, in W
LINK_MASS, LINK_INERTIA = 1.0, np.array([0.02, 0.09, 0.1])  # kg, kg m2
X, Y, Z = np.eye(3)


def link_spins(links: int) -> np.ndarray:
    """Initial angular velocities of the links of a spherical chain [rad/s], in W and in their axes."""
    return np.array([[0.5 * (-1) ** k, 0.25, 1.0] for k in range(1, links + 1)])


def spherical_chain(links: int) -> _core.Mechanism:
    """Links of 1 m and 1 kg along x, center of mass in the middle; the first hangs at the origin. All turn."""
    return _chain(f"Chain{links}", link_spins(links), [SPHERICAL] * links, [Z] * links)


def revolute_chain(links: int) -> _core.Mechanism:
    """The same links on hinges about y and z in turn, which start with 0.5 and -0.5 rad/s in turn."""
    axes = [(Y, Z)[k % 2] for k in range(links)]
    rates = np.array([0.5, -0.5, -0.5, 0.5])[np.arange(links) % 4]  # neither y nor z winds up
    spins = np.cumsum(rates[:, None] * np.array(axes), axis=0)
    return _chain(f"RevoluteChain{links}", spins, [REVOLUTE] * links, axes)


def _chain(name: str, spins: np.ndarray, kinds: list, axes: list[np.ndarray]) -> _core.Mechanism:
    mechanism = _core.Mechanism(name)
    multibody = mechanism.multibody
    multibody.gravity = GRAVITY
    mechanism.integrator.step_size = 1e-3
    end = np.zeros(3)  # velocity of the end of the link before
    for k, w in enumerate(spins):
        middle = end + np.cross(w, 0.5 * X)
        add_body(multibody, f"link{k + 1}", LINK_MASS, LINK_INERTIA, (k + 0.5) * X, velocity=middle, angular_velocity=w)
        end = end + np.cross(w, X)
        before = k - 1 if k else GROUND
        add_joint(multibody, f"joint{k + 1}", kinds[k], before, k, float(k) * X, axes[k])
    if len(spins) > MANY:
        expose_ends(mechanism)
    return mechanism


def random_tree(bodies: int, seed: int = 0) -> _core.Mechanism:
    """Links of 1 m, each in any direction from the end of any link before it, on hinges about any axis, at rest."""
    rng = np.random.default_rng(seed)
    mechanism = _core.Mechanism(f"RandomTree{bodies}")
    multibody = mechanism.multibody
    multibody.gravity = GRAVITY
    mechanism.integrator.step_size = 1e-3
    tips = [np.zeros(3)]  # of the ground, then of the links
    for i in range(bodies):
        parent = int(rng.integers(0, i + 1))
        direction, axis = rng.normal(size=(2, 3))
        direction /= np.linalg.norm(direction)
        start = tips[parent]
        tips.append(start + direction)
        add_body(multibody, f"body{i + 1}", 1.0, np.array([0.1, 0.11, 0.12]), start + 0.5 * direction)
        add_joint(multibody, f"joint{i + 1}", REVOLUTE, parent - 1, i, start, axis)
    if bodies > MANY:
        expose_ends(mechanism)
    return mechanism
