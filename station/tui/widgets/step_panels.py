"""Panels of a step: gates, accepted seconds, seating, turn, soak, monitor, warm-up, limits, the step in words."""

from textwrap import fill

from textual.content import Content

from procedures.positions import position_name
from procedures.units import S_PER_MIN
from station.guide.view import GatesView, LimitView, MonitoredView, SoakView, StepView, TurnView, WarmUpView
from station.guide.wording import rounded, step_title
from station.tui.widgets.common import ValueWidget, against_limit, bar, duration_in_words, pointer


class AcceptedBar(ValueWidget[tuple[float, float]]):
    """Value: seconds accepted, seconds wanted; wanted 0 while nothing is counted."""

    DEFAULT_CSS = "AcceptedBar { height: 1; }"

    def _drawn(self, value: tuple[float, float]) -> Content:
        accepted, wanted = value
        if not wanted:
            return Content.assemble((" ACCEPTED ", "bold"), ("nothing recorded in this step yet", "$muted"))
        numbers = f" {accepted:.0f} of {wanted:.0f} s  {100 * accepted / wanted:3.0f} % "
        seconds = bar(accepted / wanted, max(self.size.width - 10 - len(numbers), 4), "$success")
        return Content.assemble((" ACCEPTED ", "bold"), seconds, (numbers, "bold"))


class SeatingLines(ValueWidget[GatesView]):
    """Heading, then seating."""

    DEFAULT_CSS = "SeatingLines { height: 1fr; min-height: 3; }"

    def _drawn(self, gates: GatesView) -> Content:
        lines = []
        if gates.heading:
            where = f"position {position_name(gates.position)}, " if gates.position else ""
            text = fill(f"{where}{gates.heading}", max(self.size.width - 8, 20)).replace("\n", "\n       ")
            lines.append(Content.assemble((" NORTH ", "bold"), text))
        if gates.seating:
            symbol, colour = ("✓", "$success") if gates.is_seated else ("✗", "$error")
            text = fill(f"{symbol} {gates.seating}", max(self.size.width - 9, 20)).replace("\n", "\n         ")
            lines.append(Content.assemble((" SEAT  ", "bold"), (text, f"bold {colour}")))
        return Content("\n").join(lines)


class SoakLines(ValueWidget[SoakView]):
    """A line for the temperature, one for the time."""

    DEFAULT_CSS = "SoakLines { height: 3; }"

    def _drawn(self, soak: SoakView) -> Content:
        minutes, seconds = divmod(round(soak.left_s), 60)
        text = "not sent by the device"
        if soak.temperature_c is not None:
            text = f"{soak.temperature_c:.1f} degC, range {soak.low_c:.1f} to {soak.high_c:.1f}"
        return Content.assemble((" TEMP  ", "bold"), text, ("\n LEFT  ", "bold"), f"{minutes} min {seconds:02d} s")


class MonitoredLines(ValueWidget[MonitoredView]):
    """What each filter reads, and how far two are apart; or why none does."""

    DEFAULT_CSS = "MonitoredLines { height: 3; }"

    def _drawn(self, seen: MonitoredView) -> Content:
        if not seen.filters:
            return Content.assemble((" FILTERS  ", "bold"), seen.text)
        lines = [
            Content.assemble(
                (f" {one.name:7}", "bold"), f"roll {one.roll_deg:+.3f} pitch {one.pitch_deg:+.3f} deg"
            )
            for one in seen.filters
        ]
        if seen.difference_deg is not None:
            lines.append(Content.assemble((" APART ", "bold"), f" {seen.difference_deg:.3f} deg"))
        return Content("\n").join(lines)


class StepWords(ValueWidget[StepView]):
    """Name, state, seconds, how many recordings are superseded, and what was noted."""

    DEFAULT_CSS = "StepWords { height: 1fr; min-height: 3; padding: 0 1; text-wrap: wrap; }"

    def _drawn(self, step: StepView) -> Content:
        parts = [step.state, f"{step.seconds:.0f} s" if step.attempts else ""]
        parts += [f"{step.superseded} superseded" if step.superseded else "", step.note]
        return Content.assemble((f"{step_title(step)}: ", "bold"), ", ".join(word for word in parts if word))


