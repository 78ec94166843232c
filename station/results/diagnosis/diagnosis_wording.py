"""What a diagnosis says, in words."""

from collections.abc import Mapping, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

from procedures.inference.result import Because
from procedures.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, PPM_PER_ONE, UG_PER_G
from station.text import significant

if TYPE_CHECKING:
    from procedures.uncertainty.budget import ParameterBudget

PROPOSED = "proposed"
PROPOSED_IN_WORDS = "proposed: it is not in the catalogue and not in the solution; confirm it with other data"
SAMPLE_EFFECTS = (
    "auxiliary.periodic", "accelerometer.count_periodic", "gyroscope.count_periodic", "disturbance.line",
    "accelerometer.vibration_rectification",
    "gyroscope.vibration_rectification",
)  # fmt: skip
LEFT_TITLE = "largest residuals"
UNEXPLAINED = "unexplained"  # as `procedures.uncertainty.sources` names it
OTHERS_TITLE = "other error terms considered, with their probability"
NEGLIGIBLE = 0.01  # a probability that is not listed
BEYOND_BELIEF = 10.0  # times its expected size, from which on a coefficient is questioned
MIN_LOG10_P = -300  # below which a p-value is only known to be below


def confidence_in_words(finding: Mapping[str, Any]) -> str:
    """Return in words how sure a finding's name is, and how much of the error held out it removes."""
    text = f"{finding['confidence']}, probability {probability_text(finding['probability'])}"
    if finding["confidence"] == PROPOSED:
        text = f"{PROPOSED_IN_WORDS}; probability {probability_text(finding['probability'])}"
    if finding["aliases"]:
        joint = finding.get("joint_probability", 1.0)
        text += f"; the data cannot separate it from the alternatives (together {probability_text(joint)})"
    share = finding.get("share", 0.0)
    whole = "the samples' variance" if is_of_samples(finding) else "the squared held-out error"
    return f"{text}; it explains {share_text(share)} of {whole}" if share >= NEGLIGIBLE else text


def probability_text(p: float) -> str:
    """Return a probability as text: ``0.42``, ``0.996``, ``> 0.999``."""
    if p > 0.999:
        return "> 0.999"
    return f"{p:.3f}" if p > 0.95 else f"{p:.2f}" if p >= NEGLIGIBLE else "< 0.01"


def alternatives_in_words(finding: Mapping[str, Any]) -> str:
    """Return the names that a finding may have instead, each with its probability where that is known."""
    shares = finding.get("shares", {})
    return ", ".join(
        f"{name} ({probability_text(shares[name])})" if name in shares else name for name in finding["aliases"]
    )


def unnamed_in_words(cause: Mapping[str, Any]) -> str:
    """Return what a cause without a name looks like, and how."""
    return f"{cause['what']} ({cause['note']})" if cause["note"] else str(cause["what"])


def meaning_of(name: str) -> str:
    """Return what an error term is, in words: ``Second-order nonlinearity of the accelerometers``."""
    from procedures.effects import MEANINGS

    return MEANINGS.get(name, "")


