"""NovAtel's logs as lines of text: ``%NAMEA,header;fields*crc`` or, with the long header, ``#NAMEA,...``.

A line becomes a row of the table that the short binary form of its log has, so that both are decoded alike. The
CRC is NovAtel's over what stands between the first character and the ``*``; it is printed as 8 lower-case
hexadecimal digits. Source: OEM7 manual, "ASCII" and "32-Bit CRC".
"""

import struct
from dataclasses import replace
from functools import partial

import numpy as np

from drivers.wire import novatel_log
from drivers.wire._format import UNDECIDED, FrameKind, Octets, TextForm, WireFormat
from drivers.wire.novatel_lines import CRC_DIGITS, MAX_LINE_CHARS, layout_of, lines
from drivers.wire.novatel_time import gps_seconds
from procedures.counts.sample_records import CountBlock

_PLAIN = struct.Struct("<12xIdI6i4x")
_TYPED = struct.Struct("<12xBBHdI6i4x")


def end(buffer: bytes, at: int) -> int:
    """Return where the line from ``at`` on ends, its line break left out; see `TextForm`."""
    star = buffer.find(b"*", at, at + MAX_LINE_CHARS - CRC_DIGITS)
    if star >= 0:
        return star + 1 + CRC_DIGITS
    return UNDECIDED if len(buffer) - at < MAX_LINE_CHARS - CRC_DIGITS else at


def is_intact(line: Octets) -> bool:
    """Say whether a line passes its CRC."""
    text = bytes(line)
    body, star, check = text[1 : -CRC_DIGITS - 1], text[-CRC_DIGITS - 1 : -CRC_DIGITS], text[-CRC_DIGITS:]
    return text[:1] in (b"%", b"#") and star == b"*" and check == b"%08x" % novatel_log.crc(body)


def row(line: bytes) -> bytes:
    """Return a line's fields as a row of the short binary table; raise ValueError where they are others."""
    fields = line[: -CRC_DIGITS - 1].partition(b";")[2].split(b",")
    try:
        if len(fields) == 11:
            info, imu_type, week, seconds, status, *counts = fields
            return _TYPED.pack(
                int(info, 16), int(imu_type), int(week), float(seconds), int(status, 16), *map(int, counts)
            )
        week, seconds, status, *counts = fields
        return _PLAIN.pack(int(week), float(seconds), int(status, 16), *map(int, counts))
    except struct.error as error:
        raise ValueError(f"{len(fields)} fields that do not fit, expected 9 or 11") from error


def encode(block: CountBlock, dtype: np.dtype[np.void], message: int, name: str, *, is_long: bool) -> bytes:
    """Return the lines of a block, each with its line break; what is sent is as in the binary form."""
    lines = list[bytes]()
    for frame in novatel_log.rows(block, dtype, message):
        header: tuple[str, ...] = str(frame["log_week"]), f"{frame['log_ms'] / 1000:.3f}"
        if is_long:
            header = "COM1", "0", "0.0", "FINESTEERING", *header, "00000000", "0000", "0"
        start = ",".join((f"{name}A", *header))
        body = f"{start};{','.join(_fields(frame))}".encode("ascii")
        lines.append(b"%s%s*%08x\r\n" % (b"#" if is_long else b"%", body, novatel_log.crc(body)))
    return b"".join(lines)


def ascii_log(binary: WireFormat, message: int, example: bytes, *, is_long: bool, is_typed: bool) -> WireFormat:
    """Return the text form of a log whose binary form is ``binary``; rows are of the short binary table."""
    dtype = novatel_log.table(is_long=False, is_typed=is_typed)
    name = binary.name.upper()
    mark = b"#" if is_long else b"%"
    prefix = mark + name.encode() + b"A,"
    many = partial(lines, layout=layout_of(prefix, b",,,.,,,.,,," if is_long else b",,.", dtype))
    imu = FrameKind(prefix, dtype, text=TextForm(end, row, MAX_LINE_CHARS, many))
    typed = None if binary.identify is None else partial(novatel_log.identify, dtype=dtype)
    sends = partial(encode, dtype=dtype, message=message, name=name, is_long=is_long)
    return replace(
        binary,
        name=f"{binary.name}a",
        title=f"NovAtel {name}A, a line of text",
        sync=imu.prefix,
        length_at=None,
        imu=imu,
        check="CRC-32 as in the binary form, over the characters between the first and the *",
        is_intact=is_intact,
        encode=sends,
        pulse=gps_seconds(sends, is_long=is_long, is_text=True),
        example=example,
        trailer=b"\r\n",
        identity=None if typed is None else imu,
        identify=typed,
    )


def _fields(frame: np.void) -> list[str]:
    typed = [f"{frame['info']:02x}", str(frame["type"])] if "info" in (frame.dtype.names or ()) else []
    counts = [str(count) for name in ("accel", "gyro") for count in frame[name]]
    return [*typed, str(frame["week"]), f"{frame['seconds']:.9f}", f"{frame['status']:08x}", *counts]
