"""Linear models of mechanisms about a point of a motion or an equilibrium, and the search for equilibria."""

from sigmafmu.linear.campbell import Campbell, CriticalSpeed
from sigmafmu.linear.equilibrium import trim
from sigmafmu.linear.linearization import linearize
from sigmafmu.linear.model import LinearModel
from sigmafmu.linear.point import OperatingPoint, operating_point

__all__ = ["Campbell", "CriticalSpeed", "LinearModel", "OperatingPoint", "linearize", "operating_point", "trim"]
