"""A NovAtel log tells of whole seconds where its last header says that the receiver knows the time."""

import pytest

from drivers.wire.novatel_time import WEEK, gps_seconds

AT = 2400 * WEEK + 5.25


def header(status: int) -> bytes:
    """Return the long binary header of the OEM7 manual: 28 bytes, the time status is the 14th."""
    return b"\xaa\x44\x12\x1c" + bytes(9) + bytes([status]) + bytes(14)


def text(status: str) -> bytes:
    return f"#RAWIMUA,COM1,0,60.5,{status},2400,5.250,00,0,0;1,2*abcd\r\n".encode()


CASES = [
    (header(160), False, True),
    (header(180) + bytes(90), False, True),
    (header(159) + bytes(90), False, False),
    (header(60) + bytes(90) + header(180), False, True),  # the last one counts
    (header(180) + bytes(90) + header(60), False, False),
    (header(60) + bytes(90) + header(180)[:12], False, False),  # of those that are whole
    (b"", False, False),
    (text("FINESTEERING"), True, True),
    (text("COARSE") + text("SATTIME"), True, True),
    (text("SATTIME") + text("COARSE"), True, False),
    (text("SATTIME") + text("COARSE")[:40], True, True),
]


@pytest.mark.parametrize(
    ("data", "is_text", "is_known"),
    CASES,
    ids=range(len(CASES)),
)
def test_the_last_whole_header_says_how_good_the_time_is(data: bytes, is_text: bool, is_known: bool) -> None:
    form = gps_seconds(lambda block: b"", is_long=True, is_text=is_text)
    assert form.age(data, AT) == (pytest.approx(0.25) if is_known else None)
    assert form.age(data, 5.25) is None  # a receiver without the time counts from week 0


def test_short_headers_say_nothing_of_the_time_but_its_week() -> None:
    form = gps_seconds(lambda block: b"", is_long=False, is_text=False)
    assert form.age(b"", AT) == pytest.approx(0.25)
    assert form.age(b"", 5.25) is None
