"""``station reset-terminal``: a terminal that a killed screen left behind."""

import typer

from station.commands import Database

# Each undoes one thing that a screen asks a terminal for; a terminal that does not know one ignores it.
ALTERNATE_SCREEN, HIDDEN_CURSOR, PASTE, FOCUS, RESIZE, AT_ONCE = "?1049", "?25", "?2004", "?1004", "?2048", "?2026"
MOUSE = ("?1000", "?1002", "?1003", "?1006", "?1015", "?1016")
OFF = (*MOUSE, PASTE, FOCUS, RESIZE, AT_ONCE, ALTERNATE_SCREEN)
KEYBOARD, PLAIN_LETTERS = "\x1b[<u", "\x1b[0m"
RESET = "".join(f"\x1b[{mode}l" for mode in OFF) + f"\x1b[{HIDDEN_CURSOR}h{KEYBOARD}{PLAIN_LETTERS}"


def reset_terminal(db: Database = None) -> None:
    """Restore a terminal after a screen of the station was killed: its own screen, cursor, mouse and echo.

    It does no harm to a terminal that works. --db, which every command has, is not used.

    Exit code 2 if there is no terminal.

    Example: station reset-terminal
    """
    import subprocess
    import sys

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise typer.BadParameter("this is no terminal; type it in the one that is to be restored")
    sys.stdout.write(RESET)
    sys.stdout.flush()
    subprocess.run(["stty", "sane"], check=False)
    typer.echo("the terminal is restored; `station resume` goes on with a campaign that was under way")