OTHER_FACE_DEG = 45.0  # deg, beyond which another face is the one that is up
CORNER_DEG = 54.74  # deg a corner's way is from three faces
GATE_NUMBER_COLUMNS = 22  # columns of the numbers on the right


class GatesPanel(ValueWidget[GatesView]):
    """A line for each gate: name, symbol and word, bar against the limit, numbers."""

    DEFAULT_CSS = "GatesPanel { height: 2; }"

    def render(self) -> Content:
        """Draw both; while the cube is turned, or before there are counts, neither is judged."""
        gates = self.value
        if gates is None:
            unknown = ("… not checked now", "$muted")
            return Content.assemble((" FACE  ", "bold"), unknown, ("\n STILL ", "bold"), unknown)
        room = self.size.width - 17 - GATE_NUMBER_COLUMNS
        up = f"{gates.face.replace('_', ' ').capitalize()}, " if gates.face else ""
        channel = gates.still_channel.replace("accelerometer", "accel").replace("gyroscope", "gyro")
        is_tilted = gates.limit_deg < gates.off_deg < OTHER_FACE_DEG
        word = "tilted" if is_tilted else "wrong" if gates.off_deg > gates.limit_deg else "other"
        if gates.is_right_face:
            word = "right" if gates.is_wanted_face else "may do"
        name, numbers = "FACE", up + against_limit(gates.off_deg, gates.limit_deg, "deg")
        fraction = gates.off_deg / gates.limit_deg if gates.is_right_face else 1.0
        if gates.is_free:
            name, word = "FREE", "apart" if gates.is_right_face else "near"
            numbers = f"{gates.off_deg:.0f} deg from {gates.face.replace('_', ' ')}"
            fraction = gates.off_deg / CORNER_DEG
        face = _gate(name, word, fraction, numbers, room, is_open=gates.is_right_face)
        noise = against_limit(min(gates.still, 9999.0), gates.still_limit, f"noise {channel}")
        stirs = gates.still / gates.still_limit
        still = _gate("STILL", "still" if gates.is_still else "moving", stirs, noise, room, is_open=gates.is_still)
        return Content("\n").join((face, still))


def _gate(name: str, word: str, fraction: float, numbers: str, room: int, *, is_open: bool) -> Content:
    """Draw a gate; its bar is the ``fraction`` of the limit."""
    symbol, colour = ("✓", "$success") if is_open else ("✗", "$error")
    return Content.assemble(
        (f" {name:6}", "bold"), (f"{symbol} {word:7}", f"bold {colour}"),
        bar(fraction, max(room, 3), colour), f" {numbers:>{GATE_NUMBER_COLUMNS - 1}}",
    )  # fmt: skip


GAUGE_NUMBER_COLUMNS = 19  # columns of the numbers on the right


class TurnGauge(ValueWidget[TurnView]):
    """Three lines: turns, speed between its limits, and the rest."""

    DEFAULT_CSS = "TurnGauge { height: 3; }"

    def _drawn(self, turn: TurnView) -> Content:
        room = max(self.size.width - 8 - GAUGE_NUMBER_COLUMNS, 8)
        speed, (word, colour) = abs(turn.speed_deg_s), _speed_word(turn)
        turns, turned = abs(turn.revolutions) / turn.wanted, f"{abs(turn.revolutions):.2f} of {turn.wanted}"
        limits = f"{speed:.0f} deg/s, {turn.slow_deg_s:g}-{turn.fast_deg_s:g}"
        scale = Content.styled(pointer(speed / (1.2 * turn.fast_deg_s), max(room - 11, 4)), colour)
        rested = f"{turn.rest_s:.0f} of {turn.rest_wanted_s:.0f} s"
        return Content("\n").join((
            _gauge_line("TURNS", bar(turns, room, "$accent"), turned, "bold"),
            _gauge_line("SPEED", Content.assemble((f"{word:11}", f"bold {colour}"), scale), limits),
            _gauge_line("REST", bar(turn.rest_s / turn.rest_wanted_s, room, "$success"), rested),
        ))  # fmt: skip


