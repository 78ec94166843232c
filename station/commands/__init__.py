"""The commands of `station`; a line in `command_table` puts a command on the list.

A command is a function of its name (``-`` written ``_``) with typer annotations and a `Database` option, in a file
of that name or in that of its topic. It imports what is heavy inside, not at the file's top. A file with a table
``COMMANDS`` instead of such a function is a group of commands. Files that begin with ``_`` are shared options.
"""

from typing import Annotated

import typer

Database = Annotated[
    str | None,  # not a Path, which would make one slash of the four in sqlite:////var/lib/station.db
    typer.Option(
        "--db", envvar="STATION_DB", metavar="FILE", help="SQLite file, or URL, of fixtures and calibrations."
    ),
]