def other_terms(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the error terms that are no findings and not negligible, each with its probability."""
    named = {finding["effect"] for finding in document["findings"]}
    known = {name for one in document.get("unnamed", ()) for name in one["shares"]}
    return [
        (name, probability_text(p))
        for name, p in document.get("probabilities", {}).items()
        if p >= NEGLIGIBLE and name not in named | known
    ]


def not_separable_in_words(document: Mapping[str, Any]) -> str:
    """Return the error terms that these measurements cannot show, and what would; nothing where there are none."""
    if not (names := document.get("not_separable", {})):
        return ""
    by_way = dict[str, list[str]]()
    for name, separate_by in names.items():
        by_way.setdefault(separate_by, []).append(name)
    text = "; ".join(f"{both(several)} ({way})" for way, several in by_way.items())
    return f"not separable here from the calibration itself (what would separate them): {text}"


def share_text(share: float) -> str:
    """Return a share (0 to 1) in percent, with two digits below 10 %."""
    return f"{100 * share:.0f} %" if share > 0.095 else f"{100 * share:.2g} %"


EQUATIONS = {  # of what acts sample by sample, a the channel, the count or the time
    "auxiliary.periodic": "sum of cos_h cos(2 pi h a / P) + sin_h sin(2 pi h a / P)",
    "accelerometer.vibration_rectification": "K (a - mean)^2",
    "gyroscope.vibration_rectification": "K (sum of (a - mean)^2 over the accelerometers)",
    "auxiliary.channel": "c a(t - lag)",
    "disturbance.line": "sum of cos_h cos(2 pi h f t) + sin_h sin(2 pi h f t), or a sine whose phase wanders",
}  # fmt: skip


def equation_of(finding: Mapping[str, Any]) -> str:
    """Return what a finding adds to the sensors' output, as the catalogue has it."""
    if is_of_samples(finding):
        return EQUATIONS.get(finding["effect"], EQUATIONS["auxiliary.periodic"])
    if "term" in finding:  # of a file of its own, not of the catalogue
        return " + ".join(f"c ({term})" for term in finding["term"])
    if finding["effect"].endswith(".bias_walk"):  # a size, not columns of the catalogue
        return "a bias that steps at random, with standard deviation = value * sqrt(hours)"
    from procedures.effects import EFFECTS

    return next((effect.physics for effect in EFFECTS if effect.name == finding["effect"]), "")


def is_of_samples(finding: Mapping[str, Any]) -> bool:
    """Say whether a finding is one of `procedures.samples.sample_effects`: it is not in the means."""
    lagged = finding["effect"] == "auxiliary.channel" and bool(finding.get("shape"))
    return lagged or finding["effect"] in SAMPLE_EFFECTS


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


TAKEN_FOR_SCATTER = (
    "The uncertainty in a report or a calibration treats the residual as scatter of all steps. A single wrong "
    "step may change a value by more."
)


def verdict_title(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/2`'s verdict in a word or some, as a title."""
    if "log10_p" not in document:
        return "not enough data to calibrate"
    return "solved, but not checked" if nothing_is_left(document) else str(document["verdict"])


def nothing_is_left(document: Mapping[str, Any]) -> bool:
    """Say whether as many numbers were fitted as there are data: no residual is left to judge them by."""
    dof = document.get("solution", {}).get("residual", {}).get("dof")
    return bool(dof == 0 and document["verdict"] == "consistent")


def verdict_sentence(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/2`'s verdict in plain words."""
    if "log10_p" not in document:
        return "The results of this recording are below."
    found, chance = known_findings(document), p_text(document["log10_p"])
    sure, possible = ([f for f in found if (f["confidence"] == "possible") is so] for so in (False, True))
    match document["verdict"]:
        case "consistent" if nothing_is_left(document):
            return (
                "There are as many unknowns as measurements, so no residual can show an error. Repeat rests, or "
                "record more attitudes, to check the result."
            )
        case "consistent":
            return f"Residuals are consistent with noise ({chance}). No further error term was detected."
        case "established" | "likely":
            return f"{_named(sure)} With that in the model, residuals are consistent with noise ({chance})."
        case "ambiguous":
            besides = f" Also found: {_named(sure)}" if sure else ""
            return (
                f"An error term was detected, but the data cannot determine which: {_groups(possible)}.{besides}"
            )
        case _:
            known = f"{_named(sure)} " if sure else ""
            maybe = f" Possible: {_groups(possible)}." if possible else ""
            return f"{known}{_excess_text(document, chance, is_after=bool(sure))}{maybe} {TAKEN_FOR_SCATTER}"


def _named(findings: Sequence[Mapping[str, Any]]) -> str:
    """Return a sentence for each finding: what it is, its probability, the error held out without and with it."""
    wording = list[str]()
    for one in findings:
        what = meaning_of(one["effect"])
        name = f"{what} ({one['effect']}" if what else f"{one['effect']} ("
        text = f"{name}, probability {probability_text(one['probability'])})".replace("(, ", "(")
        if reduced := reduction_in_words(one):
            text += f": {reduced}"
        wording.append(f"{text}.")
    return " ".join(dict.fromkeys(wording))


def reduction_in_words(finding: Mapping[str, Any]) -> str:
    """Return by how much the error held out falls with a finding in the model, where it falls most."""
    errors = [e for e in finding.get("error", ()) if e.get("held_out_before") and "held_out_after" in e]
    if not errors or finding.get("share", 0.0) < NEGLIGIBLE:
        return ""
    best = min(errors, key=lambda e: e["held_out_after"] / e["held_out_before"])
    scale, unit = shown_unit(best["unit"])
    before, after = (best[f"held_out_{when}"] * scale for when in ("before", "after"))
    return f"the error of {best['quantity']} held out falls from {before:.3g} to {after:.3g} {unit}"


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
        found += [f"No known error term explains {both(once)}."] if code == Because.NAMELESS else once
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


def p_text(log10_p: float) -> str:
    """Return a p-value as text: ``p = 0.38``, ``p = 2e-12``, ``p < 1e-300``."""
    if log10_p <= MIN_LOG10_P:
        return f"p < 1e{MIN_LOG10_P}"
    return f"p = {10**log10_p:.2g}" if log10_p > -3 else f"p = {10**log10_p:.0e}"


def notes(finding: Mapping[str, Any]) -> list[str]:
    """Return what else is to be reported of a finding, a sentence each."""
    found = list[str]()
    if (angle := finding.get("levelling_deg")) is not None:
        along = [f"{degrees(c['value']):.2f} along {n[-1]}" for n, c in finding["coefficients"].items()]
        found.append(f"the face is {angle:.2f} deg off the vertical: {', '.join(along)}")
    if (times := finding.get("times_expected", 0.0)) > BEYOND_BELIEF:
        found.append(f"it is {significant(times)} times the expected size: check the unit and the channel")
    if shape := finding.get("shape"):
        found.append(f"shape: {shape}")
    if same := finding.get("same_here"):
        found.append(
            f"at the one attitude recorded it is indistinguishable from {both(same)}: record a second attitude"
        )
    if finding.get("unit") == "position":
        actual = both([str(round(one["value"])) for one in finding["coefficients"].values()])
        found.append(f"the cube stood in position {actual}: record it so")
    if finding.get("unit") == "direction":
        found.append(
            "these rotations are labelled with the wrong direction: with these labels the gyroscopes would count "
            "backwards, but the Earth's rate in the dwells shows that they count forwards; this diagnosis uses "
            "the opposite direction, `station solve` uses the labels"
        )
    position = finding["where"].get("position")
    if isinstance(position, list):
        found.append(
            f"the data cannot determine which of these positions it was: it is solved as position {position[0]}; "
            f"another position would change face parallelism and misalignments; their uncertainties include that"
        )
    return found


def both(names: Sequence[str]) -> str:
    """Return names as an English list."""
    once = list(dict.fromkeys(names))
    return " and ".join([", ".join(once[:-1]), once[-1]] if len(once) > 1 else once)


def where_text(where: Mapping[str, Any]) -> str:
    """Return what a finding is about: ``position 3 or 4, dwell_03.csv``."""
    wording = list[str]()
    for name, value in where.items():
        joined = " or " if name == "position" else ", "  # one position of several, but all channels
        parts = value if isinstance(value, list) else [value]
        text = joined.join(f"{each:.6g}" if isinstance(each, float) else str(each) for each in parts)
        wording.append(text if name == "file" else f"{name} {text}")
    return ", ".join(wording)


def size_in_sigmas(value: float, std: float) -> str:
    """Return how large a coefficient is in units of its standard uncertainty u."""
    sigmas = abs(value) / std
    return f"{sigmas:.2g} u" if sigmas >= 1e6 else f"{sigmas:.0f} u" if sigmas >= 10 else f"{sigmas:.1f} u"


def _groups(findings: Sequence[Mapping[str, Any]]) -> str:
    groups = [
        f"{one['effect']} ({probability_text(one['probability'])})"
        + (f" or {alternatives_in_words(one)}" if one["aliases"] else "")
        for one in findings
    ]
    return "; and ".join(dict.fromkeys(groups))


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
