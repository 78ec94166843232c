"""The names of a text log's columns, of the lines above its table: a header, and a row of units below it."""

import re
from collections.abc import Callable, Iterator, Sequence

from station.files.output_units import is_unit

COMMENT = ("#", "%", "//")


def column_names(
    above: Sequence[str],
    cells_of: Callable[[str], list[str]],
    is_number: Callable[[str], bool],
    count: int,
    ends_empty: bool = False,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of columns where the line above the table is a header, else numbers from 1; and remarks.

    Rows have ``count`` cells; ``ends_empty``: the last of each is empty, and is no column unless it has a name. A
    row of units between the two is put into brackets behind the names.
    """
    lines = [cells_of(_plain(line)) for line in above if line.strip()][-2:]
    lines = [cells[:-1] if len(cells) == count + 1 and not cells[-1] else cells for cells in lines]
    if ends_empty and not (lines and len(lines[-1]) == count and lines[-1][-1]):
        count -= 1
        lines = [cells[:-1] if len(cells) == count + 1 and not cells[-1] else cells for cells in lines]
    headers = [
        cells for cells in reversed(lines) if len(cells) == count and 2 * sum(map(is_number, cells)) < count
    ]
    if not headers or headers[0] is not lines[-1]:
        numbers = tuple(str(i + 1) for i in range(count))
        is_header = lines and len(lines[-1]) > 1 and not any(map(is_number, lines[-1]))
        return numbers, (f"{len(lines[-1])} names above rows of {count} cells: not used",) if is_header else ()
    names = headers[0]
    if len(headers) == 2 and _are_units(names):
        units = [re.sub(r"^[\[(](.*)[\])]$", r"\1", unit) for unit in headers[0]]
        pairs = zip(headers[1], units, strict=True)
        names = [f"{name} [{unit}]" if unit not in {"", "-"} else name for name, unit in pairs]
    return tuple(_unique([name or str(i + 1) for i, name in enumerate(names)])), ()


def _plain(line: str) -> str:
    line = line.strip().lstrip("\ufeff\0")
    for mark in COMMENT:
        line = line.removeprefix(mark)
    return line.strip()


def _are_units(cells: Sequence[str]) -> bool:
    """Say whether more than half of the cells that say anything are units."""
    told = [re.sub(r"^[\[(](.*)[\])]$", r"\1", cell) for cell in cells if cell not in {"", "-"}]
    return bool(told) and 2 * sum(map(is_unit, told)) > len(told)


def _unique(names: Sequence[str]) -> Iterator[str]:
    seen = list[str]()
    for name in names:
        seen.append(name)
        yield name if seen.count(name) == 1 else f"{name}_{seen.count(name)}"
