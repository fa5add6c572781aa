"""A body that nothing holds."""

import numpy as np

from research.mechanisms.parts import add_body
from sigmafmu import _core


def free_body() -> _core.Mechanism:
    """Dzhanibekov's effect: it turns about its middle axis, and again and again turns over."""
    mechanism = _core.Mechanism("FreeBody")
    mechanism.multibody.gravity = np.zeros(3)
    mechanism.integrator.step_size = 1e-3
    mechanism.stop_time = 20.0
    add_body(
        mechanism.multibody,
        "body",
        1.0,
        np.array([1.0, 2.0, 3.0]),
        np.zeros(3),
        velocity=np.array([0.1, -0.2, 0.3]),
        angular_velocity=np.array([0.0, 5.0, 0.01]),
    )
    return mechanism
