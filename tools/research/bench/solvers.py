"""Our elimination of blocks beside general sparse solvers, on the Newton matrices of our steps."""

import ctypes
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from research.bench import Effort
from research.mechanisms import linkages, named
from sigmafmu import SigmafmuError, _core
from sigmafmu.markdown import markdown_table

TITLE = "The linear solver"
FILE = "solvers.csv"
EIGEN = Path("build/release/eigen_sparse_lu")
H = 1e-3  # s
STEPS = 50
"""Before the matrix is taken."""
TILT = np.array([0.3, -0.5, 0.7])  # rad
MECHANISMS = {
    **{name: lambda name=name: named(name) for family in ("Chain", "RevoluteChain") for name in (f"{family}10",)},
    **{name: lambda name=name: named(name) for name in ("Chain100", "RevoluteChain100", "RandomTree100")},
    "FourBarRow100": lambda: linkages.four_bar_row(100, linkages.REGULAR[linkages.four_bar_row]),
    **{name: lambda name=name: named(name) for name in ("Chain1000", "RevoluteChain1000")},
}
QUICK = ("Chain10", "RevoluteChain100")
FORMS = {"index3": _core.Kkt.newton, "stabilizedIndex2": _core.Kkt.stabilized}
BUDGET = 0.15
"""Seconds for each solver and matrix."""
ACCURACY = 1e-9
"""Of each solution, beside the largest number that its check adds."""
COMMON_BYTES = 4096
"""More than KLU's struct klu_common has."""
KEEP = 1.5
"""A library's solver is taken if it needs at most so many times what ours does."""


@dataclass(frozen=True)
class Equations:
    """A x = b, as `_core.KktSolver` has its unknowns."""

    A: sparse.csc_matrix
    b: np.ndarray
    bodies: int


def newton_matrices(mechanism: _core.Mechanism) -> dict[str, Equations]:
    """Those of a step after STEPS ones in each formulation: motion, λ and μ, scaled, λ and μ of a joint side by side.

    Generalized-α with a step of 1 ms and β' = 1/h², γ' = 1/h; μ acts through the inertia of each body alone.
    """
    multibody = mechanism.multibody = tilted(mechanism.multibody)
    simulation = _core.Simulation(mechanism)
    simulation.advance(H, STEPS)
    state = simulation.state
    system = _core.System(multibody)
    shapes = [(system.velocity_size, system.velocity_size)] * 3 + [(system.constraint_size, system.velocity_size)] * 2
    parts = zip(system.entries(state.q, state.v, state.lambda_), shapes, strict=True)
    M, C, K, B, Z = (sparse.csc_matrix(entries, shape) for entries, shape in parts)
    S, zero, bodies = M + H * C, sparse.csc_matrix((B.shape[0], B.shape[0])), len(multibody.bodies)
    D = S.multiply(sparse.kron(sparse.eye(bodies), np.ones((6, 6)))).tocsc()
    index3 = sparse.bmat([[S + H**2 * K, B.T], [B, None]], format="csc")
    both = [[S + H**2 * K, B.T, D @ B.T], [B, zero, zero], [H * Z, zero, B @ B.T]]
    stabilized = sparse.bmat(both, format="csc")
    result = {}
    for name, A in (("index3", index3), ("stabilizedIndex2", stabilized)):
        A.sort_indices()
        result[name] = Equations(A, np.random.default_rng(1).normal(size=A.shape[0]), bodies)
    return result


def tilted(multibody: _core.Multibody) -> _core.Multibody:
    """The same mechanism turned as a whole: axes that are those of W leave zeros that no solver may count on."""
    turn = Rotation.from_rotvec(TILT)
    result = _core.Multibody()
    result.gravity = turn.apply(multibody.gravity)
    for body in multibody.bodies:
        body.initial_position = turn.apply(body.initial_position)
        body.initial_velocity = turn.apply(body.initial_velocity)
        orientation = turn * Rotation.from_quat(body.initial_quaternion, scalar_first=True)
        body.initial_quaternion = orientation.as_quat(scalar_first=True)
        result.add(body)
    for joint in multibody.joints:
        sides = []
        for body, frame in ((joint.body1, joint.frame1), (joint.body2, joint.frame2)):
            fixed = body == _core.GROUND
            origin, axes = frame.origin, frame.axes
            sides += [body, _core.Frame(turn.apply(origin), turn.as_matrix() @ axes) if fixed else frame]
        result.add(_core.Joint(joint.name, joint.type, *sides))
    return result


