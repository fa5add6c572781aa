"""What `python -m research gym` measures: the same pendulum everywhere."""

import pytest

from research import gym


def test_all_ways_move_the_same_pendulum():
    """Errors of the angle after 1 s: by the methods' orders smaller with a tenth of the step."""
    pytest.importorskip("mujoco")
    pytest.importorskip("imageio", reason="needs gymnasium[mujoco]; `make bench` installs it")
    rows = {(row["way"], row["h"]): row for row in gym.measure(1, lambda _: None)}
    for way, order in (("ours, generalizedAlpha", 2), ("ours, rkmk4", 4), ("MuJoCo, Euler", 1), ("MuJoCo, RK4", 4)):
        coarse, fine = (rows[way, h]["error"] for h in (gym.H, gym.H / 10))
        assert coarse < 0.1
        assert fine < 3 * coarse / 10**order, way
        assert min(rows[way, gym.H][key] for key in ("step", "alone", "reset")) > 0
    table = gym.table(list(rows.values()))
    assert all(line.split("|")[4].strip() == "1.00" for line in table.splitlines() if "MuJoCo, RK4 |" in line[2:16])
