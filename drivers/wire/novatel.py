"""NovAtel's raw IMU logs, binary and as text: increments per IMU sample in the order Z, minus Y, X, with GPS time.

Sources: OEM7 manual, logs RAWIMU, RAWIMUS, RAWIMUX, RAWIMUSX (docs.novatel.com/OEM7/Content/SPAN_Logs/NAME.htm).
Asked for with ``log rawimusxb onnew``. The header's time is that of the log, the body's that of the sample. Device
time is GPS seconds since 1980-01-06, so that it rises over a change of week. There is no frame counter and no
temperature. RAWIMU and RAWIMUS neither name the IMU nor have an error bit, and what their status word means
depends on the IMU: a frame is read as healthy whenever its time is one, so prefer the X logs where there are any.
RAWIMUX takes 72 bytes a sample where RAWIMUSX has 56: at 200 Hz 144 kbit/s.

As text a log is a line ``%NAMEA,header;fields*crc`` or, with the long header, ``#NAMEA,...``. A line becomes a row
of the table that the short binary form has, so that both are decoded alike. The CRC is NovAtel's over the
characters between the first and the ``*``; it is printed as 8 lower-case hexadecimal digits. Source: OEM7 manual,
"ASCII" and "32-Bit CRC".
"""

import struct
from dataclasses import replace
from functools import partial

import numpy as np

from drivers.wire import novatel_binary
from drivers.wire.novatel_binary import binary_log, gps_seconds
from drivers.wire.novatel_lines import CRC_DIGITS, MAX_LINE_CHARS, layout_of, lines
from drivers.wire.wire_format import UNDECIDED, FrameKind, Octets, TextForm, WireFormat
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
    return text[:1] in (b"%", b"#") and star == b"*" and check == b"%08x" % novatel_binary.crc(body)


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
    for frame in novatel_binary.rows(block, dtype, message):
        header: tuple[str, ...] = str(frame["log_week"]), f"{frame['log_ms'] / 1000:.3f}"
        if is_long:
            header = "COM1", "0", "0.0", "FINESTEERING", *header, "00000000", "0000", "0"
        start = ",".join((f"{name}A", *header))
        body = f"{start};{','.join(_fields(frame))}".encode("ascii")
        lines.append(b"%s%s*%08x\r\n" % (b"#" if is_long else b"%", body, novatel_binary.crc(body)))
    return b"".join(lines)


def ascii_log(binary: WireFormat, message: int, example: bytes, *, is_long: bool, is_typed: bool) -> WireFormat:
    """Return the text form of a log whose binary form is ``binary``; rows are of the short binary table."""
    dtype = novatel_binary.table(is_long=False, is_typed=is_typed)
    name = binary.name.upper()
    mark = b"#" if is_long else b"%"
    prefix = mark + name.encode() + b"A,"
    many = partial(lines, layout=layout_of(prefix, b",,,.,,,.,,," if is_long else b",,.", dtype))
    imu = FrameKind(prefix, dtype, text=TextForm(end, row, MAX_LINE_CHARS, many))
    typed = None if binary.identify is None else partial(novatel_binary.identify, dtype=dtype)
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


def _both(
    name: str, message: int, binary: str, text: bytes, *, is_long: bool, is_typed: bool
) -> tuple[WireFormat, WireFormat]:
    """Return a log's binary form and its text form; ``binary`` [hexadecimal] and ``text`` are examples."""
    form = binary_log(name, message, bytes.fromhex(binary), is_long=is_long, is_typed=is_typed)
    return form, ascii_log(form, message, text, is_long=is_long, is_typed=is_typed)


_LOGS = (
    _both(
        "rawimusx", 1462, is_long=False, is_typed=True,
        # novatel_edie (MIT), python/test/test_decode_encode.py
        binary="aa441328b6059c0678b9e21c 000b9c06 0b9755a832941d41 03158000"
               "ebd09102 a687f3ff 38eafcff 66b7fcff 1c5fffff 59d9ffff 475fafba",
        # the same sample, same source
        text=b"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,"
             b"43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b",
    ),
    _both(
        "rawimus", 325, is_long=False, is_typed=False,
        # The manual's ASCII example (week 2209) in the binary layout; no public binary frame was found.
        binary="aa4413284501a1085e684d1d a1080000 9b92ac0371011e41 00fe5aea"
               "98c7a013 3faad9ff fb4b4300 c9b90400 29430900 9397f0ff 0c2daf3a",
        text=b"%RAWIMUSA,2209,491612.254;2209,491612.253588,ea5afe00,329303960,-2512321,4410363,"
             b"309705,607017,-1009773*1fb76c28",  # the manual's example
    ),
    _both(
        "rawimux", 1461, is_long=True, is_typed=True,
        # The manual's ASCII example below in the binary layout; no public binary frame was found.
        binary="aa44121cb50500002800000081b4a108cd5b4f1d20000002c50da941 0429a108 00e0737070031e41 00fe57ea"
               "9427a213636ddbff91614400 afe6040031ed030073b7f1ff 262be4db",
        text=b"#RAWIMUXA,USB1,0,64.5,FINESTEERING,2209,491740.110,02000020,0dc5,16809;04,41,2209,491740.109817,"
             b"ea57fe00,329394068,-2396829,4481425,321199,257329,-936077*cf9c035d",  # the manual's example
    ),
    _both(
        "rawimu", 268, is_long=True, is_typed=False,
        # RAWIMUS's example under the long header, made by `encode`: no public frame was found.
        binary="aa44121c0c0100002800000000b4a1085d684d1d0000000000000000 a1080000 0090ac0371011e41 00fe5aea"
               "98c7a0133faad9fffb4b4300 c9b90400294309009397f0ff 07a7ffbd",
        text=b"#RAWIMUA,COM1,0,0.0,FINESTEERING,2209,491612.253,00000000,0000,0;2209,491612.253587961,ea5afe00,"
             b"329303960,-2512321,4410363,309705,607017,-1009773*d94152f0",
    ),
)  # fmt: skip
FORMATS = (*(binary for binary, _ in _LOGS), *(text for _, text in _LOGS))
