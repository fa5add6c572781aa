"""Speed control."""

from typing import ClassVar


class SpeedPI:
    """PI control of a speed with a limited torque.

        torque = limit(kp e + I),   I = ki ∫ e dt,   e = set point − speed.

    I is summed by the trapezoidal rule and stands still while the torque is at its limit and e would push it further
    (conditional integration, against windup).
    """

    inputs: ClassVar = {"speed": (0.0, "rad/s", "measured speed")}
    outputs: ClassVar = {"torque": (0.0, "N.m", "torque of the motor")}
    parameters: ClassVar = {
        "setPoint": (6.0, "rad/s", "speed to be held at first"),
        "stepTime": (1.0, "s", "time of the step of the set point"),
        "stepHeight": (6.0, "rad/s", "added to the set point from the step time on"),
        "proportionalGain": (1.0, "N.m.s/rad", "kp"),
        "integralGain": (10.0, "N.m/rad", "ki"),
        "torqueLimit": (2.0, "N.m", "largest torque of the motor, in both directions"),
    }

    def __init__(self, **values):
        self.values = {name: start for name, (start, _, _) in self.parameters.items()} | values
        self.reset()

    def reset(self):
        """Empty the integral."""
        self._integral = self._error = self._elapsed = 0.0

    def set_point(self, time):
        """Wanted speed, rad/s, at `time`, s."""
        p = self.values
        return p["setPoint"] + (p["stepHeight"] if time >= p["stepTime"] else 0.0)

    def step(self, time, H, measured):
        """One sample."""
        p = self.values
        error = self.set_point(time) - measured["speed"]
        integral = self._integral + p["integralGain"] * self._elapsed * 0.5 * (self._error + error)
        wanted = p["proportionalGain"] * error + integral
        torque = max(-p["torqueLimit"], min(p["torqueLimit"], wanted))
        if (wanted - torque) * error <= 0.0:  # within the limits, or on the way back
            self._integral = integral
        self._error, self._elapsed = error, H
        return {"torque": torque}
