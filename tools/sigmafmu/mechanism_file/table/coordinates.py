"""What joints leave free, and what acts on it."""

from collections.abc import Callable
from dataclasses import dataclass

from sigmafmu.mechanism_file.kinds import Kind, Number
from sigmafmu.mechanism_file.structures import Key
from sigmafmu.mechanism_file.table.quantities import least, limits, positive


@dataclass(frozen=True)
class Coordinate:
    """What a joint leaves free, and how keys and variables of it are called."""

    turns: bool
    number: str = ""
    """1, 2, ... where a joint has several of its kind."""
    beside_angle: bool = False
    """Whether it is a displacement of a joint that turns as well."""
    axis: int = 2
    """Of x, y, z: about or along it; what turns before it turns it."""

    @property
    def word(self) -> str:
        """What the FMU calls it: `angle`, `displacement`, with the number."""
        return ("angle" if self.turns else "displacement") + self.number

    def key(self, word: str) -> str:
        """The key for what acts on it: `stiffness`, `displacement_stiffness`; `displacement` for the value itself."""
        if not self.beside_angle:
            return word + self.number
        return ("displacement" if word == "coordinate" else f"displacement_{word}") + self.number

    def initial(self, word: str) -> str:
        """The FMU's parameter for its `coordinate` or `rate` at the start."""
        names = {"coordinate": ("initialAngle", "initialDisplacement"), "rate": ("initialAngularRate", "initialRate")}
        return names[word][0 if self.turns else 1] + self.number

    def dimension(self, of_angle: str, of_displacement: str) -> str:
        """The one or the other."""
        return of_angle if self.turns else of_displacement


ANGLE, DISPLACEMENT = Coordinate(turns=True), Coordinate(turns=False)
BOTH = (ANGLE, Coordinate(turns=False, beside_angle=True))
CROSS = (Coordinate(turns=True, number="1", axis=1), Coordinate(turns=True, number="2", axis=0))
PLANE = (
    ANGLE,
    Coordinate(turns=False, number="1", beside_angle=True, axis=0),
    Coordinate(turns=False, number="2", beside_angle=True, axis=1),
)
ACROSS = tuple(Coordinate(turns=False, number=str(i + 1), axis=i) for i in range(2))
SPACE = tuple(Coordinate(turns=False, number=str(i + 1), axis=i) for i in range(3))


@dataclass(frozen=True)
class ActingKey:
    """A key for what acts on a coordinate."""

    word: str
    dimensions: tuple[str, str]
    """For an angle, for a displacement."""
    meaning: str
    default: str = "0"
    kind: Callable[[str], Kind] = least
    """Of a dimension."""
    into: tuple[str, ...] = ()
    """Keys in the definition, where these are others."""


ACTING = {
    "joint_springs": (
        ActingKey("stiffness", ("torsional stiffness", "stiffness"), "of a spring"),
        ActingKey("damping", ("torsional damping", "damping"), "of a damper"),
        ActingKey("rest", ("angle", "length"), "where the spring has no force", kind=Number),
    ),
    "joint_frictions": (
        ActingKey("friction", ("torque", "force"), "Coulomb's"),
        ActingKey("stribeck_friction", ("torque", "force"), "what is added to it at rest"),
        ActingKey("stribeck_rate", ("angular velocity", "velocity"), "at which 1/e of that is left", "0.1", positive),
        ActingKey("viscous_friction", ("torsional damping", "damping"), "by the rate"),
        ActingKey(
            "creep_rate", ("angular velocity", "velocity"), "at which friction has 76 % of it", "0.001", positive
        ),
    ),
    "joint_stops": (
        ActingKey(
            "limits", ("angle", "length"), "where its stops are", "none", limits, into=("lower_stop", "upper_stop")
        ),
        ActingKey("stop_stiffness", ("torsional stiffness", "stiffness"), "of the stops", "by a period of 20 ms"),
        ActingKey("stop_damping", ("torsional slowness", "slowness"), "of the stops"),
        ActingKey("stop_depth", ("angle", "length"), "from which the stops are stiff", "0.001", positive),
    ),
    "joint_armatures": (ActingKey("armature", ("inertia", "mass"), "inertia that moves with it, as a motor's rotor"),),
}
"""What acts on coordinates: the list in the definition → its keys."""


def keys_of(c: Coordinate) -> tuple[Key, ...]:
    """Keys of a joint for a coordinate."""
    what = "its angle" if c.turns else "its displacement"
    start = c.dimension("angle", "length"), c.dimension("angular velocity", "velocity")
    return (
        Key(c.key("coordinate"), Number(start[0]), f"{what} at the start", default="0, or as placed"),
        Key(c.key("rate"), Number(start[1]), f"rate of {what} at the start", default="0, or by the bodies"),
        *(
            Key(c.key(key.word), key.kind(c.dimension(*key.dimensions)), key.meaning, default=key.default)
            for keys in ACTING.values()
            for key in keys
        ),
    )
