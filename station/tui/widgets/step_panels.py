"""What is said of one step: accepted seconds, how the cube stands, a soak's temperature, what became of it."""

from textwrap import fill

from textual.content import Content

from procedures.frames import position_name
from station.guide.view import GatesView, MonitoredView, SoakView, StepView
from station.tui.bars import bar
from station.tui.orientation import short_step_title
from station.tui.widgets.redrawn_on_change import ValueWidget


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
            said = fill(f"{where}{gates.heading}", max(self.size.width - 8, 20)).replace("\n", "\n       ")
            lines.append(Content.assemble((" NORTH ", "bold"), said))
        if gates.seating:
            symbol, colour = ("✓", "$success") if gates.is_seated else ("✗", "$error")
            said = fill(f"{symbol} {gates.seating}", max(self.size.width - 9, 20)).replace("\n", "\n         ")
            lines.append(Content.assemble((" SEAT  ", "bold"), (said, f"bold {colour}")))
        return Content("\n").join(lines)


class SoakLines(ValueWidget[SoakView]):
    """A line for the temperature, one for the time."""

    DEFAULT_CSS = "SoakLines { height: 3; }"

    def _drawn(self, soak: SoakView) -> Content:
        minutes, seconds = divmod(round(soak.left_s), 60)
        said = "not sent by the device"
        if soak.temperature_c is not None:
            said = f"{soak.temperature_c:.1f} degC, range {soak.low_c:.1f} to {soak.high_c:.1f}"
        return Content.assemble((" TEMP  ", "bold"), said, ("\n LEFT  ", "bold"), f"{minutes} min {seconds:02d} s")


class MonitoredLines(ValueWidget[MonitoredView]):
    """What each law reads, and how far two are apart; or why none does."""

    DEFAULT_CSS = "MonitoredLines { height: 3; }"

    def _drawn(self, seen: MonitoredView) -> Content:
        if not seen.laws:
            return Content.assemble((" LAWS  ", "bold"), seen.text)
        lines = [
            Content.assemble((f" {law.law:7}", "bold"), f"roll {law.roll_deg:+.3f} pitch {law.pitch_deg:+.3f} deg")
            for law in seen.laws
        ]
        if seen.difference_deg is not None:
            lines.append(Content.assemble((" APART ", "bold"), f" {seen.difference_deg:.3f} deg"))
        return Content("\n").join(lines)


class StepWords(ValueWidget[StepView]):
    """Name, state, seconds, how many recordings are superseded, and what was noted."""

    DEFAULT_CSS = "StepWords { height: 1fr; min-height: 3; padding: 0 1; text-wrap: wrap; }"

    def _drawn(self, step: StepView) -> Content:
        said = [step.state, f"{step.seconds:.0f} s" if step.attempts else ""]
        said += [f"{step.superseded} superseded" if step.superseded else "", step.note]
        return Content.assemble((f"{short_step_title(step)}: ", "bold"), ", ".join(word for word in said if word))
