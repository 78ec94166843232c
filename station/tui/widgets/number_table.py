"""The numbers of a verdict in columns; where the screen is too narrow for all, a row's limit stands below it."""

from collections.abc import Iterable

from textual.content import Content
from textual.geometry import Size

from station.guide.view import VerdictRow
from station.tui.widgets.redrawn_on_change import ValueWidget
from station.tui.widgets.verdict_sentence import VERDICT_LOOKS

TABLE_HEADER = ("parameter", "value", "U (95 %)", "u", "unit", "verdict", "limit", "change")
RIGHT_COLUMNS = (1, 2, 3, 7)  # columns of numbers
STD, VERDICT = TABLE_HEADER.index("u"), TABLE_HEADER.index("verdict")
GAP, INDENT = "  ", "    "


class NumberTable(ValueWidget[tuple[VerdictRow, ...]]):
    """As high as it needs and as wide as there is room; put it where it can be scrolled down."""

    DEFAULT_CSS = "NumberTable { width: 100%; height: auto; padding: 0 2; }"

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return how many lines there are at a width."""
        return len(_table(self.value or (), width))

    def _drawn(self, rows: tuple[VerdictRow, ...]) -> Content:
        return Content("\n").join(_table(rows, self.content_size.width))


def _table(rows: tuple[VerdictRow, ...], width: int) -> list[Content]:
    looks = [VERDICT_LOOKS.get(row.verdict, ("", "")) for row in rows]
    cells = [TABLE_HEADER, *(_cells(row, symbol) for row, (symbol, _) in zip(rows, looks, strict=True))]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    draw = _line if sum(widths) + len(GAP) * (len(widths) - 1) <= width else _stacked
    colours = ["", *(colour for _, colour in looks)]
    return [line for row, colour in zip(cells, colours, strict=True) for line in draw(row, widths, colour, width)]


def _line(cells: tuple[str, ...], widths: list[int], colour: str, _: int) -> list[Content]:
    """Draw a row in one line."""
    if cells is TABLE_HEADER:
        return [_aligned(cells, widths, range(len(TABLE_HEADER))).stylize("bold $muted")]
    before, after = (_aligned(cells, widths, part) for part in (range(VERDICT), range(VERDICT + 1, len(cells))))
    return [
        Content(GAP).join([before, Content.styled(cells[VERDICT].ljust(widths[VERDICT]), f"bold {colour}"), after])
    ]


def _stacked(cells: tuple[str, ...], widths: list[int], colour: str, width: int) -> list[Content]:
    """Draw the numbers of a row in one line, verdict, limit and change below as far as it has any.

    u is omitted where it does not fit: U is shown.
    """
    numbers = _aligned(cells, widths, range(VERDICT))
    if numbers.cell_length > width:
        numbers = _aligned(cells, widths, [column for column in range(VERDICT) if column != STD])
    if cells is TABLE_HEADER:
        return [numbers.stylize("bold $muted")]
    verdict, limit, change = cells[VERDICT:]
    said = [
        Content.assemble((verdict, f"bold {colour}"), f"{GAP}limit {limit}") if verdict else Content(""),
        Content(f"change {change}" if change else ""),
    ]
    parts = [part for part in said if part]
    together = Content(GAP).join(parts)
    below = [together] if len(INDENT) + together.cell_length <= width else parts
    return [numbers, *(Content(INDENT) + line for line in below if line)]


def _aligned(cells: tuple[str, ...], widths: list[int], columns: Iterable[int]) -> Content:
    return Content(
        GAP.join(cells[k].rjust(widths[k]) if k in RIGHT_COLUMNS else cells[k].ljust(widths[k]) for k in columns)
    )


def _cells(row: VerdictRow, symbol: str) -> tuple[str, ...]:
    verdict = f"{symbol} {row.verdict.replace('_', ' ')}".strip()
    return row.name, row.value, row.expanded, row.sigma, row.unit, verdict, row.limit, row.change
