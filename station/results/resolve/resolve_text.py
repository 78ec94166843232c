"""A `resolve/1` as text to read: how many of what, then every campaign that asks for a person."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import median
from textwrap import wrap
from typing import Any

from station.results.parameters_by_name import Parameter, ParameterShift, largest
from station.results.resolve.comparison import diagnosis_remarks, is_otherwise
from station.results.verdict import word_said
from station.text import WIDTH, plural

MIN_SHIFT_SIGMAS = 1.0  # sigma: a shift below is what better arithmetic does, and is only counted
Entry = Mapping[str, Any]


def turned_fail(entry: Entry) -> bool:
    """Say whether a verdict was not FAIL before and is now."""
    verdict = entry.get("verdict", {})
    return bool(verdict.get("now") == "FAIL" != verdict.get("before", "FAIL"))


def exit_code(document: Mapping[str, Any]) -> int:
    """Return what the command ends with.

    1 where a verdict turned FAIL or a recording was altered; the first refusal's code where nothing was solved.
    """
    entries = document["campaigns"]
    if any(turned_fail(one) or one.get("altered") for one in entries):
        return 1
    is_solved = any(one["outcome"] == "solved" for one in entries)
    return 0 if is_solved else next((int(one["exit_code"]) for one in entries if one.get("exit_code")), 0)


def resolve_text(document: Mapping[str, Any]) -> str:
    """Return the summary; a path longer than a line is not broken."""
    entries = document["campaigns"]
    lines = _fold(f"{plural(len(entries), 'campaign')}, {document['software']}: {_counted(entries)}", "")
    lines += _shift_lines(entries)
    for entry in entries:
        if said := list(_remarks(entry)):
            unit = f"  {entry['model']} {entry['serial']}" if "model" in entry else ""
            lines += ["", f"{entry['folder']}{unit}", *(line for text in said for line in _fold(text, "  "))]
    return "\n".join(lines)


def shift_of(entry: Entry) -> ParameterShift | None:
    """Return a campaign's largest shift, in sigmas of what was known before."""
    moved = {
        name: ParameterShift(
            Parameter(name, row["now"], row["std_before"], row["unit"]),
            row["now"] - row["before"],
            row["shift_sigma"],
        )
        for name, row in entry.get("shifts", {}).items()
    }
    return largest(moved)


def _counted(entries: Sequence[Entry]) -> str:
    kinds: tuple[tuple[str, Callable[[Entry], Any]], ...] = (
        ("solved", lambda one: one["outcome"] == "solved"),
        ("of them kept from an earlier run", lambda one: one.get("was_kept")),
        ("refused", lambda one: one["outcome"] == "refused"),
        ("with no folder", lambda one: one["outcome"] == "missing"),
        ("altered", lambda one: one.get("altered")),
        ("turned FAIL", turned_fail),
        ("with another verdict", _is_changed),
        ("with another diagnosis", is_otherwise),
        ("with new warnings", lambda one: one.get("new_warnings")),
        ("with nothing to compare with", lambda one: one["outcome"] == "solved" and "before" not in one),
    )
    counts = ((sum(bool(holds(one)) for one in entries), name) for name, holds in kinds)
    return ", ".join(f"{count} {name}" for count, name in counts if count)


def _shift_lines(entries: Sequence[Entry]) -> list[str]:
    found = [(shift, one) for one in entries if (shift := shift_of(one)) is not None]
    if not found:
        return []
    sizes = [abs(shift.sigmas) for shift, _ in found]
    most, entry = found[sizes.index(max(sizes))]
    text = (
        f"largest change of a campaign, in units of its earlier uncertainty u: median {median(sizes):.2g}, at "
        f"most {max(sizes):.2g}, {most.parameter.title} of {entry['model']} {entry['serial']}"
    )
    return _fold(text, "")


def _is_changed(entry: Entry) -> bool:
    verdict = entry.get("verdict", {})
    return "before" in verdict and verdict["before"] != verdict["now"]


def _remarks(entry: Entry) -> Iterator[str]:
    for row in entry.get("altered", []):
        yield f"ALTERED {row['file']}: found {row['found']}, expected {row['expected']} ({row['record']})"
    if entry["outcome"] == "missing":
        yield "no such folder: find it, or restore it from a copy"
    elif entry["outcome"] == "refused":
        again = "solved before, refused now" if "before" in entry else "refused"
        yield f"{again}: {entry['reason']}"
    if _is_changed(entry):
        verdict = entry["verdict"]
        was, now = (word_said(verdict[when], has_limits=verdict["limits"] > 0) for when in ("before", "now"))
        yield f"{was} before, {now} now: {verdict['reason']}"
    if (shift := shift_of(entry)) is not None and abs(shift.sigmas) >= MIN_SHIFT_SIGMAS:
        yield f"moved: {shift.parameter.title} {shift}"
    yield from diagnosis_remarks(entry)
    for name in entry.get("lost", []):
        yield f"no more estimated: {name}"
    for text in entry.get("new_warnings", []):
        yield f"new warning: {text}"


def _fold(text: str, indent: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "  ",
                break_long_words=False, break_on_hyphens=False)  # fmt: skip
