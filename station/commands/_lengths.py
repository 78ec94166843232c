"""Three lengths on a command line: ``X,Y,Z`` in m."""

from math import isfinite


def lengths(text: str) -> tuple[float, ...]:
    """Return three lengths [m], none of an empty text.

    Raises
    ------
    ValueError
        If the text is neither.
    """
    try:
        found = tuple(float(part) for part in text.split(",")) if text else ()
    except ValueError:
        found = (0.0,)
    if len(found) not in {0, 3} or not all(map(isfinite, found)):
        raise ValueError(f"found {text!r}, expected three lengths X,Y,Z in m")
    return found
