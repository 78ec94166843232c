"""Moments as a text log writes them: ISO 8601 with or without a zone, or hours:minutes:seconds of a clock."""

import re
from datetime import UTC, datetime

from procedures.units import S_PER_H

_ISO = re.compile(
    r"(\d{4})[-/](\d\d)[-/](\d\d)[T ](\d\d:\d\d:\d\d)(?:[.,](\d{1,9}))?\s?(Z|UTC|[+-]\d\d:?\d\d)?", re.ASCII
)
_CLOCK = re.compile(r"(\d{1,3}):([0-5]\d):([0-5]\d)(?:[.,](\d{1,9}))?", re.ASCII)


def moment(cell: str) -> float | None:
    """Return the seconds since 1970 of a date and time (UTC where no zone is told), or since midnight of a clock.

    None of what is neither.
    """
    if found := _CLOCK.fullmatch(cell):
        hours, minutes, seconds, fraction = found.groups()
        return int(hours) * S_PER_H + int(minutes) * 60 + float(f"{seconds}.{fraction or 0}")
    if (found := _ISO.fullmatch(cell)) is None:
        return None
    year, month, day, clock, fraction, zone = found.groups()
    zone = "+00:00" if zone in {None, "Z", "UTC"} else zone
    try:
        whole = datetime.fromisoformat(f"{year}-{month}-{day}T{clock}{zone}").astimezone(UTC).timestamp()
    except (ValueError, OverflowError):
        return None
    return whole + float(f"0.{fraction or 0}")
