"""The protobuf messages of a step's file, built at run time: no compiler is needed.

``station.Counts`` and ``station.Rates`` hold one sample each, ``station.Raw`` a piece of the stream as read.
"""

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
