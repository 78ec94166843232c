"""A GNSS receiver's MCAP file: its protobuf messages, written and read; a field that is unknown is absent."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

from procedures.gnss_records import AirData, FixType, GnssFix, TimeMark
from station.errors import cannot_write
from station.files.atomic_file import FlushInterval
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import built
from station.files.mcap_files.writer import GrowingFile, new_channel

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
    for kind, its_fields in _FIELDS.items():
        message = file.message_type.add(name=kind.__name__)
        for number, (field, wire) in enumerate(its_fields.items(), start=1):
            # optional, so that an unknown value is absent and not 0
            message.field.add(
                name=field, number=number, type=wire, label=_Field.LABEL_OPTIONAL, proto3_optional=True,
                oneof_index=number - 1,
            )  # fmt: skip
        for field in its_fields:
            message.oneof_decl.add(name=f"_{field}")
    return file


FIX_SCHEMA, _CLASSES = built(_file())
FIX_MESSAGES: dict[type[Any], Any] = {kind: _CLASSES[f"station.{kind.__name__}"] for kind in TOPICS}


FLUSH_PERIOD_S = 0.5


class FixWriter(GrowingFile):
    """Writes records as they come; each call raises `CannotWrite` if the disk refuses."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.fixes = 0
        self._channels = {
            kind: new_channel(self._writer, topic, f"station.{kind.__name__}", FIX_SCHEMA)
            for kind, topic in TOPICS.items()
        }
        self._pace = FlushInterval(FLUSH_PERIOD_S)

    def write(self, record: GnssFix | TimeMark | AirData) -> None:
        """Write one."""
        known = {f.name: value for f in fields(record) if (value := getattr(record, f.name)) is not None}
        content = FIX_MESSAGES[type(record)](**known).SerializeToString()
        self.fixes += isinstance(record, GnssFix)
        with self._refused():
            self.add(self._channels[type(record)], record.host_ns, content)
            if self._pace.is_due:
                with self._pace.flushing():
                    self.flush()

    def mark(self, host_ns: int, reason: str, *, is_open: bool) -> None:
        """Write that something may be missing from here on."""
        with self._refused(), self._pace.flushing():
            self.add_gap(host_ns, reason, is_open=is_open)
            self.flush()

    def close(self) -> None:
        """Finish the file on the disk; a second call changes nothing."""
        with self._refused():
            self.finish()

    @contextmanager
    def _refused(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise cannot_write(self.path, error) from error


Record = GnssFix | TimeMark | AirData


def read_fixes(path: Path) -> list[Record]:
    """Read what `FixWriter` wrote; a file cut short is read as far as it goes.

    Raise `DataRefused` if a checksum, a record or a message is wrong.
    """
    return list(topic_messages(path, _KINDS))


def _record(kind: type[Any], data: bytes) -> Record:
    known = {field.name: value for field, value in FIX_MESSAGES[kind].FromString(data).ListFields()}
    # a field that was set to its default is listed too: presence is explicit in these messages
    if kind is GnssFix:
        known["fix"] = FixType(known["fix"])
    known |= {"utc_ns": None} if kind is TimeMark and "utc_ns" not in known else {}
    record: Record = kind(**known)
    return record


_KINDS = {topic: partial(_record, record) for record, topic in TOPICS.items()}