Timed = tuple[np.ndarray, float]
"""Solution, and seconds of a factorization and a solution."""


def _repeats(seconds: float) -> int:
    return int(np.clip(BUDGET / max(seconds, 1e-7), 3, 2000))


def _fastest(work: Callable[[], np.ndarray]) -> Timed:
    start = process_time()
    x = work()
    taken = [process_time() - start]
    for _ in range(_repeats(taken[0])):
        start = process_time()
        x = work()
        taken.append(process_time() - start)
    return x, min(taken)


def ours(mechanism: _core.Mechanism, form: _core.Kkt, e: Equations) -> Timed:
    """Elimination of blocks."""
    solver = _core.KktSolver(mechanism.multibody, form)
    _, factorizing, solving = solver.timed(e.A, e.b, 1)
    x, factorizing, solving = solver.timed(e.A, e.b, _repeats(factorizing + solving))
    return x, factorizing + solving


def eigen(e: Equations) -> Timed:
    """Eigen's SparseLU: supernodes, column ordering, analyzed once."""

    def run(repeats: int) -> tuple[np.ndarray, float]:
        text = np.array([e.A.shape[0], e.A.nnz, repeats], dtype=np.int32).tobytes()
        text += e.A.indptr.astype(np.int32).tobytes() + e.A.indices.astype(np.int32).tobytes()
        text += e.A.data.tobytes() + e.b.tobytes()
        found = subprocess.run([EIGEN.resolve()], input=text, capture_output=True, check=True).stdout
        line, _, rest = found.partition(b"\n")
        return np.frombuffer(rest), sum(map(float, line.split()))

    return run(_repeats(run(1)[1]))


def superlu(e: Equations) -> Timed:
    """SciPy's SuperLU: supernodes; it analyzes the pattern each time."""
    return _fastest(lambda: splu(e.A).solve(e.b))


def klu(e: Equations) -> Timed:
    """SuiteSparse's KLU: analyzed once, factorized again with the same pivots.

    KVXOPT's functions pivot each time, so its library is called itself.
    """
    import kvxopt.klu  # loads what the library needs

    folder = Path(kvxopt.__file__).parents[1] / "kvxopt.libs"
    library = ctypes.CDLL(str(next(folder.glob("libklu-*"))))
    for function in ("klu_analyze", "klu_factor"):
        getattr(library, function).restype = ctypes.c_void_p
    n = e.A.shape[0]
    common = ctypes.create_string_buffer(COMMON_BYTES)
    library.klu_defaults(common)
    starts, rows = (x.astype(np.int32) for x in (e.A.indptr, e.A.indices))
    pattern = starts.ctypes.data_as(ctypes.c_void_p), rows.ctypes.data_as(ctypes.c_void_p)
    values = e.A.data.ctypes.data_as(ctypes.c_void_p)
    symbolic = ctypes.c_void_p(library.klu_analyze(n, *pattern, common))
    numeric = ctypes.c_void_p(library.klu_factor(*pattern, values, symbolic, common))

    def work() -> np.ndarray:
        x = e.b.copy()
        done = library.klu_refactor(*pattern, values, symbolic, numeric, common)
        if not done or not library.klu_solve(symbolic, numeric, n, 1, x.ctypes.data_as(ctypes.c_void_p), common):
            raise SigmafmuError("KLU finds a matrix singular")
        return x

    result = _fastest(work)
    library.klu_free_numeric(ctypes.byref(numeric), common)
    library.klu_free_symbolic(ctypes.byref(symbolic), common)
    return result


