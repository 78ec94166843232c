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


_FRACTION = r"(?:[.,](?P<fraction>\d{1,9})|:(?P<ms>\d{3}))?"
_HALF = r"(?:\s?(?P<half>[AP])M)?"
_CLOCK = re.compile(
    rf"(?P<hour>\d{{1,3}}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d){_FRACTION}{_HALF}", re.ASCII | re.IGNORECASE
)
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_DATE = (
    r"(?:(?P<year>\d{4})(?P<by>[-/.])(?P<month>\d\d?)(?P=by)(?P<day>\d\d?)"
    r"|(?P<first>\d\d?)(?P<mark>[-/])(?P<then>\d\d?)(?P=mark)(?P<last>\d{4})"
    r"|(?P<dotted_day>\d\d?)\.(?P<dotted_month>\d\d?)\.(?P<dotted_year>\d{4}|\d\d)"
    rf"|(?P<named_day>\d\d?)[- ](?P<named_month>{'|'.join(_MONTHS)})[- ](?P<named_year>\d{{4}}))"
)
_MOMENT = re.compile(
    rf"{_DATE}(?:T|_|,?\s+)(?P<hour>\d\d?):(?P<minute>[0-5]\d)(?::(?P<second>[0-5]\d){_FRACTION})?{_HALF}"
    r"\s?(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?",
    re.ASCII | re.IGNORECASE,
)
_COMPACT = re.compile(  # ISO 8601, basic format
    r"(?P<year>\d{4})(?P<month>\d\d)(?P<day>\d\d)[T_ ](?P<hour>\d\d)(?P<minute>[0-5]\d)(?P<second>[0-5]\d)"
    r"(?:[.,](?P<fraction>\d{1,9}))?(?P<zone>Z|[+-]\d\d:?\d\d)?",
    re.ASCII,
)


def moment(cell: str, order: DateOrder | None = None) -> float | None:
    """Return the seconds since 1970 of a date and time (UTC without a zone), or since midnight of a clock.

    None of what is neither, and of a date whose day and month may be in either ``order`` where that is not known.
    """
    if found := _CLOCK.fullmatch(cell):
        return _clock(found.groupdict(), 1000)
    if (found := _MOMENT.fullmatch(cell) or _COMPACT.fullmatch(cell)) is None:
        return None
    parts = found.groupdict()
    day, clock = _day(parts, order), _clock(parts, 24)
    return None if day is None or clock is None else day - _zone(parts["zone"]) + clock


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


def _day(parts: dict[str, str | None], order: DateOrder | None) -> float | None:
    if parts.get("first"):
        if order is None:
            return None
        pair = (parts["first"], parts["then"])
        day, month = pair if order is DateOrder.DAY_FIRST else pair[::-1]
        return _midnight(parts["last"] or "", month or "", day or "")
    for kind in ("", "dotted_", "named_"):
        if year := parts.get(f"{kind}year"):
            return _midnight(year, parts[f"{kind}month"] or "", parts[f"{kind}day"] or "")
    return None


@lru_cache(maxsize=64)  # a log has few days
def _midnight(year: str, month: str, day: str) -> float | None:
    number = _MONTHS.index(month.lower()) + 1 if month.isalpha() else int(month)
    try:
        return datetime(int(year) + (2000 if len(year) == 2 else 0), number, int(day), tzinfo=UTC).timestamp()
    except (ValueError, OverflowError):
        return None


def _clock(parts: dict[str, str | None], hours: int) -> float | None:
    """Return the seconds since midnight, None of an hour from ``hours`` on, or of no half day."""
    hour = int(parts["hour"] or 0)
    if half := parts.get("half"):
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if half in "pP" else 0)
    if hour >= hours:
        return None
    fraction = float(f"0.{parts.get('fraction') or parts.get('ms') or 0}")
    return hour * S_PER_H + int(parts["minute"] or 0) * 60 + int(parts["second"] or 0) + fraction


def _zone(text: str | None) -> float:
    if text is None or text.upper() in {"Z", "UTC"}:
        return 0.0
    digits = text[1:].replace(":", "")
    seconds = int(digits[:2]) * S_PER_H + int(digits[2:]) * 60
    return -seconds if text.startswith("-") else seconds
