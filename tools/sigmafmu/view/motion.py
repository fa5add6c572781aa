"""The frames of an animation, chosen from the rows of a result."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.contents.layout import Body, Layout, MovingFrame
from sigmafmu.result import Result
from sigmafmu.view import rotations

FRAMES = 601
"""So many frames are enough for a short run: ten seconds at 60 frames per second."""
RATE = 60.0
"""Frames per second of a longer run."""
MOST_FRAMES = 20_000
DRIVEN = ("displacement", "rotation")
"""Inputs of the FMU that move a frame of the ground."""
MOST_TURN = 0.5
"""A body turns no further from one frame to the next [rad], so that the arc between them is known and short."""


@dataclass(frozen=True)
class Track:
    """Where a body is: position (n × 3, m), quaternion (n × 4) and modal coordinates (n × f)."""

    position: np.ndarray
    quaternion: np.ndarray
    modal: np.ndarray


@dataclass(frozen=True)
class Motion:
    """Frames at `time` (n, s): bodies, then moving frames of the ground, and recorded variables of the same times."""

    time: np.ndarray
    bodies: dict[str, Track]
    columns: dict[str, np.ndarray]
    units: dict[str, str]


def variables_of(layout: Layout) -> list[str]:
    """What a run must record of the bodies, as vectors."""
    kinds = ("position", "quaternion", "angularVelocity")
    names = [f"{name}.{kind}" for name in layout.bodies for kind in kinds]
    names += [f"{frame.name}.{kind}" for frame in layout.moving if frame.driven for kind in DRIVEN]
    return names + [
        f"{name}.modal" for name, body in layout.bodies.items() if body.nodes is not None and modes_of(body)
    ]


def modes_of(body: Body) -> int:
    """How many modal coordinates a body has."""
    return 0 if body.modes is None else body.modes.shape[2]


def motion_of(result: Result, layout: Layout, columns: Sequence[str]) -> Motion:
    """The frames of a result: rows that are dense enough, and where the result's are not, frames between them.

    Raises SigmafmuError if the poses of a body were not recorded.
    """
    tracks = {name: _track(result, name, modes_of(body)) for name, body in layout.bodies.items()}
    tracks |= {frame.name: _prescribed(result, frame) for frame in layout.moving}
    turns = {name: _turns(result, name, track.quaternion) for name, track in tracks.items()}
    rows = _rows(result.time, turns)
    time, parts = _times(result.time[rows], {name: _between(turn, rows) for name, turn in turns.items()})
    bodies = {}
    for name, track in tracks.items():
        q = _fill(track.quaternion[rows], _between(turns[name], rows), parts)
        values = [_interpolated(result.time[rows], x[rows], time) for x in (track.position, track.modal)]
        bodies[name] = Track(values[0], rotations.continuous(q), values[1])
    values = {name: np.interp(time, result.time[rows], result[name][rows]) for name in columns}
    return Motion(time, bodies, values, {name: result.units[name] for name in columns if result.units.get(name)})


def _track(result: Result, body: str, modes: int) -> Track:
    wanted = {"position": 3, "quaternion": 4} | ({"modal": modes} if modes else {})
    arrays = {}
    for kind, width in wanted.items():
        names = [f"{body}.{kind}[{i}]" for i in range(1, width + 1)]
        absent = [name for name in names if name not in result]
        if absent:
            raise SigmafmuError(
                f"the result has no {absent[0]}: to see a mechanism, record `position`, `quaternion` and `modal` of "
                "all its bodies"
            )
        arrays[kind] = np.column_stack([result[name] for name in names])
    q = arrays["quaternion"]
    q = rotations.continuous(q / np.linalg.norm(q, axis=1, keepdims=True))
    return Track(arrays["position"], q, arrays.get("modal", np.zeros((len(q), 0))))


def _prescribed(result: Result, frame: MovingFrame) -> Track:
    """Of a moving frame; one whose motion are inputs that were not recorded stays where it is."""
    names = [f"{frame.name}.{kind}[{i}]" for kind in DRIVEN for i in (1, 2, 3)]
    inputs = [result[name] if name in result else np.zeros(len(result.time)) for name in names]
    position, q = frame.poses(result.time, np.column_stack(inputs))
    return Track(position, rotations.continuous(q), np.zeros((len(q), 0)))


def _turns(result: Result, body: str, q: np.ndarray) -> np.ndarray:
    """Rotation vectors from row to row, in the body's axes.

    The shortest one, unless the angular velocity, if recorded, says that the body has turned further: then whole turns
    more about the same axis.
    """
    psi = rotations.logarithm(rotations.product(rotations.conjugate(q[:-1]), q[1:]))
    names = [f"{body}.angularVelocity[{i}]" for i in (1, 2, 3)]
    if not len(psi) or not all(name in result for name in names):
        return psi
    w = np.column_stack([result[name] for name in names])
    expected = (w[1:] + w[:-1]) / 2 * np.diff(result.time)[:, None]
    angle = np.linalg.norm(psi, axis=1)
    far = np.linalg.norm(expected, axis=1) > np.pi / 2
    axis = np.where((angle > 1e-9)[:, None], psi / np.maximum(angle, 1e-300)[:, None], _unit(expected))
    more = np.round(((expected * axis).sum(axis=1) - angle) / (2 * np.pi))
    return np.where(far[:, None], axis * (angle + 2 * np.pi * more)[:, None], psi)


def _unit(x: np.ndarray) -> np.ndarray:
    return x / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300)


def _rows(time: np.ndarray, turns: dict[str, np.ndarray]) -> np.ndarray:
    """Which rows become frames: every n-th and the last."""
    last = len(time) - 1
    wanted = max(FRAMES, int(np.ceil(RATE * (time[-1] - time[0]))) + 1)
    angles = [np.linalg.norm(turn, axis=1) for turn in turns.values()]
    total = max((float(angle.sum()) for angle in angles), default=0.0)
    fastest = max((float(angle.max(initial=0.0)) for angle in angles), default=0.0)
    wanted = min(max(wanted, int(total / MOST_TURN)), MOST_FRAMES)
    stride = max(1, last // max(wanted - 1, 1))
    while stride > 1 and stride * fastest > MOST_TURN and last // stride < MOST_FRAMES:
        stride -= 1
    return np.unique(np.append(np.arange(0, last + 1, stride), last))


def _between(turn: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Turns from one of `rows` to the next: turns in between are nearly parallel: small, or a steady spin."""
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(turn, axis=0)])
    return np.diff(sums[rows], axis=0)


