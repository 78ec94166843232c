"""A GNSS receiver's file back as records, in the order in which they came."""

from functools import partial
from pathlib import Path
from typing import Any

from procedures.earth.gnss_records import AirData, FixType, GnssFix, TimeMark
from station.files.mcap_files.fix_schemas import FIX_MESSAGES, TOPICS
from station.files.mcap_files.reader import topic_messages

Record = GnssFix | TimeMark | AirData


def read_fixes(path: Path) -> list[Record]:
    """Read what `FixWriter` wrote; a file cut short is read as far as it goes.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong.
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


_KINDS = {topic: partial(_record, kind) for kind, topic in TOPICS.items()}
