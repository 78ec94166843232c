"""Attitude results: `attitude/1` and the CSV of a track, a tuning (`tuning/1`), a diagnosis of residuals."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_diagnosis import AttitudeDiagnosis
from procedures.attitude.attitude_estimate import AttitudeEstimate
from procedures.attitude.attitude_log import AttitudeLog, inclination, roll_pitch_of
from procedures.attitude.gain_tuning import GainTuning
from procedures.frames import wrapped
from procedures.units import DEG_H_PER_DEG_S
from station.files.atomic_file import replace_file
from station.results.diagnosis.diagnosis_document import (
    ERRORS_TITLE,
    DiagnosisDocument,
    Table,
    causes_of,
    others_table,
)
from station.results.diagnosis.diagnosis_json import (
    FORMAT,
    error_document,
    finding_document,
    probabilities_document,
)
from station.results.diagnosis.diagnosis_text import text_of
from station.results.diagnosis.finding_wording import both
from station.text import plural

ATTITUDE_FORMAT = "attitude/1"
AXES_UNIT = "rad/s"


def attitude_document(log: AttitudeLog, track: AttitudeEstimate, direction: str = "forwards") -> dict[str, Any]:
    """Return a track as `attitude/1`: JSON-ready, what was not estimated omitted; ``direction`` as asked for."""
    bias: dict[str, Any] = {"value": track.gyro_bias.tolist(), "unit": AXES_UNIT}
    if track.gyro_bias_std is not None:
        bias["std"] = track.gyro_bias_std.tolist()
    document: dict[str, Any] = {
        "format": ATTITUDE_FORMAT, "aid": track.aid, "direction": direction, "parameters": dict(track.parameters),
        "rows": len(log.t), "gaps": [list(gap) for gap in log.gaps], "gyro_bias_rad_s": bias,
    }  # fmt: skip
    if (rms := rms_deg(log, track.down)) is not None:
        document["rms_deg"] = rms
    if track.sigma is not None:
        document["sigma_deg"] = float(np.degrees(np.median(track.sigma)))
    if track.observability is not None:
        seen = track.observability
        document["observability"] = {
            "open_s": seen.open_s, "determinant_rms_rad3_s3": seen.determinant_rms, "rank_3_share": seen.rank_3
        }  # fmt: skip
    return document | {"warnings": [*_of_gaps(log), *track.warnings]}


def rms_deg(log: AttitudeLog, down: FloatArray) -> dict[str, float] | None:
    """Return rms errors [deg] of ``down`` (n, 3) over scored rows with truth; without that column, all."""
    truth = log.true_down
    if truth is None or log.roll is None or log.pitch is None:
        return None
    rows = np.isfinite(truth).all(axis=1)
    if log.scored is not None:
        rows &= log.scored
    if not rows.any():
        return None
    roll, pitch = roll_pitch_of(down[rows])
    errors = {
        "roll": wrapped(roll - log.roll[rows]),
        "pitch": pitch - log.pitch[rows],
        "inclination": inclination(down[rows], truth[rows]),
    }
    return {name: float(np.degrees(np.sqrt(np.mean(error**2)))) for name, error in errors.items()}


def write_track(path: Path, log: AttitudeLog, track: AttitudeEstimate) -> None:
    """Write a row per input row: ``t_s,roll_rad,pitch_rad,down_x,down_y,down_z``.

    Raise `CannotWrite` if the place cannot be written.
    """
    roll, pitch = roll_pitch_of(track.down)
    rows = zip(log.t.tolist(), roll.tolist(), pitch.tolist(), *track.down.T.tolist(), strict=True)
    text = "".join("{:.15g},{:.7f},{:.7f},{:.9f},{:.9f},{:.9f}\n".format(*row) for row in rows)
    replace_file(path, ("t_s,roll_rad,pitch_rad,down_x,down_y,down_z\n" + text).encode())


def attitude_text(log: AttitudeLog, document: dict[str, Any]) -> str:
    """Return an `attitude/1` as people read it."""
    bias = np.degrees(document["gyro_bias_rad_s"]["value"]) * DEG_H_PER_DEG_S
    std = document["gyro_bias_rad_s"].get("std")
    lines = [f"{document['rows']} rows, {log.t[-1] - log.t[0]:.1f} s, aid {document['aid']}"]
    if document["direction"] == "both":
        lines[0] += ", forwards and backwards"
    lines.append("gyro bias " + " ".join(f"{b:.1f}" for b in bias) + " deg/h")
    if std is not None:
        lines[-1] += "  (u " + " ".join(f"{s:.1f}" for s in np.degrees(std) * DEG_H_PER_DEG_S) + ")"
    if "rms_deg" in document:
        lines.append("error rms " + ", ".join(f"{name} {v:.3f} deg" for name, v in document["rms_deg"].items()))
    if "sigma_deg" in document:
        lines.append(f"standard uncertainty of the vertical, median {document['sigma_deg']:.3f} deg")
    if "observability" in document:
        seen = document["observability"]
        lines.append(
            f"velocity filter ran {seen['open_s']:.1f} s, observable in {100 * seen['rank_3_share']:.0f} % of it "
            f"(determinant rms {seen['determinant_rms_rad3_s3']:.3g} rad3/s3)"
        )
    return "\n".join([*lines, *(f"warning: {warning}" for warning in document["warnings"])])


def _of_gaps(log: AttitudeLog) -> list[str]:
    gaps = log.gaps
    if not gaps:
        return []
    longest = max(end - start for start, end in gaps)
    return [f"{plural(len(gaps), 'gap')} in t_s, the first at {gaps[0][0]:.6g} s, the longest of {longest:.3g} s"]


TUNING_FORMAT = "tuning/1"
BAR_WIDTH = 40  # characters


def tuning_document(tuning: GainTuning, aid: str, by_tau: bool) -> dict[str, Any]:
    """Return a tuning as `tuning/1`, JSON-ready."""
    curve = []
    for gains, rms, folds in zip(tuning.candidates, tuning.rms, tuning.by_fold, strict=True):
        point = {"k1": gains.k1, "k2": gains.k2, "rms_deg": _deg(rms), "by_stretch_deg": [_deg(x) for x in folds]}
        curve.append({"tau_s": 2 / gains.k1} | point if by_tau else point)
    best = {name: curve[tuning.best][name] for name in ("tau_s", "k1", "k2") if name in curve[tuning.best]}
    warnings = ["the best value is at the end of the grid"] if tuning.at_edge else []
    return {
        "format": TUNING_FORMAT, "aid": aid, "rows": tuning.rows, "chosen": best,
        "rms_deg": _deg(tuning.rms[tuning.best]), "held_out_rms_deg": _deg(tuning.held_out),
        "chosen_without_stretch": [curve[i].get("tau_s", [curve[i]["k1"], curve[i]["k2"]]) for i in tuning.picked],
        "curve": curve, "warnings": warnings,
    }  # fmt: skip


def tuning_text(document: dict[str, Any]) -> str:
    """Return the curve with a bar per point, and what was chosen."""
    curve = document["curve"]
    least, most = (f([point["rms_deg"] for point in curve]) for f in (min, max))
    lines = [f"error against truth, aid {document['aid']}, {document['rows']} rows"]
    for point in curve:
        name = (
            f"tau {point['tau_s']:7.3g} s" if "tau_s" in point else f"K1 {point['k1']:7.4f} K2 {point['k2']:7.5f}"
        )
        share = np.log(point["rms_deg"] / least) / np.log(most / least) if most > least else 0.0
        mark = " <- least" if point["rms_deg"] == least else ""
        lines.append(f"{name}  {point['rms_deg']:8.4f} deg {'#' * (1 + round(share * (BAR_WIDTH - 1)))}{mark}")
    chosen = document["chosen"]
    option = (
        f"--tau {chosen['tau_s']:.4g}" if "tau_s" in chosen else f"--k1 {chosen['k1']:.4g} --k2 {chosen['k2']:.4g}"
    )
    lines.append(f"chosen: {option}; on held-out stretches {document['held_out_rms_deg']:.4f} deg rms")
    return "\n".join([*lines, *(f"warning: {warning}" for warning in document["warnings"])])


def _deg(angle: float) -> float:
    return float(np.degrees(angle))


METHOD = "the last 40 % of the log, held out"
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
    """Return a trace as text, laid out as every diagnosis."""
    names = both([finding["effect"] for finding in document["findings"]]) if document["findings"] else ""
    header = ("quantity", "unit", "in the rows used", "held out")
    rows = tuple(
        (each["quantity"], each["unit"], *(_error(each, held) for held in ("", "held_out_")))
        for each in document["error"]
    )
    errors = Table(ERRORS_TITLE, "<<>>", header, rows, METHOD)
    return text_of(
        DiagnosisDocument(
            verdict=document["verdict"],
            title=document["verdict"],
            headline=EFFECT_TITLES[document["verdict"]].format(names=names),
            causes=causes_of(document),
            measure_next=document["next_measurement"],
            sections=tuple(filter(None, (errors, others_table(document)))),
        )
    )


def _error(error: Mapping[str, Any], held: str) -> str:
    known = [error.get(f"{held}{when}") for when in ("before", "after")]
    return "" if None in known else " -> ".join(f"{each:.4f}" for each in known)
