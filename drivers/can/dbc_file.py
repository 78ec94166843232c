"""A DBC file, read by cantools: the only file that knows it."""

import re
from pathlib import Path

import cantools.database
import numpy as np
from cantools.database.can import Database, Message

from drivers.can.frame_record import EXTENDED
from drivers.can.signal_layout import SignalField
from drivers.errors import BadCanFile
from drivers.text_decoding import decoded_text

_AT_LINE = re.compile(r"line (\d+)")
CLASSIC = 8  # bytes of a CAN 2.0 payload


def load_dbc(path: str) -> Database:
    """Return the database of a DBC in UTF-8 or ISO-8859-1; raise `BadCanFile` naming its line."""
    text = text_of(path)
    try:
        database = cantools.database.load_string(text, database_format="dbc")
    except Exception as error:  # the edge to a library whose parser raises what it likes
        found = " ".join(str(error).removeprefix("DBC: ").strip('"').split())
        line = _AT_LINE.search(found)
        raise BadCanFile(path, int(line[1]) if line else None, found, "a DBC without errors") from error
    if not isinstance(database, Database):
        raise BadCanFile(path, None, "no CAN database", "a DBC")
    return database


def text_of(path: str) -> str:
    """Return a file's text, in UTF-8 or ISO-8859-1; raise `BadCanFile` where it cannot be read."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise BadCanFile(path, None, error.strerror or str(error), "a readable file") from error
    return decoded_text(content)


def identifier_of(message: Message) -> int:
    """Return a message's identifier with the flag of a 29-bit one."""
    return int(message.frame_id) | (EXTENDED if message.is_extended_frame else 0)


def field_of(path: str, message: Message, name: str) -> SignalField:
    """Return where one signal of a message stands; raise `BadCanFile` if it has none such, or none we can read."""
    signals = {signal.name: signal for signal in message.signals}
    if name not in signals:
        raise BadCanFile(path, None, f"no signal {name!r} in {message.name}", f"one of {', '.join(signals)}")
    signal = signals[name]
    if signal.multiplexer_ids or message.length > CLASSIC:
        kind = "is multiplexed" if signal.multiplexer_ids else f"is in a frame of {message.length} bytes"
        raise BadCanFile(path, None, f"{message.name}.{name} {kind}", "a plain signal of a frame of up to 8 bytes")
    least, most = signal.minimum, signal.maximum
    is_stated = least is not None and most is not None and most > least  # [0|0] is how a DBC says nothing
    return SignalField(
        start=signal.start,
        bits=signal.length,
        is_big_endian=signal.byte_order == "big_endian",
        is_signed=signal.is_signed,
        is_float=signal.is_float,
        scale=float(signal.scale),
        offset=float(signal.offset),
        unit=signal.unit or "",
        least=float(least) if is_stated and least is not None else -np.inf,
        most=float(most) if is_stated and most is not None else np.inf,
    )
