"""The records of an MCAP file to samples: which channel is what, and whether all messages are there.

Many samples' messages are decoded at once, as columns: a tenth of the time of one message after another. Protobuf
joins messages that follow each other: a repeated field then holds the values of all of them. Here every field is
read as a repeated one, and a mark in each of them ends each message, so that an omitted value (protobuf omits 0)
is seen to be missing. Where the marks are not where they should be, nothing is returned: such messages are decoded
one by one.
"""

import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.message import DecodeError
from mcap.records import Channel, Schema, Statistics

from procedures.arrays import FloatArray, IntArray
from station.files.mcap_files.records import Message, Record
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES, RATES, RAW, RAW_TOPIC, built

_Field = FieldDescriptorProto
# The type that reads the same bytes and has room for a mark
_READ_AS = {_Field.TYPE_UINT32: _Field.TYPE_INT64, _Field.TYPE_MESSAGE: _Field.TYPE_BYTES}
_MARKS = {_Field.TYPE_INT64: -(2**63), _Field.TYPE_SINT64: -(2**63), _Field.TYPE_DOUBLE: -sys.float_info.max}
TRIADS = ("gyro", "accel")


def _repeated(name: str) -> DescriptorProto:
    """Return a message whose fields are those of another, each repeated."""
    message = DescriptorProto(name=name.rpartition(".")[2])
    for field in MESSAGES[name].DESCRIPTOR.fields:
        kind = _READ_AS.get(field.type, field.type)
        message.field.add(name=field.name, number=field.number, type=kind, label=_Field.LABEL_REPEATED)
    return message


def _repeated_kinds() -> dict[str, Any]:
    names = (COUNTS, RATES)
    file = FileDescriptorProto(name="columns.proto", package="station", syntax="proto3")
    file.message_type.extend(map(_repeated, names))
    return built(file)[1]


_KINDS = _repeated_kinds()


def columns(name: str, messages: Sequence[bytes]) -> dict[str, Any] | None:
    """Return the fields of messages of `COUNTS` or `RATES` by name: (n,), of a triad (n, 3), None if it is absent.

    None where messages cannot be read so, among them all with auxiliary channels.
    """
    kind = _KINDS[name]
    marks = {field.name: _MARKS[field.type] for field in kind.DESCRIPTOR.fields if field.type in _MARKS}
    end = kind(**{field: [mark] for field, mark in marks.items()}).SerializeToString()
    try:
        joined = kind.FromString(end.join([*messages, b""]))
    except DecodeError:
        return None
    values = {field: np.array(getattr(joined, field)) for field in marks}
    ends = {field: np.flatnonzero(values[field] == mark) for field, mark in marks.items()}
    held = {field: np.diff(each, prepend=-1) - 1 for field, each in ends.items()}
    if joined.aux or not all(_is_fit(field, each, len(messages)) for field, each in held.items()):
        return None
    found = {field: _column_triad(values[field], held[field]) for field in TRIADS}
    return found | {field: _scalar(values[field], ends[field], held[field]) for field in marks.keys() - found}


def _is_fit(field: str, held: IntArray, n: int) -> bool:
    """Return whether each of n messages has the field's value or none, and of a triad all or none have three."""
    if field in TRIADS:
        return len(held) == n and set(held.tolist()) in ({0}, {3}, set())
    return len(held) == n and bool(np.all(held <= 1))


def _column_triad(values: Any, held: IntArray) -> Any:
    return values.reshape(len(held), -1)[:, :-1] if held.any() else None


def _scalar(values: Any, ends: IntArray, held: IntArray) -> Any:
    return np.where(held == 1, values[ends - 1], values.dtype.type(0))


_WHOLE = ("device_ns", "host_ns", "counter", "status")
_ACCEPTED = {COUNTS_TOPIC: (COUNTS, RATES), RAW_TOPIC: (RAW,)}


@dataclass(frozen=True, slots=True, eq=False)
class StepContents:
    """All messages of a step; every array has a row per sample.

    ``device_ns``, ``host_ns`` (n,) ns; ``gyro``, ``accel`` (n, 3) int64 counts (``output`` is
    ``station.Counts``) or float64, None where the triad is absent; ``temperature`` (n,) degC or nan; ``counter``,
    ``status`` (n,) as sent; ``aux`` (n,) by name, nan where a sample lacks it; ``raw`` the bytes as read with
    their time [ns]. ``damage`` says what is wrong with the end of the file, None if nothing is.
    """

    output: str
    device_ns: IntArray
    host_ns: IntArray
    gyro: IntArray | FloatArray | None
    accel: IntArray | FloatArray | None
    temperature: FloatArray
    counter: IntArray
    status: IntArray
    aux: dict[str, FloatArray]
    raw: tuple[tuple[int, bytes], ...]
    sha256: str
    damage: str | None = None

    def __len__(self) -> int:
        return len(self.device_ns)


