"""The numbers of a verdict in columns; where the screen is too narrow for all, a row's limit stands below it."""

from collections.abc import Iterable

from textual.content import Content
from textual.geometry import Size

from station.guide.view import VerdictRow
from station.tui.widgets.redrawn_on_change import ValueWidget
from station.tui.widgets.verdict_sentence import VERDICT_LOOKS

TABLE_HEADER = ("parameter", "value", "U (95 %)", "1 sigma", "unit", "verdict", "limit", "change")
RIGHT_COLUMNS = (1, 2, 3, 7)  # columns of numbers
SIGMA, VERDICT = TABLE_HEADER.index("1 sigma"), TABLE_HEADER.index("verdict")
GAP, INDENT = "  ", "    "


class NumberTable(ValueWidget[tuple[VerdictRow, ...]]):
    """As high as it needs and as wide as there is room; put it where it can be scrolled down."""

    DEFAULT_CSS = """
    NumberTable { width: 100%; height: auto; padding: 0 2; }
    """

    def __init__(self) -> None:
        super().__init__((), id="numbers")

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return how many lines there are at a width."""
        return len(self._lines(width))

    def render(self) -> Content:
        """Draw header and rows."""
        return Content("\n").join(self._lines(self.content_size.width))

    def _lines(self, width: int) -> list[Content]:
        rows = [TABLE_HEADER, *(_cells(row) for row in self.value)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(TABLE_HEADER))]
        is_wide = sum(widths) + len(GAP) * (len(widths) - 1) <= width
        draw = _line if is_wide else _stacked
        colours = ["", *(_colour(row) for row in self.value)]
        lines = [draw(row, widths, colour, width) for row, colour in zip(rows, colours, strict=True)]
        return [line for each in lines for line in each]


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

    1 sigma is left out where it does not fit: U says as much.
    """
    numbers = _aligned(cells, widths, range(VERDICT))
    if numbers.cell_length > width:
        numbers = _aligned(cells, widths, [column for column in range(VERDICT) if column != SIGMA])
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


def _colour(row: VerdictRow) -> str:
    return VERDICT_LOOKS[row.verdict][1] if row.verdict in VERDICT_LOOKS else ""


def _cells(row: VerdictRow) -> tuple[str, ...]:
    symbol = VERDICT_LOOKS[row.verdict][0] if row.verdict in VERDICT_LOOKS else ""
    verdict = f"{symbol} {row.verdict.replace('_', ' ')}".strip()
    return row.name, row.value, row.expanded, row.sigma, row.unit, verdict, row.limit, row.change
