"""How rows of a text are parted: delimiter, decimal mark, names and units of columns, which of them are dates."""

import csv
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.output_units import OTHER_QUANTITIES, is_unit, unit_named
from station.files.tables.dates import DateOrder, date_order, may_be_moment, moment

COMMENT = ("#", "%", "//")
_REMARK = re.compile(r"(?:comment|remark|note|kommentar|bemerkung)?s?", re.IGNORECASE)  # LabVIEW's .lvm


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
    lines = [_without_remark(cells_of(_plain(line)), count) for line in above if line.strip()][-2:]
    if ends_empty and not (lines and len(lines[-1]) == count and lines[-1][-1]):
        count -= 1
        lines = [_without_remark(cells, count) for cells in lines]
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


def _without_remark(cells: list[str], count: int) -> list[str]:
    """Return names without those at the end that are empty, or of remarks, and that the rows do not have."""
    more = cells[count:]
    return cells[:count] if all(_REMARK.fullmatch(cell) for cell in more) else cells


def _plain(line: str) -> str:
    """Return a line above the table without the mark of a comment; empty cells at its ends stay."""
    line = line.strip(" \r\n\ufeff\0")
    for mark in COMMENT:
        line = line.removeprefix(mark).lstrip() if line.startswith(mark) else line
    return line


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether more than half of the cells that say anything are units."""
    stated = [re.sub(r"^[\[(](.*)[\])]$", r"\1", cell) for cell in cells if cell not in {"", "-"}]
    known = [is_unit(cell) or (len(cell) > 1 and unit_named(cell) in OTHER_QUANTITIES) for cell in stated]
    return 2 * sum(known) > len(stated)


def _unique(names: Sequence[str]) -> Iterator[str]:
    seen = list[str]()
    for name in names:
        seen.append(name)
        yield name if seen.count(name) == 1 else f"{name}_{seen.count(name)}"


LOOKED_AT = 200  # lines in which the table must begin
SAME_LINES = 6  # lines of one shape that make a table
DELIMITERS = (",", ";", "\t", "|", None)  # None: blanks
MISSING = frozenset({"", "-", "--", "?", "na", "n/a", "#n/a", "null", "none", "missing"})
DISTINCT = 100  # cells with as many decimals each: printed so, where trailing zeros are dropped 1 in 10 has fewer
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?|[+-]?(?:nan|inf)", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?(?:[0-9]{1,3}(?:\.[0-9]{3})+|[0-9]*),[0-9]+(?:[eE][+-]?[0-9]+)?")
_COMMA_GROUPS = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+(\.[0-9]+)?")
_SURE_COMMA_GROUPS = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+(?:\.[0-9]+|(?<=,[0-9]{3},[0-9]{3}))")
_HEXADECIMAL = re.compile(r"\b0x[0-9a-f]+\b", re.IGNORECASE)
_DECIMALS = re.compile(r"[+-]?[0-9]*\.([0-9]+)")


@dataclass(frozen=True, slots=True)
class Layout:
    """How rows of a text are parted, the first of them, their names; ``numbers`` less text in the first rows.

    ``moments`` are the columns that hold dates or clocks, each with the order of its dates where that matters;
    ``decimals`` how many each column prints, None where that differs. ``all_numbers`` are those of all rows looked
    at.
    ``grouping`` is what separates thousands, empty where nothing does.
    """

    delimiter: str | None
    first: int
    names: tuple[str, ...]
    has_decimal_comma: bool
    numbers: int
    all_numbers: int
    moments: Mapping[int, DateOrder | None]
    decimals: tuple[int | None, ...] = ()
    grouping: str = ""
    notes: tuple[str, ...] = ()

    def cells(self, row: str) -> list[str]:
        """Return a row's cells; without an empty one too many, which a delimiter at the end makes."""
        found = cells_of(row, self.delimiter)
        return found[:-1] if len(found) == len(self.names) + 1 and not found[-1] else found

    def plain(self, cell: str) -> str:
        """Return a cell with a decimal point and without separators of thousands."""
        if self.grouping:
            cell = cell.replace(self.grouping, "")
        return cell.replace(",", ".") if self.has_decimal_comma else cell

    def number(self, cell: str) -> float | None:
        """Return a cell's number, None of what is none."""
        plain = self.plain(cell)
        return float(plain.lower().replace("d", "e")) if is_number(plain) else None


def is_row(line: str) -> bool:
    """Return whether a line is neither empty nor a comment."""
    return bool(line.strip()) and not line.lstrip().startswith(COMMENT)


