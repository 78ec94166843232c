"""Steps as people name them: ``position 3`` for the file ``dwell_03.mcap``, and back from what is typed."""

import re
from collections.abc import Iterable, Mapping, Sequence

from station.guide.view import CalibrationView, StepView, Verdict

_FILED = re.compile(
    r"(?:[^\s:;,]*/)?\b(?:(?P<kind>dwell|move|free|soak|monitor)_(?P<number>\d\d+)(?P<again>_repeat(?P<nth>\d*))?|turn_(?P<axis>[xyz])_(?P<way>plus|minus))"
    r"(?:_\d+)?(?:\.(?:mcap|csv))?(?::\d+)?\b"
)
_KINDS = {"dwell": "position", "move": "move", "free": "free position", "soak": "soak", "monitor": "monitor"}
_WAYS = {"plus": "+", "minus": "-"}
_GAP = re.compile(r"^(?:.*/)?(?P<file>[^:/]+\.mcap)(?::\d+)?: a gap of (?P<seconds>[\d.]+) s(?P<place> at \S+ s)$")
_NEAR_S = 0.5
_TYPED = (  # what people type, and what the step's words then are
    (re.compile(r"^(?:position |p)?(\d+|[udewns]{3})$"), "position {0}"),
    (re.compile(r"^(?:position |p)?(\d+|[udewns]{3}) ?r(?:epeated)?$"), "position {0} repeated"),
    (re.compile(r"^(?:turn )?([xyz]) ?([+-])$"), "turn {0}{1}"),
    (re.compile(r"^(?:turn )?([+-]) ?([xyz])$"), "turn {1}{0}"),
    (re.compile(r"^(?:free position|free|f) ?(\d+)$"), "free position {0}"),
    (re.compile(r"^(?:soak|s) ?(\d+)$"), "soak {0}"),
    (re.compile(r"^(?:monitor|m) ?(\d+)$"), "monitor {0}"),
)


def files_as_steps(text: str) -> str:
    """Return a text with positions and turns in the place of files and of steps' names."""
    return _FILED.sub(_words, text) if "_" in text else text


def step_named(text: str, steps: Iterable[StepView]) -> str:
    """Return the name of the step that ``text`` means: ``3``, ``1r``, ``+x``, ``soak 1``; empty if none."""
    typed = re.sub(r"0+(\d)", r"\1", " ".join(files_as_steps(text.lower()).lower().split()))
    wanted = next(
        (form.format(*found.groups()) for pattern, form in _TYPED if (found := pattern.match(typed))), typed
    )
    return next((step.name for step in steps if wanted == files_as_steps(step.name).lower()), "")


def without_file_names(view: CalibrationView) -> CalibrationView:
    """Return a view whose texts name no file of a step."""
    events = tuple(event.model_copy(update={"text": files_as_steps(event.text)}) for event in view.events)
    update: dict[str, object] = {name: files_as_steps(getattr(view, name)) for name in ("line", "hint", "error")}
    if view.verdict is not None:
        update["verdict"] = verdict_without_file_names(view.verdict)
    return view.model_copy(update=update | {"events": events})


def verdict_without_file_names(verdict: Verdict) -> Verdict:
    """Return a verdict whose texts name no file of a step."""
    names = ("sentence", "status_reason", "worst_residual", "change", "diagnosis", "diagnosis_text")
    update: dict[str, object] = {name: files_as_steps(getattr(verdict, name)) for name in names}
    return verdict.model_copy(update=update | {"warnings": tuple(map(files_as_steps, verdict.warnings))})


def gap_in_words(warning: str, left_out: Mapping[str, Sequence[float]]) -> str:
    """Return a warning; a gap that the guide made itself is called what it is.

    ``left_out`` holds, by file, how long the spans were that were discarded as the cube was disturbed [s].
    """
    found = _GAP.match(warning)
    if found is None:
        return warning
    file, seconds = found["file"], float(found["seconds"])
    if not any(abs(seconds - each) < _NEAR_S for each in left_out.get(file, ())):
        return f"{file}: a gap of {seconds:.3g} s{found['place']}: samples were lost"
    return f"{file}: {seconds:.1f} s discarded, because the cube was disturbed; the rest was accepted"


def _words(found: re.Match[str]) -> str:
    if found["kind"]:
        again = f" repeated{f' ({nth})' if (nth := found['nth']) else ''}" if found["again"] else ""
        from procedures.positions import ATTITUDES, position_name

        number = int(found["number"])
        name = position_name(number) if found["kind"] == "dwell" and number <= len(ATTITUDES) else str(number)
        return f"{_KINDS[found['kind']]} {name}{again}"
    return f"turn {found['axis'].upper()}{_WAYS[found['way']]}"
