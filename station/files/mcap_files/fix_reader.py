"""A GNSS receiver's file back as records, in the order in which they came."""

from functools import partial
from pathlib import Path
from typing import Any

from procedures.earth.gnss_records import AirData, FixType, GnssFix, TimeMark
from station.files.mcap_files.fix_schemas import FIX_MESSAGES
from station.files.mcap_files.fix_writer import TOPIC_NAMES, TOPICS
from station.files.mcap_files.topics import topic_messages

Record = GnssFix | TimeMark | AirData


def read_fixes(path: Path) -> list[Record]:
    """Read what `FixWriter` wrote; a file cut short is read as far as it goes.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong.
    """
    return list(topic_messages(path, _KINDS))


def _record(kind: type[Record], message: Any, data: bytes) -> Record:
    known = {field.name: value for field, value in message.FromString(data).ListFields()}
    # a field that was set to its default is listed too: presence is explicit in these messages
    if kind is GnssFix:
        known["fix"] = FixType(known["fix"])
    known |= {"utc_ns": None} if kind is TimeMark and "utc_ns" not in known else {}
    return kind(**known)


_KINDS = {TOPICS[name]: partial(_record, kind, FIX_MESSAGES[name]) for kind, name in TOPIC_NAMES.items()}
