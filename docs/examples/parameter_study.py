"""How the force in the crank's pivot depends on the rod's mass and the crank's speed."""

import numpy as np

import sigmafmu

model = sigmafmu.load("SliderCrank")
force = "crankPivot.reactionForce"

print("rod [kg]  crank [rad/s]  largest force [N]")
for mass in (0.25, 0.5, 1.0):
    for rate in (5.0, 10.0, 20.0):
        settings = {"rod.mass": mass, "crankPivot.initialAngularRate": rate}
        result = model.run(1.0, parameters=settings, outputs=[force])
        print(f"{mass:8.2f} {rate:14.0f} {np.linalg.norm(result[force], axis=1).max():18.1f}")

# One instance, started again with other parameters, saves the time of making an FMU ready.
rates = []
with model.instance() as m:
    for torque in (0.0, 0.1, 0.2, 0.3):  # N m
        m.reset({"crankPivot.motorTorque": torque})
        rates.append(m.run(0.5, outputs=["crankPivot.angularRate"])["crankPivot.angularRate"][-1])
print("crank after 0.5 s [rad/s]:", np.round(rates, 3))
