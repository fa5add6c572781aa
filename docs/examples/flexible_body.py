"""A bar from finite element matrices, reduced to modes, swings on a hinge."""

from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import sigmafmu
from sigmafmu.modes import fe_from_matrices, fixed_modes, write

# Nodes (n, 3), stiffness and mass (3n, 3n) of the free body come from your FE program (sigmafmu.modes.read_fe reads its
# files). Here a lattice of bars stands for it: 1 m long, 20 mm thick, the near nodes of a grid tied by springs.
X = np.array(list(product(np.linspace(0.0, 1.0, 51), np.linspace(-0.01, 0.01, 2), np.linspace(-0.01, 0.01, 2))))
K = np.zeros((3 * len(X), 3 * len(X)))
for i, j in cKDTree(X).query_pairs(0.036):
    d = (X[j] - X[i]) / np.linalg.norm(X[j] - X[i])
    for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
        K[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * 1e6 * np.outer(d, d)  # N/m
M = np.eye(3 * len(X)) * 1.0 / len(X)  # 1 kg in all

# The four nodes at the hinge are held in the body's frame; four modes bend the rest.
body = fixed_modes(fe_from_matrices(K, M, X), [[0, 1, 2, 3]], modes=4)
write(body, "bar.json")
print("frequencies [Hz]:", np.sqrt(np.diag(body.K) / np.diag(body.modal_mass)) / (2 * np.pi))

Path("Bar.yaml").write_text("""
sigmafmu: 1
name: Bar
bodies:
  bar: { flexible: bar.json }
joints:
  hinge: { type: revolute, bodies: [ground, bar], point: [0, 0, 0], axis: [0, 1, 0] }
stations:
  tip: { body: bar, nodes: [200, 201, 202, 203], deflection_axes: [[0, 0, 1]] }
experiment: { stop_time: 1, step_size: 1.0e-3 }
""")
result = sigmafmu.load("Bar.yaml").run()
print("largest deflection of the tip:", np.abs(result["tip.deflection"]).max(), "m")
