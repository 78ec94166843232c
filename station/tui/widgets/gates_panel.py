"""The two gates, apart: is it the right face, and is it still."""

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
            unknown = ("… not checked now", "$muted")
            return Content.assemble((" FACE  ", "bold"), unknown, ("\n STILL ", "bold"), unknown)
        room = self.size.width - 17 - NUMBER_COLUMNS
        up = f"{gates.face.replace('_', ' ').capitalize()}, " if gates.face else ""
        channel = gates.still_channel.replace("accelerometer", "accel").replace("gyroscope", "gyro")
        is_tilted = gates.limit_deg < gates.off_deg < OTHER_FACE_DEG
        word = "tilted" if is_tilted else "wrong" if gates.off_deg > gates.limit_deg else "other"
        if gates.is_right_face:
            word = "right" if gates.is_wanted_face else "may do"
        name, numbers = "FACE", up + beside_limit(gates.off_deg, gates.limit_deg, "deg")
        fraction = gates.off_deg / gates.limit_deg if gates.is_right_face else 1.0
        if gates.is_free:
            name, word = "FREE", "apart" if gates.is_right_face else "near"
            numbers = f"{gates.off_deg:.0f} deg from {gates.face.replace('_', ' ')}"
            fraction = gates.off_deg / CORNER_DEG
        face = _gate(name, word, fraction, numbers, room, is_open=gates.is_right_face)
        noise = beside_limit(min(gates.still, 9999.0), gates.still_limit, f"noise {channel}")
        stirs = gates.still / gates.still_limit
        still = _gate("STILL", "still" if gates.is_still else "moving", stirs, noise, room, is_open=gates.is_still)
        return Content("\n").join((face, still))


def _gate(name: str, word: str, fraction: float, numbers: str, room: int, *, is_open: bool) -> Content:
    """Draw a gate; its bar is the ``fraction`` of the limit."""
    symbol, colour = ("✓", "$success") if is_open else ("✗", "$error")
    return Content.assemble(
        (f" {name:6}", "bold"), (f"{symbol} {word:7}", f"bold {colour}"),
        bar(fraction, max(room, 3), colour), f" {numbers:>{NUMBER_COLUMNS - 1}}",
    )  # fmt: skip
