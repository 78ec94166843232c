"""Options of a command line as the tables of a ``campaign.toml``."""

from typing import TypeVar

import typer
from pydantic import BaseModel, ValidationError

T = TypeVar("T", bound=BaseModel)


def checked(table: type[T], **options: object) -> T:
    """Return ``table`` of the options given; one out of its range is wrong usage."""
    try:
        return table(**options)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        name = ".".join(str(part) for part in fault["loc"])
        expected = fault["msg"].removeprefix("Input should be ")
        raise typer.BadParameter(f"{name} {fault['input']}: expected {expected}") from None