def umfpack(e: Equations) -> Timed:
    """SuiteSparse's UMFPACK: multifrontal, analyzed once."""
    from kvxopt import matrix, spmatrix
    from kvxopt import umfpack as module

    entries = e.A.tocoo()
    A = spmatrix(entries.data.tolist(), entries.row.tolist(), entries.col.tolist(), e.A.shape)
    symbolic = module.symbolic(A)

    def work() -> np.ndarray:
        x = matrix(e.b)
        module.solve(A, module.numeric(A, symbolic), x)
        return x

    x, seconds = _fastest(work)
    return np.array(x).ravel(), seconds


LIBRARIES: dict[str, Callable[[Equations], Timed]] = {
    "Eigen SparseLU": eigen,
    "KLU, refactorized": klu,
    "SuperLU": superlu,
    "UMFPACK": umfpack,
}


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each mechanism, formulation and solver."""
    return [*_rows(effort)]


def _rows(effort: Effort) -> Iterator[dict[str, Any]]:
    for name in QUICK if effort.quick else MECHANISMS:
        effort.tell(f"{name}: sparse solvers")
        mechanism = MECHANISMS[name]()
        for formulation, e in newton_matrices(mechanism).items():
            found = {"ours": ours(mechanism, FORMS[formulation], e)}
            found |= {library: solver(e) for library, solver in LIBRARIES.items() if solver != eigen or EIGEN.exists()}
            for solver, (x, seconds) in found.items():
                if np.abs(e.A @ x - e.b).max() > ACCURACY * (abs(e.A) @ np.abs(x)).max():
                    raise SigmafmuError(f"{solver} does not solve the equations of {name}, {formulation}")
                yield {
                    "mechanism": name,
                    "formulation": formulation,
                    "unknowns": e.A.shape[0],
                    "nonzeros": e.A.nnz,
                    "solver": solver,
                    "ns_per_body": 1e9 * seconds / e.bodies,
                    "times_ours": seconds / found["ours"][1],
                }


def report(rows: list[dict[str, Any]], _: Path) -> str:
    """One table, and whether a library is to be kept."""
    solvers = list(dict.fromkeys(row["solver"] for row in rows))
    lines = []
    for name, formulation in dict.fromkeys((row["mechanism"], row["formulation"]) for row in rows):
        mine = {r["solver"]: r for r in rows if (r["mechanism"], r["formulation"]) == (name, formulation)}
        cells = [f"{mine[solver]['ns_per_body']:.0f} ({mine[solver]['times_ours']:.1f})" for solver in solvers[1:]]
        ours = mine["ours"]
        lines.append([name, formulation, str(ours["unknowns"]), f"{ours['ns_per_body']:.0f}", *cells])
    table = markdown_table(("ns per body", "formulation", "unknowns", *solvers), lines)
    least = min((row for row in rows if row["solver"] != "ours"), key=lambda row: row["times_ours"])
    within = sorted({row["solver"] for row in rows if row["solver"] != "ours" and row["times_ours"] <= KEEP})
    verdict = (
        f"Within {KEEP:g} times of ours on some of them: {', '.join(within)}."
        if within
        else f"None is within {KEEP:g} times of ours on any of them, so ours stays."
    )
    return (
        f"Factorization and solution of the Newton matrix after {STEPS} steps of 1 ms, no joint along an axis of W; in "
        "brackets times ours, which copies the matrix first, as the others do. Eigen and KLU analyze the pattern once, "
        "as ours does; KLU keeps its pivots as well. UMFPACK pivots anew each time, SuperLU analyzes anew. These three "
        "are called from Python, some microseconds a call. Zeros inside of blocks are left out for all but ours. The "
        "row of four-bars has a ball and a sleeve in each loop, so that its "
        f"equations are independent.\n\n{table}\n"
        f"{verdict} The nearest is {least['solver']} on {least['mechanism']}, {least['formulation']}: "
        f"{least['times_ours']:.1f} times.\n"
    )
