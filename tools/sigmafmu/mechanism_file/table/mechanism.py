"""The whole file."""

from sigmafmu import native
from sigmafmu.mechanism_file.kinds import Number, Text, Version, Whole, Word
from sigmafmu.mechanism_file.structures import Either, Key, List, Named, Struct, vector
from sigmafmu.mechanism_file.table.bodies import BODY_KEYS
from sigmafmu.mechanism_file.table.ends import FRAME, ORIENTATION
from sigmafmu.mechanism_file.table.forces import FORCES, LOAD
from sigmafmu.mechanism_file.table.joints import JOINTS, REACTION
from sigmafmu.mechanism_file.table.outputs import SENSORS, STATION
from sigmafmu.mechanism_file.table.prescribed import COORDINATE, COUPLINGS, DRIVE, MOTION
from sigmafmu.mechanism_file.table.quantities import positive
from sigmafmu.mechanism_file.table.tendons import TENDON

VERSION = 1

NAME = Text(
    r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*",
    "allowed are letters, digits and _, no digit first, and dots between such words",
)
IDENTIFIER = Text(r"[A-Za-z_][A-Za-z0-9_]*", "allowed are letters, digits and _, no digit first")

EXPOSE = Struct(
    tuple(
        Key(name, List(Text()), f"patterns of names of {name}", default="none")
        for name in ("inputs", "outputs", "parameters")
    ),
    name="patterns",
)

EXPERIMENT = Struct(
    (
        Key("stop_time", positive("time"), "of a run", default="1"),
        Key("step_size", positive("time"), "communication step", default="0.001"),
    ),
    name="experiment",
)


def _integrator() -> Struct:
    """The integrator's settings, as the core has them: its values are numbers, words where it has enumerations."""
    settings = native.default()["integrator"]

    def kind(name: str, value: object) -> Number | Whole | Text:
        if isinstance(value, str):
            return Text()
        return Number("time") if name == "stepSize" else Whole() if isinstance(value, int) else Number()

    return Struct(
        tuple(
            Key(name, kind(name, value), f"integrator.{name} of the FMU", default=str(value))
            for name, value in settings.items()
        ),
        name="settings",
    )


MECHANISM = Struct(
    (
        Key("sigmafmu", Version(VERSION), "version of this format", required=True),
        Key("name", IDENTIFIER, "the FMU's model identifier", required=True),
        Key("description", Text(), "one sentence, for the FMU"),
        Key("gravity", vector("acceleration"), "in W", default="[0, 0, -9.81]"),
        Key("bodies", Named(BODY_KEYS, NAME), "rigid and flexible bodies", required=True),
        Key("joints", Named(JOINTS, NAME), "what ties them to each other and to the ground"),
        Key("forces", Named(FORCES, NAME), "what acts between them"),
        Key("loads", Named(LOAD, NAME), "constant forces and torques"),
        Key("tendons", Named(TENDON, NAME), "springs on sums of coordinates"),
        Key("couplings", Named(COUPLINGS, NAME), "gears and other equations between coordinates"),
        Key("drives", Named(DRIVE, COORDINATE), "prescribed coordinates, by the name of the joint"),
        Key("motions", Named(MOTION, NAME), "frames of the ground that move as prescribed"),
        Key("stations", Named(STATION, NAME), "points of flexible bodies whose places are outputs"),
        Key("sensors", Named(SENSORS, NAME), "what is measured at frames of bodies"),
        Key("expose", Either(Word(("auto", "all")), EXPOSE), "which variables the FMU has", default="auto"),
        Key("experiment", EXPERIMENT, "defaults of a run"),
        Key("integrator", _integrator(), "defaults of the FMU's integrator"),
    ),
    name="mechanism",
)

SHARED = (ORIENTATION, FRAME, REACTION)

ELEMENTS = ("bodies", "joints", "forces", "loads", "tendons", "couplings", "motions", "stations", "sensors")
"""Keys whose entries have names of their own."""
