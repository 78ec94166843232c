"""Many samples' messages at once, as columns: a tenth of the time of one message after another.

Protobuf joins messages that follow each other: a repeated field then holds the values of all of them. Here every
field is read as a repeated one, and a mark in each of them ends each message, so that a value left out (protobuf
leaves out 0) is seen to be missing. Where the marks are not where they should be, nothing is said: such messages
are for a reader that takes them one by one.
"""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto
from google.protobuf.message import DecodeError

from procedures.arrays import IntArray
from station.files.mcap_files.schemas import COUNTS, MESSAGES, RATES, built

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
    found = {field: _triad(values[field], held[field]) for field in TRIADS}
    return found | {field: _scalar(values[field], ends[field], held[field]) for field in marks.keys() - found}


def _is_fit(field: str, held: IntArray, n: int) -> bool:
    """Say whether each of n messages has the field's value or none, and of a triad all or none have three."""
    if field in TRIADS:
        return len(held) == n and set(held.tolist()) in ({0}, {3}, set())
    return len(held) == n and bool(np.all(held <= 1))


def _triad(values: Any, held: IntArray) -> Any:
    return values.reshape(len(held), -1)[:, :-1] if held.any() else None


def _scalar(values: Any, ends: IntArray, held: IntArray) -> Any:
    return np.where(held == 1, values[ends - 1], values.dtype.type(0))
