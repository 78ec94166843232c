"""A `diagnosis/2` as text to read in 80 columns: the verdict first, then what it rests on."""

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

from procedures.effects.excitation import UNITS_OF_NONLINEAR
from station.results.diagnosis.diagnosis_wording import (
    LEFT_TITLE,
    OTHERS_TITLE,
    PROPOSED,
    alternatives_in_words,
    confidence_in_words,
    known_findings,
    left_lines,
    not_separable_in_words,
    notes,
    other_terms,
    probability_text,
    reduction_in_words,
    shown_unit,
    size_in_sigmas,
    unnamed_in_words,
    verdict_sentence,
    verdict_title,
    where_text,
)  # fmt: skip
from station.results.diagnosis.uncalibrated import channel_lines, rests_and_moves_lines, turns_lines
from station.results.parameters_by_name import Parameter, shown, shown_sigma, title_of
from station.results.report.noise_document import noise_summary
from station.results.solution_text import effect_lines, measured

READINGS_SHOWN = 6  # readings
OFFERED = ("unexplained", "partly")


def proposed_lines(finding: Mapping[str, Any]) -> list[str]:
    """Return what is reported of a proposed finding in addition to its coefficients; nothing of another."""
    if finding["confidence"] != PROPOSED:
        return []
    return [line for text in proposed_in_words(finding) for line in _wrapped(text)] + [
        f"      {line}" for line in readings_in_words(finding)
    ]


def proposed_in_words(finding: Mapping[str, Any]) -> list[str]:
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


def readings_in_words(finding: Mapping[str, Any]) -> list[str]:
    """Return the terms that read the same here, the best first, each with how alike they are."""
    return [
        f"{_term(one)}, correlation {one['correlation']:.3f}"
        for one in finding.get("readings", ())[:READINGS_SHOWN]
    ]


def searched_in_words(document: Mapping[str, Any]) -> str:
    """Return how many terms were searched, or the offer to search where the verdict leaves something."""
    if (searched := document.get("searched")) is None:
        is_offered = document["verdict"] in OFFERED and "solution" in document
        return (
            "--discover searches ten thousand terms for an error term that the catalogue lacks"
            if is_offered
            else ""
        )
    found = len(document["findings"]) - len(known_findings(document))
    text = "none is significant" if not found else "one is proposed" if found == 1 else f"{found} are proposed"
    adopt = " (`station effects adopt` writes it as a file)" if found else ""
    return f"{searched['terms']} terms were searched: {text}{adopt}"


def _term(one: Mapping[str, Any]) -> str:
    several = len(one["term"]) > 1
    return " + ".join(f"c{i if several else ''} ({term})" for i, term in enumerate(one["term"], 1))


def _wrapped(text: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent="   ", subsequent_indent="   ", break_long_words=False)


WIDTH = 80
MAX_COEFFICIENTS = 12  # of a finding that are listed; the largest in sigmas
ROUNDING = 1e-9  # ug, deg/h ..: no error of an instrument is as small
MAX_MOVED = 8
RATE_TABLE_TITLE = "on the rate table; the output at rest includes the Earth's rate along its axis"
MIN_SHIFT_SIGMAS = 1.0  # sigma
MAX_OTHERS = 6
TEXTBOOK_BIASES = ("bias_12_position", "bias_two_direction")  # their sigma is counting noise only


