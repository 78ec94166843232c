"""What a diagnosis says, in words."""

from collections.abc import Mapping, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

from procedures.diagnosis.result import Because
from station.text import significant

if TYPE_CHECKING:
    from procedures.uncertainty.budget import ParameterBudget

CONFIDENCE_SAID = {
    "established": "established: it also predicts held-out data, and no other error term fits as well",
    "likely": "likely: no other error term fits as well, but there is less evidence",
    "ambiguous": "ambiguous",
    "proposed": "proposed: it is not in the catalogue and not in the solution; confirm it with other data",
}
PROPOSED = "proposed"
REASONS_SAID: Mapping[str, str] = {  # of an ambiguous finding
    Because.ALTERNATIVE: "the data cannot separate it from the error terms named below",
    Because.CURVE: "a smooth curve ({what}) predicts held-out data better by {value:.1f} in log density",
    Because.WALK: "a random walk of the bias explains the data as well",
    Because.PATTERN: "it explains {percent} of the excess and leaves a pattern that is not noise: it is only a "
    "part of the cause, or another error term looks similar",
    Because.SMALL_SHARE: "it explains only {percent} of the excess on held-out data",
    Because.NOT_SIGNIFICANT: "it is not significant ({chance})",
    Because.MEMORY: "another dependence on earlier steps explains the data as well",
    Because.NOT_DETERMINED: "the data do not determine its time constant or knee",
    Because.SINGLE_STEP: "residuals exceed noise, and a single wrong step may cause this",
    Because.NEIGHBOUR: "another step in the same recording is close to it",
    Because.TOGETHER: "another ambiguous finding of the {what} depends on temperature or time too",
}
PART_OF_A_CAUSE = "it may be only a part of the cause"  # of an ambiguous finding that states no reason
SAMPLE_EFFECTS = (
    "auxiliary.periodic", "accelerometer.count_periodic", "gyroscope.count_periodic", "disturbance.line",
    "accelerometer.vibration_rectification",
    "gyroscope.vibration_rectification",
)  # fmt: skip
LEFT_TITLE = "largest residuals"
UNEXPLAINED = "unexplained"  # as `procedures.uncertainty.sources` names it
CHANCE_OF_FINDING = (
    "with all other findings in the model, corrected for all error terms tried"  # not its first trial
)
TRIED_TITLE = "error terms tried, each by itself (a small p means: not noise)"
NO_SIGN_LOG10_P = -1.3  # above it there is no sign of an effect: more than 5 times in 100
MIN_LOG10_P = -300  # below which a p-value is only known to be below


def confidence_said(finding: Mapping[str, Any]) -> str:
    """Return in words how sure a finding's name is, and how much of what noise does not explain it explains."""
    said = CONFIDENCE_SAID[finding["confidence"]]
    if finding["confidence"] == "ambiguous":
        reasons = finding.get("reasons") or [{"code": Because.ALTERNATIVE}] * bool(finding["aliases"])
        said += ": " + ("; ".join(map(reason_said, reasons)) or PART_OF_A_CAUSE)
    share = finding.get("share", 0.0)
    whole = "the samples' variance" if is_of_samples(finding) else "the excess over noise"
    return f"{said}; on held-out data it explains {share_text(share)} of {whole}" if share else said


def reason_said(reason: Mapping[str, Any]) -> str:
    """Return why a finding is ambiguous, in words."""
    value = reason.get("value", 0.0)
    of = {"what": reason.get("what", ""), "value": value, "percent": share_text(max(value, 0.0))}
    return REASONS_SAID[reason["code"]].format(**of, chance=p_text(value) if value < 0 else "p near 1")


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
    """Say whether a finding is one of `procedures.diagnosis.sample_effects`: it is not in the means."""
    lagged = finding["effect"] == "auxiliary.channel" and bool(finding.get("shape"))
    return lagged or finding["effect"] in SAMPLE_EFFECTS


def left_lines(document: Mapping[str, Any]) -> list[str]:
    """Return where what is left shows, a line each."""
    found = list[str]()
    for one in document.get("left", ()):
        p = p_text(one["log10_p"])
        match one["by"]:
            case "temperature" | "time":
                said = f"{one['what']}: {100 * one['size']:.0f} % of the residual follows {one['by']}"
            case _:
                said = f"{one['what']}: {one['size']:.1f} times the expected noise"
        found.append(f"{said} ({p})")
    return found


TAKEN_FOR_SCATTER = (
    "The uncertainty in a report or a calibration treats the residual as scatter of all steps. A single wrong "
    "step may change a value by more."
)


