"""A linear-quadratic regulator holds the slider-crank's crank where gravity would let it fall."""

import control
import numpy as np

import sigmafmu

motor, angle = "crankPivot.motorTorque", "crankPivot.angle"
crank = sigmafmu.load("SliderCrank")

# The torque that holds the crank at 0.5 rad, and the linear model there.
rest = crank.trim(inputs=[motor], hold={angle: 0.5})
model = sigmafmu.linearize(rest, inputs=[motor], outputs=[angle])
print(model.states, model.poles())  # one of them is unstable

K, _, poles = control.lqr(model.to_control(), np.diag([100.0, 1.0]), np.eye(1))
print("regulated:", poles)

# The loop with the FMU as plant, from 0.4 rad beside.
start = crank.trim(inputs=[motor], hold={angle: 0.9})
with crank.instance(start.start_values()) as plant:
    for _ in range(3000):
        x = plant.get(model.states)
        plant.set(motor, (model.u0 - K @ (x - model.x0))[0])
        plant.step(1e-3)
print("after 3 s:", x)
assert abs(x[0] - 0.5) < 1e-6
