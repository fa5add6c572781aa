"""A mechanism file in Python: run it, change it, and see how springs hold it at rest."""

import sigmafmu

model = sigmafmu.load("Pendulum.yaml")
result = model.run()
print(result.summary())
angle = result["shoulder.angle"]
print(f"the shoulder swings between {angle.min():.2f} and {angle.max():.2f} rad")

for stiffness in (40.0, 80.0, 160.0):  # N/m; numbers of the file are parameters
    rest = model.trim(parameters={"spring.stiffness": stiffness})
    (height,) = sigmafmu.linearize(rest, outputs=["lower.position[3]"]).y0
    print(f"{stiffness:.0f} N/m: at rest the lower bar is at {height:.3f} m")

sigmafmu.build_fmu("Pendulum.yaml", "Pendulum.fmu")  # for every tool that takes FMI 2.0
