"""``station.CalibratedSample``: a sample as the protobuf message that Foxglove plots, built at run time."""

from typing import Any

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

from station.files.mcap_files.schemas import built
from station.sending.quality import Quality
from station.sending.samples import COLUMNS

SAMPLE = "station.CalibratedSample"
_Field = FieldDescriptorProto
FLAGS = tuple((flag, str(flag.name).lower()) for flag in Quality)


def _file() -> FileDescriptorProto:
    file = FileDescriptorProto(name="station_stream.proto", package="station", syntax="proto3")
    message = file.message_type.add(name=SAMPLE.partition(".")[2])
    kinds = [
        ("sequence", _Field.TYPE_UINT64), ("t_s", _Field.TYPE_DOUBLE), ("utc_s", _Field.TYPE_DOUBLE),
        *((name, _Field.TYPE_DOUBLE) for name in (*COLUMNS, "temperature_c")),
        ("lost", _Field.TYPE_UINT32), ("flags", _Field.TYPE_UINT32),
        *((name, _Field.TYPE_BOOL) for _, name in FLAGS),
    ]  # fmt: skip
    for number, (name, kind) in enumerate(kinds, start=1):
        message.field.add(name=name, number=number, type=kind, label=_Field.LABEL_OPTIONAL)
    return file


SCHEMA, _MESSAGES = built(_file())
CalibratedSample: Any = _MESSAGES[SAMPLE]