def diagnosis_text(document: Mapping[str, Any]) -> str:
    """Return the summary that `station diagnose` prints; +- is the standard uncertainty u."""
    lines = _fold(f"{verdict_title(document).upper()}. {verdict_sentence(document)}", "")
    if causes := list(_causes(document)):
        lines += ["", *causes]
    if declared := document.get("solution", {}).get("effects"):
        lines += [
            "",
            "in the model from the start",
            *(f"   {line}" for one in declared for line in effect_lines(one)),
        ]
    for number, finding in enumerate(document["findings"], 1):
        lines += ["", *_finding(number, finding)]
    for title, part in (
        (RATE_TABLE_TITLE, [f"   {name:<27}{value}" for name, value in table_rows(document.get("solution", {}))]),
        ("error (rms), without -> with the findings in the model", list(_errors(document["error"]))),
        (LEFT_TITLE, [f"   {line}" for line in left_lines(document)]),
        ("parameters that changed most (change in units of u)", list(_moved(document["parameters"]))),
        (OTHERS_TITLE, [f"   {name:<44} {p}" for name, p in other_terms(document)[:MAX_OTHERS]]),
    ):
        if part:
            lines += ["", title, *part]
    if moved := [*rests_and_moves_lines(document), *turns_lines(document)]:
        lines += ["", *moved]
    if noise := document.get("noise"):
        lines += ["", "noise at rest, 95 % (all five terms, spectrum and lines: `station noise`)"]
        lines += [f"   {line}" for line in noise_summary(noise)]
    if channels := document.get("channels"):
        lines += ["", *channel_lines(channels)]
    if wording := searched_in_words(document):
        lines += ["", *_fold(wording, "")]
    if wording := not_separable_in_words(document):
        lines += ["", *_fold(wording, "")]
    if document["next_measurement"]:
        lines += ["", *_fold(f"measure next: {document['next_measurement']}", "")]
        lines += [_PLAN] if "solution" in document else []
    if missing := document.get("not_observable"):
        lines += ["", *_fold(f"not observable: {', '.join(missing)}", "")]
    if wording := not_looked_at(document):
        lines += ["", *_fold(wording, "")]
    if warnings := warnings_of(document.get("solution", document)):
        lines += ["", *(line for text in warnings for line in _fold(f"warning: {text}", ""))]
    return "\n".join(lines)


_PLAN = "(--plan FILE writes its steps for `station calibrate --plan FILE`)"


def not_looked_at(document: Mapping[str, Any]) -> str:
    """Return what of a solution no residual was diagnosed of: gyroscopes that only transfers by hand determine."""
    looked_at = any(error["quantity"].startswith("gyroscope") for error in document["error"])
    is_solved = "gyroscope" in document.get("solution", {}) and "accelerometer" in document["solution"]
    if not is_solved or looked_at:
        return ""
    return "not diagnosed: the gyroscopes; transfers by hand determine only their scale factors and a mean bias"


def warnings_of(solution: Mapping[str, Any]) -> list[str]:
    """Return the warnings of a diagnosed solution, without the advice to diagnose it; none of an empty one."""
    return [text.removesuffix(_ADVICE) for text in solution.get("warnings", [])]


_ADVICE = "; run `station diagnose`"


def coefficient_unit(name: str, unit: str) -> tuple[float, str]:
    """Return the same of a coefficient: a time constant is in s, ``x.2`` of an effect in g/K in g/K^2."""
    if name in UNITS_OF_NONLINEAR:
        return 1.0, UNITS_OF_NONLINEAR[name]
    scale, shown = shown_unit(unit)
    order = name.rpartition(".")[2]
    return scale, f"{shown}^{order}" if shown.endswith("/K") and order.isdigit() and int(order) > 1 else shown


