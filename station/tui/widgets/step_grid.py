"""All steps of a campaign by face: two headings each, and the turns of each axis below."""

from dataclasses import dataclass

from textual.content import Content

from procedures.positions import POSITIONS, face_of, position_name
from station.guide.view import StepState, StepView
from station.tui.widgets.common import ValueWidget
from station.tui.widgets.cube import is_counter_clockwise, start_of

FACE_COLUMNS = ("X up", "X down", "Y up", "Y down", "Z up", "Z down")
TURNS = 2  # the row of the turns
ROWS = 3
STEP_LOOKS: dict[StepState, tuple[str, str]] = {
    "todo": ("○", "$muted"),
    "live": ("●", "bold $accent"),
    "done": ("✓", "$success"),
    "redo": ("!", "$warning"),
}
GridCell = tuple[int, int]  # row, column


@dataclass(frozen=True, slots=True)
class GridCursor:
    """The steps, which one is wanted, and where the cursor stands."""

    steps: tuple[StepView, ...] = ()
    wanted: str = ""
    cursor: str = ""

    @property
    def places(self) -> dict[str, GridCell]:
        """The cell of each step: repeats, free positions and soaks stand in rows of their own below the faces'."""
        by_face = {step.name: cell_of(step) for step in self.steps if not _is_below(step)}
        others = [step.name for step in self.steps if _is_below(step)]
        first = (ROWS if any(step.axis for step in self.steps) else TURNS) if by_face else 0
        below = {name: (first + i // len(FACE_COLUMNS), i % len(FACE_COLUMNS)) for i, name in enumerate(others)}
        return by_face | below

    @property
    def rows(self) -> int:
        """How many rows there are, those that are not in sight too."""
        return max(ROWS, 1 + max((row for row, _ in self.places.values()), default=0))

    @property
    def top(self) -> int:
        """The first row in sight: the cursor's is."""
        return max(self.places.get(self.cursor, (0, 0))[0] - ROWS + 1, 0)

    def at(self, place: GridCell) -> StepView | None:
        """Return the step in a cell."""
        places = self.places
        return next((step for step in self.steps if places[step.name] == place), None)

    def neighbour(self, down: int, right: int) -> str:
        """Return the name of the next step in a direction; the cursor's own where there is none."""
        row, column = self.places.get(self.cursor, (0, 0))
        for _ in range(max(len(FACE_COLUMNS), self.rows)):
            row, column = (row + down) % self.rows, (column + right) % len(FACE_COLUMNS)
            if found := self.at((row, column)):
                return found.name
        return self.cursor

    def before(self) -> str:
        """Return the name of the step before the cursor, in the order suggested."""
        names = [step.name for step in self.steps]
        at = names.index(self.cursor) if self.cursor in names else 0
        return names[max(at - 1, 0)] if names else ""


class StepGrid(ValueWidget[GridCursor]):
    """A cell has two lines: number or turn, then symbol and word."""

    DEFAULT_CSS = "StepGrid { height: auto; }"

    def _drawn(self, value: GridCursor) -> Content:
        width = max(self.size.width // len(FACE_COLUMNS), 7)
        lines, before = list[Content](), ""
        for row in range(value.top, value.top + ROWS):
            if (header := _header(value.steps, row, width)) != before:
                lines.append(Content(header).stylize("$muted"))
            before = header
            cells = [_cell(value, (row, column), width) for column in range(len(FACE_COLUMNS))]
            lines += [Content("").join(cell[line] for cell in cells) for line in (0, 1)]
        return Content("\n").join(lines)


def _header(steps: tuple[StepView, ...], row: int, width: int) -> str:
    """Return what stands above a row: what is up in each column; both turns of an axis have the same."""
    has_turns = any(step.axis for step in steps)
    if row > TURNS or (row == TURNS and not has_turns) or (steps and all(_is_below(step) for step in steps)):
        return " " + ", ".join(dict.fromkeys(_kind_below(step) for step in steps if _is_below(step)))
    if row < TURNS:
        return "".join(f" {name}".ljust(width) for name in FACE_COLUMNS)
    ups = {step.axis: face_of(start_of(step)).partition("_")[2] for step in steps if step.axis}
    turns = {axis: f" turn {axis.upper()}, {axis.upper()} {up}" for axis, up in ups.items()}
    return "".join(turns.get(axis, "").ljust(2 * width) for axis in "xyz")


def _cell(grid: GridCursor, place: GridCell, width: int) -> tuple[Content, Content]:
    step = grid.at(place)
    if step is None:
        return Content(" " * width), Content(" " * width)
    symbol, colour = STEP_LOOKS[step.state]
    is_wanted = step.name == grid.wanted
    name = _counted(f"{'▶' if is_wanted else ' '}{_short(step)}", step.superseded, width)
    ground = " on $primary 45%" if step.name == grid.cursor else ""
    first = Content.assemble((name.ljust(width), ("bold $accent" if is_wanted else "bold") + ground))
    second = Content.assemble((f" {symbol} {step.state}".ljust(width), colour + ground))
    return first, second


def _counted(name: str, superseded: int, width: int) -> str:
    """Return a name with how often it was redone, as far as that fits: the words of the step say it as well."""
    if not superseded:
        return name
    dense = name[0] + name[1:].replace(" ", "")
    return next((text for each in (name, dense) if len(text := f"{each} +{superseded}") <= width), name)


def cell_of(step: StepView) -> GridCell:
    """Return the cell of a step."""
    if step.position:
        column, row = divmod(step.position - 1, 2)
        return row, column
    return TURNS, 2 * "xyz".index(step.axis) + (step.direction != "+")


def _is_below(step: StepView) -> bool:
    """Say whether a step has no cell of its own among faces and turns."""
    return bool(step.number or step.repeat or step.position > len(POSITIONS))


def _kind_below(step: StepView) -> str:
    if step.repeat:
        return "r: repeats"
    if step.position > len(POSITIONS) and not step.number:
        return "where X, Y, Z point"
    return "s: soaks" if step.is_soak else "m: monitors" if step.is_monitor else "free positions"


def _short(step: StepView) -> str:
    if step.number:
        return f"{'s' if step.is_soak else 'm' if step.is_monitor else ''}{step.number}"
    if step.position:
        return f"{'r' * bool(step.repeat)}{position_name(step.position)}"
    return f"{'↺' if is_counter_clockwise(step) else '↻'} {step.axis.upper()}{step.direction}"
