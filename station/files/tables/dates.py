"""Dates and clocks in a log's cells, as loggers, spreadsheets and MATLAB write them, in seconds.

A date between dots has its day first. Between slashes or hyphens day and month may be in either order: all cells
of a column decide together (`date_order`), and where both orders fit the column is none of dates.
"""

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from enum import Enum
from functools import lru_cache

from procedures.units import S_PER_H

S_PER_DAY = 24 * S_PER_H


class DateOrder(Enum):
    """Which of two numbers in front of the year is the day."""

    DAY_FIRST = "day/month/year"
    MONTH_FIRST = "month/day/year"


_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_DATE = re.compile(
    r"(?!\d{5,7}$)(?P<year>\d{4})(?P<by>[-/.]?)(?P<month>\d\d?)(?P=by)(?P<day>\d\d?)"
    r"|(?P<first>\d\d?)(?P<mark>[-/])(?P<then>\d\d?)(?P=mark)(?P<last>\d{4})"
    r"|(?P<dotted_day>\d\d?)\.(?P<dotted_month>\d\d?)\.(?P<dotted_year>\d{4}|\d\d)"
    rf"|(?P<named_day>\d\d?)[- ](?P<named_month>{'|'.join(_MONTHS)})[- ](?P<named_year>\d{{4}})",
    re.ASCII | re.IGNORECASE,
)
_FRACTION = r"(?:[.,](\d{1,9})|:(\d{3}))?"  # LabVIEW and others write 09:14:03:125
_CLOCK = re.compile(rf"(\d{{1,3}}):([0-5]\d):([0-5]\d){_FRACTION}(?:\s?([AP])M)?", re.ASCII | re.IGNORECASE)
_ZONE = r"\s?(Z|UTC|[+-]\d\d:?\d\d)?"
_MOMENT = re.compile(
    rf"(\d[^:]{{5,10}}?)(?:T|_|,?\s+)(\d\d?):([0-5]\d)(?::([0-5]\d){_FRACTION})?(?:\s?([AP])M)?{_ZONE}",
    re.ASCII | re.IGNORECASE,
)
_COMPACT = re.compile(rf"(\d{{8}})[T_ ](\d\d)([0-5]\d)([0-5]\d){_FRACTION}(){_ZONE}", re.ASCII)  # ISO 8601 basic


def moment(cell: str, order: DateOrder | None = None) -> float | None:
    """Return the seconds since 1970 of a date and time (UTC without a zone), or since midnight of a clock.

    None of what is neither, and of a date whose day and month may be in either ``order`` where that is not known.
    """
    if found := _CLOCK.fullmatch(cell):
        return _clock(*found.groups(), hours=1000)
    if (found := _MOMENT.fullmatch(cell) or _COMPACT.fullmatch(cell)) is None:
        return None
    date, *clock, zone = found.groups()
    midnight, seconds = _midnight(date, order), _clock(*clock, hours=24)
    return None if midnight is None or seconds is None else midnight - _zone(zone) + seconds


def date_order(cells: Sequence[str]) -> DateOrder | None:
    """Return in which order the dates of a column are, None where both orders read as many, or none matters."""
    read = {order: sum(moment(cell, order) is not None for cell in cells) for order in DateOrder}
    best = max(read, key=lambda order: read[order])
    return best if len(set(read.values())) > 1 else None


def may_be_moment(cell: str) -> bool:
    """Return whether a cell is a clock, or a date in at least one order of day and month."""
    return any(moment(cell, order) is not None for order in DateOrder)


def readings(cell: str) -> list[str]:
    """Return the dates, as ISO 8601 writes them, that a cell may be by the order of day and month."""
    both = [seconds for order in DateOrder if (seconds := moment(cell, order)) is not None]
    return [f"{datetime.fromtimestamp(seconds, UTC):%Y-%m-%d}" for seconds in both]


@lru_cache(maxsize=64)  # a log has few days
def _midnight(date: str, order: DateOrder | None) -> float | None:
    if (found := _DATE.fullmatch(date)) is None:
        return None
    if found["first"]:
        if order is None:
            return None
        pair = found["first"], found["then"]
        day, month = pair if order is DateOrder.DAY_FIRST else pair[::-1]
        year = found["last"]
    else:
        kind = next(kind for kind in ("", "dotted_", "named_") if found[f"{kind}year"])
        year, month, day = (found[f"{kind}{part}"] for part in ("year", "month", "day"))
    number = _MONTHS.index(month.lower()) + 1 if month.isalpha() else int(month)
    try:
        return datetime(int(year) + (2000 if len(year) == 2 else 0), number, int(day), tzinfo=UTC).timestamp()
    except (ValueError, OverflowError):
        return None


def _clock(
    hour: str,
    minute: str,
    second: str | None,
    fraction: str | None,
    ms: str | None,
    half: str | None,
    *,
    hours: int,
) -> float | None:
    """Return the seconds since midnight, None of an hour from ``hours`` on, or of no half day."""
    h = int(hour)
    if half:
        if not 1 <= h <= 12:
            return None
        h = h % 12 + (12 if half in "pP" else 0)
    if h >= hours:
        return None
    return h * S_PER_H + int(minute) * 60 + float(f"{second or 0}.{fraction or ms or 0}")


def _zone(text: str | None) -> float:
    if text is None or text.upper() in {"Z", "UTC"}:
        return 0.0
    digits = text[1:].replace(":", "")
    seconds = int(digits[:2]) * S_PER_H + int(digits[2:]) * 60
    return -seconds if text.startswith("-") else seconds
