"""A guided calibration as lines of text: for screen readers, logs and consoles that can do no better.

Nothing is ever overwritten: each line says one thing once. Where somebody listens, a line of input is a key.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable
from textwrap import TextWrapper

from station.guide.step_names import files_as_steps, step_named
from station.guide.view import (
    ENDED_STAGES,
    CalibrationSession,
    CalibrationView,
    CommandVerb,
    OperatorCommand,
    StageName,
    Verdict,
)
from station.guide.wording import filters_in_words, soak_in_words
from station.stream.stream_events import Event, NewEvents, Sound

BELL_STROKES: dict[Sound, int] = {"": 0, "start": 1, "still": 2, "accepted": 3, "rejected": 4}
PROGRESS_EVERY_S = 25.0  # of accepted seconds between two lines of progress
QUIET_HINTS = ("measuring the noise", "waiting for stillness")
CALIBRATION_KEYS: dict[str, CommandVerb] = {
    "r": "redo", "p": "pause", "k": "keep_seating", "f": "finish", "s": "store", "q": "leave", "c": "cancel",
    "g": "more",
}  # fmt: skip
STAGE_KEYS: dict[tuple[StageName, str], CommandVerb] = {  # where a key means another thing in that stage
    ("warm_up", "s"): "skip_warm_up", ("paused", "p"): "go_on",
}  # fmt: skip
KEYS_HELP = (
    "keys, each followed by Enter: r repeat the last step, r 3 repeat position 3, r x+ repeat that rotation, n 4 "
    "do it next, p pause or continue, k keep the seating, f finish with the steps done, s skip the warm-up, at "
    "the verdict s store, q leave to resume later, c cancel; answer a question with the key that it names"
)
AT_THE_END: dict[StageName, str] = {  # what can be typed then, each followed by Enter
    "verdict": "s store the calibration, d the diagnosis, o the report, r 3 repeat position 3, r x+ repeat "
    "that rotation, g one more placement (if the plan is not fixed), q leave and store it later, c cancel",
    "stored": "d the diagnosis, o the report, q leave",
}
REFUSED = "g try again, an address (such as serial:///dev/ttyUSB1) try that one, q leave: nothing was recorded"
SHORTEST_ADDRESS = 4  # a shorter line is a slip
STEP_VERBS: dict[str, CommandVerb] = {"r": "redo", "n": "choose"}
SPOKEN_STAGES = frozenset({"warm_up", "place", "settle", "paused", "connecting", "solving", *ENDED_STAGES})


class PlainScreen:
    """Writes what is new in each view through ``say``; ``rings`` adds the terminal's bell.

    ``asks``: a person is there to type; what can be typed is written where all waits for it.
    """

    def __init__(self, say: Callable[[str], None], *, rings: bool, asks: bool = False) -> None:
        self._say, self._rings, self._asks = say, rings, asks
        self._written = defaultdict[str, str](str)  # what was written last, by kind
        self._new_events = NewEvents()

    def show(self, view: CalibrationView) -> None:
        """Write what is new."""
        if view.unit:
            self._once("unit", f"connected: {view.unit}; recording into {view.folder}")
            if self._asks:
                self._once("keys", KEYS_HELP)
        if view.readiness:
            words, outcomes = {"ready": "ready", "note": "note", "lacks": "LACKS"}, view.readiness.outcomes
            lines = [f"{words[line.state]:6} {line.name}: {line.text}" for line in view.readiness.lines]
            self._once("ready", "\n".join([*lines, *outcomes]))
            self._written["ends"] = ", ".join(outcomes)
        for event in self._new_events.of(view.events):
            self._hear(event)
        is_reported = view.stage in SPOKEN_STAGES or (view.turn is not None and view.turn.is_to_rest)
        task = view.line if is_reported or not view.link.is_live else ""
        if task:
            total = len(view.steps)
            at = f"[{min(view.done + 1, total)}/{total}] " if total and view.wanted else ""
            self._once("task", f"{at}{task}")
        self._hint(view)
        self._progress(view)
        if view.verdict:
            self._once("verdict", "\n".join(verdict_lines(view.verdict)))
            if view.verdict.stored_sha256:
                self._once("stored", f"stored as {view.verdict.stored_sha256}")
        if view.question:
            choices = "; ".join(f"{choice.key}: {choice.title}" for choice in view.question.choices)
            self._once("question", f"{view.question.text} {choices}")
        else:
            self._written["question"] = ""
        self._prompt(view)

    def _prompt(self, view: CalibrationView) -> None:
        """Say what can be typed where all waits for it."""
        if not self._asks:
            return
        if view.start and view.start.refused:
            self._once(f"refusal {view.start.refusals}", f"refused: {view.start.refused}\n{REFUSED}")
        self._once("prompt", AT_THE_END.get(view.stage, ""))

    def _hear(self, event: Event) -> None:
        if (ends := self._written["ends"]) and event.text.endswith(ends):
            return  # it stands below what is ready
        self._say(f"{event.text}{chr(7) * BELL_STROKES[event.sound] if self._rings else ''}")

    def _hint(self, view: CalibrationView) -> None:
        spoken = any(view.hint in event.text for event in view.events)
        if view.hint and not spoken and not view.hint.startswith(QUIET_HINTS):
            self._once("hint", view.hint)

    def _progress(self, view: CalibrationView) -> None:
        if view.stage == "dwell" and view.accepted_s >= PROGRESS_EVERY_S:
            seconds = PROGRESS_EVERY_S * (view.accepted_s // PROGRESS_EVERY_S)
            text = f"{files_as_steps(view.live)}: {seconds:.0f} s accepted"
            more = filters_in_words(view.monitored) if view.monitored else ""
            more = soak_in_words(view.soak) if view.soak else more
            self._once("seconds", f"{text}, {more}" if more else text)
        elif view.stage == "warm_up" and view.warm_up is not None:
            seconds = PROGRESS_EVERY_S * (view.warm_up.seconds // PROGRESS_EVERY_S)
            left = "" if view.warm_up.left_s is None else f", about {view.warm_up.left_s:.0f} s left"
            self._once("seconds", f"warming up, {seconds:.0f} s{left if seconds else ''}, {view.warm_up.note}")

    def _once(self, kind: str, text: str) -> None:
        if kind == "seconds" and text.split(",")[0] == self._written[kind].split(",")[0]:
            return
        if text != self._written[kind]:
            self._written[kind] = text
            if text:
                self._say(text)


def between_words(text: str, width: int) -> str:
    """Return a text whose lines are at most ``width`` long where their words allow it; a table's spaces stay."""
    wrapper = TextWrapper(width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(part for line in text.split("\n") for part in wrapper.wrap(line) or [line])


def verdict_lines(verdict: Verdict) -> list[str]:
    """Return a verdict as lines: the sentence, what stands behind it, the numbers."""
    reason = f": {verdict.status_reason}" if verdict.status_reason else ""
    lines = [verdict.sentence, f"status {verdict.status}{reason}"]
    lines += [f"worst residual: {verdict.worst_residual}", verdict.change]
    lines += [f"diagnosis: {verdict.diagnosis}"] if verdict.diagnosis else []
    lines += [f"warning: {warning}" for warning in verdict.warnings]
    lines += [
        f"{row.name}: {row.value} +- {row.sigma} {row.unit}{row.expanded and f', U (95 %) {row.expanded}'}"
        + "".join(f", {part}" for part in (row.limit and f"limit {row.limit}", row.verdict, row.change) if part)
        for row in verdict.rows
    ]
    return [*lines, verdict.report, verdict.solution]


def command_of(line: str, view: CalibrationView, first: OperatorCommand | None = None) -> OperatorCommand | None:
    """Return what a line of input asks for, None if it asks for nothing; ``first`` is what was refused."""
    key, _, rest = line.strip().partition(" ")
    if view.start and view.start.refused and first is not None:
        return _once_more(line.strip(), first)
    if view.question and key in {choice.key for choice in view.question.choices}:
        return OperatorCommand(verb="answer", key=key)
    if key in STEP_VERBS and rest:
        step = step_named(rest, view.steps)
        return OperatorCommand(verb=STEP_VERBS[key], step=step) if step else None
    verb = STAGE_KEYS.get((view.stage, key)) or CALIBRATION_KEYS.get(key)
    return OperatorCommand(verb=verb) if verb else None


def _once_more(typed: str, first: OperatorCommand) -> OperatorCommand | None:
    """Return the first command again, with another address if one was typed."""
    if typed in {"q", "c"}:
        return OperatorCommand(verb="leave")
    if typed in {"", "g"}:
        return first
    if len(typed) < SHORTEST_ADDRESS:
        return None
    setup = first.setup and first.setup.model_copy(update={"url": typed})
    return first.model_copy(update={"setup": setup} if setup else {"url": typed})


def listen(
    session: CalibrationSession,
    lines: Iterable[str],
    say: Callable[[str], None],
    first: OperatorCommand | None = None,
) -> None:
    """Turn lines of input into commands until there are no more; ``first`` is what may be refused."""
    for line in lines:
        view, (key, _, rest) = session.view, line.strip().partition(" ")
        texts = {"d": view.verdict.diagnosis_text, "o": view.verdict.report} if view.verdict else {}
        if text := texts.get(line.strip()):
            say(text)
        elif (command := command_of(line, view, first)) is not None:
            session.send(command)
        else:
            say(f"there is no step {rest.strip()!r}; {KEYS_HELP}" if key in STEP_VERBS and rest else KEYS_HELP)
