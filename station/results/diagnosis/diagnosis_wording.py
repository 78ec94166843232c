"""What a `diagnosis/2` says, in words: the sentences of its verdict, causes, alternatives and what is left."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from procedures.frames import TRIADS
from procedures.inference.result import Because
from station.results.diagnosis.finding_wording import (
    COUNTED,
    MANY,
    NEGLIGIBLE,
    PROPOSED,
    both,
    error_text,
    importance,
    meaning_of,
    most_reduced,
    notable_sizes,
    p_text,
    place_of,
    probabilities_text,
    probability_text,
    shape_of,
    share_text,
)
from station.text import significant

if TYPE_CHECKING:
    from procedures.uncertainty.budget import ParameterBudget

UNEXPLAINED = "unexplained"  # as `procedures.uncertainty.sources` names it


OTHERS_TITLE = "other error terms considered, with their probability"


def verdict_title(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/2`'s verdict in a word or some, as a title."""
    if "log10_p" not in document:
        return "not enough data to calibrate"
    return "solved, but not checked" if nothing_is_left(document) else str(document["verdict"])


def nothing_is_left(document: Mapping[str, Any]) -> bool:
    """Say whether as many numbers were fitted as there are data: no residual is left to judge them by."""
    dof = document.get("solution", {}).get("residual", {}).get("dof")
    return bool(dof == 0 and document["verdict"] == "consistent")


TAKEN_FOR_SCATTER = (
    "The uncertainty in a report or a calibration treats the residual as scatter of all steps. A single wrong "
    "step may change a value by more."
)


