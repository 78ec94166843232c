"""Options that several commands share."""

from math import isfinite
from typing import Annotated

import typer

Latitude = Annotated[
    float | None,
    typer.Option("--latitude", metavar="DEG", min=-90, max=90, help="Subtract the Earth's rate at this latitude."),
]
Heading = Annotated[
    float | None,
    typer.Option("--heading", metavar="DEG", min=-360, max=360, help="True heading of forward, at the start."),
]


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
