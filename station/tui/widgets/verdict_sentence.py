"""The verdict: a word, a symbol and one sentence in the colour of the verdict, of a warning if in doubt."""

from textual.content import Content

from station.guide.view import Verdict
from station.tui.widgets.redrawn_on_change import ValueWidget

DOUBTED = ("!", "$warning")
VERDICT_LOOKS = {"PASS": ("✓", "$success"), "FAIL": ("✗", "$error"), "NOT_MEASURED": ("?", "$warning")}


class VerdictSentence(ValueWidget[Verdict]):
    """Stands alone at the top."""

    DEFAULT_CSS = """
    VerdictSentence { text-wrap: wrap; height: auto; min-height: 3; padding: 1 2; text-style: bold; }
    VerdictSentence.PASS { background: $success 22%; }
    VerdictSentence.FAIL { background: $error 22%; }
    VerdictSentence.NOT_MEASURED, VerdictSentence.doubted { background: $warning 22%; }
    """

    def show(self, value: Verdict | None) -> None:
        """Take another verdict."""
        for word in VERDICT_LOOKS:
            self.set_class(value is not None and value.word == word, word)
        self.set_class(value is not None and _is_doubted(value), "doubted")
        super().show(value)

    def _drawn(self, verdict: Verdict) -> Content:
        symbol, colour = DOUBTED if _is_doubted(verdict) else VERDICT_LOOKS[verdict.word]
        plain = verdict.said or verdict.word.replace("_", " ")
        sentence = verdict.sentence.removeprefix(f"{plain}: ")
        return Content.assemble((f" {symbol} {plain} ", f"$background on {colour}"), f"  {sentence}")


def _is_doubted(verdict: Verdict) -> bool:
    return bool(verdict.doubt) and verdict.word == "PASS"
