"""Errors and times of all codes on the problems, and the force in one joint of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from time import process_time
from typing import Any

import numpy as np

from research.bench import runs
from research.compare import peers
from research.compare.problems import PROBLEMS, Problem
from research.reference.exudyn_models import Settings, simulate
from sigmafmu import _core

CENTER = np.zeros(3)
FINEST = 1e-8
"""No finer steps after an error below this one."""
SAME = 8
"""Errors and forces of all codes are compared at the first step of a problem divided by this."""
SPARSE_FROM = 5
"""Bodies from which on Exudyn's sparse solver is taken in space."""
OURS = "ours, default"


@dataclass(frozen=True)
class Method:
    """A code with its settings, and the order of its errors."""

    label: str
    order: int
    run: Callable[[float, int], runs.Run]  # of a step size and a number of steps


def methods(problem: Problem) -> list[Method]:
    """All that are measured on a problem."""

    def ours(label: str, order: int, **settings: Any) -> Method:
        return Method(
            label, order, lambda h, n: runs.core(problem.mechanism(), h, n, CENTER, body=problem.body, **settings)
        )

    bodies = [body.name for body in problem.mechanism().multibody.bodies]
    sparse = len(bodies) >= SPARSE_FROM and not problem.planar

    def exudyn(label: str, scheme: str) -> Method:
        def run(h: float, n: int) -> runs.Run:
            build, body = peers.exudyn(problem), bodies[problem.body]
            return runs.exudyn(build, h, n, CENTER, modified=True, sparse=sparse, scheme=scheme, body=body)

        return Method(label, 2, run)

    def mujoco(h: float, n: int) -> runs.Run:
        model = peers.InMujoco(problem, h)
        data = model.start()
        began = process_time()
        model.step(data, n)
        return runs.Run((process_time() - began) / n, 0.0, model.point(data))

    found = [ours(OURS, 2), ours("ours, rkmk4", 4, method=2)]
    found += [exudyn("Exudyn, index 3", "index3"), exudyn("Exudyn, index 2", "index2")]
    return [*found, Method("MuJoCo, RK4", 4, mujoco)] if problem.mujoco else found


@cache
def exact(problem: Problem) -> np.ndarray:
    """Where the point is at the end, from the independent solution."""
    return problem.exact()


def _error(problem: Problem, run: runs.Run) -> float:
    return float(np.linalg.norm(run.position - exact(problem))) / problem.size


def errors() -> list[dict[str, Any]]:
    """A row for each method on each problem: the error with the same step; NaN if it does not come to the end."""
    rows = []
    for problem in PROBLEMS:
        steps = round(SAME * problem.stop_time / problem.largest)
        h = problem.stop_time / steps
        for method in methods(problem):
            try:
                error = _error(problem, method.run(h, steps))
            except Exception:  # each code has errors of its own
                error = np.nan
            rows.append({"problem": problem.name, "h": h, "method": method.label, "error": error})
    return rows


def measure(rounds: int, budget: float, tell: Callable[[str], None]) -> list[dict[str, Any]]:
    """A row for each round, method and step size: steps are halved until a run takes `budget` seconds."""
    rows = []
    for problem in PROBLEMS:
        tell(f"{problem.name}, {problem.title}: independent solution")
        exact(problem)
        kept: dict[str, list[tuple[int, float]]] = {}
        for i in range(rounds):
            tell(f"{problem.name}: round {i + 1} of {rounds}")
            for method in methods(problem):
                if method.label not in kept:
                    kept[method.label] = _scan(problem, method, budget)
                for steps, error in kept[method.label]:
                    h = problem.stop_time / steps
                    ms = 1e3 * steps * method.run(h, steps).seconds
                    rows.append({"problem": problem.name, "round": i, "method": method.label, "order": method.order})
                    rows[-1] |= {"h": h, "ms": ms, "error": error}
    return rows


def _scan(problem: Problem, method: Method, budget: float) -> list[tuple[int, float]]:
    """Numbers of steps that come to the end, and errors."""
    found: list[tuple[int, float]] = []
    steps, seconds = round(problem.stop_time / problem.largest), 0.0
    while 2 * seconds < budget:
        try:
            run = method.run(problem.stop_time / steps, steps)
        except Exception:  # too long a step, a singular position: each code has errors of its own
            seconds = max(2 * seconds, budget / 64)  # not for ever
        else:
            seconds = steps * run.seconds
            error = _error(problem, run)
            if np.isfinite(error) and error < 1:
                found.append((steps, error))
            if error < FINEST:
                break
        steps *= 2
    return found


def forces() -> list[dict[str, Any]]:
    """A row for each problem: the size of the force in a joint at the end [N]; NaN where it is not told."""
    rows = []
    for problem in PROBLEMS:
        steps = round(SAME * problem.stop_time / problem.largest)
        h = problem.stop_time / steps
        row = {"problem": problem.name, "joint": problem.joint, "h": h, "unique": int(problem.unique)}
        row["exact"] = problem.force() if problem.force else np.nan
        row["ours"] = _our_force(problem, h)
        row["Exudyn"] = _exudyn_force(problem, h)
        row["MuJoCo"] = np.nan
        if problem.mujoco and not problem.stiff:
            model = peers.InMujoco(problem, h)
            data = model.start()
            model.step(data, steps)
            row["MuJoCo"] = model.force(data)
        rows.append(row)
    return rows


def _our_force(problem: Problem, h: float) -> float:
    mechanism = problem.mechanism()
    mechanism.integrator.step_size = h
    slave = _core.Slave(mechanism)
    slave.start()
    slave.do_step(0.0, problem.stop_time)
    return float(np.linalg.norm([slave.get(f"{problem.joint}.reactionForce[{i}]") for i in (1, 2, 3)]))


def _exudyn_force(problem: Problem, h: float) -> float:
    bodies = len(problem.mechanism().multibody.bodies)
    sparse = bodies >= SPARSE_FROM and not problem.planar
    settings = Settings(h, rotation="lieGroup", scheme="index3", modified_newton=True, sparse=sparse)
    history = simulate("", settings, problem.stop_time, build=peers.exudyn(problem)).history
    parts = [x[-1] for key, x in history.items() if key.startswith((f"{problem.joint}.force", f"{problem.joint}.reac"))]
    return float(np.linalg.norm(parts))