def _gauge_line(name: str, gauge: Content, numbers: str, look: str = "") -> Content:
    return Content.assemble((f" {name:6}", "bold"), gauge, (f"{numbers:>{GAUGE_NUMBER_COLUMNS}}", look))


def _speed_word(turn: TurnView) -> tuple[str, str]:
    speed = abs(turn.speed_deg_s)
    if speed < turn.slow_deg_s / 5:
        return "◼ at rest", "$foreground"
    if speed < turn.slow_deg_s:
        return "▲ faster", "$warning"
    if speed > turn.fast_deg_s:
        return "▼ slower", "$error"
    return "✓ good", "$success"


LIMITS_LABEL = " LIMITS   "
LEAST_BAR = 6  # columns; a shorter one says nothing
Limits = tuple[tuple[LimitView, ...], float]  # and the seconds that are left


class LimitsLines(ValueWidget[Limits]):
    """The sigma that is furthest from what is wanted; all of them, a line each, where there is room."""

    DEFAULT_CSS = "LimitsLines { height: 1; display: none; }"

    def _drawn(self, value: Limits) -> Content:
        limits, left_s = value
        shown = sorted(limits, key=lambda one: one.share)[: max(self.size.height, 1)]
        left = f", about {max(-(-left_s // S_PER_MIN), 1):.0f} min left" if left_s else ""
        left = ", all targets met" if all(one.share >= 1 for one in limits) else left
        parts = [(left, LIMITS_LABEL), *[("", " " * len(LIMITS_LABEL))] * (len(shown) - 1)]
        return Content("\n").join(self._line(one, *each) for one, each in zip(shown, parts, strict=True))

    def _line(self, one: LimitView, left: str, name: str) -> Content:
        width = self.size.width - len(name)
        # a number is not cut: first the minutes go, which the title has as well, then the bar
        fitting = (f" {text} " for text in (one.text + left, one.text) if len(text) + 2 + LEAST_BAR <= width)
        phrase = next(fitting, f" {one.text}")
        room = max(width - len(phrase), 0)
        colour = "$success" if one.share >= 1 else "$accent"
        return Content.assemble((name, "bold"), bar(one.share, room, colour), (phrase, "bold"))


class WarmUpPanel(ValueWidget[WarmUpView]):
    """Time gone and left, then temperature rate and gyro drift with a bar each."""

    DEFAULT_CSS = "WarmUpPanel { text-wrap: wrap; height: auto; padding: 1 2; }"

    def render(self) -> Content:
        warm = self.value
        if warm is None:
            return Content.styled("waiting for the first counts", "$muted")
        left = "not known yet" if warm.left_s is None else f"about {duration_in_words(warm.left_s)}"
        lines = [
            Content.assemble(("time so far     ", "$muted"), (duration_in_words(warm.seconds), "bold")),
            Content.assemble(("time left       ", "$muted"), (left, "bold")),
            Content(""),
            self._gate("temp. rate", warm.temperature_rate_c_min, warm.temperature_limit_c_min, "°C/min"),
            self._gate("gyro drift", warm.gyro_drift_deg_h, warm.gyro_limit_deg_h, "deg/h"),
        ]
        if warm.note:
            lines += [Content(""), Content(warm.note)]
        return Content("\n").join(lines)

    def _gate(self, name: str, value: float | None, limit: float | None, unit: str) -> Content:
        if value is None or limit is None:
            text = "not measured yet" if value is None else f"{value:.2g} {unit}, the limit is being determined"
            return Content.assemble((f"{name:16}", "bold"), (f"… {text}", "$muted"))
        is_inside = abs(value) <= limit
        colour, word = ("$success", "✓ settled ") if is_inside else ("$warning", "✗ changing")
        sign = "<" if is_inside else ">"
        numbers = f"{rounded(abs(value), limit)} {sign} {rounded(limit, limit)} {unit}"
        return Content.assemble(
            (f"{name:16}", "bold"), (f"{word} ", f"bold {colour}"),
            bar(abs(value) / limit, max(self.size.width - 16 - 11 - 24, 8), colour), f"{numbers:>24}",
        )  # fmt: skip
