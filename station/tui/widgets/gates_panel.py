"""The two gates, apart: is it the right face, and is it still."""

from textual.content import Content

from station.guide.view import Gates
from station.tui.bars import bar
from station.tui.spoken import against
from station.tui.widgets.drawn import Drawn

NUMBERS = 20  # columns of the numbers on the right


class GatesPanel(Drawn[Gates | None]):
    """A line for each gate: name, symbol and word, bar against the limit, numbers."""

    DEFAULT_CSS = """
    GatesPanel { height: 2; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="gates")

    def render(self) -> Content:
        """Draw both; without counts both are unknown."""
        gates = self.value
        if gates is None:
            return Content("\n").join(_unknown(name) for name in ("FACE", "STILL"))
        room = self.size.width - 17 - NUMBERS
        face = against(gates.off_deg, gates.limit_deg, "deg")
        still = against(gates.still, gates.still_limit, f"noise {gates.still_channel}")
        word = "right" if gates.is_right_face else "wrong"
        return Content("\n").join((
            _gate("FACE", word, gates.is_right_face, gates.off_deg / gates.limit_deg, face, room),
            _gate("STILL", "still" if gates.is_still else "moving", gates.is_still,
                  gates.still / gates.still_limit, still, room),
        ))  # fmt: skip


def _gate(name: str, word: str, is_open: bool, fraction: float, numbers: str, room: int) -> Content:
    colour = "$success" if is_open else "$error"
    filled, empty = bar(fraction, max(room, 4))
    return Content.assemble(
        (f" {name:6}", "bold"), (f"{'✓' if is_open else '✗'} {word:7}", f"bold {colour}"),
        (filled, colour), (empty, "on $foreground 12%"), (f"{numbers:>{NUMBERS - 1}} ", ""),
    )  # fmt: skip


def _unknown(name: str) -> Content:
    return Content.assemble((f" {name:6}", "bold"), ("… no counts now", "$muted"))
