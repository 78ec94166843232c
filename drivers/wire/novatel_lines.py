"""Many of NovAtel's text lines at once: what `drivers.wire.novatel` does to one, done to arrays.

Only lines that are written as a receiver writes them are taken, each with its line break. Every other one is left
to be looked at by itself, so that what is accepted does not depend on how it was read.

Eight characters are read as one 64-bit word: the first character is the lowest byte, and what stands before a
number is taken for zeros. Source of the three multiplications: D. Lemire, "Quickly parsing eight digits", 2018.
"""

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.wire.wire_format import Frames, Lines
from procedures.arrays import BoolArray, FloatArray, IntArray

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


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """How a log writes its lines: how they begin, their marks and line feed in order, the table that they fill.

    ``names`` are of the numbers behind the semicolon, the counts left out; ``most`` (m, 1) is what each can be.
    """

    prefix: bytes
    marks: bytes
    dtype: np.dtype[np.void]
    names: tuple[str, ...]
    most: IntArray
    in_hexadecimal: list[int]


def layout_of(prefix: bytes, header: bytes, dtype: np.dtype[np.void]) -> Layout:
    """Return the layout of a log whose header has these marks before the semicolon."""
    limits = {name: np.iinfo(dtype[name].base).max for name in dtype.names or () if name != "seconds"}
    limits |= {"seconds": SECONDS_LIMIT - 1, DECIMALS: 10**MAX_DECIMALS - 1}
    names = tuple(name for name in ORDER if name in limits)
    most = [limits[name] for name in names] + [limits["gyro"]] * COUNT_FIELDS
    marks = b"".join(b"." if name == "seconds" else b"," for name in names)
    return Layout(
        prefix, header + b";" + marks + b"," * (COUNT_FIELDS - 1) + b"*\n", dtype, names, np.array(most)[:, None],
        [names.index(name) for name in IN_HEXADECIMAL if name in names],
    )  # fmt: skip


def lines(buffer: bytes, layout: Layout) -> list[Lines]:
    """Return the intact lines of a buffer as rows; those that stand end to end stand together."""
    text, words = np.frombuffer(buffer, np.uint8), words_of(buffer)
    begins, places = _written(text, layout.prefix, layout.marks)
    rows, is_good = _rows(text, words, places[layout.marks.index(b";") : -1], layout)
    is_good &= _is_intact(buffer, words, begins, places[-2])
    edges = np.stack((begins, places[-2] + 1 + CRC_DIGITS), axis=1)
    return _runs(rows, edges, is_good)


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


def _rows(text: Text, words: IntArray, places: IntArray, layout: Layout) -> tuple[Frames, BoolArray]:
    """Return what stands between the marks as rows of a table, and which rows hold it truly."""
    begins, ends = places[:-1] + 1, places[1:]
    is_negative = text[begins[-COUNT_FIELDS:]] == _MINUS
    begins[-COUNT_FIELDS:] += is_negative
    values, is_true = decimal(words, begins, ends)
    for row in layout.in_hexadecimal:
        values[row], is_true[row] = hexadecimal(words, begins[row], ends[row])
    is_good = (is_true & (values <= layout.most)).all(axis=0)
    counts = np.where(is_negative, -values[-COUNT_FIELDS:], values[-COUNT_FIELDS:])
    numbers = dict(zip(layout.names, values, strict=False))
    rows = np.zeros(places.shape[1], layout.dtype)
    rows["accel"], rows["gyro"] = counts[:3].T, counts[3:].T
    size = (ends - begins)[layout.names.index(DECIMALS)]
    rows["seconds"] = _seconds(numbers.pop("seconds"), numbers.pop(DECIMALS), size)
    for name, value in numbers.items():
        rows[name] = value
    return rows, is_good & (size <= MAX_DECIMALS)


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
