"""Numbers out of text, many at once, beside Python's own reading of each."""

import numpy as np
import pytest

from drivers.wire.numerals import decimal, hexadecimal, words_of
from procedures.arrays import BoolArray, IntArray

DIGITS = "9182736450918273"


def read(how: object, *texts: str) -> tuple[list[int], list[bool]]:
    """Read each text as it stands between others."""
    line = "#######;" + ",".join(texts) + ",*"
    begins = np.cumsum([8] + [len(each) + 1 for each in texts])[:-1]
    ends = begins + [len(each) for each in texts]
    values, is_number = how(words_of(line.encode()), begins, ends)  # type: ignore[operator]
    return values.tolist(), is_number.tolist()


def test_words_are_little_endian_and_begin_at_each_character() -> None:
    text = b"0123456789"
    assert words_of(text).tolist() == [int.from_bytes(text[i : i + 8], "little") for i in range(3)]
    assert words_of(b"1234567").tolist() == []


def test_one_to_sixteen_digits_are_a_number() -> None:
    texts = [DIGITS[:n] for n in range(1, 17)] + [
        "0",
        "00000000",
        "99999999",
        "100000000",
        "9" * 16,
        "0" * 15 + "7",
    ]
    values, is_number = read(decimal, *texts)
    assert values == [int(each) for each in texts]
    assert all(is_number)


@pytest.mark.parametrize(
    "bad", ["", "1" * 17, "1" * 18, "1" * 24, "1/2", "1:2", "-1", " 1", "1 ", "a", "1e5", "\x7f1"]
)
def test_what_is_no_number_is_told_and_leaves_its_neighbours(bad: str) -> None:
    values, is_number = read(decimal, "12", bad, "34567890123")
    assert is_number == [True, False, True]
    assert (values[0], values[2]) == (12, 34567890123)


@pytest.mark.parametrize("place", range(16))
@pytest.mark.parametrize("character", "/:;,@ ")
def test_any_other_character_at_any_place_is_seen(place: int, character: str) -> None:
    text = DIGITS[:place] + character + DIGITS[place + 1 :]
    assert read(decimal, text)[1] == [False]
    if place < 8:
        assert read(decimal, text[:8])[1] == [False]


def test_one_to_eight_hexadecimal_digits_are_a_number() -> None:
    texts = ["0", "9", "a", "f", "10", "0f", "deadbeef", "01234567", "89abcdef", "ffffffff", "7fffffff", "abc"]
    values, is_number = read(hexadecimal, *texts)
    assert values == [int(each, 16) for each in texts]
    assert all(is_number)


@pytest.mark.parametrize("bad", ["", "123456789", "A", "g", "`", "G1", "0x1", "-1", ":", "/", "1 ", "f@"])
def test_what_is_no_lower_case_hexadecimal_is_told(bad: str) -> None:
    values, is_number = read(hexadecimal, "1f", bad, "a0")
    assert is_number == [True, False, True]
    assert (values[0], values[2]) == (0x1F, 0xA0)


def test_tables_of_numbers_keep_their_shape() -> None:
    line = b"########12,345;678901234567,8"
    begins: IntArray = np.array([[8, 11], [15, 28]])
    ends: IntArray = np.array([[10, 14], [27, 29]])
    found: tuple[IntArray, BoolArray] = decimal(words_of(line), begins, ends)
    assert found[0].tolist() == [[12, 345], [678901234567, 8]]
    assert found[1].all()