class Messages:
    """Collects the messages of one file, record by record."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._names: dict[int, str | None] = {}
        self._seen = Counter[int]()
        self._predicted: dict[int, int] | None = None
        self._by_name: dict[str, list[bytes]] = defaultdict(list)

    @property
    def total(self) -> int:
        """How many messages were seen."""
        return self._seen.total()

    def add(self, record: Record) -> None:
        """Take a record; raises ValueError or the parser's error where it does not fit."""
        match record:
            case Message():
                self._seen[record.channel_id] += 1
                if (name := self._names[record.channel_id]) is not None:
                    self._by_name[name].append(record.data)
            case Schema():
                self._schemas[record.id] = record
            case Channel():
                self._names[record.id] = self._name(record)
            case Statistics():
                self._predicted = dict(record.channel_message_counts)

    def _name(self, channel: Channel) -> str | None:
        if (accepted := _ACCEPTED.get(channel.topic)) is None:
            return None
        schema = self._schemas[channel.schema_id]
        if channel.message_encoding != "protobuf" or schema.name not in accepted:
            raise ValueError(f"{channel.topic} holds {channel.message_encoding} {schema.name}, not {accepted[0]}")
        _check_fields(schema)
        return schema.name

    def check_complete(self) -> None:
        """Raise ValueError if a complete file holds fewer messages than it says."""
        if self._predicted is not None and +Counter(self._predicted) != self._seen:
            raise ValueError(f"{sum(self._predicted.values())} messages predicted")

    def contents(self, sha256: str, damage: str | None) -> StepContents:
        """Return what was collected as arrays."""
        output = RATES if self._by_name[RATES] else COUNTS
        if self._by_name[RATES] and self._by_name[COUNTS]:
            raise ValueError("counts and rates in one file")
        raw = map(MESSAGES[RAW].FromString, self._by_name[RAW])
        sent, aux = columns(output, self._by_name[output]), dict[str, FloatArray]()
        if sent is None:
            sent, aux = _one_by_one(output, self._by_name[output])
        return StepContents(
            output=output,
            temperature=sent.pop("temperature_c"),
            **sent,
            aux=aux,
            raw=tuple((int(m.host_ns), bytes(m.data)) for m in raw),
            sha256=sha256,
            damage=damage,
        )


def _one_by_one(output: str, messages: Sequence[bytes]) -> tuple[dict[str, Any], dict[str, FloatArray]]:
    """Return the fields of messages by name, as `columns`, and their auxiliary channels."""
    samples = [MESSAGES[output].FromString(message) for message in messages]
    sent: dict[str, Any] = {
        name: np.array([getattr(sample, name) for sample in samples], dtype=np.int64) for name in _WHOLE
    }
    sent["temperature_c"] = np.array([sample.temperature_c for sample in samples], dtype=np.float64)
    kind = np.int64 if output == COUNTS else np.float64
    sent |= {name: _triad([getattr(sample, name) for sample in samples], name, kind) for name in TRIADS}
    maps = [sample.aux for sample in samples]
    names = sorted({name for values in maps for name in values})
    return sent, {name: np.array([values.get(name, np.nan) for values in maps]) for name in names}


def _triad(values: list[Any], name: str, kind: type) -> Any:
    lengths = set(map(len, values))
    if not lengths - {0}:
        return None
    if lengths != {3}:
        raise ValueError(f"messages with {', '.join(map(str, sorted(lengths)))} values of {name}, not 3")
    return np.array(list(chain.from_iterable(values)), dtype=kind).reshape(-1, 3)


def _check_fields(schema: Schema) -> None:
    """Refuse an embedded schema that gives one of our field names another number or type."""
    ours = {f.name: (f.number, f.type) for f in MESSAGES[schema.name].DESCRIPTOR.fields}
    for file in FileDescriptorSet.FromString(schema.data).file:
        for message in file.message_type:
            if f"{file.package}.{message.name}" == schema.name:
                for f in message.field:
                    if ours.get(f.name, (f.number, f.type)) != (f.number, f.type):
                        raise ValueError(f"{schema.name}.{f.name} with another number or type")
