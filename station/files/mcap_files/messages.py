"""The records of an MCAP file to samples: which channel is what, and whether all messages are there."""

from collections import Counter, defaultdict
from typing import Any

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.records import Channel, McapRecord, Message, Schema, Statistics

from station.files.mcap_files.contents import StepContents, step_contents
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES, RATES, RAW, RAW_TOPIC

_ACCEPTED = {COUNTS_TOPIC: (COUNTS, RATES), RAW_TOPIC: (RAW,)}


class Messages:
    """Collects the messages of one file, record by record."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._parsers: dict[int, tuple[str, Any] | None] = {}
        self._seen = Counter[int]()
        self._foretold: dict[int, int] | None = None
        self._by_name: dict[str, list[Any]] = defaultdict(list)

    @property
    def total(self) -> int:
        """How many messages were seen."""
        return self._seen.total()

    def add(self, record: McapRecord) -> None:
        """Take a record; raises ValueError or the parser's error where it does not fit."""
        match record:
            case Message():
                self._seen[record.channel_id] += 1
                if (parser := self._parsers[record.channel_id]) is not None:
                    name, message = parser
                    self._by_name[name].append(message.FromString(record.data))
            case Schema():
                self._schemas[record.id] = record
            case Channel():
                self._parsers[record.id] = self._parser(record)
            case Statistics():
                self._foretold = dict(record.channel_message_counts)
            case _:
                pass

    def _parser(self, channel: Channel) -> tuple[str, Any] | None:
        if (accepted := _ACCEPTED.get(channel.topic)) is None:
            return None
        schema = self._schemas[channel.schema_id]
        if channel.message_encoding != "protobuf" or schema.name not in accepted:
            raise ValueError(f"{channel.topic} holds {channel.message_encoding} {schema.name}, not {accepted[0]}")
        _check_fields(schema)
        return schema.name, MESSAGES[schema.name]

    def check_complete(self) -> None:
        """Raise ValueError if a complete file holds fewer messages than it says."""
        if self._foretold is not None and +Counter(self._foretold) != self._seen:
            raise ValueError(f"{sum(self._foretold.values())} messages foretold")

    def contents(self, sha256: str, damage: str | None) -> StepContents:
        """Return what was collected as arrays."""
        output = RATES if self._by_name[RATES] else COUNTS
        if self._by_name[RATES] and self._by_name[COUNTS]:
            raise ValueError("counts and rates in one file")
        raw = tuple((int(m.host_ns), bytes(m.data)) for m in self._by_name[RAW])
        return step_contents(output, self._by_name[output], raw, sha256, damage)


def _check_fields(schema: Schema) -> None:
    """Refuse an embedded schema that gives one of our field names another number or type."""
    ours = {f.name: (f.number, f.type) for f in MESSAGES[schema.name].DESCRIPTOR.fields}
    for file in FileDescriptorSet.FromString(schema.data).file:
        for message in file.message_type:
            if f"{file.package}.{message.name}" == schema.name:
                for f in message.field:
                    if ours.get(f.name, (f.number, f.type)) != (f.number, f.type):
                        raise ValueError(f"{schema.name}.{f.name} with another number or type")