def verdict_title(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/1`'s verdict in a word or some, as a title."""
    if "log10_p" not in document:
        return "not enough data to calibrate"
    return "solved, but not checked" if nothing_is_left(document) else str(document["verdict"])


def nothing_is_left(document: Mapping[str, Any]) -> bool:
    """Say whether as many numbers were fitted as there are data: no residual is left to judge them by."""
    dof = document.get("solution", {}).get("residual", {}).get("dof")
    return bool(dof == 0 and document["verdict"] == "consistent")


def verdict_sentence(document: Mapping[str, Any]) -> str:
    """Return a `diagnosis/1`'s verdict in plain words."""
    if "log10_p" not in document:
        return "The results of this recording are below."
    document = {**document, "findings": known_findings(document)}
    names = [finding["effect"] for finding in document["findings"]]
    chance = p_text(document["log10_p"])
    left = _excess_said(document, chance)
    match document["verdict"]:
        case "consistent" if nothing_is_left(document):
            return (
                "There are as many unknowns as measurements, so no residual can show an error. Repeat rests, or "
                "record more attitudes, to check the result."
            )
        case "consistent":
            return f"Residuals are consistent with noise ({chance}). No further error term was detected."
        case "established" | "likely":
            known = _named(document["findings"], "" if document["verdict"] == "established" else " probably")
            return f"{known}. With that in the model, residuals are consistent with noise ({chance})."
        case "ambiguous":
            sure = [f["effect"] for f in document["findings"] if f["confidence"] != "ambiguous"]
            besides = f" Also found, and in the solution: {both(sure)}." if sure else ""
            return (
                "An error term was detected, but the data cannot determine which: "
                f"{_groups(document['findings'])}.{besides}"
            )
        case "partly":
            sure = [f["effect"] for f in document["findings"] if f["confidence"] != "ambiguous"]
            found = f" with {both(sure)} in the model" if sure else ""
            groups = _groups([f for f in document["findings"] if f.get("share")])
            doubt = f" {groups} would explain a part of it." if groups else ""
            doubt += f" Not accepted: {too_large}." if (too_large := too_large_said(document)) else ""
            return f"{left}{found}: the cause was found in part.{doubt} {TAKEN_FOR_SCATTER}"
        case _:
            found = f", even with {both(names)} in the model" if names else ""
            too_large = too_large_said(document)
            cause = f". Not accepted: {too_large}." if too_large else ", and no known error term explains it."
            return (
                f"{left}{found}{cause} The uncertainties here include only the scatter that the fit found. "
                f"{TAKEN_FOR_SCATTER}"
            )


EXCESS_SAID: Mapping[str, str] = {  # of a verdict `partly` or `unexplained`
    Because.CURVE: "a smooth curve predicts the held-out data better than the findings do ({what})",
    Because.WALK: "a random walk explains the data better than {what}",
    Because.NOT_DETERMINED: "the data do not determine the time constant or knee of {what}",
    Because.MOTION: "the unit moves while it is assumed to be at rest: within a rest the mean output changes by "
    "{mg} mg more than noise. Put it on a firm surface for each rest",
    Because.STRUCTURE: "the samples keep a structure that is not noise: a table by the phase of {what} would "
    "explain {percent} more of their variance",
}


def _excess_said(document: Mapping[str, Any], chance: str) -> str:
    """Return every reason for which more than noise is left, as it is."""
    reasons, said = document.get("reasons", ()), list[str]()
    if not reasons or any(each["code"] == Because.RESIDUAL for each in reasons):
        said.append(f"residuals exceed noise ({chance})")
    for each in reasons:
        if text := EXCESS_SAID.get(each["code"]):
            value = each.get("value", 0.0)
            of = {"percent": share_text(max(value, 0.0)), "mg": significant(1e3 * value)}
            said.append(text.format(what=each.get("what", ""), **of))
    text = "; ".join(dict.fromkeys(said))  # several findings of one name have one reason
    return text[:1].upper() + text[1:]


def known_findings(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the findings without what is only proposed: neither verdict nor solution holds that."""
    return [finding for finding in document["findings"] if finding["confidence"] != PROPOSED]


def too_large_said(document: Mapping[str, Any]) -> str:
    """Return what would explain the rest but for its size, the best of it; nothing where there is none."""
    for one in document.get("too_large", ()):
        return f"{one['effect']} would be {significant(one['times_plausible'])} times its largest plausible size"
    return ""


def left_said(document: Mapping[str, Any], budgets: Sequence["ParameterBudget"]) -> str:
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
    """Return what else is to be said of a finding, a sentence each."""
    found = list[str]()
    if (p := finding.get("sign_flip_p")) is not None:
        draws = f"{1000 * p:.0f} of 1000 draws are as strong (the finding itself counts as one)"
        found.append(f"with the signs of the residuals flipped at random, {draws}")
    if (angle := finding.get("levelling_deg")) is not None:
        along = [f"{degrees(c['value']):.2f} along {n[-1]}" for n, c in finding["coefficients"].items()]
        found.append(f"the face is {angle:.2f} deg off the vertical: {', '.join(along)}")
    if shape := finding.get("shape"):
        found.append(f"shape: {shape}")
    if same := finding.get("same_here"):
        found.append(
            f"at the one attitude recorded it is indistinguishable from {both(same)}: record a second attitude"
        )
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
    if finding.get("effect") == "fixture.parallelism" and (channels := finding["where"].get("channel")):
        found.append(
            f"a part of it certainly comes from the cube or its seating: along {', '.join(channels)} the two "
            f"pairs of faces differ, which no error term of the sensor can cause"
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
    """Return how large a coefficient is in units of its standard uncertainty u."""
    sigmas = abs(value) / std
    return f"{sigmas:.2g} u" if sigmas >= 1e6 else f"{sigmas:.0f} u" if sigmas >= 10 else f"{sigmas:.1f} u"


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
