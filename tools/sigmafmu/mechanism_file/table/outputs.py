"""What is measured: stations of flexible bodies, sensors."""

from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_ends
from sigmafmu.mechanism_file.kinds import Text, Whole, Word
from sigmafmu.mechanism_file.structures import ByType, Direction, Key, List, Struct
from sigmafmu.mechanism_file.table.ends import ANY_BODY, BODY, FRAME, End, keys_of

STATION = Struct(
    (
        Key("description", Text(), "for the FMU"),
        Key("body", BODY, "a flexible one", required=True),
        Key("nodes", List(Whole(), least=1), "its place is their mean", required=True),
        Key("deflection_axes", List(Direction()), "of displacements by deformation, in the body's axes"),
    ),
    name="station",
)


@dataclass(frozen=True)
class SensorType:
    """A type of sensor: what it measures, and its keys beside body and frame."""

    meaning: str
    keys: tuple[Key, ...] = ()


SENSOR_ENDS = (End(("point", "orientation"), "frame"),)

SENSOR_TYPES = {
    "motion": SensorType(
        "how a frame moves, seen from another one",
        (
            Key("reference", ANY_BODY, "from where it is seen", default="ground"),
            Key("reference_frame", FRAME, "in the reference", default="its frame"),
            Key("axes", Word(("ground", "reference", "sensor")), "in which vectors are", default="reference"),
        ),
    ),
    "imu": SensorType("specific force and angular velocity of a frame, in its axes"),
}


def _sensor(name: str, sensor: SensorType) -> Struct:
    keys = (
        Key("type", Word((name,)), sensor.meaning, required=True),
        Key("description", Text(), "for the FMU"),
        Key("body", ANY_BODY, "whose frame it is", required=True),
        *keys_of(SENSOR_ENDS),
        *sensor.keys,
    )
    return Struct(keys, check_ends(SENSOR_ENDS), name)


SENSORS = ByType({name: _sensor(name, sensor) for name, sensor in SENSOR_TYPES.items()})
