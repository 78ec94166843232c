"""What an attitude's residual was traced to, as the parts of `diagnosis/2` that it has, and as people read it."""

from collections.abc import Mapping
from typing import Any

from procedures.attitude.diagnosis.attitude_diagnosis import AttitudeDiagnosis
from station.results.diagnosis.diagnosis_json import (
    FORMAT,
    error_document,
    finding_document,
    probabilities_document,
)
from station.results.diagnosis.diagnosis_text import coefficient_rows
from station.results.diagnosis.diagnosis_wording import (
    OTHERS_TITLE,
    alternatives_said,
    both,
    confidence_said,
    other_terms,
)

METHOD = "the last 40 % of the log, held out"
MAX_OTHERS = 6
EFFECT_TITLES = {
    "consistent": "No further error term was detected in this log.",
    "established": "The model lacks {names}.",
    "likely": "The model probably lacks {names}.",
    "ambiguous": "An error term was detected, but this log cannot determine which: see the alternatives.",
    "unexplained": "The findings do not predict the rest of the log: the error is unexplained.",
}


def attitude_diagnosis_document(trace: AttitudeDiagnosis) -> dict[str, Any]:
    """Return a trace as the parts of `diagnosis/2` that it has."""
    doubtful = [each.separate_by for each in trace.findings if each.confidence == "possible"]
    return {
        "format": FORMAT, "verdict": trace.verdict,
        "findings": [finding_document(each) for each in trace.findings],
        "error": [error_document(each, METHOD) for each in trace.errors],
        "probabilities": probabilities_document(trace.probabilities),
        "next_measurement": "; ".join(dict.fromkeys(doubtful)),
    }  # fmt: skip


def attitude_diagnosis_text(document: Mapping[str, Any]) -> str:
    """Return the verdict, the findings with 1 sigma, the error before and after, and what was tried."""
    names = both([finding["effect"] for finding in document["findings"]]) if document["findings"] else ""
    lines = [f"{document['verdict'].upper()}. {EFFECT_TITLES[document['verdict']].format(names=names)}"]
    for number, finding in enumerate(document["findings"], 1):
        lines += [
            "",
            f"{number}. {finding['effect']} ({finding['kind']})",
            f"   {confidence_said(finding)}",
        ]
        lines += [f"   {name:<9} {value:<44} {size:>12}" for name, value, size in coefficient_rows(finding)]
        if finding["aliases"]:
            lines.append(f"   it may also be: {alternatives_said(finding)}")
            lines.append(f"   to separate them: {finding['separate_by']}")
    for error in document["error"]:
        lines += ["", f"error, rms {error['unit']}: {error['quantity']}"]
        for title, name in (("in the rows used", ""), (error["method"], "held_out_")):
            if f"{name}before" in error and f"{name}after" in error:
                lines.append(f"   {error[f'{name}before']:.4f} -> {error[f'{name}after']:.4f}  {title}")
    if others := other_terms(document):
        lines += ["", OTHERS_TITLE, *(f"   {name:<44} {p}" for name, p in others[:MAX_OTHERS])]
    return "\n".join(lines)
