"""The arm of arm.urdf lifts its tool: two motors with a PD controller, stepped at 1 kHz."""

import subprocess
import sys
from pathlib import Path

import sigmafmu

command = Path(sys.executable).with_name("sigmafmu")
subprocess.run([command, "convert", "arm.urdf", "-o", "Arm.yaml"], check=True)

goal = {"turn": 1.0, "lift": -0.6}  # rad
with sigmafmu.load("Arm.yaml").instance() as arm:
    for _ in range(4000):
        for joint, angle in goal.items():
            now, rate = arm.get([f"{joint}.angle", f"{joint}.angularRate"])
            arm.set(f"{joint}.motorTorque", 200.0 * (angle - now) - 20.0 * rate)
        arm.step(1e-3)
    reached = {joint: arm.get(f"{joint}.angle") for joint in goal}

print(reached)  # lift is below its goal by what gravity takes: m g l / 200
assert abs(reached["turn"] - goal["turn"]) < 1e-3
