"""The protobuf messages of a GNSS receiver's file: the records of GNSS, the unknown left out."""

from typing import Any

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

from procedures.earth.gnss_records import AirData, GnssFix, TimeMark
from station.files.mcap_files.schemas import built

TOPICS = {GnssFix: "/gnss/fix", TimeMark: "/gnss/time", AirData: "/gnss/air"}

_Field = FieldDescriptorProto
_I64, _U32, _D, _S = _Field.TYPE_INT64, _Field.TYPE_UINT32, _Field.TYPE_DOUBLE, _Field.TYPE_STRING
_FIELDS: dict[type[Any], dict[str, "_Field.Type.ValueType"]] = {
    GnssFix: {
        "source": _S, "system": _U32, "host_ns": _I64, "fix": _U32, "utc_ns": _I64, "device_ns": _I64,
        "latency": _D, "latitude": _D, "longitude": _D, "height": _D, "altitude": _D, "speed": _D, "course": _D,
        "v_up": _D, "heading": _D, "horizontal_std": _D, "vertical_std": _D, "speed_std": _D, "heading_std": _D,
        "hdop": _D, "vdop": _D, "satellites": _U32, "is_filtered": _Field.TYPE_BOOL,
        "no_place": _S,
    },
    TimeMark: {"host_ns": _I64, "device_ns": _I64, "utc_ns": _I64},
    AirData: {"host_ns": _I64, "airspeed": _D},
}  # fmt: skip


def _file() -> FileDescriptorProto:
    file = FileDescriptorProto(name="station_gnss.proto", package="station", syntax="proto3")
    for kind, fields in _FIELDS.items():
        message = file.message_type.add(name=kind.__name__)
        for number, (field, wire) in enumerate(fields.items(), start=1):
            # optional, so that an unknown value is absent and not 0
            message.field.add(
                name=field, number=number, type=wire, label=_Field.LABEL_OPTIONAL, proto3_optional=True,
                oneof_index=number - 1,
            )  # fmt: skip
        for field in fields:
            message.oneof_decl.add(name=f"_{field}")
    return file


FIX_SCHEMA, _CLASSES = built(_file())
FIX_MESSAGES: dict[type[Any], Any] = {kind: _CLASSES[f"station.{kind.__name__}"] for kind in TOPICS}
