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
import zlib
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.wire import novatel_binary
from drivers.wire.novatel_binary import binary_log, gps_seconds
from drivers.wire.wire_format import UNDECIDED, FrameKind, Frames, Lines, Octets, TextForm, WireFormat
from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.counts.sample_records import CountBlock

# Many lines are decoded at once, as arrays, if they are written as a receiver writes them; every other by itself.
# Eight characters are one 64-bit word, the first the lowest byte; D. Lemire, "Quickly parsing eight digits", 2018.
WORD_CHARS, MAX_DIGITS = 8, 16  # characters of a word, of a number
_ONES = 0x0101010101010101
_ZEROS, _NIBBLE = ord("0") * _ONES, 0x0F * _ONES
_TO_HIGH = 0x76 * _ONES  # with 10 or more the high bit is set
_HIGH = 0x80 * _ONES - 2**64
_TO_LETTER = ord("a") - ord("0") - 10
_LANES, _TENS_AND_MILLIONS, _ONE_AND_TEN_THOUSAND = 0x000000FF000000FF, 0x000F424000000064, 0x0000271000000001
_SIZES = range(MAX_DIGITS + 2)  # of a number; the last stands for all above it
# of a word
_KEPT = np.array([-(2 ** (64 - 8 * size)) if 0 < size < WORD_CHARS else -bool(size) for size in _SIZES])
_WRONG = np.array([0 if 0 < size <= MAX_DIGITS else _HIGH for size in _SIZES])


def words_of(text: bytes) -> IntArray:
    """Return the word that begins at each character (m,); the last seven begin none."""
    return np.ndarray((max(0, len(text) - WORD_CHARS + 1),), "<i8", text, strides=(1,))


def decimal(words: IntArray, begins: IntArray, ends: IntArray) -> tuple[IntArray, BoolArray]:
    """Return numbers without sign, and which are 1 to 16 digits and nothing else, in the shape of ``begins``.

    Parameters
    ----------
    words
        (m,), those of the text: `words_of`.
    begins, ends
        (n,) or (k, n), where the numbers begin in the text and one beyond their last characters.
    """
    size = ends - begins
    values, is_number = _eight_digits(words, ends, size)
    long = np.nonzero(size > WORD_CHARS)  # by row and column: large arrays need not lie in the order of their rows
    if len(long[0]):
        sizes = size[long]
        more, is_more = _eight_digits(words, ends[long] - WORD_CHARS, sizes - WORD_CHARS)
        values[long] += more * 10**WORD_CHARS
        is_number[long] &= is_more & (sizes <= MAX_DIGITS)
    return values, is_number


def hexadecimal(words: IntArray, begins: IntArray, ends: IntArray) -> tuple[IntArray, BoolArray]:
    """Return numbers, and which are 1 to 8 lower-case hexadecimal digits, in the shape of ``begins``.

    Parameters
    ----------
    words, begins, ends
        (m,) and (n,) or (k, n), as in `decimal`.
    """
    size = ends - begins
    letters = _digits(words, ends, size) ^ _ZEROS
    nibbles = (letters & _NIBBLE) + 9 * (letters >> 6 & _ONES)
    again = nibbles + _ZEROS + _TO_LETTER * ((nibbles + _TO_HIGH) >> 7 & _ONES)
    octets = (nibbles << 4 | nibbles >> 8).astype("<i8").view(np.uint8).reshape(*size.shape, WORD_CHARS)[..., ::2]
    values = np.ascontiguousarray(octets).view(">u4")[..., 0]
    is_number = (again == letters) & (nibbles & ~_NIBBLE == 0) & (size > 0) & (size <= WORD_CHARS)
    return values.astype(np.int64), is_number


def _digits(words: IntArray, ends: IntArray, size: IntArray) -> IntArray:
    """Return the last eight characters less the character 0; none before the number."""
    digits: IntArray = (words[ends - WORD_CHARS] ^ _ZEROS) & _KEPT.take(size, mode="clip")
    return digits


def _eight_digits(words: IntArray, ends: IntArray, size: IntArray) -> tuple[IntArray, BoolArray]:
    digits = _digits(words, ends, size)
    is_number = ((digits + _TO_HIGH | digits | _WRONG.take(size, mode="clip")) & _HIGH) == 0
    pairs = digits * 10 + (digits >> 8)
    fours = (pairs & _LANES) * _TENS_AND_MILLIONS + (pairs >> 16 & _LANES) * _ONE_AND_TEN_THOUSAND
    return fours >> 32, is_number


MAX_LINE_CHARS = 256  # characters; the longest line that numbers at their limits give has 226
CRC_DIGITS = 8  # of the CRC
COUNT_FIELDS = 6  # the last numbers of a line; no others may be negative
DECIMALS = "decimals"  # of the seconds
ORDER = ("info", "type", "week", "seconds", DECIMALS, "status")  # of the other numbers
SECONDS_LIMIT, MAX_DECIMALS = 10**6, 9  # together below 2^53
IN_HEXADECIMAL = ("info", "status")
Text = NDArray[np.uint8]
_COMMA, _SEMICOLON, _POINT, _STAR, _MINUS, _CR, _LF = b",;.*-\r\n"


