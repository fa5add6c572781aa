"""Which σ and which formulation: errors and Newton iterations of the heavy top and the rotor beside fine steps."""

import numpy as np

import sigmafmu

CASES = {"HeavyTop": (1.0, "top.position", 2e-3, 1.58), "HighSpeedRotor": (0.1, "rotor.position", 2e-5, 1.692)}

for name, (stop_time, point, h, best) in CASES.items():
    model = sigmafmu.load(name)
    common = {"stop_time": stop_time, "step_size": stop_time / 50, "outputs": [point]}
    exact = model.run(parameters={"integrator.stepSize": h / 20}, **common)[point]
    print(f"{name}, h = {h:g} s, largest error of {point} [m]")
    for formulation in ("stabilizedIndex2", "index3"):
        for sigma in (0.0, 1.0, best):
            settings = {"stepSize": h, "formulation": formulation, "sigma": sigma}
            result = model.run(parameters={f"integrator.{key}": x for key, x in settings.items()}, **common)
            error = np.linalg.norm(result[point] - exact, axis=1).max()
            iterations = result.statistics.newton_per_step
            print(f"  {formulation:17} σ = {sigma:<5g} {error:.1e}   {iterations:.2f} iterations")
