"""The messages of some topics of an MCAP file, in the order in which they came."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

from mcap.records import Channel, Message

from station.errors import DataRefused
from station.files.mcap_files.reader import DAMAGE
from station.files.mcap_files.records import CutShort, file_records

T = TypeVar("T")


def topic_messages(path: Path, kinds: Mapping[str, Callable[[bytes], T]]) -> Iterator[T]:
    """Yield each message of the topics in ``kinds``, as these read it; a file cut short goes as far as it goes.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong.
    """
    topics, count = dict[int, str](), 0
    try:
        with path.open("rb") as stream:
            for record in file_records(stream):
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and topics[record.channel_id] in kinds:
                    yield kinds[topics[record.channel_id]](record.data)
                    count += 1
    except CutShort:
        pass
    except DAMAGE as error:
        what = " ".join(str(error).split())[:120] or type(error).__name__
        raise DataRefused(path, None, f"damage after record {count} ({what})", "an intact file") from error
