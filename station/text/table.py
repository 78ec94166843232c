"""Rows of text as the lines of a table."""

from collections.abc import Iterable, Sequence
from io import StringIO

from rich.console import Console
from rich.table import Table

WIDTH = 80


def table_lines(rows: Iterable[Sequence[str]], align: str, header: Sequence[str]) -> list[str]:
    """Return rows as indented lines of at most 80 columns; a cell that is too long goes on in the next line.

    ``align`` has ``<`` for each column that is flush left and ``>`` for each that is flush right.
    """
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for side, title in zip(align, header, strict=True):
        table.add_column(title, justify="left" if side == "<" else "right", vertical="bottom")
    for row in rows:
        table.add_row(*row)
    console = Console(
        file=StringIO(), width=WIDTH - 2, color_system=None, markup=False, emoji=False, highlight=False
    )
    with console.capture() as text:
        console.print(table)
    return [f"  {line}".rstrip() for line in text.get().splitlines()]
