"""A `diagnosis/1` as text to read in 80 columns: the verdict first, then what it rests on."""

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

from procedures.effects.effect import UNITS_OF_NONLINEAR
from procedures.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, PPM_PER_ONE, UG_PER_G
from station.results.diagnosis.diagnosis_wording import (
    CHANCE_OF_FINDING,
    LEFT_TITLE,
    NO_SIGN_LOG10_P,
    TRIED_TITLE,
    confidence_said,
    left_lines,
    notes,
    p_text,
    size_in_sigmas,
    verdict_sentence,
    verdict_title,
    where_text,
)  # fmt: skip
from station.results.diagnosis.proposed_wording import proposed_lines, searched_said
from station.results.diagnosis.rests_and_moves_said import rests_and_moves_lines
from station.results.diagnosis.single_channels import channel_lines
from station.results.diagnosis.turns_said import turns_lines
from station.results.noise.noise_text import noise_summary
from station.results.parameters_by_name import Parameter, shown, shown_sigma, title_of
from station.results.solution_text import effect_lines, measured

WIDTH = 80
MAX_COEFFICIENTS = 12  # of a finding that are listed; the largest in sigmas
ROUNDING = 1e-9  # ug, deg/h ..: no error of an instrument is as small
MAX_MOVED = 8
RATE_TABLE_TITLE = "on the rate table; the output at rest includes the Earth's rate along its axis"
MIN_SHIFT_SIGMAS = 1.0  # sigma
MAX_TRIED = 6
TEXTBOOK_BIASES = ("bias_12_position", "bias_two_direction")  # their sigma is counting noise only


def diagnosis_text(document: Mapping[str, Any]) -> str:
    """Return the summary that `station diagnose` prints; +- is the standard uncertainty u."""
    lines = _fold(f"{verdict_title(document).upper()}. {verdict_sentence(document)}", "")
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
        (TRIED_TITLE, list(_tried(document["tried"]))),
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
    if said := searched_said(document):
        lines += ["", *_fold(said, "")]
    if document["next_measurement"]:
        lines += ["", *_fold(f"measure next: {document['next_measurement']}", "")]
        lines += [_PLAN] if "solution" in document else []
    if missing := document.get("not_observable"):
        lines += ["", *_fold(f"not observable: {', '.join(missing)}", "")]
    if said := not_looked_at(document):
        lines += ["", *_fold(said, "")]
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


def shown_unit(unit: str) -> tuple[float, str]:
    """Return by what a value in a file's ``unit`` is multiplied for people, and the unit it then has.

    An error in deg is shown in arcsec, deg/h as it is. Only what stands before the first ``/`` is changed: g/g^2
    becomes ug/g^2, 1/K ppm/K.
    """
    if unit == "deg":
        return ARCSEC_PER_DEG, "arcsec"
    head, slash, rest = unit.partition("/")
    scale, name = {
        "g": (UG_PER_G, "ug"),
        "rad": (ARCSEC_PER_RAD, "arcsec"),
        "1": (PPM_PER_ONE, "ppm"),
        "": (PPM_PER_ONE, "ppm"),
    }.get(head, (1.0, head))
    return scale, f"{name}{slash}{rest}"


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
    lines += _fold(confidence_said(finding), "   ")
    if chance := finding_chance(finding):
        lines += _fold(chance, "   ")
    for note in notes(finding):
        lines += _fold(note, "   ")
    for name, value, sigmas in coefficient_rows(finding):
        lines.append(f"   {name:<9} {value:<44} {sigmas:>12}")
    if len(finding["coefficients"]) > MAX_COEFFICIENTS:
        lines.append(f"   ... and {len(finding['coefficients']) - MAX_COEFFICIENTS} more, smaller")
    lines += proposed_lines(finding)
    if finding["aliases"]:
        lines += _fold(f"indistinguishable from: {', '.join(finding['aliases'])}", "   ")
        lines += _fold(f"to separate them: {finding['separate_by']}", "   ")
    return lines


def finding_chance(finding: Mapping[str, Any]) -> str:
    """Say how often noise alone would look as much like a finding; nothing of one that was not tested."""
    if "log10_p" not in finding:
        return ""
    if "searched_p" in finding:  # of draws of noise, so many and no more
        return f"{p_text(finding['log10_p'])} or less, corrected for all terms searched"
    return f"{p_text(finding['log10_p'])}, {CHANCE_OF_FINDING}"


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
    said = ""
    for quantity, unit, inside, held_out, method in error_rows(errors):
        if method != said:
            said = method
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


def tried_rows(tried: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Return the error terms that were tried first, the clearest of them, with their p-values."""
    return [
        (each["effect"], "not significant" if p > NO_SIGN_LOG10_P else p_text(p))
        for each in tried
        for p in (each["log10_p_adjusted"],)
    ]


def _tried(tried: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    rows = tried_rows(tried)
    for effect, p in rows[:MAX_TRIED]:
        yield f"   {effect:<36} {p}"
    if rest := [effect for effect, _ in rows[MAX_TRIED:]]:
        yield from _fold(f"and {', '.join(rest)}", "   ")


def _fold(text: str, indent: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_long_words=False)