def verdict_sentence(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/2`'s verdict in plain words."""
    if "log10_p" not in document:
        return "The results of this recording are below."
    chance = p_text(document["log10_p"])
    sure, possible = sure_and_possible(document)
    known = f"{_named(sure)} {_reduction(document)}" if sure else ""
    match document["verdict"]:
        case "consistent" if nothing_is_left(document):
            return (
                "There are as many unknowns as measurements, so no residual can show an error. Repeat rests, or "
                "record more attitudes, to check the result."
            )
        case "consistent":
            further = " further" if document.get("solution", {}).get("effects") else ""
            whose = " of the accelerometers" if not_looked_at(document) else ""
            return f"Residuals{whose} are consistent with noise ({chance}). No{further} error term was detected."
        case "established" | "likely":
            return f"{known}With that in the model, residuals are consistent with noise ({chance})."
        case "ambiguous":
            return terms_in_words(document)
        case _:
            maybe = f" Also possible: {_groups(document, possible)}." if possible else ""
            return f"{known}{_excess_text(document, chance, is_after=bool(sure))}{maybe} {TAKEN_FOR_SCATTER}"


def sure_and_possible(document: Mapping[str, Any]) -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Return the findings that are likely or established, and those that are only possible."""
    found = known_findings(document)
    sure = [each for each in found if each["confidence"] != "possible"]
    return sure, [each for each in found if each["confidence"] == "possible"]


def terms_in_words(document: Mapping[str, Any]) -> str:
    """Return the error terms found, with what they explain, and those of which the data cannot determine which."""
    sure, possible = sure_and_possible(document)
    known = f"{_named(sure)} {_reduction(document)}" if sure else ""
    if not possible:
        return known.rstrip()
    detected = "Another error term was detected" if sure else "An error term was detected"
    return f"{known}{detected}, but the data cannot determine which: {_groups(document, possible)}."


def nameless_in_words(texts: Sequence[str]) -> str:
    """Return that what is left looks like ``texts``, each with its probability."""
    return f"No known error term fits. What is left looks like {both(texts)}."


def _reduction(document: Mapping[str, Any]) -> str:
    """Return by how much the error held out falls with the findings in the model, where it falls most."""
    if (best := most_reduced(document)) is None:
        return ""
    text, unit = error_text(best)
    before, _, after = text.partition(" -> ")
    return f"The held-out error of {best['quantity']} falls from {before} to {after} {unit}. "


def _named(findings: Sequence[Mapping[str, Any]]) -> str:
    """Return a sentence for each cause: what it is, probability, size, place."""
    return " ".join(_sentence(several) for several in by_term(findings))


def _sentence(several: Sequence[Mapping[str, Any]]) -> str:
    first = several[0]
    meaning, name = meaning_of(first), first["effect"]
    of = f"probability {probabilities_text(several)}"
    text = f"{meaning} ({name}, {of})" if meaning else f"{name} ({of})"
    is_one = len(several) == 1 and COUNTED not in first["where"]
    own = (shape_of(first), notable_sizes(first)) if is_one else ()
    parts = [part for part in (*own, place_of(several)) if part]
    return f"{text}{': ' if parts else ''}{', '.join(parts)}."


def _groups(document: Mapping[str, Any], findings: Sequence[Mapping[str, Any]]) -> str:
    groups = list[str]()
    for several in by_term(findings):
        one = several[0]
        text = f"{one['effect']} ({probabilities_text(several)})"
        groups.append(" or ".join([text, *alternatives_in_words(document, one)]))
    return "; and ".join(dict.fromkeys(groups))


EXCESS_TEXT: Mapping[str, str] = {  # of a verdict `partly` or `unexplained`
    Because.NAMELESS: "{what} (probability {p})",
    Because.MOTION: "The unit moves while it is assumed to be at rest: within a rest the mean output changes by "
    "{mg} mg more than noise. Put it on a firm surface for each rest.",
    Because.STRUCTURE: "The samples keep a structure that is not noise: a table by the phase of {what} would "
    "explain {percent} more of their variance.",
}


def _excess_text(document: Mapping[str, Any], chance: str, *, is_after: bool) -> str:
    """Return every reason for which more than noise is left, a sentence each; all without a name in one."""
    reasons, texts = document.get("reasons", ()), dict[str, list[str]]()
    for each in reasons:
        if text := EXCESS_TEXT.get(each["code"]):
            value = each.get("value", 0.0)
            of = {
                "percent": share_text(max(value, 0.0)), "mg": significant(1e3 * value),
                "p": probability_text(value),
            }  # fmt: skip
            texts.setdefault(each["code"], []).append(text.format(what=each.get("what", ""), **of))
    found = list[str]()
    if not reasons or any(each["code"] == Because.RESIDUAL for each in reasons):
        found.append(
            f"{'With that in the model, residuals still' if is_after else 'Residuals'} exceed noise ({chance})."
        )
    for code, several in texts.items():
        once = list(dict.fromkeys(several))  # several findings of one name have one reason
        found += [nameless_in_words(once)] if code == Because.NAMELESS else once
    return " ".join(found)


def known_findings(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the findings without what is only proposed: neither verdict nor solution holds that."""
    return [finding for finding in document["findings"] if finding["confidence"] != PROPOSED]


def left_in_words(document: Mapping[str, Any], budgets: Sequence["ParameterBudget"]) -> str:
    """Return what a verdict on limits must say of a residual that is unexplained; nothing of any other."""
    if document["verdict"] not in {"unexplained", "partly"}:
        return ""
    is_in = any(part.source == UNEXPLAINED for one in budgets for part in one.contributions)
    held = (
        "treats them as scatter, so a single wrong step may change a value by more"
        if is_in
        else "includes only the scatter that the fit found"
    )
    return f"the diagnosis cannot explain all residuals: the uncertainty {held}"


def by_term(findings: Iterable[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """Return findings, the surest and largest first; faults of one kind, or more than `MANY`, stand together."""
    by_name = dict[tuple[str, str], list[Mapping[str, Any]]]()
    for each in findings:
        by_name.setdefault((each["effect"], each.get("fault", "")), []).append(each)
    found = list[list[Mapping[str, Any]]]()
    for (_, fault), several in by_name.items():
        found += [several] if fault or len(several) > MANY else [[each] for each in several]
    return sorted(found, key=lambda several: (several[0]["confidence"] == PROPOSED, importance(several[0])))


PROBABILITY_NOTE = (
    "The probability is that the error term acts. Terms that the data cannot separate are alternatives: usually "
    "one of them acts."
)


def alternatives(document: Mapping[str, Any], cause: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the other names that a cause may have, each with its own probability, "" where none is known."""
    names = cause["aliases"] if "aliases" in cause else [name for name in cause["shares"] if " " not in name]
    of_name = {name: term_probability(document, name, cause) for name in names}
    shown = sorted(names, key=lambda name: -(of_name[name] or 0.0))
    return [(name, "" if (p := of_name[name]) is None else probability_text(p)) for name in shown]


def alternatives_in_words(document: Mapping[str, Any], cause: Mapping[str, Any]) -> list[str]:
    """Return the same, each as text: ``gyroscope.bias_drift (0.36)``."""
    return [f"{name} ({p})" if p else name for name, p in alternatives(document, cause)]


def term_probability(document: Mapping[str, Any], name: str, cause: Mapping[str, Any]) -> float | None:
    """Return the one probability of an error term: as a finding, else by all models, else as the cause's name."""
    as_finding: list[float] = [each["probability"] for each in document["findings"] if each["effect"] == name]
    of_models: float | None = document.get("probabilities", {}).get(name, cause.get("shares", {}).get(name))
    return max(as_finding) if as_finding else of_models


def other_terms(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the error terms that no cause names and that are not negligible, each with its probability."""
    named = {name for each in document["findings"] for name in (each["effect"], *each["aliases"])}
    known = {name for one in document.get("unnamed", ()) for name in one["shares"]}
    return [
        (name, probability_text(p))
        for name, p in document.get("probabilities", {}).items()
        if p >= NEGLIGIBLE and name not in named | known
    ]


def unnamed_in_words(cause: Mapping[str, Any]) -> str:
    """Return what a cause without a name looks like, and how."""
    return f"{cause['what']} ({cause['note']})" if cause["note"] else str(cause["what"])


def not_separable_in_words(document: Mapping[str, Any]) -> list[str]:
    """Return the error terms that these measurements cannot show, with what would, a line for each way."""
    by_way = dict[str, list[str]]()
    for name, separate_by in document.get("not_separable", {}).items():
        by_way.setdefault(separate_by, []).append(name)
    return [f"{both(several)}: {way}" for way, several in by_way.items()]


def left_lines(document: Mapping[str, Any]) -> list[str]:
    """Return where what is left shows, a line each."""
    found = list[str]()
    for one in document.get("left", ()):
        p = p_text(one["log10_p"])
        match one["by"]:
            case "temperature" | "time":
                text = f"{one['what']}: {100 * one['size']:.0f} % of the residual follows {one['by']}"
            case _:
                text = f"{one['what']}: {one['size']:.1f} times the expected noise"
        found.append(f"{text} ({p})")
    return found


OFFERED = ("unexplained", "partly")


def searched_in_words(document: Mapping[str, Any]) -> str:
    """Return how many terms were searched, or the offer to search where the verdict leaves something."""
    if (searched := document.get("searched")) is None:
        is_searchable = any(triad in document.get("solution", {}) for triad in TRIADS)
        is_offered = document["verdict"] in OFFERED and is_searchable
        return (
            "--discover searches ten thousand terms for an error term that the catalogue lacks"
            if is_offered
            else ""
        )
    if not searched["terms"]:
        return (
            "--discover searched nothing: it needs a campaign whose positions and rotations determine a triad; "
            "a rate table or a rest does not"
        )
    found = len(document["findings"]) - len(known_findings(document))
    text = "none is significant" if not found else "one is proposed" if found == 1 else f"{found} are proposed"
    adopt = " (`station effects adopt` writes it as a file)" if found else ""
    return f"{searched['terms']} terms were searched: {text}{adopt}"


def not_looked_at(document: Mapping[str, Any]) -> list[str]:
    """Return what of a solution no residual was diagnosed of: gyroscopes that only transfers by hand determine."""
    looked_at = any(error["quantity"].startswith("gyroscope") for error in document["error"])
    is_solved = "gyroscope" in document.get("solution", {}) and "accelerometer" in document["solution"]
    if not is_solved or looked_at:
        return []
    return ["not diagnosed: the gyroscopes; transfers by hand determine only their scale factors and a mean bias"]


def warnings_of(solution: Mapping[str, Any]) -> list[str]:
    """Return the warnings of a diagnosed solution, without the advice to diagnose it; none of an empty one."""
    return [text.removesuffix(_ADVICE) for text in solution.get("warnings", [])]


_ADVICE = "; run `station diagnose`"
