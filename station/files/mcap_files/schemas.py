"""The protobuf messages of MCAP files and of Foxglove, built at run time: no compiler is needed.

``station.Counts`` and ``station.Rates`` hold one sample each, ``station.Raw`` a piece of the stream as read.
``station.CalibratedSample`` is what Foxglove plots, in files and live: a field has one number and one kind
wherever it is; a message has those that are known of it and no others, so that nothing shows as 0 that is not.
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

COUNTS, RATES, RAW = "station.Counts", "station.Rates", "station.Raw"
BY_OUTPUT = {"increments": COUNTS, "rate": RATES}  # the message that holds a wire format's samples
COUNTS_TOPIC, RAW_TOPIC = "/imu/counts", "/imu/raw"
CAMERA_RAW_TOPIC, GNSS_RAW_TOPIC, WHEEL_RAW_TOPIC = "/camera/raw", "/gnss/raw", "/wheel/raw"

_Field = FieldDescriptorProto
_INT64, _UINT32, _DOUBLE, _BYTES = _Field.TYPE_INT64, _Field.TYPE_UINT32, _Field.TYPE_DOUBLE, _Field.TYPE_BYTES


def _sample(file: FileDescriptorProto, name: str, output: "_Field.Type.ValueType") -> None:
    message = file.message_type.add(name=name)
    for number, (field, kind, repeated) in enumerate(
        (
            ("device_ns", _INT64, False),
            ("host_ns", _INT64, False),
            ("gyro", output, True),
            ("accel", output, True),
            ("temperature_c", _DOUBLE, False),
            ("counter", _UINT32, False),
            ("status", _UINT32, False),
        ),
        start=1,
    ):
        label = _Field.LABEL_REPEATED if repeated else _Field.LABEL_OPTIONAL
        message.field.add(name=field, number=number, type=kind, label=label)
    entry = message.nested_type.add(name="AuxEntry")
    entry.options.map_entry = True
    entry.field.add(name="key", number=1, type=_Field.TYPE_STRING, label=_Field.LABEL_OPTIONAL)
    entry.field.add(name="value", number=2, type=_DOUBLE, label=_Field.LABEL_OPTIONAL)
    message.field.add(
        name="aux",
        number=8,
        type=_Field.TYPE_MESSAGE,
        label=_Field.LABEL_REPEATED,
        type_name=f".station.{name}.AuxEntry",
    )


def _file() -> FileDescriptorProto:
    file = FileDescriptorProto(name="station.proto", package="station", syntax="proto3")
    _sample(file, "Counts", _Field.TYPE_SINT64)
    _sample(file, "Rates", _DOUBLE)
    raw = file.message_type.add(name="Raw")
    raw.field.add(name="data", number=1, type=_BYTES, label=_Field.LABEL_OPTIONAL)
    raw.field.add(name="host_ns", number=2, type=_INT64, label=_Field.LABEL_OPTIONAL)
    return file


def built(file: FileDescriptorProto) -> tuple[bytes, dict[str, Any]]:
    """Return a file of messages as the FileDescriptorSet that MCAP embeds, and their classes by full name."""
    pool = DescriptorPool()
    pool.AddSerializedFile(file.SerializeToString())
    names = [f"{file.package}.{message.name}" for message in file.message_type]
    classes = {name: GetMessageClass(pool.FindMessageTypeByName(name)) for name in names}
    return FileDescriptorSet(file=[file]).SerializeToString(), classes


SCHEMA, MESSAGES = built(_file())


TOPIC, SAMPLE = "/imu/calibrated", "station.CalibratedSample"
COLUMNS = ("f_x_m_s2", "f_y_m_s2", "f_z_m_s2", "omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s")
FIRST_FLAG, FIRST_CHANNEL = 13, 100  # numbers, from which flags and what only a file carries along are counted
_KINDS = {"sequence": _Field.TYPE_UINT64, "lost": _Field.TYPE_UINT32, "flags": _Field.TYPE_UINT32}
FIELDS: Mapping[str, int] = MappingProxyType(
    {
        name: number
        for number, name in enumerate(
            ("sequence", "t_s", "utc_s", *COLUMNS, "temperature_c", "lost", "flags"), start=1
        )
    }
)
"""Every field that has a number of its own."""


def numbered(names: Iterable[str]) -> dict[str, int]:
    """Return fields by name with their numbers; what has none of its own gets one in this order."""
    found = dict[str, int]()
    for name in names:
        found[name] = FIELDS.get(name) or FIRST_CHANNEL + sum(number >= FIRST_CHANNEL for number in found.values())
    return found


def sample_message(names: Iterable[str], flags: Iterable[str] = ()) -> FileDescriptorProto:
    """Return the schema of a message of some fields; ``flags`` are all there are, each a truth value."""
    file = FileDescriptorProto(name="calibrated_sample.proto", package="station", syntax="proto3")
    message = file.message_type.add(name=SAMPLE.partition(".")[2])
    fields = [(name, number, _KINDS.get(name, _Field.TYPE_DOUBLE)) for name, number in numbered(names).items()]
    fields += [(name, number, _Field.TYPE_BOOL) for number, name in enumerate(flags, start=FIRST_FLAG)]
    for name, number, kind in fields:
        message.field.add(name=name, number=number, type=kind, label=_Field.LABEL_OPTIONAL)
    return file
