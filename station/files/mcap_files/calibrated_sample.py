"""``station.CalibratedSample``: a sample as the protobuf message that Foxglove plots, in files and live.

A field has one number and one kind wherever it is; a message has those that are known of it and no others, so that
nothing shows as 0 that is not.
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

TOPIC, SAMPLE = "/imu/calibrated", "station.CalibratedSample"
COLUMNS = ("f_x_m_s2", "f_y_m_s2", "f_z_m_s2", "omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s")
FIRST_FLAG, FIRST_CHANNEL = 13, 100  # numbers, from which flags and what only a file carries along are counted
_Field = FieldDescriptorProto
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
