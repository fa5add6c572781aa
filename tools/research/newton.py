"""Full and modified Newton's method by the number of bodies. `python -m research.newton`.

Processor time of a step, the least of ten rounds in turn, at tolerances that give both the same error; chains and
random trees of revolute or ball joints, rows of four-bars, the benchmark mechanisms; default settings, h = 1 ms or the
mechanism's.
"""

from collections.abc import Callable
from time import process_time

import numpy as np

from research.scale import mechanism
from sigmafmu import _core

FULL, MODIFIED = 1, 2
ROUNDS = 10
SIZES = (3, 10, 30, 100, 300)
MOST_IN_LOOPS = 100  # bodies: which equations depend on others is found by dense linear algebra
REVOLUTE, SPHERICAL = _core.JointType.revolute, _core.JointType.spherical


def on_balls(bodies: int) -> _core.Mechanism:
    """The chain of `scale` on ball joints."""
    hinged, result = mechanism(bodies, tree=False), _core.Mechanism()
    result.multibody.gravity = hinged.multibody.gravity
    for body in hinged.multibody.bodies:
        result.multibody.add(body)
    for j in hinged.multibody.joints:
        result.multibody.add(_core.Joint(j.name, SPHERICAL, j.body1, j.frame1, j.body2, j.frame2))
    return result


def row_of_four_bars(bodies: int) -> _core.Mechanism:
    """Squares of 1 m side by side, cranks upright, couplers between their tips; all move with 1 m/s."""
    count = max(1, (bodies - 1) // 2)
    m = _core.Mechanism()
    m.multibody.gravity = np.array([0.0, -9.81, 0.0])
    x, y = np.eye(3)[:2]
    places = [(i * x, i * x + y) for i in range(count + 1)] + [(i * x + y, (i + 1) * x + y) for i in range(count)]
    for i, (one, two) in enumerate(places):
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = f"bar{i + 1}", 1.0, np.array([0.1, 0.1, 0.1])
        body.initial_position = (one + two) / 2
        body.initial_velocity = x if i > count else x / 2
        body.initial_angular_velocity = np.array([0, 0, 0.0 if i > count else -1.0])
        m.multibody.add(body)

    def hinge(name: str, body1: int, body2: int, point: np.ndarray) -> None:
        sides = []
        for body in (body1, body2):
            origin = np.zeros(3) if body == _core.GROUND else m.multibody.body(body).initial_position
            sides += [body, _core.Frame(point - origin, np.eye(3))]
        m.multibody.add(_core.Joint(name, REVOLUTE, *sides))

    for i in range(count + 1):
        hinge(f"pivot{i + 1}", _core.GROUND, i, i * x)
    for i in range(count):
        hinge(f"left{i + 1}", i, count + 1 + i, i * x + y)
        hinge(f"right{i + 1}", count + 1 + i, i + 1, (i + 1) * x + y)
    return m


FAMILIES: dict[str, Callable[[int], _core.Mechanism]] = {
    "chain, revolute": lambda bodies: mechanism(bodies, tree=False),
    "chain, ball": on_balls,
    "random tree": lambda bodies: mechanism(bodies, tree=True),
    "four-bar row": row_of_four_bars,
}


class Run:
    """A mechanism on its way, of which some steps are timed now and then."""

    def __init__(self, m: _core.Mechanism, newton: int) -> None:
        m.integrator.newton = newton
        self.h, self.steps = m.integrator.step_size, max(10, 1000 // len(m.multibody.bodies))
        self.simulation = _core.Simulation(m)
        self.simulation.advance(self.h, 20)
        self.seconds = np.inf
        """Of a step, in the fastest round."""

    def round(self) -> None:
        """Some steps more."""
        start = process_time()
        self.simulation.advance(self.h, self.steps)
        self.seconds = min(self.seconds, (process_time() - start) / self.steps)


def line(name: str, m: _core.Mechanism) -> str:
    """Both methods in turn."""
    full, modified = (Run(m, newton) for newton in (FULL, MODIFIED))
    for _ in range(ROUNDS):
        full.round()
        modified.round()
    counters = modified.simulation.state.counters
    distance = np.abs(full.simulation.state.q - modified.simulation.state.q).max()
    return (
        f"{name:20} {len(m.multibody.bodies):6} {1e6 * full.seconds:10.1f} {1e6 * modified.seconds:10.1f} "
        f"{full.seconds / modified.seconds:8.2f} {counters.newton_iterations / counters.steps:11.1f} {distance:11.0e}"
    )


def main() -> None:
    """Print a line for each mechanism."""
    print("                     bodies  full [µs]  modified   faster   iterations   distance")
    for name, make in FAMILIES.items():
        for bodies in SIZES:
            if make is row_of_four_bars and bodies > MOST_IN_LOOPS:
                continue
            m = make(bodies)
            m.integrator.step_size = 1e-3
            print(line(name, m), flush=True)
    for name in _core.mechanisms():
        print(line(name, _core.mechanism(name)), flush=True)


if __name__ == "__main__":
    main()
