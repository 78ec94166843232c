"""Options that several commands share, how wrong values are refused, and where a result goes."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer


def option(names: str, metavar: str, text: str, **more: Any) -> Any:
    """Return typer's option; ``names`` are parted by blanks, ``metavar`` is empty where typer's own will do."""
    return typer.Option(*names.split(), metavar=metavar or None, help=text or None, **more)


def argument(metavar: str, text: str, **more: Any) -> Any:
    """Return typer's argument."""
    return typer.Argument(metavar=metavar or None, help=text or None, **more)


def day_option(names: str, text: str) -> Any:
    """Return typer's option of a date."""
    return option(names, "DATE", text, formats=["%Y-%m-%d"])


Latitude = Annotated[
    float | None, option("--latitude", "DEG", "Subtract the Earth's rate at this latitude.", min=-90, max=90)
]
Heading = Annotated[
    float | None, option("--heading", "DEG", "True heading of forward, at the start.", min=-360, max=360)
]


OfModel = Annotated[str, option("--model", "MODEL", "The IMU model.")]
OfSerial = Annotated[str | None, option("--serial", "SERIAL", "One unit of it; else all.")]
Effects = Annotated[
    list[Path] | None, option("--effects", "FILE", "An error term (effect/1) to include in the model; repeatable.")
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


@contextmanager
def refused_as(name: str) -> Iterator[None]:
    """Take a `ValueError` as wrong usage of the option ``name``."""
    try:
        yield
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=name) from error


def write_result(document: Mapping[str, Any], text: str, file: Path | None, what: str) -> None:
    """Say a result as text; with a ``file`` write it there as JSON instead, and say ``what`` it is."""
    if file is None:
        typer.echo(text)
    else:
        from station.files.atomic_file import write_json

        write_json(file, document)
        typer.echo(f"{file}: {what}")


def signing_libraries(token: bool = False) -> None:
    """Raise `ExtraMissing` where what signs and checks certificates is not installed."""
    from importlib.util import find_spec

    from procedures.optional_libraries import ExtraMissing

    for name in ("lxml", "defusedxml", "signxml", "pyhanko", "rfc3161_client"):
        if find_spec(name) is None:
            raise ExtraMissing(name, "sign")
    if token and find_spec("pkcs11") is None:
        raise ExtraMissing("pkcs11", "token")
