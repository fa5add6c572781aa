"""The slider-crank as an FMU: look at it, run it, drive its crank."""

import sigmafmu

model = sigmafmu.load("SliderCrank")
print(model.description)
print(model.inputs[:3], model.outputs[:3])

# One number starts it: the crank at 10 rad/s, and rod and slider with it.
free = model.run(2.0, parameters={"crankPivot.initialAngularRate": 10.0})
print(free.summary())
force = abs(free["crankPivot.reactionForce"]).max()
print(f"largest force in the crank's pivot: {force:.2f} N")

# The crank falls and is driven: 0.2 N m for a second, then nothing.
torque = ([0.0, 1.0, 1.0, 2.0], [0.2, 0.2, 0.0, 0.0])
driven = model.run(2.0, inputs={"crankPivot.motorTorque": torque})
driven.to_csv("driven.csv")
driven.plot("driven.png", names=["crankPivot.angularRate", "guide.displacement"])
