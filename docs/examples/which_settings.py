"""Which σ and which formulation: errors and Newton iterations of the heavy top and the rotor beside fine steps."""

import numpy as np

import sigmafmu

CASES = {"HeavyTop": (1.0, "top.position", 2e-3, 1.58), "HighSpeedRotor": (0.1, "rotor.position", 2e-5, 1.692)}

for name, (stop_time, point, h, sigma) in CASES.items():
    model = sigmafmu.load(name)

    def run(h, model=model, stop_time=stop_time, point=point, **settings):
        parameters = {"integrator.stepSize": h} | {f"integrator.{key}": value for key, value in settings.items()}
        return model.run(stop_time, step_size=stop_time / 50, parameters=parameters)

    exact = run(h / 20)[point]
    print(f"{name}, h = {h:g} s, largest error of {point} [m]")
    for formulation in ("stabilizedIndex2", "index3"):
        for value in (0.0, 1.0, sigma):
            result = run(h, formulation=formulation, sigma=value)
            error = np.linalg.norm(result[point] - exact, axis=1).max()
            print(f"  {formulation:17} σ = {value:<5g} {error:.1e}   {result.statistics.newton_per_step:.2f} iterations")