def coefficient_rows(finding: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return name, value with sigma and unit, and size in sigmas of a finding's largest coefficients."""
    found = finding["coefficients"]
    own = finding.get("units", {})  # of the parameters of a term
    shown = {n: (1.0, own[n]) if n in own else coefficient_unit(n, finding["unit"]) for n in found}
    strength = {name: abs(c["value"]) / c["std"] if c["std"] > 0 else 0.0 for name, c in found.items()}
    kept = sorted(found, key=lambda name: -strength[name])[:MAX_COEFFICIENTS]
    return [
        (name, measured(c["value"] * scale, c["std"] * scale, unit), size_in_sigmas(c["value"], c["std"]))
        for name, c in found.items()
        for scale, unit in [shown[name]]
        if name in kept and c["std"] > 0
    ]


def _finding(number: int, finding: Mapping[str, Any]) -> list[str]:
    where = where_text(finding["where"])
    lines = [f"{number}. {finding['effect']} ({finding['kind']}){f', {where}' if where else ''}"]
    lines += _fold(confidence_in_words(finding), "   ")
    for note in notes(finding):
        lines += _fold(note, "   ")
    for name, value, sigmas in coefficient_rows(finding):
        lines.append(f"   {name:<9} {value:<44} {sigmas:>12}")
    if len(finding["coefficients"]) > MAX_COEFFICIENTS:
        lines.append(f"   ... and {len(finding['coefficients']) - MAX_COEFFICIENTS} more, smaller")
    lines += proposed_lines(finding)
    if finding["aliases"]:
        lines += _fold(f"it may also be: {alternatives_in_words(finding)}", "   ")
        lines += _fold(f"to separate them: {finding['separate_by']}", "   ")
    return lines


def cause_rows(document: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return every cause with its probability, and the error held out without and with it, named ones first."""
    rows = list[tuple[str, str, str]]()
    for finding in document["findings"]:
        held_out = reduction_in_words(finding).partition(" from ")[2].replace(" to ", " -> ")
        rows.append((finding["effect"], probability_text(finding["probability"]), held_out))
    for one in document.get("unnamed", ()):
        names = [
            name for name, p in one["shares"].items() if not name.startswith(("a ", one["what"])) and p > 0.05
        ]
        other = f"; or {', '.join(names)}" if names else ""
        rows.append((f"unnamed: {unnamed_in_words(one)}{other}", probability_text(one["joint_probability"]), ""))
    return rows


def error_rows(errors: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, str, str, str]]:
    """Return quantity, unit, error in the campaign, error held out, and how it was held out."""
    found = []
    for error in errors:
        scale, unit = shown_unit(error["unit"])
        pairs = [
            f"{_plain(error[b] * scale)} -> {_plain(error[a] * scale)}" if b in error and a in error else ""
            for b, a in (("before", "after"), ("held_out_before", "held_out_after"))
        ]
        found.append((error["quantity"], unit, *pairs, error["method"]))
    return found


def _plain(value: float) -> str:
    """Return an error with three digits; 0 where only rounding is left."""
    return f"{value:.3g}" if value > ROUNDING else "0"


def _errors(errors: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    text = ""
    for quantity, unit, inside, held_out, method in error_rows(errors):
        if method != text:
            text = method
            title = "validation data" if method.startswith("validation") else "held out"
            yield f"   {'':<24} {'unit':<8} {'in the data':<20} {title}"
            yield from _fold(f"({method})", "   ")
        yield f"   {quantity:<24} {unit:<8} {inside:<20} {held_out:<20}".rstrip()


def moved_rows(parameters: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, str, str, str]]:
    """Return title, before, after with sigma, unit and shift in sigmas of those that moved most."""
    notable = [
        p
        for p in parameters
        if abs(p["shift_sigma"]) >= MIN_SHIFT_SIGMAS and p["name"].split(".")[1] not in TEXTBOOK_BIASES
    ]
    notable.sort(key=lambda row: -abs(row["shift_sigma"]))
    found = []
    for row in notable[:MAX_MOVED]:
        one = Parameter(row["name"], row["after"], row["std"], row["unit"])
        after, unit = shown(one)
        before, _ = shown(one, row["before"])
        found.append((title_of(row["name"]), before, f"{after} +- {shown_sigma(one)}", unit,
                      _sigmas(row["shift_sigma"])))  # fmt: skip
    return found


def _sigmas(shift: float) -> str:
    return f"{shift:+.1f}" if abs(shift) < 999.5 else f"{shift:+.0f}" if abs(shift) < 99999 else f"{shift:+.0e}"


def table_rows(solution: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what rate tables gave: name, and value with sigma and unit."""
    found = solution.get("rate_tables", {"gyroscope": {}, "unit": {}})
    return [
        (f"gyroscope {name.replace('_', ' ')} {axis}", measured(one["value"], one["std"], found["unit"][name]))
        for name, sensors in found["gyroscope"].items()
        for axis, one in sensors.items()
    ]


def _moved(parameters: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    rows = moved_rows(parameters)
    if rows:
        yield f"  {'':<29} {'before':>10} {'after +- u':>18} {'unit':<11} {'change':>6}"
    for title, before, after, unit, sigmas in rows:
        yield f"  {title:<29} {before:>10} {after:>18} {unit:<11} {sigmas:>6}"


def _causes(document: Mapping[str, Any]) -> Iterator[str]:
    rows = cause_rows(document)
    if len(rows) > 1 or document.get("unnamed"):
        yield f"   {'cause':<44} {'probability':<12} held-out error"
        for name, probability, held_out in rows:
            first, *more = wrap(name, 44, break_long_words=False)
            yield f"   {first:<44} {probability:<12} {held_out}".rstrip()
            yield from (f"     {line}" for line in more)


def _fold(text: str, indent: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_long_words=False)
