"""Of all positions that close the joints nearby, those that are the nearest to where the file has the bodies.

Newton's method of the core takes steps that are each the least in the mass metric, but from one step to the next it
forgets where it began. Here the distance itself is made least (sequential quadratic programming): with x the way from
the file's positions to q, in the coordinates of velocities, and g = P^T M x its gradient, P = dx/dq,

    dq = M^-1 (B^T lambda - g),   B dq = -Phi.

For mechanisms of rigid bodies without prescribed motions; others stay where the core has put them.
"""

from collections.abc import Callable, Sequence

import numpy as np

from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.definition import Json

MOST_BODIES = 50
"""The cost is the cube of their number."""
ITERATIONS = 100
REACHED = 1e-10
"""Of the mechanism's size: the rest is rounding of dependent equations. The core closes the joints after that."""
DEPENDENT = 1e-10
"""Of the largest singular value: less belongs to equations that follow from others."""

Closure = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""What joints, and coordinates that must stay, miss at q, and the gradients of these by velocities."""


def applies(content: Json) -> bool:
    """Whether it is for this mechanism."""
    prescribed = any(content.get(key) for key in ("drives", "couplings", "motions"))
    return len(content["bodies"]) <= MOST_BODIES and not prescribed and all("mass" in b for b in content["bodies"])


def nearest(content: Json, q: np.ndarray, closure: Closure) -> np.ndarray | None:
    """Positions near q with the least change from those of the definition; None: none were found."""
    bodies = content["bodies"]
    start = [np.concatenate([body["position"], body["orientation"]["quaternion"]]) for body in bodies]
    inverse = [np.linalg.inv(_inertia(body)) for body in bodies]
    size = 1 + np.abs(q).max()
    for _ in range(ITERATIONS):
        gaps, B = closure(q)
        g = np.concatenate([_gradient(bodies, start, q, i) for i in range(len(bodies))])
        WB, Wg = _weighted(bodies, inverse, B.T), _weighted(bodies, inverse, g)
        multipliers = np.linalg.lstsq(B @ WB, B @ Wg - gaps, rcond=DEPENDENT)[0]
        step = WB @ multipliers - Wg
        q = _moved(q, step)
        if not np.isfinite(q).all():
            return None
        if np.abs(step).max() <= REACHED * size:
            return q
    return None


def _moved(q: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Bodies moved by displacements in W and turns about their own axes."""
    result = q.copy()
    for i in range(len(q) // 7):
        place, way = result[7 * i : 7 * i + 7], step[6 * i : 6 * i + 6]
        place[:3] += way[:3]
        turned = rotations.product(place[3:], rotations.of_vector(way[3:]))
        place[3:] = turned / np.linalg.norm(turned)
    return result


def _inertia(body: Json) -> np.ndarray:
    J = body["inertia"]
    matrix = np.array([[J["xx"], J["xy"], J["xz"]], [J["xy"], J["yy"], J["yz"]], [J["xz"], J["yz"], J["zz"]]])
    moments, axes = np.linalg.eigh(matrix)  # a thin rod gets a little about its axis
    return axes @ np.diag(np.maximum(moments, 1e-6 * moments[2])) @ axes.T


def _weighted(bodies: Sequence[Json], inverse: Sequence[np.ndarray], columns: np.ndarray) -> np.ndarray:
    """M^-1 times columns."""
    result = np.empty_like(columns)
    for i, body in enumerate(bodies):
        result[6 * i : 6 * i + 3] = columns[6 * i : 6 * i + 3] / body["mass"]
        result[6 * i + 3 : 6 * i + 6] = inverse[i] @ columns[6 * i + 3 : 6 * i + 6]
    return result


def _gradient(bodies: Sequence[Json], start: Sequence[np.ndarray], q: np.ndarray, i: int) -> np.ndarray:
    """Of half the squared distance, by the velocities of a body."""
    shift = q[7 * i : 7 * i + 3] - start[i][:3]
    turned = rotations.product(start[i][3:] * [1, -1, -1, -1], q[7 * i + 3 : 7 * i + 7])
    psi = rotations.vector(turned)
    return np.concatenate([bodies[i]["mass"] * shift, _inverse_tangent(psi).T @ _inertia(bodies[i]) @ psi])


def _inverse_tangent(psi: np.ndarray) -> np.ndarray:
    """psi' by the angular velocity in the turned axes."""
    x, y, z = psi
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = float(np.linalg.norm(psi))
    factor = 1 / 12 if angle < 1e-2 else (1 - angle / 2 / np.tan(angle / 2)) / angle**2
    return np.eye(3) + hat / 2 + factor * hat @ hat
