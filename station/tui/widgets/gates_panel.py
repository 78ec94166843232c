"""The two gates, apart: is it the right face, and is it still."""

from dataclasses import dataclass

from textual.content import Content

from station.guide.view import GatesView
from station.tui.bars import bar
from station.tui.durations_in_words import beside_limit
from station.tui.widgets.redrawn_on_change import ValueWidget

OTHER_FACE_DEG = 45.0  # deg, beyond which another face is the one that is up
CORNER_DEG = 54.74  # deg a corner's way is from three faces
NUMBER_COLUMNS = 22  # columns of the numbers on the right


class GatesPanel(ValueWidget[GatesView]):
    """A line for each gate: name, symbol and word, bar against the limit, numbers."""

    DEFAULT_CSS = "GatesPanel { height: 2; }"

    def render(self) -> Content:
        """Draw both; while the cube is turned, or before there are counts, neither is judged."""
        gates = self.value
        if gates is None:
            unknown = ("… not judged now", "$muted")
            return Content.assemble((" FACE  ", "bold"), unknown, ("\n STILL ", "bold"), unknown)
        room = self.size.width - 17 - NUMBER_COLUMNS
        up = f"{gates.face.replace('_', ' ').capitalize()}, " if gates.face else ""
        channel = gates.still_channel.replace("accelerometer", "accel").replace("gyroscope", "gyro")
        is_tilted = gates.limit_deg < gates.off_deg < OTHER_FACE_DEG
        word = "tilted" if is_tilted else "wrong" if gates.off_deg > gates.limit_deg else "other"
        if gates.is_right_face:
            word = "right" if gates.is_wanted_face else "may do"
        if gates.is_free:
            word = "apart" if gates.is_right_face else "near"
            far = f"{gates.off_deg:.0f} deg from {gates.face.replace('_', ' ')}"
            return Content("\n").join(
                (_Gate("FREE", word, gates.is_right_face, gates.off_deg / CORNER_DEG, far).drawn(room),
                 _still(gates, channel).drawn(room))
            )  # fmt: skip
        face = _Gate("FACE", word, gates.is_right_face,
                     gates.off_deg / gates.limit_deg if gates.is_right_face else 1.0,
                     up + beside_limit(gates.off_deg, gates.limit_deg, "deg"))  # fmt: skip
        return Content("\n").join((face.drawn(room), _still(gates, channel).drawn(room)))


@dataclass(frozen=True, slots=True)
class _Gate:
    name: str
    word: str
    is_open: bool
    fraction: float  # of the limit
    numbers: str

    def drawn(self, room: int) -> Content:
        colour = "$success" if self.is_open else "$error"
        return Content.assemble(
            (f" {self.name:6}", "bold"), (f"{'✓' if self.is_open else '✗'} {self.word:7}", f"bold {colour}"),
            bar(self.fraction, max(room, 3), colour), f" {self.numbers:>{NUMBER_COLUMNS - 1}}",
        )  # fmt: skip


def _still(gates: GatesView, channel: str) -> _Gate:
    return _Gate("STILL", "still" if gates.is_still else "moving", gates.is_still,
                 gates.still / gates.still_limit,
                 beside_limit(min(gates.still, 9999.0), gates.still_limit, f"noise {channel}"))  # fmt: skip
