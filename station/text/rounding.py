"""Numbers as people read them: rounded by their sigma, aligned on the decimal point.

Two significant digits of the standard uncertainty, and the value to the same place (JCGM 100:2008, 7.2.6).
"""

import math
from collections.abc import Sequence

MINUS, FIGURE_SPACE, POINT_SPACE = "\u2212", "\u2007", "\u2008"
_MOST_DECIMALS = 15


def decimals(std: float) -> int:
    """Return the decimals that show two significant digits of ``std``; negative left of the point."""
    if not (math.isfinite(std) and std > 0):
        return 6
    exponent = math.floor(math.log10(float(f"{std:.1e}")))
    return min(1 - exponent, _MOST_DECIMALS)


def fixed(value: float, places: int, sign: bool = False) -> str:
    """Return a number with ``places`` decimals (left of the point where negative) and a real minus sign."""
    if not math.isfinite(value):
        return "\u2013"
    rounded = round(value, places) + 0.0  # + 0.0: no minus zero
    return f"{rounded:{'+' if sign else ''}.{max(places, 0)}f}".replace("-", MINUS)


def significant(value: float, digits: int = 2) -> str:
    """Return a number with so many significant digits, in powers of ten where it is very large or small."""
    if value == 0 or not math.isfinite(value):
        return fixed(value, 0)
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if -5 < exponent < 6:
        return fixed(value, digits - 1 - exponent)
    return f"{fixed(value / 10.0**exponent, digits - 1)}\u00b7{power_of_ten(exponent)}"


def power_of_ten(exponent: int) -> str:
    """Return 10 with its exponent raised."""
    return f"10{str(exponent).translate(_SUPERSCRIPT)}"


def aligned(numbers: Sequence[str]) -> list[str]:
    """Return numbers padded on the right so that, set flush right in tabular figures, their points meet."""
    tails = [len(number.partition(".")[2]) for number in numbers]
    longest = max(tails, default=0)
    padded = []
    for number, tail in zip(numbers, tails, strict=True):
        point = POINT_SPACE if longest and not tail else ""
        padded.append(number + point + FIGURE_SPACE * (longest - tail))
    return padded


_SUPERSCRIPT = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
