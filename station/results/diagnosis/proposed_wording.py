"""What a search for terms says: the term, what it is one with in this data, and the offer to search."""

from collections.abc import Mapping
from textwrap import wrap
from typing import Any

from station.results.diagnosis.diagnosis_wording import PROPOSED, known_findings

WIDTH = 80
SHOWN = 6  # readings
OFFERED = ("unexplained", "partly")


def proposed_lines(finding: Mapping[str, Any]) -> list[str]:
    """Return what is said of a proposed finding beside its coefficients; nothing of another."""
    if finding["confidence"] != PROPOSED:
        return []
    return [line for text in proposed_said(finding) for line in _folded(text)] + [
        f"      {line}" for line in readings_said(finding)
    ]


def proposed_said(finding: Mapping[str, Any]) -> list[str]:
    """Return sentences of a proposed finding: its term, its error held out, how many terms read the same."""
    held, count = finding["held_out_sigmas"], finding["readings_in_all"]
    alike = (
        f"the data cannot separate it from {count} other {'term' if count == 1 else 'terms'}"
        if count
        else "no other tested term fits as well"
    )
    return [
        f"it adds {_term(finding)}",
        f"error of its rows when held out: {held['before']:.2f} sigma without it, "
        f"{held['after']:.2f} with it (rms)",
        alike,
        *([f"measure next: {finding['separate_by']}"] if finding["separate_by"] else []),
    ]


def readings_said(finding: Mapping[str, Any]) -> list[str]:
    """Return the terms that read the same here, the best first, each with how alike they are."""
    return [f"{_term(one)}, correlation {one['correlation']:.3f}" for one in finding.get("readings", ())[:SHOWN]]


def searched_said(document: Mapping[str, Any]) -> str:
    """Return how many terms were searched, or the offer to search where the verdict leaves something."""
    if (searched := document.get("searched")) is None:
        is_offered = document["verdict"] in OFFERED and "solution" in document
        return (
            "--discover searches ten thousand terms for an error term that the catalogue lacks"
            if is_offered
            else ""
        )
    found = len(document["findings"]) - len(known_findings(document))
    said = "none is significant" if not found else "one is proposed" if found == 1 else f"{found} are proposed"
    adopt = " (`station effects adopt` writes it as a file)" if found else ""
    return f"{searched['terms']} terms were searched: {said}{adopt}"


def _term(one: Mapping[str, Any]) -> str:
    several = len(one["term"]) > 1
    return " + ".join(f"c{i if several else ''} ({term})" for i, term in enumerate(one["term"], 1))


def _folded(text: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent="   ", subsequent_indent="   ", break_long_words=False)