def _times(time: np.ndarray, turns: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Times of all frames, and into how many parts each interval is divided."""
    if len(time) < 2:
        return time, np.zeros(0, dtype=int)
    largest = np.max([np.linalg.norm(turn, axis=1) for turn in turns.values()], axis=0)
    parts = np.maximum(1, np.ceil(largest / MOST_TURN - 1e-9).astype(int))
    if parts.sum() > MOST_FRAMES > len(time):
        parts = np.maximum(1, parts * (MOST_FRAMES / parts.sum())).astype(int)
    starts, steps = np.repeat(time[:-1], parts), np.repeat(np.diff(time) / parts, parts)
    return np.append(starts + _count(parts) * steps, time[-1]), parts


def _count(parts: np.ndarray) -> np.ndarray:
    """0, 1, … within each interval."""
    return np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)


def _fill(q: np.ndarray, turns: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Quaternions of all frames: at the rows those of the result, between them along the turns."""
    share = _count(parts) / np.repeat(parts, parts)
    between = rotations.product(
        np.repeat(q[:-1], parts, axis=0), rotations.exponential(np.repeat(turns, parts, axis=0) * share[:, None])
    )
    return np.concatenate([between, q[-1:]])


def _interpolated(time: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Cubic Hermite interpolation with differences as slopes, n × k."""
    if len(time) == len(at) or len(time) < 3:
        return values if len(time) == len(at) else np.column_stack([np.interp(at, time, x) for x in values.T])
    slopes = np.gradient(values, time, axis=0)
    i = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    h = np.diff(time)[i][:, None]
    s = (at - time[i])[:, None] / h
    basis = ((1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2, s**2 * (3 - 2 * s), s**2 * (s - 1))
    return basis[0] * values[i] + basis[1] * h * slopes[i] + basis[2] * values[i + 1] + basis[3] * h * slopes[i + 1]
