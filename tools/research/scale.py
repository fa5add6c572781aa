"""What a mechanism of n bodies costs: to build, assemble and initialise, and for a step. `python -m research.scale`.

Chains and random trees of revolute joints, bodies of 1 kg and 1 m, default settings, h = 1 ms; the fastest of three.
"""

from time import perf_counter

import numpy as np

from sigmafmu import _core

SIZES = (10, 100, 1000)
STEPS = 5
H = 1e-3  # s


def mechanism(bodies: int, tree: bool) -> _core.Mechanism:
    """Links of 1 m in a row along x, or each in any direction from any link before it."""
    rng = np.random.default_rng(0)
    result = _core.Mechanism()
    result.name = "Tree" if tree else "Chain"
    result.integrator.step_size = H
    result.multibody.gravity = np.array([0.0, 0.0, -9.81])
    centres, tips = [np.zeros(3)], [np.zeros(3)]  # of the ground, then of the links
    for i in range(bodies):
        parent = int(rng.integers(0, i + 1)) if tree else i
        direction, axis = rng.normal(size=(2, 3)) if tree else (np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
        direction /= np.linalg.norm(direction)
        start, axes = tips[parent], _core.axes_with_z(axis)
        centres.append(start + 0.5 * direction)
        tips.append(start + direction)
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = f"body{i + 1}", 1.0, np.array([0.1, 0.11, 0.12])
        body.initial_position = centres[-1]
        result.multibody.add(body)
        frames = _core.Frame(start - centres[parent], axes), _core.Frame(start - centres[-1], axes)
        joint = _core.Joint(f"joint{i + 1}", _core.JointType.revolute, parent - 1, frames[0], i, frames[1])
        result.multibody.add(joint)
    return result


def measure(bodies: int, tree: bool) -> tuple[float, float]:
    """(seconds to build, assemble and initialise; seconds per step)."""
    m = mechanism(bodies, tree)
    start, step = [], []
    for _ in range(3):
        times = [perf_counter()]
        simulation = _core.Simulation(m)
        times.append(perf_counter())
        simulation.advance(H, STEPS)
        times.append(perf_counter())
        start.append(times[1] - times[0])
        step.append((times[2] - times[1]) / STEPS)
    return min(start), min(step)


def main() -> None:
    """Print a line for each mechanism."""
    print("              bodies   start [s]   step [ms]")
    for tree in (False, True):
        for bodies in SIZES:
            start, step = measure(bodies, tree)
            print(f"{'random tree' if tree else 'chain':12} {bodies:7} {start:11.4f} {1e3 * step:11.3f}")


if __name__ == "__main__":
    main()
