"""A GNSS receiver's file back as records, in the order in which they came."""

from pathlib import Path
from typing import Any

from mcap.records import Channel, Message

from procedures.gnss import AirData, FixType, GnssFix, TimeMark
from station.errors import DataRefused
from station.mcap_files.fix_schemas import FIX_MESSAGES
from station.mcap_files.fix_writer import NAMES, TOPICS
from station.mcap_files.reader import DAMAGE
from station.mcap_files.records import CutShort, file_records

Record = GnssFix | TimeMark | AirData
_KINDS = {TOPICS[name]: (kind, FIX_MESSAGES[name]) for kind, name in NAMES.items()}


def read_fixes(path: Path) -> list[Record]:
    """Read what `FixWriter` wrote; a file cut short is read as far as it goes.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong.
    """
    topics, found = dict[int, str](), list[Record]()
    try:
        with path.open("rb") as stream:
            for record in file_records(stream):
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and topics[record.channel_id] in _KINDS:
                    kind, message = _KINDS[topics[record.channel_id]]
                    found.append(_record(kind, message.FromString(record.data)))
    except CutShort:
        pass
    except DAMAGE as error:
        what = " ".join(str(error).split())[:120] or type(error).__name__
        raise DataRefused(path, None, f"damage after record {len(found)} ({what})", "an intact file") from error
    return found


def _record(kind: type[Record], message: Any) -> Record:
    known = {field.name: value for field, value in message.ListFields()}
    # a field that was set to its default is listed too: presence is explicit in these messages
    if kind is GnssFix:
        known["fix"] = FixType(known["fix"])
    known |= {"utc_ns": None} if kind is TimeMark and "utc_ns" not in known else {}
    return kind(**known)
