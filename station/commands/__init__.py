"""The commands of `station`, one file each; a line here puts a command on the list.

A command's file defines a function of the command's name (``-`` written ``_``) with typer annotations and a
`Database` option. It imports what is heavy inside that function, not at its top.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True, slots=True)
class Command:
    """A command's name, one line of help, and the module that is imported when it is asked for."""

    name: str
    help: str
    module: str


COMMANDS = (
    Command("solve", "Solve recorded campaigns for a calibration with 1 sigma.", "station.commands.solve"),
    Command("verify", "Hash every recorded file again and compare.", "station.commands.verify"),
)

Database = Annotated[
    Path | None,
    typer.Option("--db", envvar="STATION_DB", metavar="FILE", help="SQLite file of fixtures and calibrations."),
]
