"""The command ``station``: finds a command, runs it, and turns what it raises into an exit code and one line.

Exit codes: 0 done, 1 FAIL or altered, 2 wrong usage, 3 data refused, 4 device fault, 5 not observable,
130 cancelled. 70 is a bug of ours; ``STATION_TRACEBACK=1`` then shows where.
"""

import importlib
import os
import sys
from itertools import groupby
from types import ModuleType
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from station.commands._options import with_groups
from station.commands.command_table import COMMANDS, Command
from station.errors import CANCELLED, error_code, explain, one_line


class LazyGroup(TyperGroup):
    """A group whose commands are imported when they are asked for, so that ``--help`` stays quick."""

    table = COMMANDS

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order of the table."""
        return [command.name for command in self.table]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a command by its name; a module with a table instead of its function is a group of commands."""
        for command in self.table:
            if command.name == cmd_name:
                module = importlib.import_module(command.module)
                is_single = hasattr(module, command.function)
                return _single(command, module) if is_single else _group(command, module.COMMANDS)
        return None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by the table under their headings, importing none."""
        width = max(len(command.name) for command in self.table)
        for heading, commands in groupby(self.table, lambda command: command.group):
            with formatter.section(heading):
                formatter.write_dl([(command.name.ljust(width), command.help) for command in commands])


def _group(command: Command, table: tuple[Command, ...]) -> Any:
    kind = type("Group", (LazyGroup,), {"table": table})
    made = typer.Typer(name=command.name, cls=kind, add_completion=False, rich_markup_mode=None)
    made.callback(help=command.help)(lambda: None)
    return typer.main.get_command(made)


def _single(command: Command, module: ModuleType) -> Any:
    single = typer.Typer(add_completion=False, rich_markup_mode=None)
    single.command(command.name, short_help=command.help)(with_groups(getattr(module, command.function)))
    return typer.main.get_command(single)


app = typer.Typer(cls=LazyGroup, add_completion=False, rich_markup_mode=None, no_args_is_help=False)


def _print_version(is_asked: bool) -> None:
    if is_asked:
        from importlib.metadata import version

        typer.echo(f"station {version('fog-station')}")
        raise typer.Exit


VERBOSE = "--verbose"


@app.callback()
def _station(
    *,
    verbose: Annotated[
        bool, typer.Option(VERBOSE, help="Add its stable code to an error; may stand anywhere in the line.")
    ] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Say the version and exit.")
    ] = False,
) -> None:
    """Calibrate fibre-optic-gyro IMUs that output counts, and find what is wrong with any inertial sensor.

    `station COMMAND --help` shows what a command does, its units and an example. Every command takes --db
    (or STATION_DB).
    """


def main() -> None:
    """Run `station` and exit."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run a command line and return its exit code; what is refused is one line on stderr."""
    is_verbose = VERBOSE in arguments
    try:
        plain = [word for word in arguments if word != VERBOSE]
        result = app(plain, prog_name="station", standalone_mode=False)
        sys.stdout.flush()
    except BaseException as error:
        if isinstance(error.__context__ if isinstance(error, SystemExit) else error, BrokenPipeError):
            # whoever read our output has left, as `head` does; typer makes exit 1 of it
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        if os.environ.get("STATION_TRACEBACK"):
            raise
        code, line = explain(error)
        if is_verbose and line:
            stable = error_code(error)
            line = f"{line} [{stable}: {stable.meaning}]"
    else:
        code = result if isinstance(result, int) else 0  # typer hands a command's Exit back as its code
        line = "cancelled" if code == CANCELLED else ""  # ... and Ctrl-C as that of Exit(130)
    if line:
        sys.stderr.write(one_line(line) + "\n")
    return code
