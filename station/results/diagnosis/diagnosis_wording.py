"""What a diagnosis says, in words."""

from collections.abc import Mapping, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from procedures.uncertainty.budget import ParameterBudget

SURE = {
    "established": "established: it repeats on what was left out, and nothing else looks like it",
    "likely": "likely: nothing else looks like it, but the evidence is thinner",
    "ambiguous": "ambiguous: this data cannot tell it from what is named below",
}
UNEXPLAINED = "unexplained"  # as `procedures.uncertainty.sources` names it
P_OF = "beside all other findings, counting all that was tried"  # of a finding; not that of its first trial
TRIED_HOW = "each by itself on the model without findings, p after Holm"
LEAST_P = -300  # log10 below which a p-value is only said to be below


def verdict_sentence(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/1`'s verdict in plain words."""
    if "log10_p" not in document:
        return "Neither triad can be solved; how level the cube stood is all that can be said."
    names = [finding["effect"] for finding in document["findings"]]
    p = p_text(document["log10_p"])
    match document["verdict"]:
        case "consistent":
            return f"The residual is what noise leaves (p {p}): the model lacks nothing that this data can show."
        case "established" | "likely":
            known = _named(document["findings"], "" if document["verdict"] == "established" else " probably")
            return f"{known}. With that in, the residual is what noise leaves (p {p})."
        case "ambiguous":
            sure = [f["effect"] for f in document["findings"] if f["confidence"] != "ambiguous"]
            beside = f" Sure beside it, and in the solution: {both(sure)}." if sure else ""
            return f"Something is there, but this data cannot say what: {_groups(document['findings'])}.{beside}"
        case _:
            found = f", also with {both(names)} in the model" if names else ""
            return (
                f"The residual is more than noise (p {p}){found}, and no effect of the catalogue accounts for it: "
                f"it is unexplained. The sigmas here cover only the scatter that the fit found; the uncertainty "
                f"of a report or a calibration holds the rest."
            )


def left_said(document: Mapping[str, Any], budgets: Sequence["ParameterBudget"]) -> str:
    """Return what a verdict on limits must say of a residual that is unexplained; nothing of any other."""
    if document["verdict"] != "unexplained":
        return ""
    is_in = any(part.source == UNEXPLAINED for one in budgets for part in one.contributions)
    held = "what is left is in the uncertainty" if is_in else "the uncertainty holds the scatter the fit found"
    return f"the diagnosis is unexplained, the residual is more than noise: {held}"


def p_text(log10_p: float) -> str:
    """Return a p-value with one or two digits, however small."""
    if log10_p <= LEAST_P:
        return f"< 1e{LEAST_P}"
    exponent = int(log10_p // 1)
    return f"{10**log10_p:.2g}" if log10_p > -3 else f"{min(10 ** (log10_p - exponent), 9):.0f}e{exponent}"


def notes(finding: Mapping[str, Any]) -> list[str]:
    """Return what else is to be said of a finding, a sentence each."""
    found = list[str]()
    if (p := finding.get("sign_flip_p")) is not None:
        draws = f"{1000 * p:.0f} of 1000 draws come out as large, the finding itself counted"
        found.append(f"with the signs of the residual flipped at random {draws}")
    if (angle := finding.get("levelling_deg")) is not None:
        along = [f"{degrees(c['value']):.2f} along {n[-1]}" for n, c in finding["coefficients"].items()]
        found.append(f"the vertical stands {angle:.2f} deg off the face: {', '.join(along)}")
    if shape := finding.get("shape"):
        found.append(f"shape: {shape}")
    if finding.get("unit") == "direction":
        found.append(
            "these turns are labelled in the opposite direction: by them the gyroscopes count backwards, by the "
            "Earth's rate in the dwells forwards; they are solved the other way round here, not by `station solve`"
        )
    position = finding["where"].get("position")
    if isinstance(position, list):
        found.append(
            f"which of these positions it was this data cannot tell: it is solved as position {position[0]}, and "
            f"face parallelism and misalignments would be others if it was another, and their sigmas hold both"
        )
    if finding.get("effect") == "fixture.parallelism" and (channels := finding["where"].get("channel")):
        found.append(
            f"part of it is fixture, or a seating, for certain: along {', '.join(channels)} the two pairs of "
            f"faces differ, which no term of the sensor does"
        )
    return found


def both(names: Sequence[str]) -> str:
    """Return names as an English list."""
    once = list(dict.fromkeys(names))
    return " and ".join([", ".join(once[:-1]), once[-1]] if len(once) > 1 else once)


def where_text(where: Mapping[str, Any]) -> str:
    """Return what a finding is about: ``position 3 or 4, dwell_03.csv``."""
    said = []
    for name, value in where.items():
        joined = " or " if name == "position" else ", "  # one position of several, but all channels
        text = joined.join(map(str, value)) if isinstance(value, list) else str(value)
        said.append(text if name == "file" else f"{name} {text}")
    return ", ".join(said)


def size_in_sigmas(value: float, std: float) -> str:
    """Return how large a coefficient is in its own sigma."""
    return (
        f"{abs(value) / std:.0f} sigma" if std > 0 and abs(value) >= 10 * std else f"{abs(value) / std:.1f} sigma"
    )


def _named(findings: Sequence[Mapping[str, Any]], doubt: str) -> str:
    """Say what was found; slab and faces the model holds from the start."""
    bench = [f["effect"] for f in findings if f["kind"] == "bench"]
    lacked = [f["effect"] for f in findings if f["kind"] != "bench"]
    said = [f"the model{doubt} lacked {both(lacked)}"] if lacked else []
    said += [f"the bench{doubt} has {both(bench)}"] if bench else []
    text = "; ".join(said)
    return text[0].upper() + text[1:]


def _groups(findings: Sequence[Mapping[str, Any]]) -> str:
    doubtful = [f for f in findings if f["confidence"] == "ambiguous"]
    groups = [" or ".join(dict.fromkeys((f["effect"], *f["aliases"]))) for f in doubtful]
    return "; and ".join(dict.fromkeys(groups))
