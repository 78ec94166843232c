"""Numbers out of a text, many at once: eight characters are read as one 64-bit word.

In a word the first character is the lowest byte, and what stands before a number is taken for zeros. Source of the
three multiplications: D. Lemire, "Quickly parsing eight digits", 2018.
"""

import numpy as np

from procedures.arrays import BoolArray, IntArray

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
