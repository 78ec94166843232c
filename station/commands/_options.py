"""Options that several commands share, how wrong values are refused, and where a result goes."""

import inspect
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import is_dataclass
from functools import wraps
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

import typer

if TYPE_CHECKING:
    from sqlalchemy.orm import Session


def option(metavar: str, text: str, names: str = "", **more: Any) -> Any:
    """Return typer's option, by default of the parameter's name; ``metavar`` is empty where typer's will do."""
    return typer.Option(*names.split(), metavar=metavar or None, help=text or None, **more)


def flag(names: str, text: str) -> Any:
    """Return typer's option of a yes or no."""
    return typer.Option(names, help=text)


def argument(metavar: str, text: str, **more: Any) -> Any:
    """Return typer's argument."""
    return typer.Argument(metavar=metavar or None, help=text or None, **more)


def day_option(text: str, names: str = "") -> Any:
    """Return typer's option of a date."""
    return option("DATE", text, names, formats=["%Y-%m-%d"])


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has an option for each field of its groups, the parameters that are dataclasses.

    ``Annotated[Group, names]`` offers the fields of these names only; the others keep their defaults.
    """
    shown, groups = list[inspect.Parameter](), dict[str, tuple[Any, list[str]]]()
    for each in inspect.signature(command).parameters.values():
        is_annotated = get_origin(each.annotation) is Annotated
        group, chosen = get_args(each.annotation)[:2] if is_annotated else (each.annotation, ())
        if not is_dataclass(group):
            shown.append(each)
            continue
        fields = inspect.signature(group).parameters  # type: ignore[arg-type]
        groups[each.name] = group, [name for name in fields if not chosen or name in chosen]
        shown += [fields[name] for name in groups[each.name][1]]

    @wraps(command)
    def grouped(**given: Any) -> None:
        made = {name: group(**{n: given.pop(n) for n in fields}) for name, (group, fields) in groups.items()}
        command(**given, **made)

    grouped.__signature__ = inspect.Signature([  # type: ignore[attr-defined]
        each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in shown
    ])  # fmt: skip
    grouped.__annotations__ = {each.name: each.annotation for each in shown}
    return grouped


Latitude = Annotated[float | None, option("DEG", "Subtract the Earth's rate at this latitude.", min=-90, max=90)]
Heading = Annotated[float | None, option("DEG", "True heading of forward, at the start.", min=-360, max=360)]
OfModel = Annotated[str, option("MODEL", "The IMU model.")]
OfSerial = Annotated[str | None, option("SERIAL", "One unit of it; else all.")]
Effects = Annotated[
    list[Path] | None, option("FILE", "An error term (effect/1) to include in the model; repeatable.")
]
Gnss = Annotated[str, option("URL", "A GNSS receiver, as in mavlink:udpin:0.0.0.0:14550.")]
Model = Annotated[str, option("", "For a device that does not send its own.")]
Serial = Model
Axes = Annotated[str, option("F,R,D", "Which IMU axes point forward, right, down.")]
Seconds = Annotated[float, option("S", "Device time after which it ends.", min=0.0)]
Speed = Annotated[float, option("N", "Of a replay; 0: as fast as it can.", min=0.0)]
Plain = Annotated[bool, flag("--plain", "Lines of text instead of a screen.")]
Slow = Annotated[bool, flag("--slow", "Update twice per second, for a slow console.")]
Quiet = Annotated[bool, flag("--quiet", "No sounds.")]
Noise = Annotated[
    list[Path] | None, option("CAMPAIGN", "A campaign of the unit that shows its noise; repeatable.")
]


def lengths(text: str) -> tuple[float, ...]:
    """Return three lengths [m], none of an empty text.

    Raise `ValueError` if the text is neither.
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


def refuse_other_than_toml(plan: Path | None, name: str) -> None:
    """Raise `typer.BadParameter` where a plan, which is TOML, would have the name of another format."""
    if plan is not None and plan.suffix.lower() != ".toml":
        found = f"found {plan.name!r}, expected a name that ends in .toml: a plan is a TOML file"
        raise typer.BadParameter(found, param_hint=name)


@contextmanager
def reading(db: str | None) -> Iterator["Session"]:
    """Yield a session that reads a database."""
    from fixtures_db.database import open_db

    with open_db(db) as database, database.read() as session:
        yield session


@contextmanager
def writing(db: str | None, file: Path | None = None) -> Iterator["Session"]:
    """Yield a session that is committed at its end; an impossible value is refused: of a ``file`` or of usage."""
    from fixtures_db.database import open_db
    from fixtures_db.errors import DatabaseError
    from station.errors import DataRefused

    try:
        with open_db(db) as database, database.write() as session:
            yield session
    except ValueError as error:
        if isinstance(error, DatabaseError | DataRefused):
            raise
        if file is None:
            raise typer.BadParameter(str(error)) from error
        raise DataRefused(file, None, str(error), "possible values") from error


def end_on_signals() -> None:
    """End by `KeyboardInterrupt` on the signals of Ctrl-C and of a service's stop."""
    for ending in (signal.SIGINT, signal.SIGTERM):  # the first is ignored in a shell's background otherwise
        signal.signal(ending, signal.default_int_handler)


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