class LineReader:
    """Reads the lines of a log that begin with ``prefix``, whose header has these marks before the semicolon."""

    def __init__(self, prefix: bytes, header: bytes, dtype: np.dtype[np.void]) -> None:
        limits = {name: np.iinfo(dtype[name].base).max for name in dtype.names or () if name != "seconds"}
        limits |= {"seconds": SECONDS_LIMIT - 1, DECIMALS: 10**MAX_DECIMALS - 1}
        names = tuple(name for name in ORDER if name in limits)
        marks = b"".join(b"." if name == "seconds" else b"," for name in names)
        self._prefix, self._dtype = prefix, dtype
        self._marks = header + b";" + marks + b"," * (COUNT_FIELDS - 1) + b"*\n"
        self._names = names  # of the numbers behind the semicolon, the counts left out
        self._most = np.array([limits[name] for name in names] + [limits["gyro"]] * COUNT_FIELDS)[:, None]
        self._in_hexadecimal = [names.index(name) for name in IN_HEXADECIMAL if name in names]

    def __call__(self, buffer: bytes) -> list[Lines]:
        """Return the intact lines of a buffer as rows; those that stand end to end stand together."""
        text, words = np.frombuffer(buffer, np.uint8), words_of(buffer)
        begins, places = _written(text, self._prefix, self._marks)
        rows, is_good = self._rows(text, words, places[self._marks.index(b";") : -1])
        is_good &= _is_intact(buffer, words, begins, places[-2])
        edges = np.stack((begins, places[-2] + 1 + CRC_DIGITS), axis=1)
        return _runs(rows, edges, is_good)

    def _rows(self, text: Text, words: IntArray, places: IntArray) -> tuple[Frames, BoolArray]:
        """Return what stands between the marks as rows of a table, and which rows hold it truly."""
        begins, ends = places[:-1] + 1, places[1:]
        is_negative = text[begins[-COUNT_FIELDS:]] == _MINUS
        begins[-COUNT_FIELDS:] += is_negative
        values, is_true = decimal(words, begins, ends)
        for row in self._in_hexadecimal:
            values[row], is_true[row] = hexadecimal(words, begins[row], ends[row])
        is_good = (is_true & (values <= self._most)).all(axis=0)
        counts = np.where(is_negative, -values[-COUNT_FIELDS:], values[-COUNT_FIELDS:])
        numbers = dict(zip(self._names, values, strict=False))
        rows = np.zeros(places.shape[1], self._dtype)
        rows["accel"], rows["gyro"] = counts[:3].T, counts[3:].T
        size = (ends - begins)[self._names.index(DECIMALS)]
        rows["seconds"] = _seconds(numbers.pop("seconds"), numbers.pop(DECIMALS), size)
        for name, value in numbers.items():
            rows[name] = value
        return rows, is_good & (size <= MAX_DECIMALS)


def _written(text: Text, prefix: bytes, marks: bytes) -> tuple[IntArray, IntArray]:
    """Return where lines begin (n,) that have these marks in this order, and where those stand (m, n)."""
    at = np.flatnonzero(
        (text == _COMMA) | (text == _SEMICOLON) | (text == _POINT) | (text == _STAR) | (text == _LF)
    )
    found = text[at]
    last = np.flatnonzero(found == _LF)  # mark of each line
    first = np.concatenate(([0], last + 1))[:-1]
    has_all = last + 1 - first == len(marks)
    begins, mine = np.concatenate(([0], at[last] + 1))[:-1][has_all], first[has_all] + _down(marks)
    places = at[mine]
    ends = places[-1] - 1
    is_written = (text[ends] == _CR) & (places[-2] + 1 + CRC_DIGITS == ends) & (ends - begins <= MAX_LINE_CHARS)
    is_written &= _reads(found, mine, marks) & _reads(text, begins + _down(prefix), prefix)
    return begins[is_written], places[:, is_written]


def _down(text: bytes) -> IntArray:
    return np.arange(len(text))[:, None]


def _reads(text: Text, places: IntArray, expected: bytes) -> BoolArray:
    reads: BoolArray = (text[places] == np.frombuffer(expected, np.uint8)[:, None]).all(axis=0)
    return reads


def _is_intact(buffer: bytes, words: IntArray, begins: IntArray, stars: IntArray) -> BoolArray:
    """Say which lines pass their CRC."""
    bodies = zip((begins + 1).tolist(), stars.tolist(), strict=True)
    sums = np.array([zlib.crc32(buffer[begin:star], 0xFFFFFFFF) for begin, star in bodies], np.uint32)
    sent, is_number = hexadecimal(words, stars + 1, stars + 1 + CRC_DIGITS)
    is_intact: BoolArray = is_number & (sent == ~sums)
    return is_intact


def _seconds(whole: IntArray, decimals: IntArray, size: IntArray) -> FloatArray:
    """Return the numbers with these digits before and behind the point.

    Below 2^53 both are float64 exactly, so that their quotient is rounded once, as by `float`.
    """
    tens = 10 ** np.minimum(size, MAX_DECIMALS)
    seconds: FloatArray = (whole * tens + decimals) / tens
    return seconds


def _runs(rows: Frames, edges: IntArray, is_good: BoolArray) -> list[Lines]:
    """Return the good lines; those that stand end to end, each with its line break, together."""
    goes_on = is_good[1:] & is_good[:-1] & (edges[1:, 0] == edges[:-1, 1] + 2)
    firsts = np.flatnonzero(is_good & ~np.concatenate(([False], goes_on)))
    lasts = np.flatnonzero(is_good & ~np.concatenate((goes_on, [False])))
    return [
        Lines(rows[a:b].tobytes(), edges[a:b]) for a, b in zip(firsts.tolist(), (lasts + 1).tolist(), strict=True)
    ]


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
    many = LineReader(prefix, b",,,.,,,.,,," if is_long else b",,.", dtype)
    imu = FrameKind(prefix, dtype, text=TextForm(end, row, MAX_LINE_CHARS, many))
    typed = None if binary.identify is None else partial(novatel_binary.identify, dtype=dtype)
    sends = partial(encode, dtype=dtype, message=message, name=name, is_long=is_long)
    return replace(
        binary,
        name=f"{binary.name}a",
        title=f"NovAtel {name}A, a line of text",
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
