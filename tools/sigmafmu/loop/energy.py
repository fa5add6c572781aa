"""Energy that a coupling makes or loses, after Sadjina, Kyllingstad, Skjong, Pedersen (Eng. Comput. 33, 2017).

Two subsystems share a power bond: an effort e (torque) and a flow f (rate) whose product is the power that goes from
one to the other. Between communication points each has its own idea of the other's signal, so that what one gives,
e₂ f₂, is not what the other gets, e₁ f₁. The difference is the residual power, its integral the residual energy. Zero
for the true solution, it is an error measure that needs no reference.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Bond:
    """Course of effort and flow over one communication step of H [s]: samples at equal distances, both ends included.

    Of each pair the first is what the driven subsystem has, the second what the driving one has.
    """

    H: float
    effort: tuple[np.ndarray, np.ndarray]
    flow: tuple[np.ndarray, np.ndarray]

    def work(self) -> float:
        """Energy that the driven subsystem gets, J."""
        return self._integral(self.effort[0] * self.flow[0])

    def residual(self) -> float:
        """Energy that the driving subsystem gives and the driven one does not get, J."""
        return self._integral(self.effort[1] * self.flow[1] - self.effort[0] * self.flow[0])

    def mismatch(self) -> float:
        """Power residual at the end of the step, W."""
        return float(self.effort[1][-1] * self.flow[1][-1] - self.effort[0][-1] * self.flow[0][-1])

    def _integral(self, power: np.ndarray) -> float:
        """Simpson's rule; needs an even number of intervals."""
        intervals = len(power) - 1
        if intervals < 2 or intervals % 2:
            raise ValueError(f"a bond needs an even number of intervals to be integrated, not {intervals}")
        return float(self.H / intervals / 3 * (power[0] + power[-1] + 4 * power[1::2].sum() + 2 * power[2:-1:2].sum()))
