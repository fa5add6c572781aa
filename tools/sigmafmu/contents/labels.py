"""Places text beside what it names: where the picture is empty, near, and without crossings; pixels, y up."""

import numpy as np

ANGLES = np.radians(np.arange(0, 360, 12))
DISTANCES = np.array([8, 14, 20, 26, 33, 41, 50, 60, 72, 86, 104, 125, 150, 190, 240, 300])
GAP = 3.0
"""Between boxes."""
CONSIDERED = 100
"""So many free places are compared by their leaders."""


def place(anchors: np.ndarray, sizes: np.ndarray, covered: np.ndarray, fixed: int) -> np.ndarray:
    """Centres of text boxes, n × 2, for anchors and sizes, n × 2; the first `fixed` boxes have them at their anchors.

    `covered` (rows up) says which pixels are in use.
    """
    height, width = covered.shape
    sums = np.pad(covered.astype(np.int64).cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    directions = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    centres = anchors.copy()
    for i in range(fixed, len(anchors)):
        half = sizes[i] / 2
        reach = DISTANCES[:, None, None] + (np.abs(directions) * half).sum(axis=1)[None, :, None]
        choices = (anchors[i] + reach * directions).reshape(-1, 2)
        low, high = choices - half - GAP, choices + half + GAP
        inside = ((low >= 0) & (high <= (width, height))).all(axis=1)
        (x0, y0), (x1, y1) = (np.clip(edge.T.astype(int), 0, [[width], [height]]) for edge in (low, high))
        hidden = sums[y1, x1] - sums[y0, x1] - sums[y1, x0] + sums[y0, x0]
        apart = np.abs(choices[:, None] - centres[:i]) - half - sizes[:i] / 2 - 2 * GAP
        cost = np.repeat(DISTANCES, len(ANGLES)) + 1000.0 * hidden / sizes[i].prod()
        cost += 1e9 * ~inside + 1e6 * (apart < 0).all(axis=2).sum(axis=1)
        best = np.argsort(np.round(cost, 6), kind="stable")[:CONSIDERED]
        choices, cost = choices[best], cost[best]
        cost += _conflicts(anchors[i], choices, half, anchors[:i], centres[:i], sizes[:i] / 2)
        centres[i] = choices[np.argmin(np.round(cost, 6))]
    return centres


def leader_end(anchor: np.ndarray, centre: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Where the line from an anchor meets the text's box."""
    return np.clip(anchor, centre - size / 2, centre + size / 2)


def _conflicts(anchor, choices, half, anchors, centres, halves) -> np.ndarray:
    """Cost of leaders that cross, and of leaders behind a text; for every choice."""
    ends = np.clip(anchor, choices - half, choices + half)
    others = np.clip(anchors, centres - halves, centres + halves)
    s = np.linspace(0, 1, 12)[:, None, None]
    own_lines = (1 - s) * anchor + s * ends  # 12 × choices × 2
    old_lines = (1 - s) * anchors + s * others  # 12 × placed × 2
    behind = (np.abs(own_lines[:, :, None] - centres) < halves + GAP).all(axis=3).any(axis=0)
    under = (np.abs(old_lines[:, None] - choices[:, None]) < half + GAP).all(axis=3).any(axis=0)
    crossing = _side(anchor, ends[:, None], anchors) * _side(anchor, ends[:, None], others) < 0
    crossing &= _side(anchors, others, anchor) * _side(anchors, others, ends[:, None]) < 0
    return 2e3 * (behind | under).sum(axis=1) + 150.0 * crossing.sum(axis=1)


def _side(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
    """On which side of the line from a to b the point p is."""
    return np.sign(
        (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (p[..., 0] - a[..., 0])
    )