def is_number(cell: str) -> bool:
    """Return whether a cell is a number with a decimal point, or nan."""
    return bool(_NUMBER.fullmatch(cell))


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return a line's cells; one in quotes may hold the delimiter."""
    if '"' in line and delimiter is not None:
        try:
            parted = next(csv.reader([line.strip("\0")], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:
            parted = line.split(delimiter)
    else:
        parted = line.split(delimiter)
    return [cell.strip().strip('"\0') for cell in parted]


def layout_of(lines: Sequence[str], file: Path) -> Layout:
    """Return the layout of lines with the most numbers, text counted against it.

    Raise `DataRefused` if no lines make a table, or commas part cells and decimals alike.
    """
    found = [layout for each in DELIMITERS for layout in _layouts(lines, each)]
    if not found:
        raise _no_table(lines, file)
    best = max(found, key=lambda each: (each.numbers, len(each.names), each.all_numbers))
    _refuse_commas_of_both_kinds(lines, best, file)
    return best


def _no_table(lines: Sequence[str], file: Path) -> DataRefused:
    """Return the refusal of lines that make no table, with what hides the numbers in them."""
    found, remedy = "no table", "name another file"
    written = [line.lstrip() for line in lines if line.strip()]
    marked = [line for line in written if line.startswith(COMMENT)]
    if 2 * len(marked) > len(written):
        mark = next(each for each in COMMENT if marked[0].startswith(each))
        found += f": {len(marked)} of {len(written)} lines begin with {mark}, as comments"
        remedy = f"remove the {mark} from rows of numbers, and part all cells by one delimiter"
    elif hexadecimal := next((match[0] for line in written if (match := _HEXADECIMAL.search(line))), ""):
        found += f": hexadecimal numbers, as {hexadecimal}"
        remedy = "write signed decimal numbers"
    return DataRefused(file, None, found, "rows of numbers, two at least", remedy, ErrorCode.TABLE)


def _layouts(lines: Sequence[str], delimiter: str | None) -> Iterator[Layout]:
    """Yield the first stretch of rows of one shape, or that goes to the end; with decimal commas or without."""
    at = [i for i, line in enumerate(lines) if is_row(line)]
    split = [cells_of(lines[i], delimiter) for i in at]
    for comma in (False, True):
        if comma and delimiter == "," and not any('"' in lines[i] for i in at):
            continue
        numbers_of = cache(lambda i, comma=comma: sum(_is_cell(cell, comma) for cell in split[i]))
        for k, cells in enumerate(split):
            rows = split[k : k + SAME_LINES]
            if len(rows) < min(SAME_LINES, 2) or any(len(row) != len(cells) for row in rows):
                continue
            numbers = [numbers_of(i) for i in range(k, k + len(rows))]
            if min(numbers) > 0 and 2 * numbers[0] >= max(numbers):
                yield _layout(lines, at, split, k, delimiter, comma=comma, numbers=sum(numbers))
                break


def _layout(
    lines: Sequence[str], at: Sequence[int], split: Sequence[list[str]], k: int, delimiter: str | None,
    *, comma: bool, numbers: int,
) -> Layout:  # fmt: skip
    """Return the layout of a table whose rows are of one shape from the ``k``-th on, and begin there or before."""
    rows = split[k : k + SAME_LINES]
    text = sum(bool(cell) for row in rows for cell in row) - numbers
    first = k
    while first and 2 * sum(_is_cell(cell, comma) for cell in split[first - 1]) > len(split[first - 1]) > 1:
        first -= 1  # a damaged row, and those before it
    count = len(split[k])
    above = lines[: at[first]]
    ends_empty = all(not row[-1] for row in rows) and count > 1
    names, mismatch = column_names(above, lambda line: cells_of(line, delimiter), is_number, count, ends_empty)
    looked = [row[: len(names)] for row in split[first:] if len(row) >= len(names)]
    dated = [i for i in range(len(names)) if all(may_be_moment(row[i]) for row in rows)]
    orders = {i: date_order([row[i] for row in looked]) for i in dated}
    moments = {i: order for i, order in orders.items() if moment(rows[0][i], order) is not None}
    grouping = _grouping([cell for row in looked for cell in row], comma=comma)
    is_decimal = comma and grouping != ","
    total = sum(_is_cell(cell, comma) for row in looked for cell in row)
    layout = Layout(
        delimiter, at[first], names, is_decimal, numbers - text, total, moments, (), grouping, mismatch
    )
    columns = [[layout.plain(row[i]) for row in looked] for i in range(len(names))]
    return replace(layout, decimals=tuple(_decimals(column) for column in columns))


def _is_cell(cell: str, comma: bool) -> bool:
    """Return whether a cell is a number or a moment; ``comma``: also one with a comma in it."""
    if is_number(cell) or may_be_moment(cell):
        return True
    return comma and bool(_DECIMAL_COMMA.fullmatch(cell) or _COMMA_GROUPS.fullmatch(cell))


def _grouping(cells: Sequence[str], *, comma: bool) -> str:
    """Return what separates thousands: ``1,234.5`` and ``1,234,567``, ``1.234,5``; empty where nothing does.

    ``998``, ``999``, ``1,000`` are thousands as well: a decimal comma would be in all of them.
    """
    if not comma:
        return ""
    with_comma = [cell for cell in cells if "," in cell and _is_cell(cell, comma) and not may_be_moment(cell)]
    if any(_SURE_COMMA_GROUPS.fullmatch(cell) for cell in with_comma):
        return ","
    if any("." in cell for cell in with_comma):
        return "."
    all_groups = with_comma and all(_COMMA_GROUPS.fullmatch(cell) for cell in with_comma)
    return "," if all_groups and any(len(cell) == 3 and cell.isdigit() for cell in cells) else ""


def _decimals(cells: Sequence[str]) -> int | None:
    """Return how many decimals a column prints, None where that is not always the same number."""
    found = [match for cell in cells if (match := _DECIMALS.fullmatch(cell))]
    if len({match[0] for match in found}) < DISTINCT:
        return None
    counts = [len(match[1]) for match in found]
    usual = max(set(counts), key=counts.count)
    return usual if len(cells) - counts.count(usual) <= max(1, len(cells) // 100) else None


def _refuse_commas_of_both_kinds(lines: Sequence[str], layout: Layout, file: Path) -> None:
    """Refuse ``0,5,9,81`` under two names: nobody can say which comma is which."""
    if layout.delimiter != "," or not layout.notes or "names" not in layout.notes[0]:
        return
    header = next((cells_of(lines[i], ",") for i in range(layout.first - 1, -1, -1) if is_row(lines[i])), [])
    if 2 * len(header) == len(layout.names):
        raise DataRefused(
            file, layout.first + 1, f"{len(layout.names)} cells under {len(header)} names, separated by commas",
            "one kind of comma", "save it with another delimiter, or with decimal points", ErrorCode.TABLE,
        )  # fmt: skip
